"""Certificates of other programs' trajectories, against scenes and against maps."""

from __future__ import annotations

from pathlib import Path

import pytest

SCENE = """\
stplan: 1
map: {rectangle: [0, 0, 10, 4]}
horizon: 10
agents:
  - {id: sam, start: [1, 1], goal: [9, 1], after_arrival: vanish}
  - {id: ann, start: [9, 3], goal: [1, 3], after_arrival: vanish}
"""
APART = "#framerate: 1\n" + "".join(f"7 {k} {9 - k} 3 0\n3 {k} {1 + k} 1 0\n" for k in range(9))
CROSSING = APART.replace(" 3 0\n", " 1 0\n")


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("scene.yaml").write_text(SCENE)
    Path("hall.wkt").write_text("POLYGON ((0 0, 10 0, 10 4, 0 4, 0 0))")
    Path("apart.txt").write_text(APART)
    Path("crossing.txt").write_text(CROSSING)


def test_who_is_who_shows_at_the_starts(run) -> None:
    result = run("check", "scene.yaml", "apart.txt")
    assert (result.status, result.out.splitlines()[0][:28]) == (0, "scene: certificate holds; ti")


def test_others_trajectories_against_a_map(run) -> None:
    assert run("check", "hall.wkt", "apart.txt").status == 0
    assert run("check", "hall.wkt", "apart.txt", "--radius", "0.9").status == 0
    wide = run("check", "hall.wkt", "apart.txt", "--radius", "1.05")
    assert wide.status == 1
    result = run("check", "hall.wkt", "crossing.txt", "--json")
    assert result.status == 1
    assert any(
        "7 and 3" in violation or "3 and 7" in violation for violation in result.json["violations"]
    )


def test_agents_on_one_another_are_violations_not_faults(run) -> None:
    Path("same.txt").write_text("#framerate: 1\n1 0 2 2 0\n1 1 3 2 0\n2 0 2.1 2 0\n2 1 3.1 2 0\n")
    assert run("check", "hall.wkt", "same.txt").status == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["scene.yaml", "apart.txt", "--radius", "0.2"], "--radius is for maps"),
        (["hall.wkt", "apart.txt", "--radius", "-1"], "--radius is -1"),
        (["hall.wkt", "none.txt"], "no such file"),
    ],
)
def test_what_is_refused(run, words: list[str], said: str) -> None:
    result = run("check", *words)
    assert result.status == 2
    assert said in result.err
