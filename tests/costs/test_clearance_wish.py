"""Wished clearances are kept where there is room, and given up where they are not worth it."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.planner import Plan, plan
from stplan.scene import parse_scene

PASS = """
stplan: 1
horizon: 12
defaults: {{radius: 0.3, after_arrival: vanish{wish}}}
agents:
  - {{id: east, start: [-4, 0], goal: [4, 0]}}
  - {{id: west, start: [4, 0.1], goal: [-4, 0.1]}}
pairs: [{pair}]
"""
DOOR = """
stplan: 1
horizon: 12
map: {{rectangle: [-4, -2, 4, 2], obstacles: [{{rectangle: [-0.1, 0.{half}, 0.1, 2]}},
      {{rectangle: [-0.1, -2, 0.1, -0.{half}]}}]}}
agents: [{{id: walker, start: [-3, -1.2], goal: [3, -1.2], radius: 0.3, clearance: {wish}}}]
"""


def smallest(result: Plan) -> float:
    assert result.exit_status == 0
    assert result.certificate.smallest is not None
    return result.certificate.smallest.clearance


def passing(wish: str = "", pair: str = "") -> Plan:
    return plan(parse_scene(PASS.format(wish=wish, pair=pair)))


def test_who_wishes_for_more_room_gets_it_where_there_is_some() -> None:
    plain, wished = passing(), passing(", clearance: 0.5, weights: {clearance: 5}")
    assert smallest(plain) < 0.2
    assert smallest(wished) > 0.35
    assert plain.report.metrics.kinetic_over_straight < wished.report.metrics.kinetic_over_straight


def test_the_more_it_weighs_the_more_is_kept() -> None:
    kept = [
        smallest(passing(f", clearance: 0.5, weights: {{clearance: {weight}}}"))
        for weight in (0.01, 0.1, 1.0)
    ]
    assert kept == sorted(kept)
    assert kept[-1] > 1.2 * kept[0]


def test_a_pair_has_a_wish_of_its_own() -> None:
    rule = "{between: [east, west], clearance: 0.5}"
    both = ", clearance: 0.5"
    assert smallest(passing(pair=rule)) == pytest.approx(smallest(passing(both)), rel=1e-6)
    none = "{between: [east, west], clearance: 0}"
    assert smallest(passing(both, none)) == pytest.approx(smallest(passing()), rel=1e-6)


@pytest.mark.parametrize("half", [5, 31])
def test_a_door_that_is_too_narrow_for_a_wish_is_passed_all_the_same(half: int) -> None:
    wished = plan(parse_scene(DOOR.format(half=half, wish=0.15)))
    plain = plan(parse_scene(DOOR.format(half=half, wish=0)))
    assert wished.certificate.holds
    # Nobody has more than the half of what the door leaves; a walker with a wish takes the middle.
    least = (half * 10 ** -len(str(half))) - 0.3
    assert smallest(wished) > min(0.4 * least, 0.1)
    assert smallest(wished) >= smallest(plain)


def test_without_a_wish_nothing_changes() -> None:
    same = passing(", clearance: 0, weights: {clearance: 3}")
    assert np.array_equal(same.trajectories.knots, passing().trajectories.knots)
