"""The commands that make scenes, and `-` for a scene on stdin."""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from stplan.imports.templates import TEMPLATES
from stplan.scene import load_scene, parse_scene
from stplan.world import fitted_free_space
from tests.maps.formats.samples import movingai, vadere


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_scene_is_written_where_it_is_asked_for(run, here: Path) -> None:
    movingai(here)
    Path("scenes").mkdir()
    result = run("import", "rooms.map", "-n", "6", "-o", "scenes/rooms.yaml", "--simplify", "0")
    assert (result.status, result.out) == (0, "scenes/rooms.yaml: rooms with 6 agents\n")
    text = Path("scenes/rooms.yaml").read_text()
    assert text.startswith(
        "# yaml-language-server: $schema=stplan.schema.json\n# Made by stplan import rooms.map;"
    )
    assert "file: ../rooms.map" in text
    assert fitted_free_space(load_scene("scenes/rooms.yaml")) is not None


def test_without_a_target_it_goes_to_stdout_and_notes_do_not(run, here: Path) -> None:
    vadere(here)
    result = run("import", "rooms.scenario", "--agents", "14")
    assert result.status == 0
    assert len(parse_scene(result.out).agents) == 14
    assert result.err == "note: 10 agents of the files fit; 4 more are placed at random\n"


@pytest.mark.parametrize("template", TEMPLATES)
def test_templates_are_valid_scenes(run, template: str) -> None:
    result = run("new", template)
    scene = parse_scene(result.out)
    assert (result.status, scene.name) == (0, template)
    assert fitted_free_space(scene) is not None
    other = parse_scene(run("new", template, "--agents", "9", "--seed", "4", "--radius", "0.2").out)
    assert len(other.agents) == 9
    assert fitted_free_space(other) is not None


def test_a_map_is_tried_in_one_line(run, here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    movingai(here)
    made = run("new", "--map", "rooms.map", "--agents", "4")
    assert made.out == run("new", "from-map", "rooms.map", "--agents", "4").out

    class Pipe:
        buffer = io.BytesIO(made.out.encode())

    monkeypatch.setattr("sys.stdin", Pipe())
    result = run("solve", "-", "--set", "solver.effort=quick")
    assert result.status == 0, result.err
    assert Path("outputs/rooms/trajectories.csv").is_file()


def test_faults_of_stdin_are_located(run, monkeypatch: pytest.MonkeyPatch) -> None:
    class Pipe:
        buffer = io.BytesIO(
            b"stplan: 1\nhorizon: no\nagents: [{id: a, start: [0, 0], goal: [1, 1]}]\n"
        )

    monkeypatch.setattr("sys.stdin", Pipe())
    result = run("validate", "-")
    assert result.status == 2
    assert result.err.startswith("-:2:1: horizon:")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["import", "none.map"], "no such file"),
        (["import", "rooms.txt"], "expected a name that ends in"),
        (["import", "rooms.map", "rooms.map", "-n", "2"], "several maps"),
        (["import", "rooms.map", "--flip", "z", "-n", "2"], "--flip is 'z'"),
        (["import", "rooms.map", "--origin", "1", "-n", "2"], "--origin is '1'"),
        (["import", "rooms.map", "--level", "2", "-n", "2"], "map.level: is no option"),
        (["new"], "expected corridor, room, warehouse, or from-map FILE"),
        (["new", "from-map"], "expected stplan new from-map FILE"),
        (["new", "castle"], "castle: expected"),
        (["new", "from-map", "agents.xml"], "agents.xml: holds no map to place agents on"),
        (["new", "room", "--agents", "5000"], "fit on the floor"),
    ],
)
def test_what_cannot_be_is_refused(run, here: Path, words: list[str], said: str) -> None:
    movingai(here)
    Path("rooms.txt").write_text("")
    agent = '<agent id="0" start_i="5" start_j="3" goal_i="1" goal_j="4"/>'
    Path("agents.xml").write_text(f"<root>{agent}</root>")
    result = run(*words)
    assert (result.status, result.out) == (2, "")
    assert said in result.err
