"""Places for meetings: cheap for both, apart by what they keep, around walls, one after another."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.problem.planning_problem import PlanningProblem
from stplan.scene import parse_scene
from stplan.seeding.rendezvous import Rendezvous, with_rendezvous
from stplan.world import build_free_space

FAR = (
    "  - {id: a, start: [0, 0], goal: [9, 0]}\n  - {id: b, start: [0, 7], goal: [9, 7], mass: %s}\n"
)
MEET = "pairs: [{between: [a, b], meet: {within: 1.0%s}}]\n"


def places(
    agents: str, more: str, world: str = ""
) -> tuple[PlanningProblem, tuple[Rendezvous, ...]]:
    scene = parse_scene(f"stplan: 1\nhorizon: 20\n{world}agents:\n{agents}{more}")
    return with_rendezvous(PlanningProblem.from_scene(scene, build_free_space(scene)))


def test_equals_meet_half_way_at_half_time() -> None:
    problem, (place,) = places(FAR % 1, MEET % "")
    assert place.agents == (0, 1)
    assert place.places[0] == pytest.approx([4.5, 3.5], abs=0.5)
    assert place.time == pytest.approx(10.0, abs=0.5)
    assert np.array_equal(problem.waypoints[0], place.places[:1])
    assert np.array_equal(problem.waypoints[1], place.places[1:])
    # Beside one another: further apart than they must be, near enough to meet.
    assert 0.6 < np.hypot(*(place.places[0] - place.places[1])) < 1.0


def test_the_light_one_comes_to_the_heavy_one_in_the_window() -> None:
    _, (place,) = places(FAR % 100, MEET % ", window: [4, 6]")
    assert place.places[0][1] > 6.0
    assert 4.0 < place.time < 6.0


def test_who_may_touch_meets_in_one_point() -> None:
    rule = "pairs: [{between: [a, b], collide: false, meet: {within: 1.0}}]\n"
    _, (place,) = places(FAR % 1, rule)
    assert np.array_equal(*place.places)


def test_around_walls_places_have_room() -> None:
    world = "map: {rectangle: [-1, -1, 10, 8], obstacles: [{rectangle: [-1, 3, 6, 4]}]}\n"
    problem, (place,) = places(FAR % 1, MEET % "", world)
    free_space = build_free_space(parse_scene(
        f"stplan: 1\nhorizon: 20\n{world}agents:\n{FAR % 1}"
    ))  # fmt: skip
    assert free_space is not None
    assert (free_space.clearance(np.array(place.places)) > problem.radii).all()
    # The gap is at the right.
    assert place.places[0][0] > 5.0


def test_later_meetings_heed_earlier_ones() -> None:
    agents = FAR % 1 + "  - {id: c, start: [9, 3.5], goal: [0, 3.5]}\n"
    rules = "groups: [{members: [a, b, c], meet: {within: 1.0}}]\n"
    problem, found = places(agents, rules)
    assert [place.agents for place in found] == [(0, 1), (0, 2), (1, 2)]
    for agent in range(3):
        own = {tuple(p.places[p.agents.index(agent)]): p.time for p in found if agent in p.agents}
        times = [own[tuple(point)] for point in problem.waypoints[agent]]
        assert times == sorted(times)


def test_only_the_other_one_goes_to_meet_who_moves_as_told() -> None:
    agents = (
        "  - {id: a, start: [0, 0], goal: [9, 0]}\n  - {id: b, path: [[0, 5, 0], [18, 5, 18]]}\n"
    )
    problem, (place,) = places(agents, MEET % "")
    assert len(problem.waypoints[1]) == 0
    assert place.places[1] == pytest.approx([place.time, 5.0])
    assert np.hypot(*(place.places[0] - place.places[1])) < 1.0


def test_nobody_goes_where_no_time_is_common() -> None:
    agents = (
        "  - {id: a, start: [0, 0], goal: [9, 0], max_time: 8}\n"
        "  - {id: b, start: [0, 7], goal: [9, 7], start_time: 9}\n"
    )
    problem, found = places(agents, MEET % "")
    assert found == ()
    assert all(len(own) == 0 for own in problem.waypoints)


@pytest.mark.parametrize("limit", ["max_speed: 1.0", "max_acceleration: 0.4"])
def test_places_are_reached_within_limits_of_motion(limit: str) -> None:
    # Without limits the light one would come all the way.
    agents = (FAR % 100).replace("goal: [9, 0]", f"goal: [9, 0], {limit}")
    problem, (place,) = places(agents, MEET % ", window: [4, 6]")
    way = float(np.hypot(*(place.places[0] - problem.starts[0])))
    least = way if "speed" in limit else np.sqrt(2 * way / 0.4)
    assert place.time >= least
    assert way > 3.0


def test_where_limits_leave_no_time_there_is_a_place_all_the_same() -> None:
    agents = (FAR % 1).replace("goal: [9, 0]", "goal: [9, 0], max_speed: 0.45")
    _, found = places(agents, MEET % "")
    assert len(found) == 1
