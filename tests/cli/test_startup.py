"""A command loads no library that it does not need: loading takes longer than planning a small scene."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from stplan import planner
from stplan.scene import load_scene

ROOT = Path(__file__).parents[2]
PROGRAM = """
import json, sys
from stplan.cli.app import main
try:
    main(sys.argv[1:])
except SystemExit as end:
    assert not end.code, end.code
print(json.dumps(sorted(sys.modules)), file=sys.stderr)
"""
AGENTS = """
agents:
  - {id: sam, start: [-2.0, 0.0], goal: [2.0, 0.1], radius: 0.3}
  - {id: ann, start: [0.1, -2.0], goal: [0.0, 2.0], radius: 0.3}
"""
OPEN = f"stplan: 1\nname: open\nhorizon: 6.0{AGENTS}"
WALLED = f"stplan: 1\nname: walled\nhorizon: 6.0\nmap: {{rectangle: [-5, -5, 5, 5]}}{AGENTS}"

# Parts of scipy: numba loads its top to look at the version.
SCIPY = {"scipy.linalg", "scipy.optimize", "scipy.sparse", "scipy.spatial"}
MESHES = {"trimesh", "networkx"}
PICTURES = {"matplotlib", "PIL", "imageio_ffmpeg", "rich"}
COMPILED = {"numba", "llvmlite", "ipopt_wrapper"}


def loaded_by(*arguments: str, cwd: Path) -> set[str]:
    """The modules that a command, run in a process of its own, ends with."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *arguments],
        cwd=cwd, env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return set(json.loads(done.stderr.splitlines()[-1]))


@pytest.fixture
def place(tmp_path: Path) -> Path:
    (tmp_path / "open.yaml").write_text(OPEN)
    (tmp_path / "walled.yaml").write_text(WALLED)
    return tmp_path


@pytest.mark.parametrize("words", [["--help"], ["solve", "--help"], ["bench", "--help"]])
def test_help_needs_nothing(tmp_path, words):
    loaded = loaded_by(*words, cwd=tmp_path)
    heavy = {"numpy", "scipy", "shapely", "yaml", "stplan.scene"}
    assert not loaded & (heavy | COMPILED | MESHES | PICTURES)


def test_validating_needs_no_kernels_and_no_solver(place):
    loaded = loaded_by("validate", "open.yaml", cwd=place)
    assert "yaml" in loaded
    assert not loaded & (COMPILED | SCIPY | MESHES | PICTURES | {"shapely"})
    loaded = loaded_by("validate", "walled.yaml", cwd=place)
    assert "shapely" in loaded
    assert not loaded & (COMPILED | MESHES | PICTURES)


def test_planning_in_the_open_needs_no_library_of_maps(place):
    # Once here, because compiling kernels takes more than loading them does.
    planner.plan(load_scene(place / "open.yaml"))
    loaded = loaded_by("solve", "open.yaml", "-q", cwd=place)
    assert loaded >= {"numba", "ipopt_wrapper"}
    assert not loaded & (SCIPY | MESHES | PICTURES | {"shapely"})
    loaded = loaded_by("check", "outputs/open", cwd=place)
    assert not loaded & (SCIPY | MESHES | PICTURES | {"shapely"})


def test_planning_between_plain_walls_needs_no_library_of_meshes(place):
    planner.plan(load_scene(place / "walled.yaml"))
    loaded = loaded_by("solve", "walled.yaml", "-q", cwd=place)
    assert "shapely" in loaded
    assert not loaded & (MESHES | PICTURES | {"scipy.optimize"})


def test_importing_the_package_needs_nothing_and_offers_its_names():
    program = """
import sys, stplan
assert not {"numpy", "importlib.metadata"} & set(sys.modules)
assert set(stplan.__all__) <= set(dir(stplan))
for name in stplan.__all__:
    getattr(stplan, name)
assert issubclass(stplan.errors.SceneError, stplan.errors.StplanError)
"""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_unknown_names_of_the_package():
    import stplan

    with pytest.raises(AttributeError, match="no attribute 'plam'"):
        _ = stplan.plam
