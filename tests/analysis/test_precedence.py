"""The order of passing, and what delays do where it is kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.analysis.precedence import Precedence, endurance, precedence
from stplan.arrays import FloatArray
from stplan.certify.certificate import certify
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene
from stplan.scene.model import Scene

CROSSING = """\
stplan: 1
name: crossing
horizon: 10
defaults: {radius: 0.4}
agents:
  - {id: ann, start: [-5, 0], goal: [5, 0]}
  - {id: bob, start: [0, -5], goal: [0, 5]}
"""


def lines_of(scene: Scene, *curves: list[list[float]]) -> WorldLines:
    """World lines of hand-made curves."""
    return WorldLines.from_curves([one.id for one in scene.agents], [np.array(c) for c in curves])


def crossing(later: float = 0.0) -> tuple[Scene, WorldLines]:
    """ann crosses at 5 s, bob so much later than 6.5 s."""
    scene = parse_scene(CROSSING)
    lines = lines_of(
        scene, [[-5, 0, 0], [5, 0, 10.0]], [[0, -5, 0], [0, -1, 5.5 + later], [0, 5, 10.0]]
    )
    assert certify(scene, None, lines).holds
    return scene, lines


def simulated(
    order: Precedence, curves: dict[str, FloatArray], stops: dict[str, tuple[float, float]]
) -> dict[str, list[tuple[float, float]]]:
    """(time, planned time) of everybody in small steps, where all keep the order and some stop on the way."""
    step, now = 0.01, {name: float(curve[0, 2]) for name, curve in curves.items()}
    begin = min(now.values())
    left = {name: lasts for name, (_, lasts) in stops.items()}
    tracks: dict[str, list[tuple[float, float]]] = {name: [] for name in curves}
    for tick in range(2500):
        time = begin + tick * step
        before = dict(now)
        for name in curves:
            tracks[name].append((time, before[name]))
            if name in stops and left[name] > 0.0 and before[name] >= stops[name][0]:
                left[name] -= step
                continue
            gates = [
                one.entered
                for one in order.passings
                if one.second == name
                and before[one.first] < one.left
                and before[name] <= one.entered
            ]
            now[name] = min([before[name] + step, *gates])
    return tracks


@pytest.mark.parametrize("who", ["ann", "bob"])
@pytest.mark.parametrize("moment", [0.0, 3.0, 4.9, 5.6])
def test_any_stop_is_survived_at_every_instant(who: str, moment: float) -> None:
    scene, lines = crossing()
    order = precedence(scene, lines)
    curves = dict(zip(lines.agent_ids, lines.curves(), strict=True))
    tracks = simulated(order, curves, {who: (moment, 2.0)})
    places = []
    for name, curve in curves.items():
        at = [planned for _, planned in tracks[name]]
        places.append(np.column_stack([np.interp(at, curve[:, 2], curve[:, x]) for x in range(2)]))
    gap = np.hypot(*(places[0] - places[1]).T)
    # Steps of the simulation are this much apart at most, in place.
    assert gap.min() > 0.8 - 0.03
    assert max(at for _, at in tracks["ann"]) >= 10.0
    assert max(at for _, at in tracks["bob"]) >= 10.0


def test_who_comes_later_waits_by_what_is_left_of_the_delay() -> None:
    for later in (0.0, 2.0):
        scene, lines = crossing(later)
        found = precedence(scene, lines)
        assert not found.touching
        assert {(one.first, one.second) for one in found.passings} == {("ann", "bob")}
        slack = min(one.slack for one in found.passings)
        tried = endurance(found, 2.0)
        assert tried.survives
        assert [(who, whose) for who, _, whose in tried.late] == [("bob", "ann")]
        assert tried.late[0][1] == pytest.approx(2.0 - slack)
        assert not endurance(found, 0.9 * slack).late


def test_prescribed_motion_cannot_wait() -> None:
    scene, lines = crossing(2.0)
    path = tuple(map(tuple, list(lines.curves())[1].tolist()))
    ann, bob = scene.agents
    fixed = replace(scene, agents=(ann, replace(bob, path=path)))
    found = precedence(fixed, lines)
    slack = min(one.slack for one in found.passings)
    assert slack > 0.2
    tried = endurance(found, slack + 1.0)
    assert not tried.survives
    assert "bob would have to wait" in tried.broken[0]
    assert endurance(found, 0.9 * slack).survives


def test_who_touches_keeps_no_order() -> None:
    scene = parse_scene(CROSSING)
    lines = lines_of(scene, [[-5, 0, 0], [5, 0, 10.0]], [[0, -5, 0], [0, 5, 10.0]])
    found = precedence(scene, lines)
    assert found.touching == (("ann", "bob"),)
    assert not endurance(found, 1.0).survives


def test_who_stays_is_passed_before() -> None:
    """ann stops on bob's way when he has passed: he may not be later than that without her waiting."""
    scene = parse_scene(CROSSING.replace("goal: [5, 0]", "goal: [0, 0]"))
    lines = lines_of(scene, [[-5, 0, 0], [0, 0, 10.0]], [[0, -5, 0], [0, 5, 4.0]])
    found = precedence(scene, lines)
    assert {(one.first, one.second) for one in found.passings} == {("bob", "ann")}
    late = found.lateness("bob", 8.0)
    assert late["ann"] > 0.0
    assert late["bob"] == 8.0


def test_delays_are_handed_on() -> None:
    text = CROSSING + "  - {id: cem, start: [4, 5], goal: [4, -5]}\n"
    scene = parse_scene(text.replace("horizon: 10", "horizon: 30"))
    lines = lines_of(
        scene,
        [[-5, 0, 0], [-1.5, 0, 9], [5, 0, 20.0]],
        [[0, -5, 0], [0, 5, 9.0]],
        [[4, 5, 0], [4, 1.2, 20.0], [4, -5, 30.0]],
    )
    found = precedence(scene, lines)
    late = found.lateness("bob", 9.0)
    assert late["bob"] > late["ann"] > late["cem"] > 0.0
