"""Relaxation: what it finds is clear, repeatable, and respects everything a scene can ask for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
import shapely

from stplan.arrays import FloatArray
from stplan.bench.families_crowds import FAMILIES as FAMILIES_OF_CROWDS
from stplan.planner import prepare
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import requirement
from stplan.problem.verification import verify
from stplan.scene.model import Agent, PairRule, Scene, Weights
from stplan.seeding.elastic_bands.relaxation import middle_of, relax
from stplan.seeding.elastic_bands.relaxation_seeder import Relaxation
from stplan.seeding.search.levels import Levels
from stplan.seeding.seeder import Budget, SeedAttempt
from stplan.seeding.shortcutting.shortcuts import prepare_seed
from stplan.world import FreeSpace
from tests.seeding.families import (
    agent,
    circle,
    crossing_flows,
    energy,
    lanes,
    open_field,
    scene,
    straight_energy,
)


def relaxed(
    one: Scene, space: FreeSpace | None = None, initial: list[FloatArray] | None = None
) -> tuple[PlanningProblem, SeedAttempt]:
    """The scene relaxed with the default margin, proven clear with it if solved."""
    problem = PlanningProblem.from_scene(one, space)
    result = relax(problem, requirement(problem, 1.02), initial, max_sweeps=600)
    return problem, result


def sampled_ratio(problem: PlanningProblem, curves: Sequence[FloatArray]) -> float:
    """Least ratio of distance to R over colliding pairs at 2000 common instants."""
    times = np.linspace(0.0, problem.final_time, 2000)
    places = np.stack(
        [
            np.column_stack([np.interp(times, curve[:, 2], curve[:, x]) for x in range(2)])
            for curve in curves
        ]
    )
    worst = np.inf
    for a in range(len(curves)):
        for b in np.flatnonzero(problem.collides[a]):
            present = np.ones(len(times), dtype=bool)
            for c in (a, int(b)):
                present &= times >= curves[c][0, 2]
                if not problem.stays[c]:
                    present &= times <= curves[c][-1, 2]
            gap = np.hypot(*(places[a] - places[b])[present].T).min(initial=np.inf)
            worst = min(worst, float(gap) / float(problem.distance[a, b]))
    return worst


FAMILIES = {
    "open field": open_field(40, 0.15),
    "crossing flows": crossing_flows(40, density=0.2),
    "circle": circle(12, 8.0, 30.0),
    "lanes": lanes(16),
}


@pytest.mark.parametrize("name", FAMILIES)
def test_families_are_solved_close_to_straight(name: str) -> None:
    one = FAMILIES[name]
    problem, result = relaxed(one)
    assert result.clear
    assert result.touching == ()
    assert verify(problem, result.curves) == []
    assert sampled_ratio(problem, result.curves) > 1.0
    assert energy(one, result.curves) < 1.2 * straight_energy(one)


def test_the_same_seed_gives_the_same_bytes_and_another_one_another_answer() -> None:
    problem = PlanningProblem.from_scene(circle(6, 5.0, 20.0), None)
    first, again, other = (
        relax(problem, requirement(problem, 1.05), rng_seed=seed) for seed in (3, 3, 4)
    )
    assert [c.tobytes() for c in first.curves] == [c.tobytes() for c in again.curves]
    assert [c.tobytes() for c in first.curves] != [c.tobytes() for c in other.curves]


def test_two_head_on_part_although_everything_is_symmetric() -> None:
    problem, result = relaxed(scene([agent("a", (0, 0), (10, 0)), agent("b", (10, 0), (0, 0))]))
    assert result.clear
    assert sampled_ratio(problem, result.curves) > 1.0


@pytest.mark.parametrize("time_scale", [0.3, 3.0])
def test_the_time_scale_counts(time_scale: float) -> None:
    one = replace(circle(6, 8.0, 30.0), time_scale=time_scale)
    problem, result = relaxed(one)
    assert result.clear
    assert problem.rod(0, result.curves[0])[-1, 2] == pytest.approx(30.0 * time_scale)


def test_heavy_agents_yield_less() -> None:
    heavy = agent("heavy", (0, 0), (20, 0), mass=50.0)
    light = agent("light", (20, 0.1), (0, 0.1), mass=1.0)
    _, result = relaxed(scene([heavy, light]))
    assert result.clear
    detour = [np.abs(curve[:, 1]).max() for curve in result.curves]
    assert detour[0] < 0.5 * detour[1]


def test_unequal_radii_are_kept_apart() -> None:
    elephant = agent("elephant", (0, 0), (20, 0), radius=2.0)
    people = [agent(f"p{k}", (20, k - 2.0), (0, k - 2.0), radius=0.3) for k in range(5)]
    problem, result = relaxed(scene([elephant, *people]))
    assert result.clear
    assert sampled_ratio(problem, result.curves) > 1.0


def test_agents_that_ignore_each_other_go_straight_through() -> None:
    agents = [agent("a", (0, 0), (10, 0)), agent("b", (10, 0), (0, 0))]
    one = scene(agents, pairs=(PairRule((0,), (1,), collide=False),))
    _, result = relaxed(one)
    assert result.clear
    assert result.record.sweeps == 4


def test_a_tail_is_walked_around() -> None:
    early = agent("early", (0, 0), (5, 0), max_time=5.0)
    late = agent("late", (5, -8), (5, 8), max_time=20.0)
    problem, result = relaxed(scene([early, late]))
    assert result.clear
    assert sampled_ratio(problem, result.curves) > 1.0
    assert np.abs(result.curves[1][:, 0] - 5).max() > 0.9
    gone = replace(early, after_arrival="vanish")
    _, result = relaxed(scene([gone, late]))
    assert result.clear
    assert np.abs(result.curves[1][:, 0] - 5).max() < 0.9


def test_vanishing_agents_with_one_goal_arrive_one_after_the_other() -> None:
    agents = [
        agent(name, start, (0, 0), after_arrival="vanish")
        for name, start in (("a", (-8, 0)), ("b", (8, 0)), ("c", (0, 8)))
    ]
    problem, result = relaxed(scene(agents))
    assert result.clear
    assert len({round(float(curve[-1, 2]), 3) for curve in result.curves}) == 3
    assert sampled_ratio(problem, result.curves) > 1.0


def test_own_times_are_respected() -> None:
    agents = [
        agent("a", (0, 0), (10, 0), start_time=2.0, max_time=12.0),
        agent("b", (10, 0), (0, 0), start_time=0.0, max_time=18.0),
        agent("c", (5, 5), (5, -5), preferred_time=9.0, weights=Weights(arrival=1.0)),
    ]
    problem, result = relaxed(scene(agents))
    assert result.clear
    assert result.curves[0][0, 2] == 2.0
    assert result.curves[0][-1, 2] == 12.0
    assert result.curves[2][-1, 2] == pytest.approx(9.0, abs=2.0)
    assert sampled_ratio(problem, result.curves) > 1.0


def test_waypoints_are_passed_exactly() -> None:
    agents = [
        agent("a", (0, 0), (10, 0), waypoints=((5.0, 4.0), (7.0, 4.0))),
        agent("b", (5, 8), (5, -8)),
        agent("c", (10, 4), (0, 4)),
    ]
    problem, result = relaxed(scene(agents))
    assert result.clear
    assert verify(problem, result.curves) == []
    assert (result.curves[0][:, :2] == [5.0, 4.0]).all(axis=1).any()


def test_given_paths_never_move() -> None:
    path = ((0.0, 0.0, 0.0), (6.0, 0.0, 9.0), (10.0, 0.0, 20.0))
    told = agent("told", (0, 0), (10, 0), path=path)
    problem, result = relaxed(scene([told, agent("a", (10, 0), (0, 0))]))
    assert result.clear
    assert (result.curves[0] == np.array(path)).all()
    assert sampled_ratio(problem, result.curves) > 1.0


def test_a_goal_on_a_given_path_is_reached_after_it_is_free() -> None:
    told = agent("told", (5, -9), (5, 9), path=((5.0, -9.0, 0.0), (5.0, 9.0, 20.0)))
    keen = agent("keen", (0, 0), (5, 0), preferred_time=6.0, weights=Weights(arrival=1.0))
    problem, result = relaxed(scene([told, keen]))
    assert result.clear
    assert sampled_ratio(problem, result.curves) > 1.0
    hopeless = replace(keen, max_time=6.0)
    _, result = relaxed(scene([told, hopeless]))
    assert not result.clear
    assert result.touching == ((0, 1),)


def door() -> FreeSpace:
    """Two rooms joined by a door 1.6 m wide."""
    wall = shapely.union(shapely.box(4.8, -9, 5.2, -0.8), shapely.box(4.8, 0.8, 5.2, 9))
    return FreeSpace.from_polygon(shapely.box(-1, -4, 11, 4).difference(wall))


def through_the_door(one: Agent) -> FloatArray:
    """The way through the middle of the door at constant speed."""
    near, far = (4.5, 5.5) if one.start[0] < 5 else (5.5, 4.5)
    places = np.array([one.start, (near, 0.0), (far, 0.0), one.goal])
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))])
    return np.column_stack([places, length * (one.max_time / length[-1])])


def test_walls_are_kept_off_and_never_crossed() -> None:
    agents = [
        agent(f"{side}{k}", (x, y), (10 - x, y), radius=0.4, max_time=40.0)
        for side, x in (("e", 0.0), ("w", 10.0))
        for k, y in enumerate((-2.0, 2.0))
    ]
    ways = [through_the_door(one) for one in agents]
    problem, result = relaxed(scene(agents), door(), ways)
    assert result.clear
    assert verify(problem, result.curves) == []
    assert sampled_ratio(problem, result.curves) > 1.0
    walls = door().boundary
    for curve in result.curves:
        assert shapely.LineString(curve[:, :2]).distance(walls) > 0.4


def test_the_smallest_scenes() -> None:
    alone = agent("alone", (0, 0), (10, 0))
    _, result = relaxed(scene([alone]))
    assert result.clear
    told = replace(alone, path=((0.0, 0.0, 0.0), (10.0, 0.0, 20.0)))
    problem, result = relaxed(scene([told]))
    assert result.clear
    assert (result.curves[0] == np.array(told.path)).all()
    assert (
        prepare_seed(problem, result.curves, requirement(problem, 1.05))[0] == result.curves[0]
    ).all()
    still = [agent("a", (0, 0), (0, 0)), agent("b", (3, 0), (3, 0))]
    _, result = relaxed(scene(still))
    assert result.clear
    assert (result.curves[0][:, :2] == 0.0).all()


def test_the_impossible_is_reported_within_its_limits() -> None:
    agents = [agent("a", (0, 0), (10, 0)), agent("b", (10, 0), (10.5, 0))]
    problem = PlanningProblem.from_scene(scene(agents), None)
    required = requirement(problem, 1.05)
    result = relax(problem, required, max_sweeps=200)
    assert not result.clear
    assert result.touching == ((0, 1),)
    assert result.record.sweeps == 200
    assert (result.record.retensions or 0) > 0
    assert relax(problem, required, stopped=lambda: True).record.sweeps == 1


def test_a_crowd_without_room_is_given_up_early_and_one_with_room_is_not() -> None:
    def in_a_room(count: int) -> SeedAttempt:
        problem = prepare(FAMILIES_OF_CROWDS["grid room"](count, 0))
        return Relaxation(problem, 400, Levels(problem)).attempt(Budget())

    crowd, few = in_a_room(40), in_a_room(8)
    assert crowd.jammed
    assert not crowd.clear
    assert crowd.record.sweeps == 100
    assert len(crowd.touching) > 4 * 40
    assert few.clear
    assert not few.jammed


def test_the_middle_of_a_square_is_its_median() -> None:
    rng = np.random.default_rng(0)
    for size in (2, 3, 8):
        for square in (rng.random((size, size)), rng.integers(0, 2, (size, size)).astype(float)):
            assert middle_of(square).mean() == np.median(square)
