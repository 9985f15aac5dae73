"""An optimisation keeps the homotopy class of its seed, even where a better one is a thin rod away."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.costs.terms.collision import Collision
from stplan.costs.terms.wall import Wall
from stplan.optimize.continuation import optimise
from stplan.problem.planning_problem import prepare
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene

TIMES = np.linspace(0.0, 10.0, 11)
ALONG = np.linspace(-4.0, 4.0, 11)
# Sideways at the middle of the way, nowhere at its ends.
BUMP = np.where(np.abs(ALONG) < 4.0, np.exp(-((ALONG / 1.5) ** 2)), 0.0)


def passed_on_the_wrong_side(radius: float) -> float:
    """By how much the second of two thin agents is left of the first when they meet, m.

    It is in the seed, although its start and goal are on the right: both swing over to where the other is.
    """
    scene = parse_scene(
        "stplan: 1\nhorizon: 10\nagents:\n"
        f"  - {{id: a, start: [-4, 0.1], goal: [4, 0.1], radius: {radius}}}\n"
        f"  - {{id: b, start: [4, -0.1], goal: [-4, -0.1], radius: {radius}}}\n"
    )
    first = np.column_stack([ALONG, 0.1 - BUMP, TIMES])
    second = np.column_stack([-ALONG, BUMP - 0.1, TIMES])
    return left(optimised(scene, first, second))


def left(lines: WorldLines) -> float:
    times = np.linspace(0.0, 10.0, 2001)
    first, second = (
        np.column_stack([np.interp(times, curve[:, 2], curve[:, x]) for x in range(2)])
        for curve in lines.curves()
    )
    gap = second - first
    return float(gap[np.hypot(*gap.T).argmin(), 1])


def passed_behind_a_thin_pillar(radius: float) -> float:
    """By how much an agent's way lies above the foot of a pillar that stands beside its straight way, m."""
    scene = parse_scene(
        "stplan: 1\nhorizon: 10\n"
        "map: {rectangle: [-6, -6, 6, 6], obstacles: [{rectangle: [-0.02, 0.2, 0.02, 0.3]}]}\n"
        f"agents: [{{id: a, start: [-4, 0], goal: [4, 0], radius: {radius}}}]\n"
    )
    curve = optimised(scene, np.column_stack([ALONG, BUMP, TIMES])).curve(0)
    return float(np.interp(0.0, curve[:, 0], curve[:, 1])) - 0.2


def optimised(scene, *curves) -> WorldLines:
    problem = prepare(scene)
    seed = WorldLines.from_curves(problem.agent_ids, curves)
    outcome = optimise(problem, seed, progress=lambda line: None, stop=lambda: False)
    assert outcome.status == "converged"
    return outcome.world_lines


@pytest.mark.parametrize("radius", [0.3, 0.03, 0.01])
def test_thin_rods_do_not_jump_through_each_other(radius: float) -> None:
    assert passed_on_the_wrong_side(radius) >= 2.0 * radius


@pytest.mark.parametrize("radius", [0.1, 0.01])
def test_thin_rods_do_not_jump_through_thin_walls(radius: float) -> None:
    assert passed_behind_a_thin_pillar(radius) >= 0.1 + 0.99 * radius


def test_without_asking_for_the_way_there_they_would(monkeypatch: pytest.MonkeyPatch) -> None:
    for term in (Collision, Wall):
        monkeypatch.setattr(term, "allows_step", lambda self, start, end: True)
    assert passed_on_the_wrong_side(0.01) < 0
    assert passed_behind_a_thin_pillar(0.01) < 0
