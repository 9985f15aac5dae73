"""How soon agents can be through a gate: never later than any way of passing it that keeps discs apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.analysis.arrival_bound import arrival_bound
from stplan.analysis.capacity import passings
from stplan.analysis.shortest_trips import shortest_legs
from stplan.certify.certificate import certify
from stplan.planner import plan
from stplan.problem.planning_problem import prepare
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene

HEAD = """\
stplan: 1
horizon: 60.0
map:
  rectangle: [-20, -4, 20, 4]
  obstacles: [{{rectangle: [-0.001, -4, 0.001, -{half}]}}, {{rectangle: [-0.001, {half}, 0.001, 4]}}]
defaults: {{radius: 0.2, max_speed: 1.3, after_arrival: vanish}}
solver: {{knots: 20, effort: quick, starts: 1}}
agents:
"""


def block(columns: int, rows: int, half: float):
    """The densest block of discs, which moves through a gate as it is, as a scene and a plan."""
    apart = 0.4002
    lines = []
    curves = []
    for c in range(columns):
        for r in range(rows):
            x = -1.0 - apart * np.sqrt(0.75) * c
            y = apart * (r - 0.5 * (rows - 1) + (0.25 if c % 2 else -0.25))
            lines.append(
                f"  - {{id: a{c}-{r}, start: [{x}, {y}], goal: [{1.0 + 0.01 * c}, {y}], max_speed: 1.3}}"
            )
            end = (1.0 + 0.01 * c - x) / 1.3 * (1.0 + 1e-9)
            curves.append(np.array([[x, y, 0.0], [1.0 + 0.01 * c, y, end]]))
    scene = parse_scene(HEAD.format(half=half) + "\n".join(lines) + "\n")
    return scene, WorldLines.from_curves([agent.id for agent in scene.agents], curves)


@pytest.mark.parametrize(("rows", "half"), [(1, 0.31), (2, 0.51), (3, 0.71), (5, 1.11)])
def test_the_densest_block_of_discs_is_not_refuted(rows, half):
    scene, lines = block(12, rows, half)
    problem = prepare(scene)
    assert certify(problem.scene, problem.free_space, lines).holds
    (passing,) = passings(problem, shortest_legs(problem))
    assert len(passing.agents) == 12 * rows
    starts = np.array([agent.start for agent in scene.agents])
    passed = np.sort(-starts[:, 0] / 1.3)
    assert np.all(passing.passages <= passed)
    arrivals = np.array([curve[-1, 2] for curve in lines.curves()])
    assert passing.total <= arrivals.sum()
    assert passing.makespan <= arrivals.max()


def dropped(rng: np.random.Generator, count: int, half: float):
    """Discs of several radii behind a gate, each as near behind those before it as its height lets it be."""
    placed: list[tuple[float, float, float]] = []
    for radius in rng.uniform(0.12, 0.25, count).tolist():
        y = rng.uniform(radius - half + 0.001, half - radius - 0.001)
        x = -1.0
        for other_x, other_y, other in placed:
            apart = 1.0002 * (radius + other)
            if abs(y - other_y) < apart:
                x = min(x, other_x - np.sqrt(apart**2 - (y - other_y) ** 2))
        placed.append((x, y, radius))
    return placed


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("half", [0.3, 0.6, 1.0])
def test_no_random_crowd_that_moves_through_a_gate_beats_the_bound(seed, half):
    rng = np.random.default_rng(seed)
    rows, curves = [], []
    for k, (x, y, radius) in enumerate(dropped(rng, 30, half)):
        speed = 1.3 if k % 2 else 1.6
        rows.append(
            f"  - {{id: a{k}, start: [{x}, {y}], goal: [1, {y}], radius: {radius}, max_speed: {speed}}}"
        )
        curves.append(np.array([[x, y, 0.0], [1.0, y, (1.0 - x) / 1.3 * (1.0 + 1e-9)]]))
    scene = parse_scene(HEAD.format(half=half) + "\n".join(rows) + "\n")
    problem = prepare(scene)
    lines = WorldLines.from_curves([agent.id for agent in scene.agents], curves)
    assert certify(problem.scene, problem.free_space, lines).holds
    starts = np.array([agent.start for agent in scene.agents])
    for passing in passings(problem, shortest_legs(problem)):
        passed = np.sort(-starts[passing.agents, 0] / 1.3)
        assert np.all(passing.passages <= passed)


def test_discs_just_past_a_gate_lack_no_more_than_its_width_says():
    rng = np.random.default_rng(5)
    tightest = 0.0
    for _ in range(300):
        radii = rng.uniform(0.2, 1.0, rng.integers(1, 7))
        beyond = radii * rng.choice([0.0, 1.0], len(radii)) * rng.uniform(0.0, 1.0, len(radii))
        half_chords = np.sqrt(radii**2 - beyond**2)
        steps = np.sqrt((radii[1:] + radii[:-1]) ** 2 - np.diff(beyond) ** 2)
        width = half_chords[0] + steps.sum() + half_chords[-1]
        lacking = 2.0 * (np.arccos(beyond / radii) - beyond / radii**2 * half_chords) / np.pi
        share = float((radii * lacking).sum() / (0.5 * width))
        assert share <= 1.0 + 1e-12
        tightest = max(tightest, share)
    assert tightest > 0.99


def test_a_crowd_at_a_door_is_bounded_by_its_width():
    rng = np.random.default_rng(0)
    grid = [(-2.0 - 0.5 * (k // 12), -3.0 + 0.5 * (k % 12)) for k in range(60)]
    rows = [
        f"  - {{id: a{k}, start: [{x}, {y}], goal: [{4.0 + 0.5 * (k // 12)}, {y}]}}"
        for k, (x, y) in enumerate(rng.permutation(grid).tolist())
    ]
    bounds = {}
    for half in (0.25, 0.6, 1.2):
        scene = parse_scene(HEAD.format(half=half) + "\n".join(rows) + "\n")
        bounds[half] = arrival_bound(prepare(scene))
    assert bounds[0.25].makespan > bounds[0.6].makespan > bounds[1.2].makespan
    for bound in bounds.values():
        assert bound.makespan >= bound.earliest.max()
        assert bound.total >= bound.earliest.sum()
    assert bounds[0.6].total > 1.05 * bounds[0.6].earliest.sum()


@pytest.mark.parametrize("goal", ["[3, {y}]", "{{rectangle: [2, -3, 4, 3]}}"])
def test_hurried_plans_through_a_door_do_not_beat_the_bound(goal):
    rows = [
        f"  - {{id: a{k}, start: [-2, {y}], goal: {goal.format(y=y)}, preferred_time: 1, "
        "weights: {arrival: 20}}"
        for k, y in enumerate([-1.5, -0.5, 0.5, 1.5])
    ]
    scene = parse_scene(HEAD.format(half=0.22).replace("60.0", "20.0") + "\n".join(rows) + "\n")
    found = plan(scene)
    assert found.certificate.holds
    arrivals = np.array([curve[-1, 2] for curve in found.trajectories.curves()])
    problem = prepare(scene)
    bound = arrival_bound(problem)
    assert bound.makespan <= arrivals.max()
    assert bound.earliest.sum() < bound.total <= arrivals.sum()
    slow = replace(
        scene, agents=tuple(replace(agent, max_speed=0.25 * 1.3) for agent in scene.agents)
    )
    assert arrival_bound(prepare(slow)).total > arrivals.sum()


def test_those_without_a_limit_of_speed_have_no_capacity():
    scene, _ = block(3, 1, 0.31)
    free = replace(scene, agents=tuple(replace(agent, max_speed=None) for agent in scene.agents))
    problem = prepare(free)
    assert passings(problem, shortest_legs(problem)) == []
