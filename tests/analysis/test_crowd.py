"""The arrays that analysis reads: from a problem, in any order of curves, or from discs alone."""

from __future__ import annotations

import numpy as np

from stplan.analysis.crowd import Crowd
from stplan.problem.planning_problem import prepare
from stplan.problem.world_lines import WorldLines
from tests.analysis.crowds import ANN, EVE, SAM, lines_of, scene_of

TOP = "map: {rectangle: [-9, -9, 9, 12]}\npairs: [{between: [sam, eve], distance: 3}]\n"
TRAM = "id: tram, path: [[-5, 5, 0], [5, 5, 9]], weights: {wall: 0}"
KIM = "id: kim, start: [-5, -6], goal: [5, -6], max_acceleration: 1"


def test_arrays_follow_the_curves():
    problem = prepare(scene_of(SAM, ANN, EVE, TRAM, KIM, top=TOP))
    curves = {"tram": [[-5, 5, 0], [5, 5, 9]], "kim": [[-5, -6, 0], [5, -6, 9]]}
    lines = lines_of(problem.scene, **curves)
    crowd = Crowd.of_problem(problem, lines)
    turned = WorldLines.from_curves(lines.agent_ids[::-1], [*lines.curves()][::-1])
    back = Crowd.of_problem(problem, turned)
    for name in ("radii", "stays", "heeds_walls", "preferred", "prescribed", "unhurried", "leaves"):
        np.testing.assert_array_equal(getattr(back, name), getattr(crowd, name)[::-1])
    for name in ("collides", "distance"):
        np.testing.assert_array_equal(getattr(back, name), getattr(crowd, name)[::-1, ::-1])
    assert crowd.distance[0, 2] == 3.0
    assert crowd.prescribed.tolist() == [False, False, False, True, False]
    assert crowd.unhurried.tolist() == [False, False, False, False, True]
    assert crowd.heeds_walls.tolist() == [True, True, True, False, True]
    # Who vanishes is there until it arrives, the others until the horizon.
    assert crowd.leaves.tolist() == [10.0, 20.0, 20.0, 20.0, 20.0]
    assert crowd.free_space is problem.free_space


def test_discs_alone_stay_and_keep_their_radii_apart():
    lines = lines_of(scene_of(SAM, ANN))
    crowd = Crowd.of_discs(lines, np.array([0.5, 0.2]))
    assert crowd.leaves.tolist() == [13.0, 13.0]
    assert crowd.distance[0, 1] == 0.7
    assert crowd.collides.tolist() == [[False, True], [True, False]]
    assert np.isnan(crowd.preferred).all()
    assert crowd.free_space is None
