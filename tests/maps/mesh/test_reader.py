"""Meshes of every format, odd ones and hostile ones."""

from __future__ import annotations

import logging
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh

from stplan.errors import SceneError
from stplan.world import build_free_space
from tests.world.scenes import scene

FLAT = "v 0 0 0\nv 4 0 0\nv 4 2 0\nv 0 2 0\n"
SPLIT = "f 1 2 3\nf 1 3 4\n"


def area(folder: Path, name: str, content: str | bytes, up: str = "z") -> float:
    """The free area of a mesh file with this content."""
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    built = scene(f"{{mesh: {name}, up: {up}}}", folder=folder)
    return float(build_free_space(built).polygon.area)


@pytest.mark.parametrize("kind", ["obj", "ply", "off", "stl", "glb"])
def test_formats_agree(tmp_path: Path, kind: str) -> None:
    corners = [[0, 0, 0], [4, 0, 0], [4, 2, 0], [0, 2, 0], [6, 0, 0]]
    mesh = trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3], [1, 4, 2]], process=False)
    content = mesh.export(file_type=kind)
    assert area(tmp_path, f"m.{kind}", content) == pytest.approx(10.0, rel=1e-6)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (FLAT + "f 1 2 3 4\n", 8),
        (FLAT + "f -4 -3 -2 -1\n", 8),
        ("mtllib missing.mtl\nusemtl a\n" + FLAT + SPLIT, 8),
        (FLAT + "vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1 4/1/1\n", 8),
        (FLAT + "v nan 0 0\nv 900 900 0\n" + SPLIT, 8),
        (FLAT + SPLIT + "f 1 1 2\nf 1 2 2\n", 8),
        (FLAT + SPLIT + "f 3 2 1\n", 8),
        ("o a\n" + FLAT + "f 1 2 3\no b\nf 1 3 4\n", 8),
        ("v 0 0 0\nv 4 0 5\nv 4 2 3\nv 0 2 -2\n" + SPLIT, 8),
        (FLAT + "v 2 4 0\nv 1 0.5 0\n" + SPLIT + "f 1 3 6\nf 4 3 5\n", 12),
    ],
    ids=[
        "quad", "negative indices", "missing materials", "normals", "unused vertices", "degenerate",
        "turned twin", "two objects", "relief", "non-manifold",
    ],
)  # fmt: skip
def test_odd_meshes(tmp_path: Path, content: str, expected: float) -> None:
    assert area(tmp_path, "m.obj", content) == pytest.approx(expected)


def test_comments_in_any_encoding(tmp_path: Path) -> None:
    assert area(tmp_path, "m.obj", b"# caf\xe9\n" + (FLAT + SPLIT).encode()) == pytest.approx(8)


@pytest.mark.parametrize(("up", "expected"), [("x", 6), ("y", 3), ("z", 2)])
def test_the_axis_that_is_dropped(tmp_path: Path, up: str, expected: float) -> None:
    box = trimesh.creation.box(extents=(1, 2, 3)).export(file_type="obj")
    assert area(tmp_path, "m.obj", box, up) == pytest.approx(expected)


BAD = {
    "empty.obj": "",
    "empty.ply": "",
    "empty.stl": "",
    "empty.off": "",
    "empty.glb": "",
    "lines.obj": FLAT + "l 1 2\nl 2 3\n",
    "points.obj": FLAT,
    "nan.obj": FLAT + "v nan 0 0\nf 1 2 5\n",
    "inf.obj": FLAT + "v inf 0 0\nf 1 2 5\n",
    "far.obj": FLAT + "v 1e300 0 0\nf 1 2 5\n",
    "range.obj": FLAT + "f 1 2 9\n",
    "below.obj": FLAT + "f -9 -8 -7\n",
    "edgewise.obj": "v 0 0 0\nv 0 0 1\nv 1 0 0\nf 1 2 3\n",
    "noise.obj": np.random.default_rng(0).bytes(400),
    "noise.ply": np.random.default_rng(0).bytes(400),
    "noise.stl": np.random.default_rng(0).bytes(400),
    "noise.glb": np.random.default_rng(0).bytes(400),
}


def refused(folder: Path, name: str, content: str | bytes) -> None:
    """The mesh is refused with a located sentence."""
    with pytest.raises(SceneError) as caught:
        area(folder, name, content)
    assert re.match(rf"scene:3:\d+: map\.mesh: {re.escape(name)} (has|cannot)", str(caught.value))


@pytest.mark.parametrize("name", BAD)
def test_bad_meshes_are_refused_quietly(
    tmp_path: Path, name: str, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    with caplog.at_level(logging.DEBUG, logger="trimesh"):
        refused(tmp_path, name, BAD[name])
    assert not caplog.records
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("kind", ["ply", "off", "stl", "glb"])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.5, 0.94])
def test_cut_short(tmp_path: Path, kind: str, share: float) -> None:
    mesh = trimesh.Trimesh(
        [[0, 0, 0], [4, 0, 0], [4, 2, 0], [0, 2, 0]], [[0, 1, 2], [0, 2, 3]], process=False
    )
    content = mesh.export(file_type=kind)
    refused(tmp_path, f"m.{kind}", content[: int(share * len(content))])
