"""How outer iterations end: by what falls, or by the first-order optimality."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stplan.bench import families_open as wide
from stplan.planner import Plan, plan
from stplan.scene.model import Scene


def circle(**solver: object) -> Scene:
    scene = wide.circle(4, 5.0, 12.0)
    return replace(scene, solver=replace(scene.solver, starts=1, **solver))


def planned(**solver: object) -> Plan:
    result = plan(circle(**solver))
    assert result.exit_status == 0
    return result


def iterations(result: Plan) -> int:
    assert result.report.optimisation is not None
    return sum(one.iterations for one in result.report.optimisation.outer_iterations)


def test_first_order_optimality_leads_to_the_same_plan() -> None:
    decrease, first_order = planned(), planned(convergence="first-order")
    costs = [one.report.metrics.kinetic_over_straight for one in (decrease, first_order)]
    assert costs[1] == pytest.approx(costs[0], rel=1e-3)
    assert iterations(decrease) != iterations(first_order)


@pytest.mark.parametrize("convergence", ["decrease", "first-order"])
def test_a_smaller_tolerance_goes_on_for_longer(convergence: str) -> None:
    rough, fine = (
        planned(convergence=convergence, optimality_tolerance=tolerance, step_tolerance=1e-9)
        for tolerance in (0.1, 1e-4)
    )
    assert iterations(rough) < iterations(fine)
