"""How much further than alone."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.analysis.detours import detours, ways_alone
from stplan.problem.planning_problem import prepare
from tests.analysis.crowds import EVE, SAM, crowd_of, scene_of


def test_detours_in_the_open_and_round_walls():
    scene = scene_of(SAM, EVE)
    (detour,) = detours(crowd_of(scene), ways_alone(prepare(scene)))
    assert detour.agent == "eve"
    assert (detour.alone, detour.length) == pytest.approx((10.0, 2 * np.hypot(5, 1)))
    walled = scene_of(
        "id: sam, start: [-5, 0], goal: [5, 0]",
        top="map: {rectangle: [-9, -9, 9, 9], obstacles: [{rectangle: [-1, -6, 1, 1]}]}\n",
    )
    around = [[-5, 0, 0], [-1.5, 1.5, 4], [1.5, 1.5, 8], [5, 0, 12]]
    alone = ways_alone(prepare(walled))
    # The wall's corners have to be passed, so this is no detour although it is not straight.
    assert detours(crowd_of(walled, sam=around), alone) == []
    wide = [[-5, 0, 0], [0, 6, 6], [5, 0, 12]]
    (detour,) = detours(crowd_of(walled, sam=wide), alone)
    assert 10.5 < detour.alone < 10.9


def test_the_longest_detour_comes_first_and_none_without_a_way():
    scene = scene_of(SAM, EVE)
    crowd = crowd_of(scene, sam=[[-5, 0, 0], [0, 3, 5], [5, 0, 10]])
    alone = ways_alone(prepare(scene))
    assert [detour.agent for detour in detours(crowd, alone)] == ["sam", "eve"]
    assert [detour.agent for detour in detours(crowd, [None, alone[1]])] == ["eve"]
