"""How the work of an iteration grows, counted, and what repulsive curves do with the same agents."""

from __future__ import annotations

import pytest

from stplan.bench import paper, repulsion
from stplan.bench.scaling import growth
from stplan.bench.solves import run, with_solver
from tests.claims.plans import SCENES, planned

PLOTS = {plot.name: plot for plot in paper.PLOTS}


def _contacts(plot: str, way: str, sizes: tuple[int, ...]) -> float:
    """Exponent of the contacts that are listed over the size."""
    counted = [paper.count_contacts(PLOTS[plot].scene(size, 0))[way] for size in sizes]
    return growth(list(map(float, sizes)), list(map(float, counted)))


def _entries(plot: str, sizes: tuple[int, ...]) -> float:
    """Exponent of the entries of the default's Hessian over the size."""
    counted = []
    for size in sizes:
        one = with_solver(PLOTS[plot].scene(size, 0), outer_iterations=1, max_iterations=1)
        counted.append(float(run(one)[0].hessian_nonzeros))
    return growth(list(map(float, sizes)), counted)


@pytest.mark.claims
def test_work_grows_with_agents_and_not_with_their_pairs(claim):
    """With a broad phase "the performance is linear" in the agents; without one "quadratic"."""
    sizes = (8, 16, 32)
    claim("crossing flows", "exponent of listed contacts over agents",
          _contacts("paper-agents", "default", sizes), at_most=1.4)  # fmt: skip
    claim("crossing flows", "exponent of entries of the Hessian over agents",
          _entries("paper-agents", sizes), at_most=1.4)  # fmt: skip
    claim("crossing flows", "exponent of listed contacts over agents, all pairs",
          _contacts("paper-agents", "all pairs", (8, 16)), at_least=1.8)  # fmt: skip


def test_work_grows_with_knots_and_not_with_their_pairs(claim):
    """Over nodes it is "very nearly linear with broad phase", and without "quadratic"."""
    sizes = (30, 60, 120)
    claim("circle of 8", "exponent of entries of the Hessian over knots",
          _entries("paper-knots", sizes), at_most=1.4)  # fmt: skip
    claim("circle of 8", "exponent of listed contacts over knots, all pairs",
          _contacts("paper-knots", "all pairs", sizes), at_least=1.9)  # fmt: skip


@pytest.mark.claims
def test_finer_walls_make_no_larger_problem(claim):
    """Over the boundary's edges, too, performance is "nearly linear"."""
    sizes = (840, 3360)
    claim("maze", "exponent of entries of the Hessian over wall edges", _entries("paper-walls", sizes),
          at_most=0.1)  # fmt: skip
    claim("maze", "exponent of listed contacts over wall edges",
          _contacts("paper-walls", "default", sizes), at_most=1.0)  # fmt: skip


def test_repulsive_curves_spread_as_far_as_they_may(claim):
    """Repulsive curves "maximally repel agents" where ours keep to what costs least."""
    files = {"three-agents/symmetric": SCENES / "three-agents" / "symmetric.yaml"}
    ours, theirs = repulsion.measure(files, (1.1,), progress=lambda line: None)
    name = planned("three-agents/symmetric").scene.name
    claim(name, "our paths over straight", ours.length, at_most=1.01)
    claim(
        name,
        "repulsive curves' paths over straight, rods 10 % longer",
        theirs.length,
        at_least=1.05,
    )
    claim(
        name,
        "repulsive curves' kinetic energy over ours",
        theirs.energy / ours.energy,
        at_least=1.1,
    )
    claim(name, "their mean nearest distance over ours", theirs.mean / ours.mean, at_least=1.5)
