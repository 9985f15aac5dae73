"""Spots for those who end in places, and points that are assigned."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from stplan.errors import SceneError
from stplan.planner import prepare
from stplan.scene import parse_scene

ROOM = """\
stplan: 1
horizon: 60
map:
  rectangle: [0, 0, 12, 8]
  obstacles: [{rectangle: [8, 1.2, 8.2, 6.8]}]
places:
  hall: {rectangle: [0.5, 0.5, 7.5, 7.5]}
  north: {line: [[8.1, 6.8], [8.1, 8]]}
  south: {line: [[8.1, 0], [8.1, 1.2]]}
  lawn: {rectangle: [9, 0, 12, 8]}
"""
LEAVING = "{id: p, count: 16, start: {place: hall}, goal: {any: [north, south]}, radius: 0.2"


def goals(*agents: str) -> np.ndarray:
    """Where planning leads those of such a scene."""
    text = ROOM + "agents:\n" + "".join(f"  - {agent}\n" for agent in agents)
    return np.array([agent.goal for agent in prepare(parse_scene(text)).written.scene.agents])


def test_a_crowd_spreads_over_exits_and_over_their_width() -> None:
    found = goals(LEAVING + ", after_arrival: vanish, max_speed: 1.3}")
    assert np.allclose(found[:, 0], 8.1)
    north = (found[:, 1] > 4).sum()
    assert 5 <= north <= 11
    assert len(np.unique(found.round(6), axis=0)) >= 3


def test_queues_at_the_near_exit_lead_to_the_far_one() -> None:
    near = "{id: p, count: 30, start: {rectangle: [0.5, 5, 7.5, 7.5]}, goal: {any: [north, south]}"
    found = goals(near + ", radius: 0.2, after_arrival: vanish, max_speed: 1.3}")
    assert 1 <= (found[:, 1] < 4).sum() < 15


def test_those_who_stay_get_spots_of_their_own() -> None:
    found = goals("{id: p, count: 16, start: {place: hall}, goal: {place: lawn}, radius: 0.3}")
    assert (found > [9, 0.3]).all()
    assert (found < [11.7, 7.7]).all()
    gaps = np.hypot(*(found[:, None] - found[None]).transpose(2, 0, 1))
    assert gaps[np.triu_indices(16, 1)].min() > 0.6


def test_one_who_is_alone_in_its_place_ends_where_it_is_nearest() -> None:
    bench = "goal: {rectangle: [4, 2, 7, 6]}"
    (end,) = goals(f"{{id: a, start: [1, 5], {bench}, radius: 0.3}}")
    assert end == pytest.approx([4.0, 5.0])
    (inside,) = goals(f"{{id: a, start: [5, 3], {bench}, radius: 0.3}}")
    assert inside == pytest.approx([5.0, 3.0])
    # Somebody who stays is in the way: as near as it leaves room.
    beside, _ = goals(
        f"{{id: a, start: [1, 5], {bench}, radius: 0.3}}",
        "{id: b, start: [1, 1], goal: [3.7, 5], radius: 0.3}",
    )
    assert 0.6 < np.hypot(*(beside - [3.7, 5.0])) < 1.2
    # Walls keep their distance, and nobody is drawn through them.
    (corner,) = goals("{id: a, start: [5, 4], goal: {rectangle: [0, 0, 7, 1]}, radius: 0.3}")
    assert corner == pytest.approx([5.0, 1.0])
    (behind,) = goals("{id: a, start: [5, 4], goal: {rectangle: [8.6, 3, 12, 5]}, radius: 0.3}")
    assert 8.6 <= behind[0] < 12.0


def test_too_many_to_stay_are_refused() -> None:
    small = "{id: p, count: 9, start: {place: hall}, goal: {rectangle: [9, 2, 10, 3]}, radius: 0.3}"
    with pytest.raises(
        SceneError, match=r"agents\[0\].goal: the place has room for at most 7 who stay 0.6 m apart"
    ):
        goals(small)


def test_of_several_crowds_the_one_without_spots_is_named() -> None:
    wide = "{id: q, count: 3, start: {place: hall}, goal: {place: lawn}, radius: 0.3}"
    # By their area four could stand there, but a lattice has three spots.
    small = (
        "{id: p, count: 4, start: {place: hall}, goal: {rectangle: [9, 2, 10.1, 3.1]}, radius: 0.5}"
    )
    with pytest.raises(SceneError, match=r"place has no room for all of 4 agents of 0\.5 m"):
        goals(wide, small)


def test_points_are_assigned_by_length_of_ways() -> None:
    rng = np.random.default_rng(4)
    starts, ends = rng.uniform(0, 30, (40, 2)), rng.uniform(0, 30, (40, 2))
    text = (
        "stplan: 1\nhorizon: 60\nagents:\n  - {id: p, count: 40, radius: 0.01, "
        f"start: {{points: {starts.tolist()}}}, goal: {{assign: {ends.tolist()}}}}}\n"
    )
    found = np.array([agent.goal for agent in prepare(parse_scene(text)).written.scene.agents])
    lengths = np.hypot(*(starts[:, None] - ends[None]).transpose(2, 0, 1))
    least = lengths[linear_sum_assignment(lengths)].sum()
    assert np.hypot(*(found - starts).T).sum() <= 1.005 * least
    assert sorted(map(tuple, found)) == sorted(map(tuple, ends))


def test_walls_make_ways_longer() -> None:
    # Straight ways would cross over; around the wall it is the other way round.
    pair = "{id: p, count: 2, start: {points: [[7, 6.2], [7, 1.8]]}, "
    found = goals(pair + "goal: {assign: [[9, 2.0], [9, 6.0]]}}")
    assert found.tolist() == [[9, 6.0], [9, 2.0]]
