"""Where in a place a disc can stand."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from stplan.errors import SceneError
from stplan.planner import prepare
from stplan.scene import parse_scene
from stplan.scene.places import Place
from stplan.world.free_space import FreeSpace
from stplan.world.places import StandingRoom, spots

FLOOR = FreeSpace.from_polygon(shapely.box(0, 0, 10, 4))
EXIT = Place("exit", ((9.0, 0.0), (9.0, 4.0)), area=False)


def test_walls_take_a_radius_off() -> None:
    rooms = StandingRoom(FLOOR)
    assert rooms.within(EXIT, 0.5).length == pytest.approx(3.0, abs=1e-6)
    corner = Place("corner", ((0.0, 0.0), (0.4, 0.0), (0.4, 0.4)), area=True)
    assert rooms.within(corner, 0.5).is_empty
    assert StandingRoom(None).within(EXIT, 0.5).length == 4.0


def test_spots_keep_their_distance() -> None:
    along = spots(shapely.LineString([[9, 0.5], [9, 3.5]]), 0.7, 0.1)
    assert len(along) == 5
    assert np.diff(np.sort(along[:, 1])).min() >= 0.7 - 1e-9
    assert along[:, 1].min() == pytest.approx(0.6)
    inside = spots(shapely.box(0, 0, 3, 3), 0.7, 0.1)
    gaps = np.hypot(*(inside[:, None] - inside[None]).transpose(2, 0, 1))
    assert gaps[np.triu_indices(len(inside), 1)].min() >= 0.7 - 1e-9
    assert len(inside) >= 12
    assert len(spots(shapely.box(0, 0, 0.1, 0.1), 0.7, 0.3)) == 1


def test_a_place_that_nobody_can_reach_is_refused() -> None:
    scene = parse_scene(
        "stplan: 1\nhorizon: 20\nmap: {rectangle: [0, 0, 10, 4]}\n"
        "places: {exit-a: {line: [[9.9, 0], [9.9, 4]]}}\n"
        "agents: [{id: a, start: [1, 1], goal: {place: exit-a}}]\n"
    )
    with pytest.raises(SceneError) as error:
        prepare(scene)
    text = "agents[0].goal: place exit-a has no point that a disc of 0.3 m can reach"
    assert error.value.messages == [f"scene:5:33: {text}"]


def test_a_crowd_that_cannot_reach_its_place_is_refused_once() -> None:
    scene = parse_scene(
        "stplan: 1\nhorizon: 20\nmap: {rectangle: [0, 0, 10, 4]}\n"
        "places: {exit-a: {line: [[9.9, 0], [9.9, 4]]}, hall: {rectangle: [0, 0, 6, 4]}}\n"
        "agents: [{id: a, count: 3, start: {place: hall}, goal: {place: exit-a}}]\n"
    )
    with pytest.raises(SceneError) as error:
        prepare(scene)
    text = "agents[0].goal: place exit-a has no point that a disc of 0.3 m can reach"
    assert error.value.messages == [f"scene:5:50: {text}"]
