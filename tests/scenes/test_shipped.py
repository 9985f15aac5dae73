"""Every shipped scene is planned, certified and repeatable; what it shows is asked in `tests/claims`."""

from __future__ import annotations

from pathlib import Path

import pytest

from stplan.files.csv_file import csv_bytes, read_csv
from stplan.files.json_file import json_bytes
from stplan.planner import write_plan
from stplan.replanning.execution import check, plan
from stplan.scene import load_scene
from tests.claims.plans import SCENES, planned

# Scenes that take more than a few seconds are planned by `make claims` only.
LARGE = {
    "aircraft/first-class", "chases/herd", "chases/mist", "chases/slow-wolf", "circle/circle-20",
    "comparison/gap", "circle/circle-25", "circle/circle-30", "circle/circle-35", "crowds/counterflow",
    "crowds/evacuation", "crowds/lecture-hall", "crowds/platform-exchange", "crowds/shop",
    "crowds/stadium-mouth", "flash-mob/flash-mob", "mazes/corn", "mazes/rings", "meadow/meadow",
    "pond/friends", "pond/meeting", "pond/messenger", "safari/safari", "subway/platform", "tight/cabin",
    "tight/door", "tight/parking-lot", "tight/warehouse",
}  # fmt: skip
NAMES = sorted(str(path.relative_to(SCENES).with_suffix("")) for path in SCENES.rglob("*.yaml"))
SHIPPED = [
    pytest.param(name, marks=pytest.mark.claims) if name in LARGE else name for name in NAMES
]


@pytest.mark.parametrize("name", SHIPPED)
def test_scene_is_planned_and_certified(name: str, tmp_path: Path) -> None:
    result = planned(name)
    assert result.exit_status == 0
    assert result.certificate.holds
    # What a reader of the file sees is checked again, from the text alone.
    write_plan(result, tmp_path)
    again = check(load_scene(SCENES / f"{name}.yaml"), read_csv(tmp_path / "trajectories.csv"))
    assert again.holds, again.violations
    assert again.as_dict() == result.certificate.as_dict()


@pytest.mark.parametrize("name", NAMES)
def test_scene_says_what_it_shows(name: str) -> None:
    first = (SCENES / f"{name}.yaml").read_text(encoding="utf-8").splitlines()[0]
    assert first.startswith("# ")
    assert len(first) > 20


OPTIMISED = [
    pytest.param(name, marks=pytest.mark.claims) if name in LARGE else name
    for name in NAMES
    if not name.startswith(("chases/", "tasks/"))
]


@pytest.mark.parametrize("name", OPTIMISED)
def test_time_is_split_into_evaluation_and_the_rest(name: str) -> None:
    optimisation = planned(name).run.optimisation
    assert optimisation is not None
    times = optimisation.as_dict()
    split = times["seconds"]
    assert times["seconds_per_iteration"] > 0
    assert split["evaluation"] > 0
    assert split["evaluation"] == pytest.approx(split["objective_and_gradient"] + split["hessian"])
    assert split["linear_solve_and_rest"] > 0


@pytest.mark.parametrize("name", SHIPPED)
def test_running_twice_gives_the_same_bytes(name: str) -> None:
    first, second = planned(name), plan(load_scene(SCENES / f"{name}.yaml"))
    assert first.trajectories is not None
    assert second.trajectories is not None
    assert csv_bytes(first.trajectories) == csv_bytes(second.trajectories)
    assert csv_bytes(first.seed) == csv_bytes(second.seed)
    assert json_bytes(first.report.as_dict()) == json_bytes(second.report.as_dict())
