"""Smoothness, choice of ways, and what the barrier's weight does."""

from __future__ import annotations

from itertools import pairwise

import pytest

from stplan.analysis.metrics import turning
from tests.claims.plans import curves, path_length, planned

QUICK = ("roomba/roomba", "subway/platform", "subway/platform-tight")
SLOW = ("mazes/corn", "mazes/rings", "aircraft/first-class", "circle/circle-35", "tight/cabin")


@pytest.mark.parametrize(
    "name", [*QUICK, *(pytest.param(name, marks=pytest.mark.claims) for name in SLOW)]
)
def test_optimisation_smooths_the_initial_curves(name, claim):
    """Kinks and sharp turns of the initial paths "get smoothed out during the optimization"."""
    result = planned(name)
    scale = result.scene.time_scale
    assert result.trajectories is not None
    seed, end = (
        sum(turning(curve, scale) for curve in lines.curves())
        for lines in (result.seed, result.trajectories)
    )
    claim(result.scene.name, f"turning cost over the seed's {seed:.2f}", end / seed, at_most=0.9)
    after, before = (
        part.metrics.kinetic_over_straight for part in (result.report, result.report.seed)
    )
    assert after is not None
    assert before is not None
    claim(result.scene.name, "kinetic energy over the seed's", after / before, at_most=1.05)


def test_clearance_grows_with_mu(claim):
    """Collisions are ever more penalised near contact: the barrier's weight sets the distance kept."""
    gaps = []
    for mu in (0.001, 0.01, 0.1, 1.0):
        settings = (f"solver.mu={mu}", "solver.outer_iterations=1")
        spot = planned("three-agents/symmetric", *settings).certificate.smallest
        assert spot is not None
        gaps.append(spot.clearance)
    growth = min(after / before for before, after in pairwise(gaps))
    claim("three-agents-symmetric", "growth of clearance for ten times mu, least of three", growth,
          at_least=1.2)  # fmt: skip


def test_the_shorter_way_is_chosen(claim):
    """Agents "explore routes when multiple paths are available and choose the most optimal"."""
    longest = max(
        path_length(own) / path_length(planned("roomba/roomba").seed.curve(a))
        for a, own in enumerate(curves("roomba/roomba").values())
    )
    claim("roomba", "path over that of the initial curve", longest, at_most=1.0)
