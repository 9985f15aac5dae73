"""Who waits for whom: one rule, whether there is a scene or only an .npz file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.analysis.crowd import Crowd
from stplan.analysis.waiting import waits
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import PairRule
from tests.analysis.crowds import ANN, EVE, SAM, crowd_of, lines_of, scene_of


def test_who_waits_where_and_for_whom():
    (wait,) = waits(crowd_of(scene_of(SAM, ANN, EVE)))
    assert (wait.agent, wait.begin, wait.end) == ("ann", 2.0, 7.0)
    assert wait.pace == pytest.approx(8 / 13)
    assert (wait.speed, wait.lost, wait.place) == (0.0, 5.0, (0.0, -2.0))
    assert wait.is_wait
    assert wait.meeting is not None
    assert wait.meeting.agent == "sam"
    # Going on from (0, -2) at 8 / 13 m/s she crosses his line at 5.25 s, a quarter of a metre off.
    assert wait.meeting.overlap == pytest.approx(1.0 - 0.25 * (8 / 13) / np.hypot(1, 8 / 13))
    assert wait.meeting.time == pytest.approx(5.25, abs=0.3)


def test_nobody_is_blamed_who_is_not_in_the_way():
    scene = scene_of(SAM, ANN, EVE)
    for other in (
        replace(scene, pairs=(PairRule((0,), (1,), collide=False),)),
        replace(scene, pairs=(PairRule((0,), (1,), distance=0.01),)),
    ):
        (wait,) = waits(crowd_of(other))
        assert wait.meeting is None
    # Sam is gone before ann would be there.
    assert waits(crowd_of(scene, sam=[[-5, 0, 0], [5, 0, 3]]))[0].meeting is None


def test_who_stays_is_in_the_way_after_its_arrival():
    stays = scene_of(SAM.replace("goal: [5, 0], after_arrival: vanish", "goal: [0, 0]"), EVE,
                     ANN.replace("goal: [0, 4]", "goal: [3, 4]"))  # fmt: skip
    early = {"sam": [[-5, 0, 0], [0, 0, 3]], "ann": [[0, -4, 0], [0, -2, 2], [0, -2, 7], [0, 1, 9],
             [3, 4, 13]]}  # fmt: skip
    (wait,) = waits(crowd_of(stays, **early))
    assert wait.meeting is not None
    assert wait.meeting.agent == "sam"
    assert wait.meeting.time > 3.0


def test_going_on_slowly_is_no_wait_but_holding_back_for_somebody():
    scene = scene_of(SAM, ANN)
    # A tenth slower than on average.
    assert waits(crowd_of(scene, ann=[[0, -4, 0], [0, 0.4, 8], [0, 4, 13]])) == []
    (wait,) = waits(crowd_of(scene, ann=[[0, -4, 0], [0, -0.5, 7], [0, 4, 11]]))
    assert not wait.is_wait
    assert wait.meeting is not None
    assert waits(crowd_of(scene, ann=[[0, -4, 0], [0, 4, 16]])) == []


def test_agents_that_stand_or_whose_motion_is_prescribed_do_not_wait():
    given = "id: ann, path: [[0, -4, 0], [0, -2, 2], [0, -2, 7], [0, 4, 13]]"
    scene = scene_of(SAM, given, "id: eve, start: [3, 3], goal: [3, 3]")
    assert waits(crowd_of(scene, eve=[[3, 3, 0], [3, 3, 20]])) == []


def test_setting_off_from_rest_is_no_wait():
    slowly = [[0, 0, 0], [1, 0, 4], [8, 0, 10], [9, 0, 14]]
    scene = scene_of("id: sam, start: [0, 0], goal: [9, 0], max_acceleration: 0.5")
    assert waits(crowd_of(scene, sam=slowly)) == []
    free = scene_of("id: sam, start: [0, 0], goal: [9, 0]")
    assert len(waits(crowd_of(free, sam=slowly))) == 2


def test_the_longest_wait_comes_first_whatever_the_order_of_the_curves():
    scene = scene_of(SAM, ANN, EVE)
    eve = [[-5, 9, 0], [0, 9, 4], [0, 9, 15], [5, 9, 19]]
    crowd = crowd_of(scene, eve=eve)
    assert [wait.agent for wait in waits(crowd)] == ["eve", "ann"]
    lines = crowd.lines
    turned = WorldLines.from_curves(lines.agent_ids[::-1], [*lines.curves()][::-1])
    turned_crowd = Crowd.of_discs(turned, crowd.radii[::-1])
    assert [wait.agent for wait in waits(turned_crowd)] == ["eve", "ann"]


def test_discs_alone_wait_for_the_same_agents():
    scene = scene_of(SAM.replace(", after_arrival: vanish", ""), ANN, EVE)
    lost = Crowd.of_discs(lines_of(scene), np.full(3, 0.5))
    assert waits(lost) == waits(crowd_of(scene))
