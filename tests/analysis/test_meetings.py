"""What a meeting costs at least: never more than any plan with one, and nearly what the best one does."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.analysis.cost_bound import least_costs
from stplan.analysis.meetings import meeting_bound
from stplan.planner import plan, prepare
from stplan.scene import parse_scene

SCENE = """\
stplan: 1
horizon: 20
defaults: {radius: 0.2}
solver: {knots: 20, starts: 1}
agents:
  - {id: a, start: [-4, 6], goal: [-4, -6], MORE_A}
  - {id: b, start: [4, 6], goal: [4, -6], MORE_B}
pairs:
  - {between: [a, b], meet: {within: WITHIN}}
"""
LATE = "preferred_time: 12, weights: {arrival: 2}"


def scene(more_a: str = "mass: 1", more_b: str = "mass: 1", within: float = 1.0):
    text = SCENE.replace("MORE_A", more_a).replace("MORE_B", more_b)
    return parse_scene(text.replace("WITHIN", str(within)))


def bound(found) -> float | None:
    problem = prepare(found)
    one = problem.meetings[0]
    value = meeting_bound(problem, one.first, one.second, one.meet.within)
    return None if value is None else value * problem.frame.cost


def test_of_two_alike_who_do_not_mind_when_they_arrive_it_is_exact():
    """Both walk the sides of a triangle of height 3.5 over half of 12 m, at an even pace."""
    length = 2.0 * np.hypot(6.0, 3.5)
    assert bound(scene()) == pytest.approx(length**2 / 20.0, rel=1e-6)


@pytest.mark.parametrize("mass", [1, 3])
@pytest.mark.parametrize("more", ["max_time: 15", LATE])
def test_plans_pay_little_more(mass, more):
    found = plan(scene(more, f"mass: {mass}"))
    assert found.certificate.holds
    cost = found.report.bound.cost
    assert 0.94 * cost < found.report.bound.total <= cost
    assert found.report.bound.together[0].kind == "meeting"
    assert found.report.bound.least.sum() < 0.9 * cost


@pytest.mark.parametrize("seed", range(20))
def test_no_way_with_a_meeting_costs_less(seed):
    """Random meeting places and durations of either agent."""
    rng = np.random.default_rng(seed)
    within = float(rng.uniform(0.5, 3.0))
    mass, weight, aim = rng.uniform(0.5, 3.0), rng.uniform(0.1, 5.0), rng.uniform(3.0, 25.0)
    more = f"mass: {mass}, preferred_time: {min(aim, 20.0)}, weights: {{arrival: {weight}}}"
    least = bound(scene(more_b=more, within=within))
    middle = rng.uniform(-1.0, 1.0, (500, 2)) * [4.0, 3.0]
    angle = rng.uniform(0.0, 2.0 * np.pi, 500)
    aside = 0.5 * within * np.column_stack([np.cos(angle), np.sin(angle)])
    costs = 0.0
    for x, place, kg, arrival in (
        (-4.0, middle + aside, 1.0, 0.0),
        (4.0, middle - aside, mass, weight),
    ):
        length = sum(np.hypot(*(place - [x, y]).T) for y in (6.0, -6.0))
        duration = np.full(500, 20.0) if arrival == 0.0 else rng.uniform(1.0, 20.0, 500)
        costs = costs + 0.5 * kg * length**2 / duration
        costs = costs + 0.5 * arrival * (duration - min(aim, 20.0)) ** 2
    assert least <= costs.min()


def test_who_comes_near_enough_anyway_pays_nothing_more():
    problem = prepare(scene(within=9.0))
    assert bound(scene(within=9.0)) <= least_costs(problem).sum() * problem.frame.cost * (1 + 1e-6)


@pytest.mark.parametrize("more", ["waypoints: [[-4, 1]]", "weights: {kinetic: 0}"])
def test_of_others_nothing_is_known(more):
    assert bound(scene(more)) is None
