"""Search solves a member of every tight family, provably clear, and the same way twice."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stplan.problem.clearance import rod_clearances, wall_clearance
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.verification import verify
from stplan.scene.model import Scene
from stplan.scene.reading.load import load_scene
from stplan.seeding.elastic_bands.geodesics import geodesic_curves
from stplan.seeding.search.levels import Levels
from stplan.seeding.search.mending import Mending
from stplan.seeding.search.schedule import Search
from stplan.seeding.seeder import SeedAttempt
from stplan.wording import sentences
from stplan.world import build_free_space
from tests.seeding import tight_families as families

SCENES = Path(__file__).parents[3] / "scenes"


def prepared(scene: Scene) -> PlanningProblem:
    return PlanningProblem.from_scene(scene, build_free_space(scene))


def searched(scene: Scene) -> SeedAttempt:
    problem = prepared(scene)
    result = Search(Levels(problem)).attempt(families.budget_of(scene))
    assert result.clear, sentences(result.reasons)
    assert verify(problem, result.curves) == []
    return result


SMALL = {
    "corridor": families.corridor_with_pocket,
    "narrowest corridor": lambda rng: families.corridor_with_pocket(rng, half_width=1.05),
    "widest corridor": lambda rng: families.corridor_with_pocket(rng, half_width=3.0),
    "right turns": lambda rng: families.plus_crossing(rng, turn=1),
    "straight": lambda rng: families.plus_crossing(rng, turn=2),
    "left turns": lambda rng: families.plus_crossing(rng, turn=3),
    "door": lambda rng: families.door(rng, per_side=4),
    "warehouse": lambda rng: families.warehouse(rng, robots=10),
    "cabin one deep": lambda rng: families.cabin(rng, depth=1, passengers=6),
    "cabin two deep": lambda rng: families.cabin(rng, depth=2, passengers=6),
    "pillars": lambda rng: families.pillars(rng, agents=16),
}


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("family", SMALL)
def test_a_member_of_every_family_is_solved(family: str, seed: int) -> None:
    result = searched(SMALL[family](np.random.default_rng(seed)))
    parts = ("prioritized", "priority-based", "repair", "joint")
    assert result.found_by in {f"search ({part})" for part in parts}
    assert result.reasons == ()


@pytest.mark.parametrize("family", ["narrowest corridor", "left turns", "door", "cabin two deep"])
def test_the_same_scene_gives_the_same_bytes(family: str) -> None:
    first, second = (searched(SMALL[family](np.random.default_rng(3))) for _ in range(2))
    for one, other in zip(first.curves, second.curves, strict=True):
        assert one.tobytes() == other.tobytes()


@pytest.mark.parametrize("path", sorted((SCENES / "tight").glob("*.yaml")), ids=lambda p: p.stem)
def test_shipped_tight_scenes_are_solved(path: Path) -> None:
    searched(load_scene(path))


def test_a_swap_past_a_pocket_behind_the_start_takes_a_joint_search() -> None:
    # One has to back into the pocket, the other to pass it, wait beyond and come back.
    outer = (
        (0.0, 0.0), (1.1, 0.0), (1.1, -0.9), (1.9, -0.9), (1.9, 0.0), (8.0, 0.0), (8.0, 0.8),
        (0.0, 0.8),
    )  # fmt: skip
    journeys = [((2.5, 0.4), (7.5, 0.4)), ((7.5, 0.4), (2.5, 0.4))]
    result = searched(families.make_scene("behind", outer, [], journeys))
    assert result.found_by == "search (joint)"


def test_others_are_planned_around_a_joint_pair() -> None:
    outer = (
        (0.0, 0.0), (1.1, 0.0), (1.1, -0.9), (1.9, -0.9), (1.9, 0.0), (8.0, 0.0), (8.0, -2.0),
        (12.0, -2.0), (12.0, 2.0), (8.0, 2.0), (8.0, 0.8), (0.0, 0.8),
    )  # fmt: skip
    journeys = [((2.5, 0.4), (7.5, 0.4)), ((7.5, 0.4), (2.5, 0.4))]
    journeys += [((11.0, y), (9.0, -y)) for y in (-1.2, 1.2)]
    searched(families.make_scene("room", outer, [], journeys))


@pytest.mark.parametrize("family", ["warehouse", "pillars", "door"])
def test_curves_that_touch_are_repaired(family: str) -> None:
    scene = SMALL[family](np.random.default_rng(6))
    problem = prepared(scene)
    ways = [way for way in geodesic_curves(problem) if way is not None]
    touching = {a for pair in rod_clearances(problem, ways).violations for a in pair[:2]}
    assert touching
    result = Mending(Levels(problem)).attempt_from(ways, families.budget_of(scene))
    assert result.clear
    assert verify(problem, result.curves) == []


def test_curves_that_are_clear_are_left_alone() -> None:
    scene = SMALL["pillars"](np.random.default_rng(6))
    problem = prepared(scene)
    curves = searched(scene).curves
    result = Mending(Levels(problem)).attempt_from(curves, families.budget_of(scene))
    assert result.clear
    assert all(np.array_equal(a, b) for a, b in zip(curves, result.curves, strict=True))


@pytest.mark.parametrize("family", ["corridor", "cabin two deep", "pillars"])
def test_geodesics_are_clear_of_the_walls_and_short(family: str) -> None:
    scene = SMALL[family](np.random.default_rng(8))
    problem = prepared(scene)
    for agent, way in enumerate(geodesic_curves(problem)):
        assert way is not None
        assert wall_clearance(problem, agent, way) > problem.radii[agent]
        assert tuple(way[0]) == (*problem.starts[agent], 0.0)
        assert tuple(way[-1]) == (*problem.goals[agent], problem.preferred_times[agent])
        speed = np.hypot(*np.diff(way[:, :2], axis=0).T) / np.diff(way[:, 2])
        assert np.allclose(speed, speed[0])


def test_a_geodesic_round_a_corner_is_taut() -> None:
    scene = families.make_scene(
        "corner",
        families.rectangle(0, 0, 10, 10),
        [families.rectangle(-1, -1, 6, 6)],
        [((8.0, 1.0), (1.0, 8.0))],
        radii=0.5,
    )
    problem = prepared(scene)
    way = geodesic_curves(problem)[0]
    assert way is not None
    length = float(np.hypot(*np.diff(way[:, :2], axis=0).T).sum())
    # Round the corner (6, 6) on an arc of the radius, straight to both ends.
    reach = np.hypot(2.0, 5.0)
    straight = np.sqrt(reach**2 - 0.25)
    between = np.arccos((2.0 * -5.0 + -5.0 * 2.0) / reach**2)
    turn = 2 * np.pi - between - 2 * np.arccos(0.5 / reach)
    shortest = 2 * straight + 0.5 * turn
    assert shortest < length < 1.03 * shortest
