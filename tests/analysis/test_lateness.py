"""Who is late, and what waiting cost it."""

from __future__ import annotations

from stplan.analysis.lateness import Late, late_agents, timed
from stplan.analysis.waiting import waits
from tests.analysis.crowds import ANN, SAM, crowd_of, scene_of


def test_who_is_late():
    scene = scene_of(SAM, ANN, "id: bob, start: [9, 9], goal: [9, 0], preferred_time: 9")
    crowd = crowd_of(scene, bob=[[9, 9, 0], [9, 0, 9]])
    assert timed(crowd) == [1, 2]
    assert late_agents(crowd, waits(crowd)) == [Late("ann", 13.0, 9.0, 5.0)]
    assert late_agents(crowd, []) == [Late("ann", 13.0, 9.0, 0.0)]


def test_a_hundredth_of_the_time_wanted_is_not_late():
    scene = scene_of("id: bob, start: [9, 9], goal: [9, 0], start_time: 1, preferred_time: 11")
    assert late_agents(crowd_of(scene, bob=[[9, 9, 1], [9, 0, 11.09]]), []) == []
    assert late_agents(crowd_of(scene, bob=[[9, 9, 1], [9, 0, 11.11]]), []) != []


def test_nobody_asks_when_those_arrive_whose_motion_is_prescribed():
    scene = scene_of(SAM, "id: ann, path: [[0, -4, 0], [0, 4, 13]]")
    assert timed(crowd_of(scene, ann=[[0, -4, 0], [0, 4, 13]])) == []
