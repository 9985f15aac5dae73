"""Every shipped scene is planned, certified, repeatable, and shows what its figure shows."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from stplan.files.csv_file import csv_bytes, read_csv
from stplan.files.json_file import json_bytes
from stplan.pipeline import Plan, check, plan, write_plan
from stplan.scene import load_scene
from stplan.scene.model import Scene

SCENES = Path(__file__).parents[2] / "scenes"
SHIPPED = sorted(str(path.relative_to(SCENES)) for path in SCENES.rglob("*.yaml"))


@cache
def planned(name: str) -> Plan:
    """The plan of a shipped scene, made once."""
    return plan(load_scene(SCENES / name))


def curves(name: str) -> dict[str, np.ndarray]:
    """Optimised curves by agent id."""
    lines = planned(name).trajectories
    assert lines is not None
    return dict(zip(lines.agent_ids, lines.curves(), strict=True))


def deviation(name: str, agent: str) -> float:
    """Largest distance of an agent from its straight line, m."""
    curve = curves(name)[agent]
    start, goal = curve[0, :2], curve[-1, :2]
    along = (goal - start) / np.linalg.norm(goal - start)
    offset = curve[:, :2] - start
    return float(np.abs(offset[:, 0] * along[1] - offset[:, 1] * along[0]).max())


def mean_distance(name: str, first: str, second: str) -> float:
    """Mean distance of two agents over the time both are present, m."""
    a, b = curves(name)[first], curves(name)[second]
    times = np.linspace(max(a[0, 2], b[0, 2]), min(a[-1, 2], b[-1, 2]), 500)
    gap = [np.interp(times, a[:, 2], a[:, x]) - np.interp(times, b[:, 2], b[:, x]) for x in (0, 1)]
    return float(np.hypot(*gap).mean())


@pytest.mark.parametrize("name", SHIPPED)
def test_scene_is_planned_and_certified(name: str, tmp_path: Path) -> None:
    result = planned(name)
    assert result.exit_status == 0
    assert result.certificate.holds
    # What a reader of the file sees is checked again, from the text alone.
    write_plan(result, tmp_path)
    again = check(load_scene(SCENES / name), read_csv(tmp_path / "trajectories.csv"))
    assert again.holds, again.violations
    assert again.as_dict() == result.certificate.as_dict()


@pytest.mark.parametrize("name", SHIPPED)
def test_scene_says_what_it_shows(name: str) -> None:
    first = (SCENES / name).read_text(encoding="utf-8").splitlines()[0]
    assert first.startswith("# ")
    assert len(first) > 20


@pytest.mark.parametrize("name", SHIPPED)
def test_time_is_split_into_evaluation_and_the_rest(name: str) -> None:
    times = planned(name).run["optimisation"]
    split = times["seconds"]
    assert times["seconds_per_iteration"] > 0
    assert split["evaluation"] > 0
    assert split["evaluation"] == pytest.approx(split["objective_and_gradient"] + split["hessian"])
    assert split["linear_solve_and_rest"] > 0


@pytest.mark.parametrize("name", SHIPPED)
def test_running_twice_gives_the_same_bytes(name: str) -> None:
    first, second = planned(name), plan(load_scene(SCENES / name))
    assert first.trajectories is not None
    assert second.trajectories is not None
    assert csv_bytes(first.trajectories) == csv_bytes(second.trajectories)
    assert csv_bytes(first.seed) == csv_bytes(second.seed)
    assert json_bytes(first.report) == json_bytes(second.report)


@pytest.mark.parametrize(
    ("name", "bound"),
    [("circle/circle-8", 1.006), ("circle/circle-8-small", 1.016), ("circle/circle-20", 1.02)],
)
def test_circles_cost_little_more_than_straight_lines(name: str, bound: float) -> None:
    assert 1.0 <= planned(f"{name}.yaml").report["metrics"]["kinetic_over_straight"] <= bound


def test_without_interaction_everyone_goes_straight() -> None:
    assert planned("three-agents/none.yaml").certificate.pairs == ()
    for agent in ("sam", "ann", "ben"):
        assert deviation("three-agents/none.yaml", agent) < 0.05


def test_the_symmetric_stand_off_resolves_and_everyone_gives_way() -> None:
    moved = [deviation("three-agents/symmetric.yaml", agent) for agent in ("sam", "ann", "ben")]
    assert sum(value > 0.1 for value in moved) >= 2


def test_a_heavy_agent_keeps_its_line() -> None:
    heavy = deviation("three-agents/mass.yaml", "sam")
    others = [deviation("three-agents/mass.yaml", agent) for agent in ("ann", "ben")]
    assert max(others) > 5 * heavy
    assert heavy < 0.3 * deviation("three-agents/symmetric.yaml", "sam")


def test_a_large_agent_makes_others_go_further_round() -> None:
    def most(name: str) -> float:
        return max(deviation(name, agent) for agent in ("ann", "ben"))

    assert most("three-agents/size-and-mass.yaml") > 1.5 * most("three-agents/mass.yaml")
    # Large alone does not make stubborn: the light giant gives way more than the heavy one.
    light = deviation("three-agents/size.yaml", "sam")
    assert light > 3 * deviation("three-agents/size-and-mass.yaml", "sam")


def test_friends_stay_closer_than_without_the_grouping_term() -> None:
    together = mean_distance("three-agents/friends.yaml", "ann", "ben")
    apart = mean_distance("three-agents/symmetric.yaml", "ann", "ben")
    assert together < 0.9 * apart


def test_at_the_bottleneck_someone_waits_and_someone_is_late() -> None:
    scene: Scene = planned("bottleneck/bottleneck.yaml").scene
    late, waits, passages = 0, 0, []
    for agent in scene.agents:
        curve = curves("bottleneck/bottleneck.yaml")[agent.id]
        assert agent.preferred_time is not None
        late += curve[-1, 2] > agent.preferred_time + 1.0
        through = np.interp(10.0, curve[:, 0], curve[:, 2])
        length = np.append(0.0, np.cumsum(np.hypot(*np.diff(curve[:, :2], axis=0).T)))
        before = np.interp(through, curve[:, 2], length) / (through - curve[0, 2])
        after = (length[-1] - before * through) / (curve[-1, 2] - through)
        waits += before < 0.7 * after
        passages.append(through)
    assert late >= 1
    assert waits >= 1
    # One at a time: the gap is 1.5 m wide, two walkers side by side are 1.8 m.
    assert np.diff(sorted(passages)).min() > 0.3


def test_in_the_tunnel_the_heavy_wagon_moves_aside_less() -> None:
    assert deviation("tunnel/tunnel.yaml", "wagon") < 0.5 * deviation("tunnel/tunnel.yaml", "miner")
