"""Who wishes to be early is as early as limits allow, whatever others weigh and the horizon is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml

import stplan
from stplan.arrays import FloatArray
from stplan.scene import parse_scene
from stplan.status import Status

HASTY = {"max_speed": 1.2, "max_acceleration": 0.7, "preferred_time": 0.1}


def agent(name: str, start: list[float], goal: list[float], **weights: float) -> dict[str, Any]:
    """Who wishes to be there at once."""
    weights = {"arrival": 10.0, **weights}
    return {"id": name, "start": start, "goal": goal, "weights": weights, "radius": 0.3, **HASTY}


def arrivals(agents: list[dict[str, Any]], horizon: float = 60.0, **top: float) -> FloatArray:
    """(A,) s."""
    text = yaml.safe_dump({"stplan": 1, "horizon": horizon, "agents": agents, **top})
    plan = stplan.plan(parse_scene(text))
    assert plan.status is Status.CONVERGED
    assert plan.trajectories is not None
    return np.array([curve[-1, 2] for curve in plan.trajectories.curves()])


def soonest(length: float) -> float:
    """From rest to rest, s."""
    speed, rate = HASTY["max_speed"], HASTY["max_acceleration"]
    return length / speed + speed / rate


def crossing(**weights: float) -> list[dict[str, Any]]:
    """Two whose ways cross."""
    return [
        agent("sam", [0, 0], [9, 0.2], **weights),
        agent("ann", [4, -4], [4.5, 4], **weights),
    ]


@pytest.mark.parametrize("kinetic", [0.0, 1e-4, 1.0])
def test_who_meets_nobody_arrives_as_soon_as_can_be(kinetic: float) -> None:
    agents = [
        agent("sam", [0, 0], [3, 0], kinetic=kinetic),
        agent("ann", [0, 9], [24, 9], kinetic=kinetic),
    ]
    # Knots round the corners of the velocity off: rest begins half a segment beyond the ends.
    assert arrivals(agents) == pytest.approx([soonest(3.0), soonest(24.0)], rel=0.02)


@pytest.mark.parametrize("factor", [1e-3, 1e3])
@pytest.mark.parametrize("top", [{"time_scale": 1.0}, {}])
def test_weights_of_who_is_far_away_do_not_matter(top: dict[str, float], factor: float) -> None:
    def planned(scale: float) -> FloatArray:
        far = agent("eve", [0, 60], [7, 61], kinetic=scale, arrival=10.0 * scale)
        return arrivals([*crossing(), far], **top)

    assert planned(factor) == pytest.approx(planned(1.0), rel=1e-3)


def test_a_horizon_that_does_not_bind_does_not_matter() -> None:
    early, late = arrivals(crossing(), 50.0), arrivals(crossing(), 200.0)
    assert late == pytest.approx(early, rel=1e-3)


@pytest.fixture(scope="module")
def behind_a_wall() -> list[stplan.Plan]:
    """Who has to go around a wall at once, planned within two horizons; one meets it in the door."""
    walls = {
        "rectangle": [0, 0, 20, 10],
        "obstacles": [{"rectangle": [9.8, 0, 10.2, 4]}, {"rectangle": [9.8, 6, 10.2, 10]}],
    }
    agents = [agent("sam", [8, 8], [12, 8]), agent("ann", [1, 5], [12, 5])]
    scenes = [
        yaml.safe_dump({"stplan": 1, "horizon": horizon, "map": walls, "agents": agents})
        for horizon in (60, 240)
    ]
    return [stplan.plan(parse_scene(scene)) for scene in scenes]


def test_ways_around_walls_are_taken_as_soon_as_can_be(behind_a_wall: list[stplan.Plan]) -> None:
    plan = behind_a_wall[0]
    assert plan.status is Status.CONVERGED
    assert plan.trajectories is not None
    sam, ann = plan.trajectories.curves()
    length = float(np.hypot(*np.diff(sam[:, :2], axis=0).T).sum())
    assert sam[-1, 2] == pytest.approx(soonest(length), rel=0.05)
    assert ann[-1, 2] == pytest.approx(soonest(11.0), rel=0.05)


def test_plans_are_the_same_from_any_horizon_nobody_needs(behind_a_wall: list[stplan.Plan]) -> None:
    early, late = (plan.trajectories for plan in behind_a_wall)
    assert early is not None
    assert late is not None
    assert np.array_equal(early.knots, late.knots)


def test_who_minds_lateness_more_is_never_later() -> None:
    times = np.array([arrivals(crossing(arrival=weight)) for weight in (0.01, 1.0, 100.0)])
    assert (times[1:] <= times[:-1] * (1.0 + 1e-3)).all()
    assert (times[-1] < times[0]).all()
