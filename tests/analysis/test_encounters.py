"""Who would meet whom if everybody went as if alone."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.analysis.detours import ways_alone
from stplan.analysis.encounters import encounters
from stplan.problem.planning_problem import prepare
from tests.analysis.crowds import ANN, EVE, SAM, scene_of


def test_two_cross_and_the_third_meets_nobody():
    problem = prepare(scene_of(SAM, ANN, EVE))
    found = encounters(problem, ways_alone(problem))
    assert (found.num_pairs, found.all_able) == (3, True)
    (meeting,) = found.found
    assert meeting.who == ("sam", "ann")
    # Both are in the middle of their ways at half of the horizon.
    assert meeting.overlap == pytest.approx(1.0)
    assert (meeting.time, *meeting.place) == pytest.approx((10.0, 0.0, 0.0))


def test_who_has_no_way_meets_nobody():
    problem = prepare(scene_of(SAM, ANN))
    way = np.array([[-5.0, 0.0, 0.0], [5.0, 0.0, 20.0]])
    found = encounters(problem, [way, None])
    assert (found.found, found.num_pairs, found.all_able) == ((), 0, False)
