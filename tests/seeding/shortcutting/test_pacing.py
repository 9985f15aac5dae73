"""A way is kept, and walked when it is clear."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.arrays import FloatArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import least_requirement
from stplan.problem.verification import verify
from stplan.seeding.shortcutting.pacing import STEPS, paced
from tests.seeding.families import agent, scene


def crossing(**options: object) -> tuple[PlanningProblem, list[FloatArray]]:
    """One that goes east, and one whose way north is walked first."""
    agents = [agent("a", (0, 0), (10, 0), **options), agent("b", (5, -5), (5, 5))]
    problem = PlanningProblem.from_scene(scene(agents), None)
    ends = [
        np.column_stack([problem.stops[a][[0, -1]], [problem.start_times[a], problem.max_times[a]]])
        for a in range(2)
    ]
    return problem, ends


def test_the_way_is_kept_and_the_other_is_let_past() -> None:
    problem, curves = crossing()
    assert verify(problem, curves)
    way = np.array([[0.0, 0.0], [10.0, 0.0]])
    found = paced(problem, curves, 0, way, least_requirement(problem))
    assert found is not None
    assert len(found) == STEPS + 1
    assert not found[:, 1].any()
    assert not verify(problem, [found, curves[1]])


def test_it_costs_nothing_where_nobody_is_in_the_way() -> None:
    problem, curves = crossing()
    way = np.array([[0.0, 0.0], [10.0, 0.0]])
    alone = paced(problem, curves, 0, way, least_requirement(problem), unheeded=[1])
    met = paced(problem, curves, 0, way, least_requirement(problem))

    def energy(curve: FloatArray) -> float:
        step = np.diff(curve, axis=0)
        return float(((step[:, :2] ** 2).sum(axis=1) / step[:, 2]).sum())

    even = 100.0 / float(problem.preferred_times[0])
    assert even <= energy(alone) < energy(met)
    assert energy(alone) == pytest.approx(even, rel=0.4)


def test_nothing_is_found_where_somebody_stays_in_the_way() -> None:
    problem, curves = crossing()
    parked = np.array([[5.0, -5.0, 0.0], [5.0, 0.0, 1.0], [5.0, 0.0, curves[1][-1, 2]]])
    way = np.array([[0.0, 0.0], [10.0, 0.0]])
    assert paced(problem, [curves[0], parked], 0, way, least_requirement(problem)) is None


def test_waypoints_are_knots() -> None:
    problem, curves = crossing(waypoints=((3.0, 1.0),))
    way = np.array([[0.0, 0.0], [3.0, 1.0], [10.0, 0.0]])
    found = paced(problem, curves, 0, way, least_requirement(problem))
    assert found is not None
    assert not verify(problem, [found, curves[1]])


def test_nobody_is_faster_than_its_limit() -> None:
    problem, curves = crossing(max_speed=2.0)
    way = np.array([[0.0, 0.0], [10.0, 0.0]])
    found = paced(problem, curves, 0, way, least_requirement(problem))
    assert found is not None
    step = np.diff(found, axis=0)
    assert (np.hypot(step[:, 0], step[:, 1]) <= 2.0 * step[:, 2] * (1.0 + 1e-9)).all()
