"""What agents pay by themselves is what the terms of the objective say, grouping included."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.analysis.own_costs import own_costs
from stplan.costs.formulation import TermSetup
from stplan.costs.registry import build_terms
from stplan.nlp.term import Capability
from stplan.optimize.assembly import formulate
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene

SCENE = """
stplan: 1
horizon: 12.0
time_scale: 1.3
defaults: {radius: 0.2}
agents:
- {id: sam, start: [0, 0], goal: [9, 0], mass: 3, preferred_time: 8, weights: {arrival: 2, kinetic: 0.5}}
- {id: ann, start: [0, 2], goal: [9, 3], weights: {acceleration: 0.7}}
- {id: eve, start: [0, 5], goal: [9, 6]}
- {id: joe, start: [0, 9], goal: [9, 9]}
pairs:
- {between: [ann, eve], grouping: 1.5}
- {between: [sam, eve], grouping: 0.5, distance: 1.0}
- {between: [sam, ann], grouping: 0.25}
"""


def lines_of(problem: PlanningProblem, rng_seed: int) -> WorldLines:
    rng = np.random.default_rng(rng_seed)
    curves = []
    for start, goal in zip(problem.starts, problem.goals, strict=True):
        share = np.linspace(0.0, 1.0, 9)[:, None]
        places = start + share * (goal - start)
        places[1:-1] += rng.normal(scale=0.2, size=(7, 2))
        curves.append(np.column_stack([places, np.cumsum(rng.uniform(0.8, 1.2, 9)) - 0.8]))
    return WorldLines.from_curves(problem.agent_ids, curves)


@pytest.mark.parametrize("rng_seed", range(3))
def test_own_costs_sum_to_what_plans_are_compared_by(rng_seed: int) -> None:
    problem = PlanningProblem.from_scene(parse_scene(SCENE), None)
    lines = lines_of(problem, rng_seed)
    terms = build_terms(TermSetup(formulate(problem, lines), lines.knots, 0.1), Capability.PRICE)
    assert {term.name for term in terms} == {"kinetic", "acceleration", "arrival", "grouping"}
    price = sum(term.value(lines.knots) for term in terms)
    assert own_costs(problem.scene, lines).sum() == pytest.approx(price, rel=1e-9)


def test_friends_pay_alike_for_what_is_between_them_and_strangers_nothing() -> None:
    friends = parse_scene(SCENE)
    strangers = parse_scene(SCENE.partition("pairs:")[0])
    lines = lines_of(PlanningProblem.from_scene(friends, None), 0)
    sam, ann, eve, joe = own_costs(friends, lines) - own_costs(strangers, lines)
    assert joe == 0.0
    assert ann + eve > sam > 0.0
