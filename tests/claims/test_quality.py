"""Smoothness, choice of ways, and what the barrier's weight does."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import trimesh

from stplan import load_scene
from stplan.analysis.metrics import turning
from stplan.analysis.own_costs import own_costs
from stplan.bench import quality
from stplan.bench.ledger import read_ledger
from stplan.planner import plan
from stplan.problem.kinetic_cost import total_kinetic_cost
from stplan.scene import parse_scene
from tests.claims.plans import SCENES, path_length, planned, raw_seed

LEDGER = read_ledger(SCENES.parent / "docs" / "ledger.csv")
# What plans of some scenes cost over the best ones known, where that is more than a fiftieth: the shipped
# setting of the tight subway takes the first way found; in car parks and at doors more improvement pays.
DEARER = {"subway/platform-tight": 1.17, "tight/parking-lot": 1.11, "tight/door": 1.05}
SMALL = ("comparison/lane", "tight/pocket-swap", "tight/plus-crossing", "tunnel/tunnel")

QUICK = ("roomba/roomba", "subway/platform-tight")
SLOW = (
    "subway/platform",
    "mazes/corn",
    "mazes/rings",
    "aircraft/first-class",
    "circle/circle-35",
    "tight/cabin",
)


@pytest.mark.parametrize(
    "name", [*QUICK, *(pytest.param(name, marks=pytest.mark.claims) for name in SLOW)]
)
def test_optimisation_smooths_the_initial_curves(name, claim):
    """Kinks and sharp turns of the initial paths "get smoothed out during the optimization"."""
    result = planned(name)
    scale = result.scene.time_scale
    assert result.trajectories is not None
    raw = raw_seed(name)
    seed, end = (
        sum(turning(curve, scale) for curve in lines.curves())
        for lines in (raw, result.trajectories)
    )
    claim(result.scene.name, f"turning cost over {seed:.3g} of the raw initial curves", end / seed,
          at_most=0.5)  # fmt: skip
    masses = np.array([agent.mass for agent in result.scene.agents])
    before, after = (
        total_kinetic_cost(masses, list(lines.curves())) for lines in (raw, result.trajectories)
    )
    claim(result.scene.name, "kinetic energy over that of the raw initial curves", after / before,
          at_most=1.0)  # fmt: skip


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


ISLAND = """
stplan: 1
horizon: 30
map: {{rectangle: [0, 0, 12, 6], obstacles: [{{rectangle: [3, 1.2, 9, 4]}}]}}
defaults: {{radius: 0.4, after_arrival: stay}}
agents:
  - {{id: walker, start: [1, 2], goal: [11, 2]}}
{stander}
"""


def _length_around(stander: str) -> float:
    result = plan(parse_scene(ISLAND.format(stander=stander)))
    assert result.trajectories is not None
    return path_length(result.trajectories.curve(0))


def test_the_best_of_two_ways_is_chosen(claim):
    """Agents "explore routes when multiple paths are available and choose the most optimal"."""
    below, above = (
        path_length(np.array(corners))
        for corners in (
            [(1, 2), (2.72, 0.92), (3, 0.8), (9, 0.8), (9.28, 0.92), (11, 2)],
            [(1, 2), (2.62, 4.14), (3, 4.4), (9, 4.4), (9.38, 4.14), (11, 2)],
        )
    )
    claim("island", "path over that of the shorter way", _length_around("") / below, at_most=1.01)
    # Somebody stands in the shorter way for good: it is no way any more.
    blocked = _length_around("  - {id: stander, start: [6, 0.6], goal: [6, 0.6]}")
    claim("island", "path over that of the longer way, the shorter one blocked", blocked / above,
          at_most=1.01)  # fmt: skip


def test_the_first_choice_is_given_up_where_it_is_wrong(claim):
    """Agents "choose the most optimal" way with the others in it, not the one that is shortest alone."""
    heavy = (
        "  - {id: slow, start: [11, 0.6], goal: [1, 0.6], mass: 200, radius: 0.5}\n"
        "  - {id: slower, start: [9.5, 0.6], goal: [2.2, 0.6], mass: 200, radius: 0.5}"
    )
    assert _length_around("") < 11.0
    claim("island", "path against two heavy ones in the shorter way, m", _length_around(heavy),
          at_least=11.5, at_most=13.5)  # fmt: skip


@pytest.mark.parametrize("knots", [40, 80, 160])
def test_knots_do_not_matter(knots, claim):
    """More degrees of freedom give "no additional benefit to the quality"."""
    few, many = (
        planned(
            "three-agents/symmetric", f"solver.knots={count}"
        ).report.metrics.kinetic_over_straight
        for count in (30, knots)
    )
    assert few is not None
    assert many is not None
    claim("three-agents-symmetric", f"change of cost from 30 to {knots} knots", abs(many / few - 1.0),
          at_most=0.005)  # fmt: skip


def test_the_coarseness_of_the_mesh_does_not_matter(tmp_path, claim):
    """The "coarseness of the map mesh does not impact the smoothness of agent path"."""
    mesh = trimesh.load_mesh(SCENES / "bottleneck" / "gap.obj")
    mesh.subdivide().subdivide().export(tmp_path / "gap.obj")
    (tmp_path / "fine.yaml").write_text((SCENES / "bottleneck" / "bottleneck.yaml").read_text())
    fine = plan(load_scene(tmp_path / "fine.yaml"))
    coarse = planned("bottleneck/bottleneck")
    costs = [own_costs(one.scene, one.trajectories or one.seed).sum() for one in (coarse, fine)]
    claim("bottleneck", "change of cost with triangles a sixteenth as large",
          abs(costs[1] / costs[0] - 1.0), at_most=0.002)  # fmt: skip


def test_the_coarseness_of_the_mesh_hardly_matters_to_the_papers_own_recipe(tmp_path, claim):
    """The "coarseness of the map mesh does not impact" paths that began on its edges, either."""
    scene = (SCENES / "bottleneck" / "bottleneck.yaml").read_text()
    mesh = trimesh.load_mesh(SCENES / "bottleneck" / "gap.obj")
    mesh.subdivide().subdivide().export(tmp_path / "gap.obj")
    (tmp_path / "fine.yaml").write_text(scene)
    fine = plan(load_scene(tmp_path / "fine.yaml", overrides=["preset=paper"]))
    coarse = planned("bottleneck/bottleneck", "preset=paper")
    costs = [own_costs(one.scene, one.trajectories or one.seed).sum() for one in (coarse, fine)]
    claim(
        "bottleneck", "the same by the paper's recipe", abs(costs[1] / costs[0] - 1.0), at_most=0.02
    )


@pytest.mark.parametrize(
    "name",
    [
        name if name in SMALL else pytest.param(name, marks=pytest.mark.claims)
        for name in quality.FULL_SCENES
    ],
)
def test_plans_cost_little_more_than_the_best_ones_known(name, claim):
    """Plans are near the best ones that anything has led to.

    The ledger has the best ones, by scene; a run that beats it is recorded by `stplan bench quality`.
    """
    result = planned(name)
    lines = result.trajectories or result.seed
    cost = float(own_costs(result.scene, lines).sum())
    claim(result.scene.name, "cost over the least one known", cost / LEDGER[name].cost,
          at_most=DEARER.get(name, 1.02))  # fmt: skip
