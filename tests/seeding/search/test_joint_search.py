"""Joint search: the puzzles of discrete path finding, full cabins, and proofs that a roadmap has no way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.planner import plan, prepare
from stplan.problem.verification import verify
from stplan.scene.model import Scene
from stplan.seeding.search.joint_search import JointSearch
from stplan.seeding.search.levels import Levels
from stplan.seeding.seeder import Budget, SeedAttempt
from tests.seeding import tight_families as families
from tests.seeding.search.puzzles import ROOMS, puzzle, reversal


def searched(scene: Scene, budget: Budget | None = None) -> SeedAttempt:
    problem = prepare(scene)
    found = JointSearch(Levels(problem)).attempt(budget or Budget())
    if found.clear:
        assert verify(problem, found.curves) == []
    return found


@pytest.mark.parametrize("radius", [0.3, 0.45])
@pytest.mark.parametrize("name", sorted(ROOMS))
def test_puzzles_are_solved(name: str, radius: float) -> None:
    for rng_seed in range(2):
        assert searched(puzzle(name, rng_seed, radius)).clear


@pytest.mark.parametrize("radius", [0.3, 0.45])
def test_an_order_is_reversed_with_one_pocket_by_a_whole_plan(radius: float) -> None:
    result = plan(reversal(radius))
    assert result.exit_status == 0
    assert result.certificate.holds


@pytest.mark.parametrize("passengers", [10, 12])
def test_passengers_of_a_full_cabin_change_seats(passengers: int) -> None:
    for rng_seed in range(3):
        rng = np.random.default_rng(rng_seed)
        scene = families.cabin(rng, depth=1, passengers=passengers)
        assert searched(scene).clear


def test_what_a_roadmap_does_not_have_is_said_of_the_roadmap() -> None:
    lane = families.rectangle(0, 0, 6, 0.8)
    journeys = [((1.0, 0.4), (5.0, 0.4)), ((5.0, 0.4), (1.0, 0.4))]
    found = searched(families.make_scene("lane", lane, [], journeys))
    assert not found.clear
    (reason,) = found.reasons
    assert reason.kind == "blocked"
    assert not reason.proven
    assert reason.figures["vertices"] > 2


def test_the_same_random_number_gives_the_same_bytes() -> None:
    scene = puzzle("loop-chain", 1, 0.45)
    first, second = (searched(scene, Budget(rng_seed=4)).curves for _ in range(2))
    assert all(a.tobytes() == b.tobytes() for a, b in zip(first, second, strict=True))


def test_waypoints_are_left_to_others() -> None:
    scene = puzzle("corners", 0, 0.3)
    agents = (replace(scene.agents[0], waypoints=((1.5, -1.5),)), *scene.agents[1:])
    assert not searched(replace(scene, agents=agents)).clear


def test_agents_that_start_later_stand_where_they_start() -> None:
    scene = puzzle("connector", 1, 0.3)
    agents = tuple(replace(a, start_time=0.5 * k) for k, a in enumerate(scene.agents))
    later = replace(scene, agents=agents)
    found = searched(later)
    assert found.clear
    starts = prepare(later).start_times
    assert len(np.unique(starts)) == 4
    assert [curve[0, 2] for curve in found.curves] == starts.tolist()


@pytest.mark.parametrize("room", [1e-4, 1e-6])
def test_people_packed_on_a_grid_get_out_of_it_and_into_another(room: float) -> None:
    pitch = 2 * 0.3 + room
    journeys = [
        ((pitch * x, pitch * y), (7 + pitch * x, 2 + pitch * y)) for x in range(3) for y in range(3)
    ]
    assert searched(families.make_scene("grid", None, [], journeys, horizon=30.0)).clear


def test_a_packed_grid_is_planned_to_the_end() -> None:
    pitch = 2 * 0.3 + 1e-5
    journeys = [
        ((pitch * x, pitch * y), (6 + pitch * x, pitch * y)) for x in (0, 1) for y in (0, 1)
    ]
    result = plan(families.make_scene("grid", None, [], journeys, horizon=20.0))
    assert result.exit_status == 0
    assert result.certificate.holds
