"""How near rods and walls come, against brute force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from stplan.geometry.rod_distances import rod_distance
from stplan.problem.clearance import crosses_boundary, rod_clearances, wall_clearance
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import requirement
from stplan.problem.verification import verify
from stplan.scene.model import PairRule, Weights
from stplan.seeding.elastic_bands.band_neighbours import Bodies, near_rows
from stplan.seeding.shortcutting.rod_field import build_field, segment_clear
from tests.geometry.points import apart_squared
from tests.problem.samples import brute_distance, random_curve, random_problem, room
from tests.seeding.families import agent, scene


def test_rod_distance_equals_all_pairs_of_segments() -> None:
    rng = np.random.default_rng(0)
    for _ in range(100):
        first, second = random_curve(rng, 6), random_curve(rng, 9)
        second[:, 2] += rng.uniform(-15.0, 15.0)
        expected = brute_distance(first, second)
        assert rod_distance(first, second, 50.0) == pytest.approx(expected)
        assert rod_distance(first, second, 1.0) == pytest.approx(min(expected, 1.0))


def test_rod_clearances_find_every_near_pair() -> None:
    rng = np.random.default_rng(1)
    problem, curves = random_problem(rng, 12)
    found = rod_clearances(problem, curves, reach=3.0)
    near = {(a, b): gap for (a, b), gap in zip(found.pairs.tolist(), found.distance, strict=True)}
    ratios = []
    for a in range(12):
        for b in range(a + 1, 12):
            gap = brute_distance(problem.rod(a, curves[a]), problem.rod(b, curves[b]))
            ratios.append(gap / problem.distance[a, b])
            assert ((a, b) in near) == (gap < 3.0 * problem.distance[a, b])
            if (a, b) in near:
                assert near[a, b] == pytest.approx(gap)
                assert ((a, b) in [pair[:2] for pair in found.violations]) == (ratios[-1] <= 1)
    nearest = found.distance / problem.distance[tuple(found.pairs.T)]
    assert nearest.min() == pytest.approx(min(ratios))
    assert len(near) > 3


def test_near_rows_hold_every_near_segment() -> None:
    rng = np.random.default_rng(2)
    points = rng.uniform(0.0, 12.0, (80, 3))
    points[1::2] = points[::2] + rng.normal(size=(40, 3)) * rng.choice([0.3, 2.0, 8.0], (40, 1))
    segments = np.arange(80).reshape(-1, 2)
    agents = np.arange(40) // 2
    collides = rng.random((20, 20)) < 0.7
    collides &= collides.T
    np.fill_diagonal(collides, False)
    reach = rng.uniform(0.5, 2.0, (20, 20))
    reach = (reach + reach.T) / 2
    movable = agents != 3
    for cell in (0.1, 1.0, 30.0):
        near = near_rows(Bodies(points, segments, agents, movable), collides, reach, cell)
        for i in range(40):
            a = agents[i]
            expected = {
                j
                for j in range(40)
                if movable[i]
                and collides[a, agents[j]]
                and apart_squared(*points[segments[i]], *points[segments[j]])
                < reach[a, agents[j]] ** 2
            }
            assert sorted(expected) == sorted(
                near.members[near.rows[i] : near.rows[i + 1]].tolist()
            )


def test_walls_are_met_on_segments_and_only_by_those_who_heed_them() -> None:
    pillar = shapely.box(4, 4.9, 6, 5.1)
    heeding = agent("a", (1, 5), (9, 5))
    ghost = replace(heeding, id="g", weights=Weights(wall=0.0, collision=0.0))
    rule = PairRule((0,), (1,), collide=False)
    problem = PlanningProblem.from_scene(scene([heeding, ghost], pairs=(rule,)), room(pillar))
    straight = np.array([[1, 5, 0], [9, 5, 20.0]])
    around = np.array([[1, 5, 0], [5, 6, 10], [9, 5, 20.0]])
    detour = np.array([[1, 5, 0], [3, 6, 5], [7, 6, 15], [9, 5, 20.0]])
    assert crosses_boundary(problem, 0, straight)
    assert not crosses_boundary(problem, 1, straight)
    assert not crosses_boundary(problem, 0, around)
    walls = room(pillar).boundary
    for curve in (around, detour):
        expected = shapely.LineString(curve[:, :2]).distance(walls)
        assert wall_clearance(problem, 0, curve) == pytest.approx(expected)
    assert wall_clearance(problem, 1, straight) == np.inf
    assert len(verify(problem, [straight, straight])) == 1
    assert verify(problem, [detour, straight]) == []


def test_the_index_answers_like_brute_force() -> None:
    rng = np.random.default_rng(5)
    problem, curves = random_problem(rng, 10)
    wanted = requirement(problem, 1.1)
    field = build_field(problem, curves, wanted)
    answers = []
    for _ in range(400):
        a = int(rng.integers(10))
        ends = np.column_stack([rng.uniform(-2, 12, (2, 2)), np.sort(rng.uniform(0, 25, 2))])
        ends[1] = ends[0] + (ends[1] - ends[0]) * [1, 1, 1] * rng.choice([0.1, 1.0])
        ends[:, 2] *= problem.time_scale
        clear = all(
            brute_distance(ends, problem.rod(b, curves[b])) > wanted.rods[a, b]
            for b in range(10)
            if b != a
        )
        answers.append(clear)
        assert segment_clear(field, a, ends[0], ends[1]) == clear
    assert 50 < sum(answers) < 350


def test_the_index_answers_like_brute_force_at_walls() -> None:
    rng = np.random.default_rng(6)
    space = room(shapely.Point(5, 5).buffer(2.0), shapely.box(1, 1, 3, 1.2))
    problem = PlanningProblem.from_scene(scene([agent("a", (1, 9), (9, 9), radius=0.3)]), space)
    field = build_field(problem, [np.array([[1, 9, 0], [9, 9, 20.0]])], requirement(problem, 1.0))
    for _ in range(300):
        ends = np.column_stack([rng.uniform(0, 10, (2, 2)), [0.0, 20.0]])
        gap = shapely.LineString(ends[:, :2]).distance(space.boundary)
        assert segment_clear(field, 0, ends[0], ends[1]) == (gap > 0.3)
