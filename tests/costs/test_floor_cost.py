"""A cost of one's own: its derivatives in any frame, what it does to plans, and that it goes again."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.api.building import AgentSpec, build_scene
from stplan.api.results import to_pandas
from stplan.arrays import FloatArray
from stplan.costs.floor_cost import FloorCost, FloorTerm
from stplan.costs.registry import added_costs
from stplan.nlp.derivatives import check_derivatives, dense
from stplan.planner import plan
from stplan.problem.planning_frame import PlanningFrame
from tests.derivatives.samples import LAYOUT, WEIGHTS, sample_knots

MIDDLE = np.array([4.0, 1.0])


def hill(points: FloatArray) -> FloatArray:
    """30 W at the middle, falling off over a metre."""
    return np.asarray(30.0 * np.exp(-0.5 * ((points - MIDDLE) ** 2).sum(axis=1)))


def slope(points: FloatArray) -> FloatArray:
    return -hill(points)[:, None] * (points - MIDDLE)


def bend(points: FloatArray) -> FloatArray:
    away = points - MIDDLE
    return np.asarray(
        hill(points)[:, None, None] * (away[:, :, None] * away[:, None, :] - np.eye(2))
    )


HILL = FloorCost("hill", hill, slope, bend)
FRAME = PlanningFrame((1.0, -2.0), 3.0, 0.8, 0.6, 1.7, 0.6, 5.0)


@pytest.mark.parametrize("frame", [PlanningFrame(), FRAME])
def test_derivatives(frame: PlanningFrame) -> None:
    term = FloorTerm(HILL, LAYOUT, WEIGHTS, frame)
    check_derivatives(term, sample_knots())
    stand_in = dense(
        term.gauss_newton_structure(),
        term.gauss_newton_hessian(sample_knots()),
        3 * LAYOUT.num_knots,
    )
    eigenvalues = np.linalg.eigvalsh(stand_in)
    assert eigenvalues[0] > -1e-9 * eigenvalues[-1]
    assert eigenvalues[-1] > 0


def test_the_cost_is_the_users_in_any_frame() -> None:
    outside = FloorTerm(HILL, LAYOUT, WEIGHTS, PlanningFrame()).value(sample_knots())
    knots = sample_knots()
    local = np.column_stack([FRAME.local_points(knots[:, :2]), FRAME.local_times(knots[:, 2])])
    inside = FloorTerm(HILL, LAYOUT, WEIGHTS, FRAME).value(local)
    assert inside * FRAME.cost == pytest.approx(outside, rel=1e-9)


def test_plans_go_around_what_costs_and_forget_it_afterwards() -> None:
    scene = build_scene(
        [AgentSpec("sam", (0, 0.9), (8, 0.9)), AgentSpec("dog", (0, 5), (8, 5))], horizon=10
    )
    before = plan(scene)
    with added_costs(FloorCost("hill", hill, slope, bend, weights={"dog": 0.0})):
        around = plan(scene)
    report = around.report.optimisation
    assert report is not None
    assert 0 < report.costs["hill"] < 30
    lowest = to_pandas(around).groupby("agent").y.min()
    assert lowest["sam"] < -0.5
    assert lowest["dog"] == pytest.approx(5.0, abs=0.05)
    assert plan(scene).report.as_dict() == before.report.as_dict()


def test_a_name_stands_for_one_cost() -> None:
    with (
        pytest.raises(ValueError, match="kinetic"),
        added_costs(FloorCost("kinetic", hill, slope, bend)),
    ):
        pass
    with pytest.raises(ValueError, match="hill"), added_costs(HILL, HILL):
        pass
