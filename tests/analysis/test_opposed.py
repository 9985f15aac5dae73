"""What two opposed agents pay in a lane that fits one: no motion that keeps them apart pays less."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.analysis import joint_bounds
from stplan.analysis.cost_bound import cost_bound
from stplan.analysis.opposed import opposed_bound
from stplan.analysis.own_costs import own_costs
from stplan.analysis.queues import Passers
from stplan.certify.certificate import certify
from stplan.explain.costs import cost_section
from stplan.planner import plan, prepare
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene

ROOMS = """\
stplan: 1
horizon: 30
map: {polygon: [[-2, -2], [2, -2], [2, -0.5], [8, -0.5], [8, -2], [12, -2],
                [12, 2], [8, 2], [8, 0.5], [2, 0.5], [2, 2], [-2, 2]]}
defaults: {radius: 0.4, after_arrival: AFTER}
solver: {knots: 20, effort: quick, starts: 1}
agents:
  - {id: east, start: [0, 1], goal: [10, 1], mass: 2}
  - {id: west, start: [10, -1], goal: [0, -1], radius: 0.35, start_time: 1, max_time: 28}
"""


def scene(after="stay"):
    return parse_scene(ROOMS.replace("AFTER", after))


def random_motion(rng: np.random.Generator) -> list[np.ndarray]:
    """One after the other through the lane; the second one waits beside the end that both use.

    Half a turn about (5, 0) exchanges both ways.
    """
    east_first = rng.random() < 0.5
    out, follow = np.sort(rng.uniform(6.0, 24.0, 2))
    curves = []
    for east in (True, False):
        begin, end = (0.0, 30.0) if east else (1.0, 28.0)
        start, mouth, exit_, goal = (0, 1), (1.8, 0), (8.2, 0), (10, 1)
        if east == east_first:
            places = [start, mouth, exit_, goal]
            times = [begin, begin + (out - begin) * rng.uniform(0.1, 0.6), out, end]
        else:
            wait = (rng.uniform(0.0, 1.5), rng.uniform(0.3, 1.5))
            places = [start, wait, mouth, exit_, goal]
            times = [begin, out, follow, follow + (end - follow) * rng.uniform(0.3, 0.95), end]
        xy = np.array(places, dtype=float)
        xy = xy if east else np.array([10.0, 0.0]) - xy
        curves.append(np.column_stack([xy, times]))
    return curves


@pytest.mark.parametrize("after", ["stay", "vanish"])
def test_no_motion_that_keeps_apart_costs_less(after, monkeypatch):
    rng = np.random.default_rng(3)
    own = scene(after)
    problem = prepare(own)
    costs, cheapest = [], None
    for _ in range(400):
        lines = WorldLines.from_curves(problem.agent_ids, random_motion(rng))
        if certify(own, problem.written.free_space, lines).holds:
            costs.append(float(own_costs(own, lines).sum()))
            cheapest = lines if costs[-1] == min(costs) else cheapest
    assert len(costs) > 20
    bound = cost_bound(problem, cheapest)
    (group,) = bound.together
    assert group.kind == "lane"
    assert 1.2 * bound.least.sum() < bound.total <= min(costs) < 1.5 * bound.total
    # Were the ends of the lane twice as far away, these motions could not be.
    monkeypatch.setattr(
        joint_bounds,
        "opposed_bound",
        lambda low, high, room: opposed_bound(
            replace(low, before=2.0 * low.before), replace(high, before=2.0 * high.before), room
        ),
    )
    assert cost_bound(problem, cheapest).total > min(costs)


def test_plans_are_near_the_bound_and_the_report_names_the_lane():
    found = plan(scene())
    bound = found.report.bound
    assert found.certificate.holds
    (group,) = found.report.as_dict()["bound"]["together"]
    assert (group["kind"], group["agents"]) == ("lane", ["east", "west"])
    assert group["width"] == pytest.approx(1.0)
    assert group["place"] == pytest.approx([5.0, 0.0], abs=1e-6)
    assert bound.total <= bound.cost < 1.2 * bound.total
    assert bound.cost > 1.4 * bound.least.sum()
    assert (
        "east and west are opposed in a lane of 1 m around (5, "
        in cost_section(bound).facts[0].sentence
    )


def at_gate(before, after, begin=(0.0, 0.0)) -> Passers:
    return Passers(
        stiffness=np.array([1.0, 3.0]),
        begin=np.array(begin),
        end=np.array([20.0, 20.0]),
        aside=np.zeros(2),
        before=np.array(before),
        after=np.array(after),
        whole=np.array([10.0, 10.0]),
    )


def test_it_is_the_shortest_joint_way_around_a_corner():
    # The first one is through after 8 of 10 m, then the second one still has 9 to go: in lengths times
    # roots of stiffness, joint motion bends around that corner, at an even pace.
    low, high = at_gate([1.0, 9.0], [9.0, 1.0]), at_gate([8.0, 1.0], [2.0, 9.0])
    roots = np.sqrt([1.0, 3.0])
    ways = [
        np.hypot(*(roots * corner)) + np.hypot(*(roots * (10.0 - np.array(corner))))
        for corner in ((8.0, 1.0), (1.0, 9.0))
    ]
    found = opposed_bound(low, high, (True, True))
    assert 0.99 * min(ways) ** 2 / 20.0 < found <= min(ways) ** 2 / 20.0
    one_way = opposed_bound(low, high, (False, True))
    assert 0.99 * ways[0] ** 2 / 20.0 < one_way <= ways[0] ** 2 / 20.0


def test_who_has_no_room_cannot_wait_but_may_come_later():
    low, high = at_gate([1.0, 9.0], [9.0, 1.0]), at_gate([8.0, 1.0], [2.0, 9.0])
    assert opposed_bound(low, high, (False, False)) == np.inf
    later = [at_gate(one.before, one.after, begin=(0.0, 1.0)) for one in (low, high)]
    assert np.isfinite(opposed_bound(*later, (False, False)))
