"""Shortcutting and retiming: clear curves stay clear, get cheaper, and end with even durations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from stplan.arrays import FloatArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import held_requirement, least_requirement, requirement
from stplan.problem.verification import verify
from stplan.scene.model import Scene, Weights
from stplan.seeding.elastic_bands.relaxation import relax
from stplan.seeding.shortcutting.resampling import resample_curve
from stplan.seeding.shortcutting.shortcuts import (
    prepare_seed,
    resample,
    retime,
    stretch,
    take_shortcuts,
)
from stplan.world import FreeSpace
from tests.seeding.families import agent, circle, crossing_flows, energy, open_field, scene

MARGIN = 1.05


def shortest_part(curve: FloatArray) -> float:
    """Least duration over the mean one."""
    durations = np.diff(curve[:, 2])
    return float(durations.min() / durations.mean())


def detours() -> tuple[Scene, list[FloatArray]]:
    """Two agents that cross with clumsy curves: waits, corners, early arrivals."""
    agents = [agent("a", (0, 0), (10, 0)), agent("b", (5, -5), (5, 5))]
    curves = [
        np.array([[0, 0, 0], [1, 2, 0.2], [1, 2, 1], [4, 3, 3], [9, -2, 5], [10, 0, 8.0]]),
        np.array([[5, -5, 0], [6, -5, 6], [5, -5, 8], [5, 5, 16.0]]),
    ]
    return scene(agents), curves


def two_rooms() -> FreeSpace:
    """A wall with a gap in the middle."""
    wall = shapely.union(shapely.box(4.8, -9, 5.2, -0.8), shapely.box(4.8, 0.8, 5.2, 9))
    return FreeSpace.from_polygon(shapely.box(-1, -4, 11, 4).difference(wall))


@pytest.mark.parametrize(
    "one", [open_field(30, 0.15), crossing_flows(30), circle(8, 6.0, 20.0)], ids=lambda one: "-"
)
def test_prepared_seeds_are_clear_cheap_and_even(one: Scene) -> None:
    problem = PlanningProblem.from_scene(one, None)
    required = requirement(problem, MARGIN)
    found = relax(problem, required)
    assert found.clear
    curves = prepare_seed(problem, found.curves, required)
    assert verify(problem, curves, requirement(problem, 1.03)) == []
    assert energy(one, curves) <= energy(one, found.curves)
    assert all(30 <= len(curve) <= 100 for curve in curves)
    parts = [shortest_part(curve) for curve in curves]
    assert min(parts) > 0.1
    assert np.median(parts) > 0.5


def test_shortcuts_take_detours_out() -> None:
    one, curves = detours()
    problem = PlanningProblem.from_scene(one, None)
    assert verify(problem, curves) == []
    held = held_requirement(problem, curves, requirement(problem, MARGIN))
    better = take_shortcuts(problem, curves, held)
    assert verify(problem, better, held) == []
    assert energy(one, better) < 0.5 * energy(one, curves)
    assert sum(map(len, better)) <= sum(map(len, curves)) + 10


def test_the_same_seed_gives_the_same_bytes() -> None:
    one, curves = detours()
    problem = PlanningProblem.from_scene(one, None)
    first, again = (
        prepare_seed(problem, curves, requirement(problem, MARGIN), rng_seed=7) for _ in range(2)
    )
    assert [c.tobytes() for c in first] == [c.tobytes() for c in again]


def test_waypoints_and_given_paths_are_kept() -> None:
    path = ((0.0, 6.0, 0.0), (6.0, 6.0, 9.0), (10.0, 6.0, 20.0))
    agents = [
        agent("a", (0, 0), (10, 0), waypoints=((2.0, 3.0), (8.0, 3.0))),
        agent("told", path[0][:2], path[-1][:2], path=path),
    ]
    curves = [
        np.array([[0, 0, 0], [0, 2, 1], [2, 3, 2], [5, 4, 3], [8, 3, 4], [9, 3, 5], [10, 0, 6.0]]),
        np.array(path),
    ]
    problem = PlanningProblem.from_scene(scene(agents), None)
    result = prepare_seed(problem, curves, requirement(problem, MARGIN), num_knots=40)
    assert verify(problem, result) == []
    assert len(result[0]) == 40
    assert (result[1] == np.array(path)).all()
    assert result[0][-1, 2] == 20.0


def test_stretching_uses_the_time_there_is() -> None:
    agents = [agent("a", (0, 0), (10, 0)), agent("b", (10, 5), (0, 5), max_time=15.0)]
    curves = [np.array([[0, 0, 0], [10, 0, 5.0]]), np.array([[10, 5, 0], [0, 5, 5.0]])]
    problem = PlanningProblem.from_scene(scene(agents), None)
    slow = stretch(problem, curves, least_requirement(problem))
    assert [curve[-1, 2] for curve in slow] == [20.0, 15.0]


def test_stretching_minds_starts_tails_and_given_paths() -> None:
    # The late starter crosses behind the early one; slowed down on its own it would be hit, and
    # the told one must not be delayed at all.
    agents = [
        agent("early", (0, 0), (10, 0), max_time=40.0),
        agent("late", (5, -5), (5, 5), start_time=4.0, max_time=40.0),
        agent("told", (0, 8), (10, 8), path=((0.0, 8.0, 0.0), (10.0, 8.0, 10.0)), max_time=10.0),
    ]
    curves = [
        np.array([[0, 0, 0], [10, 0, 5.0]]),
        np.array([[5, -5, 4], [5, 5, 9.0]]),
        np.array([[0, 8, 0], [10, 8, 10.0]]),
    ]
    problem = PlanningProblem.from_scene(scene(agents), None)
    assert verify(problem, curves) == []
    wanted = held_requirement(problem, curves, requirement(problem, MARGIN))
    slow = stretch(problem, curves, wanted)
    assert verify(problem, slow, wanted) == []
    assert (slow[2] == curves[2]).all()
    final = prepare_seed(problem, curves, requirement(problem, MARGIN))
    assert verify(problem, final) == []
    assert final[1][0, 2] == 4.0
    assert final[0][-1, 2] > 5.0


def test_arrival_is_not_put_off_beyond_the_preferred_time() -> None:
    keen = agent("k", (0, 0), (10, 0), preferred_time=8.0, weights=Weights(arrival=1.0))
    problem = PlanningProblem.from_scene(scene([keen]), None)
    result = prepare_seed(
        problem, [np.array([[0, 0, 0], [10, 0, 5.0]])], requirement(problem, MARGIN)
    )
    # When it would like to arrive if haste had a price too.
    assert 8.0 < problem.preferred_times[0] < 9.0
    assert result[0][-1, 2] == problem.preferred_times[0]


def test_walls_are_never_cut() -> None:
    agents = [agent("a", (0, 3), (10, 3), radius=0.4), agent("b", (10, -3), (0, -3), radius=0.4)]
    curves = [
        np.array([[0, 3, 0], [4, 0, 4], [6, 0, 5], [10, 3, 9.0]]),
        np.array([[10, -3, 0], [6, 0, 10], [4, 0, 13], [0, -3, 19.0]]),
    ]
    problem = PlanningProblem.from_scene(scene(agents), two_rooms())
    assert verify(problem, curves) == []
    result = prepare_seed(problem, curves, requirement(problem, MARGIN))
    assert verify(problem, result) == []
    assert energy(scene(agents), result) < energy(scene(agents), curves)


def test_who_ignores_walls_may_cut_them() -> None:
    ghost = agent("g", (0, 3), (10, 3), weights=Weights(wall=0.0))
    problem = PlanningProblem.from_scene(scene([ghost]), two_rooms())
    curves = [np.array([[0, 3, 0], [5, 0, 10], [10, 3, 20.0]])]
    result = take_shortcuts(problem, curves, least_requirement(problem))
    assert np.abs(result[0][:, 1] - 3).max() < 1e-9


def test_resampling_keeps_the_curve_and_its_knots() -> None:
    _, curves = detours()
    for curve in curves:
        finer = resample_curve(curve, 33)
        assert len(finer) == 33
        for knot in curve:
            assert (finer == knot).all(axis=1).any()
        for x in range(2):
            on_curve = np.interp(finer[:, 2], curve[:, 2], curve[:, x])
            assert finer[:, x] == pytest.approx(on_curve, abs=1e-12)
        assert (resample_curve(curve, 3) == curve).all()


def test_resampling_a_scene_leaves_given_paths() -> None:
    one, curves = detours()
    told = replace(one.agents[0], path=tuple(map(tuple, curves[0].tolist())), max_time=8.0)
    problem = PlanningProblem.from_scene(replace(one, agents=(told, one.agents[1])), None)
    result = resample(problem, curves, 25)
    assert (result[0] == curves[0]).all()
    assert len(result[1]) == 25


@pytest.mark.parametrize("num_knots", [20, 45])
def test_retiming_gives_the_knots_asked_for(num_knots: int) -> None:
    one, curves = detours()
    problem = PlanningProblem.from_scene(one, None)
    held = held_requirement(problem, curves, requirement(problem, MARGIN))
    result = retime(problem, curves, held, num_knots)
    assert [len(curve) for curve in result] == [num_knots] * 2
    assert verify(problem, result) == []
    assert min(shortest_part(curve) for curve in result) > 0.29


def test_a_corner_of_two_close_knots_becomes_one_knot() -> None:
    # The two knots round the standing agent are closer in time than half the mean duration.
    agents = [agent("a", (0, 0), (10, 0)), agent("stands", (5, 0), (5, 0))]
    curves = [
        np.array([[0, 0, 0], [4.9, 1.06, 9.9], [5.1, 1.06, 10.1], [10, 0, 20.0]]),
        np.array([[5, 0, 0], [5, 0, 20.0]]),
    ]
    problem = PlanningProblem.from_scene(scene(agents), None)
    required = requirement(problem, 1.01)
    assert verify(problem, curves, required) == []
    result = retime(problem, curves, required, 30)
    assert verify(problem, result, required) == []
    assert shortest_part(result[0]) >= 0.5


def test_who_stands_keeps_standing() -> None:
    agents = [agent("stands", (0, 0), (0, 0)), agent("walks", (0, 3), (9, 3))]
    curves = [
        np.array([[0, 0, 0], [0, 0, 20.0]]),
        np.array([[0, 3, 0], [9, 3, 20.0]]),
    ]
    problem = PlanningProblem.from_scene(scene(agents), None)
    result = prepare_seed(problem, curves, requirement(problem, MARGIN))
    assert (result[0][:, :2] == 0.0).all()
    assert verify(problem, result) == []
