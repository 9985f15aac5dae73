"""A second backend finds what Ipopt finds: costs and outer loop know neither."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stplan.arrays import FloatArray
from stplan.certify.certificate import certify
from stplan.errors import SolverError
from stplan.nlp.backend import Backend
from stplan.optimize.continuation import Optimisation, optimise
from stplan.planner import find_initial_curves
from stplan.problem.planning_problem import prepare
from stplan.scene import load_scene, parse_scene
from stplan.scene.model import Scene
from stplan.status import Status
from tests.nlp.dense_newton import DenseNewton

TWO_AGENTS = Path(__file__).parents[2] / "scenes" / "circle" / "circle-2.yaml"
AROUND_A_PILLAR = """
stplan: 1
horizon: 12
map: {rectangle: [-1, -1.5, 9, 1.5], obstacles: [{rectangle: [3.6, -0.2, 4.4, 0.2]}]}
agents:
  - {id: a, start: [0, 0], goal: [8, 0.1]}
  - {id: b, start: [8, 0], goal: [0, -0.1], mass: 2.0}
solver: {outer_iterations: 3}
"""
# Both minimise to the end, Ipopt's own barrier on the latest arrivals included.
THOROUGH = {"step_tolerance": 1e-12, "optimality_tolerance": 1e-9, "ipopt": {"tol": 1e-11}}


def scenes() -> dict[str, Scene]:
    return {"two agents": load_scene(TWO_AGENTS), "a pillar": parse_scene(AROUND_A_PILLAR)}


def solved(
    scene: Scene, backend: Backend | None, **solver: object
) -> tuple[Optimisation, list[FloatArray]]:
    """The optimisation of the scene's own seed, and all its iterates; they are clear."""
    scene = replace(scene, solver=replace(scene.solver, **solver))
    problem = prepare(scene)
    (initial,) = find_initial_curves(problem)
    seed = initial.seed.world_lines
    iterates: list[FloatArray] = []
    found = optimise(
        problem, seed, progress=lambda line: None, stop=lambda: False,
        observe=lambda knots, terms: iterates.append(knots.copy()), backend=backend,
    )  # fmt: skip
    written = problem.written
    for knots in iterates:
        lines = written.outside(seed.with_knots(knots))
        assert certify(scene, written.free_space, lines).holds
    return found, iterates


@pytest.mark.parametrize(
    ("name", "hessian"),
    # By exact Hessians steps differ so much that a pillar's two solvers end in different minima.
    [("two agents", "gauss-newton"), ("two agents", "exact"), ("a pillar", "gauss-newton")],
)
def test_a_dense_newton_method_ends_where_ipopt_does(name: str, hessian: str) -> None:
    scene = scenes()[name]
    expected, _ = solved(scene, None, hessian=hessian, **THOROUGH)
    found, iterates = solved(scene, DenseNewton(), hessian=hessian, **THOROUGH)
    assert found.status is expected.status is Status.CONVERGED
    assert [done.mu for done in found.outer_iterations] == [
        done.mu for done in expected.outer_iterations
    ]
    assert len(iterates) > found.iterations > 10
    assert sum(found.costs.values()) == pytest.approx(sum(expected.costs.values()), rel=1e-7)
    for term, cost in expected.costs.items():
        assert found.costs[term] == pytest.approx(cost, rel=1e-6, abs=1e-9), term
    assert found.world_lines.knots == pytest.approx(expected.world_lines.knots, abs=1e-3)
    assert sum(found.costs.values()) < sum(found.seed_costs.values())


def test_with_the_scene_as_it_is_shipped_costs_agree_as_far_as_runs_are_ended() -> None:
    expected, _ = solved(load_scene(TWO_AGENTS), None)
    found, _ = solved(load_scene(TWO_AGENTS), DenseNewton())
    assert found.status is expected.status is Status.CONVERGED
    assert sum(found.costs.values()) == pytest.approx(sum(expected.costs.values()), rel=1e-6)


def test_it_says_why_it_ends_in_words_of_its_own_outer_loop() -> None:
    scene = scenes()["a pillar"]
    found, _ = solved(scene, DenseNewton(), max_iterations=1)
    assert [done.status for done in found.outer_iterations] == [Status.LIMIT] * 3
    assert found.iterations == 3
    costs = [found.seed_costs, found.costs]
    assert np.diff([one["kinetic"] + one["wall"] for one in costs]) < 0


def test_it_refuses_what_it_cannot_do() -> None:
    scene = scenes()["a pillar"]
    irregular = replace(
        scene,
        agents=tuple(
            replace(agent, weights=replace(agent.weights, regularity=0.0)) for agent in scene.agents
        ),
    )
    with pytest.raises(SolverError, match="linear constraints"):
        solved(irregular, DenseNewton())
