"""The prepared problem: arrays over its agents, made once."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.errors import SceneError
from stplan.problem.planning_problem import PlanningProblem, prepare
from stplan.scene.model import Weights
from tests.problem.samples import room
from tests.seeding.families import agent, scene
from tests.seeding.tight_families import make_scene, rectangle

PATH = ((0.0, 6.0, 0.0), (6.0, 6.0, 9.0))


def problem() -> PlanningProblem:
    agents = [
        agent("a", (0, 0), (10, 0), waypoints=((2.0, 3.0), (8.0, 3.0)), max_time=15.0),
        agent("tram", PATH[0][:2], PATH[-1][:2], path=PATH, max_time=9.0),
        agent("keen", (0, 3), (9, 3), preferred_time=8.0, weights=Weights(arrival=1.0, wall=0.0)),
        agent("gone", (0, 9), (9, 9), preferred_time=8.0, after_arrival="vanish"),
    ]
    return PlanningProblem.from_scene(scene(agents, horizon=20.0, time_scale=2.0), room())


def test_stops_are_of_those_who_plan_their_motion() -> None:
    stops = problem().stops
    assert stops[0].tolist() == [[0, 0], [2, 3], [8, 3], [10, 0]]
    assert stops[1].shape == (0, 2)
    assert stops[2].tolist() == [[0, 3], [9, 3]]
    assert problem().prescribed.tolist() == [False, True, False, False]


def test_slow_is_preferred_unless_a_time_has_weight() -> None:
    times = problem().preferred_times
    assert times[[0, 1, 3]].tolist() == [15.0, 9.0, 20.0]
    # Who would be there at 8.0 pays for the haste, too.
    assert 8.0 < times[2] < 9.0


def test_who_stays_is_there_until_the_end_of_all() -> None:
    arrivals = np.array([10.0, 9.0, 8.0, 7.0])
    assert problem().present_until(arrivals).tolist() == [20.0, 20.0, 20.0, 7.0]


def test_a_rod_has_a_tail_where_its_agent_stays() -> None:
    curve = np.array([[0.0, 3.0, 0.0], [9.0, 3.0, 8.0]])
    staying, gone = problem().rod(2, curve), problem().rod(3, curve)
    assert staying.tolist() == [[0, 3, 0], [9, 3, 16], [9, 3, 40]]
    assert gone.tolist() == staying[:2].tolist()


def test_walls_are_heeded_by_those_with_a_weight_for_them() -> None:
    one = problem()
    assert one.boundary is not None
    assert one.wall_edges_heeded(0) is one.boundary
    assert one.wall_edges_heeded(2) is None


def test_a_scene_that_does_not_fit_its_map_or_memory_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    journeys = [((1.0, 1.0), (7.0, 5.0))]
    assert prepare(make_scene("x", rectangle(0, 0, 8, 6), [], journeys)).num_agents == 1
    with pytest.raises(SceneError, match="outside the free space"):
        prepare(make_scene("x", rectangle(0, 0, 6, 6), [], journeys))
    monkeypatch.setattr("stplan.memory.available", lambda: 1.0)
    with pytest.raises(SceneError, match="1 agents make 0 pairs, and 30 knots"):
        prepare(make_scene("x", None, [], journeys))
