"""The portfolio as a whole: what it says when there is no way, its limit, and how its parts work together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import get_args, get_type_hints

import numpy as np
import pytest

from stplan.errors import SeedingError
from stplan.problem.kinetic_cost import total_kinetic_cost
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import held_requirement, requirement
from stplan.problem.verification import verify
from stplan.scene import parse_scene
from stplan.scene.model import Scene, SeedingSettings
from stplan.seeding.elastic_bands.tightening import tighten
from stplan.seeding.portfolio import AUTO, Seed, find_seed, prepare_portfolio
from stplan.seeding.registry import SEEDERS
from stplan.seeding.search.levels import Levels
from stplan.seeding.search.schedule import Search
from stplan.seeding.seeder import Budget, SeedAttempt
from stplan.seeding.shortcutting.shortcuts import take_shortcuts
from stplan.world import build_free_space
from tests.seeding.families import circle
from tests.seeding.tight_families import budget_of, door, make_scene, rectangle

ROOM = rectangle(0, 0, 8, 6)


@dataclass(frozen=True)
class Given:
    """A seeder that finds what it is given."""

    found: SeedAttempt

    def attempt(self, budget: Budget) -> SeedAttempt:
        return self.found


def problem_of(scene: Scene) -> PlanningProblem:
    return PlanningProblem.from_scene(scene, build_free_space(scene))


def seed(scene: Scene) -> Seed:
    return find_seed(problem_of(scene), progress=lambda line: None)


def failure(scene: Scene) -> str:
    with pytest.raises(SeedingError) as caught:
        seed(scene)
    return str(caught.value)


def with_seeding(scene: Scene, **changes: object) -> Scene:
    return replace(scene, seeding=replace(scene.seeding, **changes))


def with_speed(scene: Scene, speed: float) -> Scene:
    return replace(scene, agents=tuple(replace(one, max_speed=speed) for one in scene.agents))


def test_a_start_that_cannot_move_is_proven_hopeless() -> None:
    cell = [rectangle(1.4, 1.0, 1.6, 3.0), rectangle(0.0, 2.8, 1.6, 3.0)]
    message = failure(make_scene("x", ROOM, cell, [((0.7, 1.4), (6.0, 3.0))], radii=0.6))
    assert message.startswith("no collision-free curves exist: ")
    assert "through, the agent's is 0.6 m" in message


def test_the_widest_radius_that_gets_through_is_named() -> None:
    walls = [rectangle(3.5, -1, 4.5, 2.6), rectangle(3.5, 3.4, 4.5, 7)]
    journey = [((1.0, 3.0), (7.0, 3.0))]
    message = failure(make_scene("x", ROOM, walls, journey, radii=0.5))
    assert message.startswith("no collision-free curves exist: a0: no way connects")
    assert "a radius of 0.4 m through" in message
    assert seed(make_scene("x", ROOM, walls, journey, radii=0.39)).found_by


def test_a_horizon_too_short_for_the_shortest_way_is_proven_hopeless() -> None:
    # Round the wall's end the way is 2 * hypot(3, 4) m and a little, straight it would be 6 m.
    wall = [rectangle(3.99, -1, 4.01, 4.7)]
    scene = make_scene("x", ROOM, wall, [((1.0, 1.0), (7.0, 1.0))], horizon=10.0)
    message = failure(with_speed(scene, 0.95))
    assert message.startswith("no curves keep the limits of the scene: ")
    assert "a0 cannot reach its goal by 10 s: its way is at least 1" in message
    assert "at 0.95 m/s" in message
    in_the_open = replace(scene, map=None)
    assert "at least 6 m long" in failure(with_speed(in_the_open, 0.55))


def test_what_is_not_found_within_the_limit_says_so_and_claims_no_proof() -> None:
    lane = rectangle(0, 0, 12, 0.8)
    x = [1.0, 2.0, 3.0, 9.0, 10.0, 11.0]
    journeys = [((a, 0.4), (b, 0.4)) for a, b in zip(x, x[::-1], strict=True)]
    scene = make_scene("x", lane, [], journeys, horizon=20.0)
    message = failure(with_seeding(scene, time_limit=1.0))
    assert message.startswith("no collision-free initial curves: ")
    assert "not found within 1 s; raise seeding.time_limit" in message
    assert "proven" not in message


@pytest.mark.parametrize("method", ["auto", "relaxation", "search", "dijkstra"])
def test_no_part_goes_on_when_the_limit_has_struck(method: str) -> None:
    message = failure(with_seeding(circle(20, 8.0, 20.0), time_limit=1e-6, method=method))
    assert "not found within 1e-06 s" in message


def test_the_limit_does_not_decide_which_curves_are_found() -> None:
    scene = door(np.random.default_rng(3), per_side=3)
    short, long = (seed(with_seeding(scene, time_limit=limit)) for limit in (60.0, 6000.0))
    assert short.world_lines.knots.tobytes() == long.world_lines.knots.tobytes()


def test_what_search_found_is_relaxed() -> None:
    parts = []
    for draw in range(5):
        scene = door(np.random.default_rng(draw), per_side=4)
        problem = problem_of(scene)
        required = requirement(problem, 1.05)
        found = Search(Levels(problem)).attempt(budget_of(scene))
        assert found.clear
        tight = tighten(problem, found.curves, required)
        assert verify(problem, tight) == []
        held = held_requirement(problem, found.curves, required)
        shortened = take_shortcuts(problem, found.curves, held)
        after, before = (total_kinetic_cost(problem.masses, c) for c in (tight, shortened))
        parts.append(after / before)
    assert max(parts) <= 1.0
    assert min(parts) < 0.97


def test_what_cannot_be_prepared_in_time_is_no_seed() -> None:
    problem = problem_of(circle(4, 8.0, 20.0))
    found = prepare_portfolio(problem).seeders[0].attempt(Budget())
    assert found.clear
    late = replace(prepare_portfolio(problem), seeders=(Given(found),))
    with pytest.raises(SeedingError, match="not shortened and given their knots within 60 s"):
        late.find(Budget(deadline=-1e9))
    assert late.find(Budget()).found_by == "relaxation"


def test_a_map_far_wider_than_the_ways_is_seeded_like_its_middle() -> None:
    wall = {"rectangle": [4, -1, 5, 8]}
    agents = (
        "agents:\n  - {id: a, start: [0, 0], goal: [9, 0], radius: 0.4}\n"
        "  - {id: b, start: [9, 3], goal: [0, 3], radius: 0.4}\n"
    )
    text = "stplan: 1\nhorizon: 20\nmap: {{rectangle: [{0}, {0}, {1}, {1}], obstacles: [{2}]}}\n"
    found = [
        seed(parse_scene(text.format(-size, size, wall) + agents)).world_lines.knots
        for size in (5e2, 5e8)
    ]
    assert np.array_equal(*found)


def test_the_scene_format_names_the_seeders_there_are() -> None:
    assert set(get_args(get_type_hints(SeedingSettings)["method"])) == {AUTO, *SEEDERS}
    assert all(
        name == seeder(problem_of(circle(2, 8.0, 20.0))).name for name, seeder in SEEDERS.items()
    )


def test_prescribed_paths_alone_need_no_seeding_in_any_map() -> None:
    tram = "agents: [{id: tram, path: [[1, 1, 0], [8, 1, 20]]}]\n"
    world = "map: {rectangle: [0, 0, 10, 6]}\n"
    found = seed(parse_scene(f"stplan: 1\nhorizon: 20\n{world}{tram}"))
    assert found.world_lines.knots.tolist() == [[1.0, 1.0, 0.0], [8.0, 1.0, 20.0]]


def test_without_shortcuts_a_seed_is_what_was_found() -> None:
    """The paper's initial curves: along edges of the mesh, from layer to layer, with kinks and waits."""
    scene = with_seeding(door(np.random.default_rng(1), per_side=2), method="dijkstra")
    scene = replace(scene, solver=replace(scene.solver, knots=120))
    raw, polished = seed(with_seeding(scene, shortcuts=False)), seed(scene)
    problem = problem_of(scene)
    found = SEEDERS["dijkstra"](problem).attempt(budget_of(scene)).curves
    for knots, curve in zip(raw.world_lines.curves(), found, strict=True):
        assert len(knots) >= 120
        assert {tuple(row) for row in np.round(curve, 9)} <= {
            tuple(row) for row in np.round(knots, 9)
        }
    assert not verify(problem, list(raw.world_lines.curves()))
    costs = [
        total_kinetic_cost(problem.masses, list(one.world_lines.curves()))
        for one in (raw, polished)
    ]
    assert costs[0] > 1.2 * costs[1]
