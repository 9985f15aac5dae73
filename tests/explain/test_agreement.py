"""`explain SCENE` and `solve` judge alike: both go through the same stages."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from stplan import memory
from stplan.cli.app import main
from stplan.explain.run import explain_run
from stplan.explain.scene import explain_scene
from stplan.planner import plan
from stplan.scene import load_scene, parse_scene
from tests.claims.plans import SCENES, planned
from tests.refusals.case import Case
from tests.refusals.test_refusals import CORPUS, judge, tree, written
from tests.scenes.test_shipped import SHIPPED

TIMED = """
stplan: 1
horizon: 20
agents:
  - {id: a, start: [0, 0], goal: [9, 0], waypoints: [{at: [4, 0], window: [5, 6], dwell: 0.9}]}
  - {id: b, start: [4, 5], goal: [4, -5], waypoints: [{at: [4, 0.1], window: [5, 6], dwell: 0.9}]}
"""
PLAIN = """
stplan: 1
horizon: 20
agents:
  - {id: a, start: [0, 0], goal: [9, 0]}
"""


def status(*arguments: str) -> int:
    """The exit status of a command."""
    with pytest.raises(SystemExit) as left:
        main([*arguments, "--quiet"])
    return int(left.value.code or 0)


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_scenes_are_plannable_in_both_words(name: str) -> None:
    scene = load_scene(SCENES / f"{name}.yaml")
    explanation, plannable = explain_scene(scene, time_limit=scene.seeding.time_limit)
    assert plannable == (planned(name).exit_status == 0)
    assert explanation.headline == f"{scene.name}: a valid scene."
    # The curves that are explained are those that solving starts from, and hold their certificate.
    assert not any(section.key == "violations" for section in explanation.sections)


@pytest.mark.parametrize("case", CORPUS, ids=lambda case: case.name)
def test_what_solve_refuses(case: Case, tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    written(tmp_path, case)
    before = tree(tmp_path)
    found = status("explain", "scene.yaml", "--time-limit", "60")
    err = capsys.readouterr().err
    # `tests/refusals` asserts the same status of `solve`.
    assert found == case.status
    if found == 2:
        judge(case, found, err)
    assert tree(tmp_path) == before


@pytest.mark.parametrize(
    ("text", "settings", "expected"),
    [
        # Clear initial curves are found at once, but none that keep the times that are asked.
        (TIMED, [], 3),
        (PLAIN, ["agents.a.max_speed=0.4"], 3),
        (PLAIN, ["agents.a.max_speed=0.5"], 0),
        (PLAIN, ["solver.linear_solver=ma57", "solver.ipopt.hsllib=/nowhere"], 2),
        (PLAIN, ["solver.ipopt.no_such_option=1"], 2),
        (PLAIN, ["solver.ipopt.mu_strategy=bogus"], 2),
        (PLAIN, ["solver.ipopt.acceptable_iter=3"], 0),
    ],
)
def test_the_same_verdict_at_every_stage(
    text: str, settings: list[str], expected: int, tmp_path: Path, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("scene.yaml").write_text(text)
    options = [part for setting in settings for part in ("--set", setting)]
    assert status("solve", "scene.yaml", *options) == expected
    assert status("explain", "scene.yaml", "--time-limit", "60", *options) == expected


def test_too_large_a_scene(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("scene.yaml").write_text(PLAIN)
    monkeypatch.setattr(memory, "available", lambda: 100.0 * memory.MIB)
    assert status("solve", "scene.yaml") == status("explain", "scene.yaml") == 2


def test_without_a_search_a_valid_scene_is_only_described() -> None:
    scene = parse_scene(TIMED)
    explanation, plannable = explain_scene(scene, time_limit=0.0)
    assert plannable
    assert "seeding" not in explanation.as_dict()["sections"]


def test_the_initial_curves_explained_are_those_that_solve_starts_from() -> None:
    scene = parse_scene(PLAIN)
    scene = replace(scene, agents=(replace(scene.agents[0], max_acceleration=0.2),))
    explanation, _ = explain_scene(scene, time_limit=60.0)
    of_seed, _ = explain_run(scene, plan(scene).seed)
    found = explanation.as_dict()["sections"]
    assert found["limits"]["facts"]
    assert all(found[key] == section for key, section in of_seed.as_dict()["sections"].items())
