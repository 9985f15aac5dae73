"""The bound of costs: reached where nobody is in the way, and never above any certified plan's cost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.analysis.cost_bound import cost_bound, least_costs
from stplan.analysis.own_costs import own_costs
from stplan.bench import families_open as wide
from stplan.bench import families_tight as tight
from stplan.certify.certificate import certify
from stplan.planner import plan, prepare
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene
from stplan.scene.model import Scene

ALONE = """\
stplan: 1
horizon: 20.0
{map}
agents: [{{id: sam, start: [-4, 0], goal: [4, 0], radius: 0.5, mass: 3.0, {more}}}]
"""
BLOCK = "map: {rectangle: [-9, -9, 9, 9], obstacles: [{rectangle: [-1, -9, 1, 1]}]}"
MORE = {
    "plain": "max_time: 16.0",
    "late": "preferred_time: 5.0, weights: {kinetic: 2.0, arrival: 0.7}",
    "in time": "preferred_time: 19.0, weights: {arrival: 50.0}",
    "hurried": "preferred_time: 0.5, weights: {arrival: 100.0}, max_speed: 2.0",
    "accelerated": "max_time: 14.0, max_acceleration: 0.5",
    "waypoint": "waypoints: [[0, 3]]",
    "dwell": "waypoints: [{at: [0, 3], dwell: 6.0}]",
    "window": "waypoints: [{at: [0, 3], window: [1.0, 3.0]}]",
    "windows": "waypoints: [{at: [0, 3], window: [9, 12], dwell: 2}, {at: [3, 3], window: [0, 14]}]",
    "late window": "waypoints: [{at: [0, 3], window: [15, 18]}], "
    "preferred_time: 8.0, weights: {arrival: 0.2}",
}  # fmt: skip


def alone(more: str, walls: str = "") -> Scene:
    return parse_scene(ALONE.format(map=walls, more=MORE[more]))


@pytest.mark.parametrize("more", MORE)
@pytest.mark.parametrize("walls", ["", BLOCK], ids=["open", "walls"])
def test_one_agent_alone_comes_near_its_bound_and_not_below(more, walls):
    scene = alone(more, walls)
    found = plan(scene)
    bound = found.report.bound
    assert found.certificate.holds
    assert bound.cost == pytest.approx(float(own_costs(scene, found.trajectories).sum()))
    assert 0.0 < bound.total <= bound.cost
    # Accelerations bound the way only; who has one, or a narrow window, pays for more than that.
    loose = more in ("accelerated", "windows", "late window", "hurried")
    assert bound.excess < (1.0 if loose else 0.02)


@pytest.mark.parametrize("seed", range(8))
def test_certified_curves_through_windows_never_cost_less(seed):
    """Random times and places, with what the certificate lets pass."""
    rng = np.random.default_rng(seed)
    for more in MORE:
        scene = alone(more)
        problem = prepare(scene)
        (agent,) = scene.agents
        least = float(least_costs(problem).sum())
        for _ in range(40):
            curve = _random_curve(agent, rng)
            lines = WorldLines.from_curves(("sam",), [curve])
            if certify(scene, None, lines).holds:
                assert float(own_costs(scene, lines).sum()) >= least


def _random_curve(agent, rng):
    """From stop to stop at random times, dwelling long enough, now and then on a bent way."""
    curve = [[*agent.start, 0.0]]
    cuts = np.sort(rng.uniform(0.0, 1.0, len(agent.waypoints)))
    end = rng.uniform(0.3, 1.0) * agent.max_time
    for k, place in enumerate(agent.waypoints):
        begin, past = (agent.visits and agent.visits[k].window) or (0.0, end)
        when = max(
            curve[-1][2] + 0.1, rng.uniform(begin, past) if rng.random() < 0.7 else cuts[k] * end
        )
        curve.append([*place, when])
        dwell = agent.visits[k].dwell if agent.visits else 0.0
        if dwell:
            curve.append([*place, when + dwell])
    curve.append([*agent.goal, max(curve[-1][2] + 0.1, end)])
    if rng.random() < 0.5:
        middle = 0.5 * (np.array(curve[-2]) + curve[-1])
        curve.insert(-1, [*(middle[:2] + rng.normal(0.0, 0.5, 2)), middle[2]])
    return np.array(curve)


@pytest.mark.parametrize(
    "scene",
    [
        wide.circle(5, 3.0, 20.0, radius=0.4),
        tight.plus_crossing(np.random.default_rng(3), turn=1),
        tight.door(np.random.default_rng(2), per_side=2),
        tight.warehouse(np.random.default_rng(2), robots=6),
        tight.cabin(np.random.default_rng(4)),
    ],
    ids=lambda scene: scene.name,
)
def test_every_agent_of_a_plan_pays_at_least_its_bound(scene):
    scene = replace(scene, solver=replace(scene.solver, knots=20, effort="quick", starts=1))
    found = plan(scene)
    bound = found.report.bound
    assert np.all(bound.costs >= bound.least)
    assert np.all(bound.least > 0.0)
    assert found.report.as_dict()["bound"]["excess"] == pytest.approx(bound.cost / bound.total - 1)
    assert f"at most {100 * bound.excess:.3g} % above any plan's" in bound.sentence


def test_prescribed_motion_costs_what_it_costs_and_standing_still_nothing():
    scene = parse_scene("""\
stplan: 1
horizon: 10.0
agents:
  - {id: sam, path: [[0, 0, 0], [3, 0, 2], [3, 1, 9]], radius: 0.5}
  - {id: ann, start: [0, 5], goal: [0, 5], radius: 0.5}
""")
    curves = [np.array(scene.agents[0].path), np.array([[0, 5, 0], [0, 5, 10.0]])]
    lines = WorldLines.from_curves(("sam", "ann"), curves)
    bound = cost_bound(prepare(scene), lines)
    assert bound.least == pytest.approx([2.25 + 0.5 / 7, 0.0])
    assert bound.excess == pytest.approx(0.0, abs=1e-7)
    still = replace(scene, agents=scene.agents[1:])
    nothing = cost_bound(prepare(still), WorldLines.from_curves(("ann",), curves[1:]))
    assert nothing.excess is None
    assert nothing.sentence == "cost 0"
