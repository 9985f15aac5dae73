"""plot, animate, view and export as commands: files, streams, statuses, what is refused."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
from pathlib import Path

import pytest

from stplan import optional
from tests.viewing.runs import hall_run


@pytest.fixture
def hall(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return hall_run(tmp_path)


def test_files_go_beside_the_run_unless_told(hall, run):
    result = run("plot", hall, "--dpi", 30)
    assert (result.status, result.out, result.err) == (0, f"{hall}/plot.png\n", "")
    assert run("plot", hall / "seed.npz", "--dpi", 30, "-q").out == ""
    assert run("view", hall).out == f"{hall}/view.html\n"
    assert run("view", hall, hall / "seed.npz").out == f"{hall}/view-both.html\n"
    assert run("export", hall).out == f"{hall}/rods.glb\n"
    assert run("export", hall, "--format", "jupedsim", "--fps", 4).status == 0
    result = run("animate", hall, "--size", "200", "--fps", 2, "--speed", 9, "--json")
    assert result.json == {
        "exit_status": 0,
        "file": f"{hall}/movie.mp4",
        "bytes": (hall / "movie.mp4").stat().st_size,
    }
    made = {"plot.png", "seed-plot.png", "view.html", "rods.glb", "jupedsim.txt", "movie.mp4"}
    assert made <= {path.name for path in hall.iterdir()}
    # The pictures of a run are no part of it.
    assert run("check", hall).status in (0, 1)


def test_a_named_file_decides_the_format(hall, run):
    assert run("plot", hall, "--show", "map", "--seed", "-o", "there/map.svg").status == 0
    assert "initial curve" in Path("there/map.svg").read_text()
    two = run("animate", hall / "seed.npz", hall, "--size", "200x120", "--speed", 9, "-o", "x.gif")
    assert two.status == 0
    assert Path("x.gif").read_bytes().startswith(b"GIF89a")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["plot", "-o", "x.bmp"], "x.bmp: expected a name ending in .png, .svg, .pdf"),
        (["plot", "--show", "map,walls"], "--show: 'walls' is none of map, time, rods"),
        (["plot", "--dpi", "0"], "--dpi is 0.0; expected a number above 0"),
        (["plot", "--dpi", "5000"], "--dpi is 5000.0; expected a number above 0, at most 1200"),
        (["animate", "--speed", "1e-9"], "more than 50000 frames; raise --speed or lower --fps"),
        (["animate", "-o", "x.avi"], "x.avi: expected a name ending in .mp4, .gif, .webp"),
        (["animate", "--speed", "nan"], "--speed is nan; expected a number above 0"),
        (["animate", "--size", "12x"], "--size is 12x; expected WIDTH or WIDTHxHEIGHT, 64 to 8192"),
        (["animate", "--size", "9000"], "--size is 9000; expected WIDTH or WIDTHxHEIGHT"),
        (["view", "a", "b"], "3 runs are named; one is shown, or two over each other"),
        (["view", "-o", "x.pdf"], "x.pdf: expected a name ending in .html"),
        (["export", "--format", "obj"], "--format: 'obj' is none of glb, animated-glb, csv"),
        (["export", "--pace", "-1"], "--pace is -1.0; expected a number above 0"),
        (["view", "--scene", "no.yaml"], "no.yaml"),
    ],
)
def test_what_is_refused(hall, run, words, message):
    before = sorted(hall.parent.rglob("*"))
    result = run(words[0], hall, *words[1:])
    assert result.status == 2
    assert message in result.err
    assert len(result.err.splitlines()) == 1
    assert sorted(hall.parent.rglob("*")) == before


@pytest.mark.parametrize("command", ["plot", "animate", "view", "export"])
def test_a_folder_without_a_run(tmp_path, run, command):
    result = run(command, tmp_path)
    assert result.status == 2
    assert "holds no trajectories.npz" in result.err


def test_pictures_of_a_run_whose_scene_is_lost(hall, run):
    (hall.parent / "scene.yaml").unlink()
    result = run("plot", hall, "--dpi", 30)
    assert result.status == 0
    assert result.err.startswith("note: drawn without the scene: ")
    assert len(result.err.splitlines()) == 1


@pytest.mark.parametrize(
    ("words", "missing", "message"),
    [
        (["plot"], "matplotlib", "stplan plot needs the package matplotlib"),
        (["animate"], "matplotlib", "stplan animate needs the package matplotlib"),
        (["animate"], "imageio_ffmpeg", "an MP4 movie needs the package imageio-ffmpeg"),
    ],
)
def test_a_missing_package_is_one_sentence(hall, run, monkeypatch, words, missing, message):
    def without(name):
        if name == missing:
            raise ImportError(name)
        return importlib.import_module(name)

    monkeypatch.setattr(optional, "import_module", without)
    result = run(words[0], hall)
    assert result.status == 2
    assert result.err == f"{message}: pip install 'stplan[view]'\n"


def test_the_page_and_exports_need_no_extra_package(hall):
    """In a process where the packages of the extra cannot be imported."""
    code = (
        "import sys\n"
        "for name in ('matplotlib', 'PIL', 'imageio_ffmpeg'): sys.modules[name] = None\n"
        "from stplan.cli.app import main\n"
        f"main([COMMAND, {str(hall)!r}, '--json'])\n"
    )
    for command in ("view", "export"):
        done = subprocess.run(
            [sys.executable, "-c", code.replace("COMMAND", repr(command))],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)["exit_status"] == 0
