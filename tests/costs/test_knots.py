"""How many knots a curve has does not matter to what it costs: sums over its segments tend to integrals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from stplan.arrays import FloatArray
from stplan.costs.formulation import TermSetup
from stplan.costs.registry import build_terms
from stplan.optimize.assembly import formulate
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene
from stplan.world import build_free_space

SCENE = """
stplan: 1
horizon: 30.0
map: {rectangle: [-1.0, -1.3, 11.0, 1.9], obstacles: [{rectangle: [4.5, -1.1, 5.5, -0.75]}]}
defaults: {radius: 0.3, max_speed: 1.6, max_acceleration: 0.345, weights: {kinetic: 1.0}}
agents:
- {id: sam, start: [0, 0], goal: [10, 0], mass: 2}
- {id: ann, start: [10, 0], goal: [0, 0.5]}
- {id: joe, start: [2, 1.5], goal: [2.5, -0.9], start_time: 16}
"""
NUMBERS = (120, 240, 480, 960)


def smooth(share: FloatArray) -> FloatArray:
    """From 0 to 1, at rest at both ends."""
    result: FloatArray = share - np.sin(2.0 * np.pi * share) / (2.0 * np.pi)
    return result


def curve(
    points: Sequence[tuple[float, float]], begin: float, duration: float, segments: int
) -> FloatArray:
    """From the first to the last of three points on a parabola past the second."""
    first, middle, last = np.array(points)
    when = np.linspace(0.0, 1.0, segments + 1)
    s = smooth(when)[:, None]
    places = first + s * (last - first) + 4.0 * s * (1.0 - s) * (middle - 0.5 * (first + last))
    places[-1] = last
    return np.column_stack([places, begin + duration * when])


def costs_of(problem: PlanningProblem, segments: int) -> dict[str, float]:
    """Of three walkers that pass close to each other, to walls and to their limits."""
    curves = [
        curve([(0, 0), (5, -0.33), (10, 0)], 0.0, 14.0, segments),
        curve([(10, 0), (5, 0.28), (0, 0.5)], 0.0, 14.0, segments),
        curve([(2, 1.5), (2.5, 0.4), (2.5, -0.9)], 16.0, 7.0, 2 * segments),
    ]
    lines = WorldLines.from_curves(problem.agent_ids, curves)
    terms = build_terms(TermSetup(formulate(problem, lines), lines.knots, 1.0))
    return {term.name: term.value(lines.knots) for term in terms}


@pytest.mark.parametrize("reach", ["auto", "0.6"])
def test_barriers_tend_to_a_limit_as_knots_are_added(reach: str) -> None:
    scene = parse_scene(SCENE + f"solver: {{barrier_range: {reach}}}\n")
    problem = PlanningProblem.from_scene(scene, build_free_space(scene))
    rows = [costs_of(problem, number) for number in NUMBERS]
    barriers = ("collision", "wall", "speed limit", "acceleration limit")
    for name in ("kinetic", *barriers):
        values = np.array([row[name] for row in rows])
        assert values[-1] > 0.0, name
        change = np.abs(np.diff(values)) / values[-1]
        # An error of order 1/n halves with twice the knots.
        assert (change <= 120.0 / np.array(NUMBERS[:-1])).all(), (name, change)
        assert change[-1] <= 0.65 * change[0], (name, change)
