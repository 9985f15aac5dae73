"""What scenes may ask of a search besides tight places, and what it says when it fails."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.errors import SeedingError
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import requirement
from stplan.problem.verification import verify
from stplan.scene.model import PairRule, Scene, Weights
from stplan.seeding.portfolio import find_seed
from stplan.seeding.search.levels import Levels
from stplan.seeding.search.planner import MAX_CLASSES, classes
from stplan.seeding.search.schedule import Search
from stplan.seeding.seeder import SeedAttempt
from stplan.wording import sentences
from stplan.world import build_free_space
from tests.seeding.tight_families import budget_of, make_scene, rectangle

ROOM = rectangle(0, 0, 8, 6)
CROSSING = [((1.0, 3.0), (7.0, 3.0)), ((7.0, 3.0), (1.0, 3.0)), ((4.0, 1.0), (4.0, 5.0))]


def search(scene: Scene) -> tuple[PlanningProblem, SeedAttempt]:
    problem = PlanningProblem.from_scene(scene, build_free_space(scene))
    return problem, Search(Levels(problem)).attempt(budget_of(scene))


def solved(scene: Scene) -> tuple[PlanningProblem, list[np.ndarray]]:
    problem, result = search(scene)
    assert result.clear, sentences(result.reasons)
    assert verify(problem, result.curves) == []
    return problem, result.curves


def with_agent(scene: Scene, index: int, **changes: object) -> Scene:
    agents = list(scene.agents)
    agents[index] = replace(agents[index], **changes)
    return replace(scene, agents=tuple(agents))


@pytest.mark.parametrize("stay", [True, False])
@pytest.mark.parametrize("outer", [ROOM, None])
def test_agents_cross_a_room_and_the_open_plane(outer: tuple | None, stay: bool) -> None:
    solved(make_scene("crossing", outer, [], CROSSING, stay=stay, horizon=30.0))


@pytest.mark.parametrize("time_scale", [0.2, 5.0])
def test_the_time_scale_counts(time_scale: float) -> None:
    solved(make_scene("crossing", ROOM, [], CROSSING, horizon=30.0, time_scale=time_scale))


def test_waypoints_are_knots_in_order() -> None:
    stops = ((6.5, 5.0), (1.5, 1.0), (6.5, 5.0))
    scene = with_agent(make_scene("stops", ROOM, [], CROSSING), 0, waypoints=stops)
    _, curves = solved(scene)
    knots = [tuple(knot) for knot in curves[0][:, :2]]
    after = 0
    for stop in stops:
        after = knots.index(stop, after) + 1


def test_every_agent_keeps_its_own_times() -> None:
    scene = make_scene("times", ROOM, [], CROSSING, horizon=40.0)
    scene = with_agent(scene, 0, start_time=3.3, max_time=21.7)
    scene = with_agent(scene, 1, start_time=-2.0, max_time=17.0)
    _, curves = solved(scene)
    assert curves[0][0, 2] == 3.3
    assert curves[0][-1, 2] <= 21.7
    assert curves[1][0, 2] == -2.0
    assert curves[1][-1, 2] <= 17.0


def test_given_paths_are_kept_and_avoided() -> None:
    path = ((4.0, 5.5, 0.0), (4.0, 0.5, 40.0), (4.0, 5.5, 60.0))
    scene = make_scene("patrol", ROOM, [], [*CROSSING[:2], ((4.0, 5.5), (4.0, 5.5))])
    scene = with_agent(scene, 2, path=path, after_arrival="vanish")
    _, curves = solved(scene)
    assert np.array_equal(curves[2], np.array(path))


def test_radii_and_pair_distances_differ() -> None:
    scene = make_scene("mixed", ROOM, [], CROSSING, radii=[0.2, 0.7, 0.4], horizon=60.0)
    scene = replace(
        scene,
        pairs=(PairRule((0,), (2,), distance=1.4), PairRule((1,), (2,), collide=False)),
    )
    solved(scene)


def test_agents_may_ignore_walls() -> None:
    wall = rectangle(3.5, -1, 4.5, 7)
    scene = make_scene("ghost", ROOM, [wall], [CROSSING[0], ((1.0, 5.0), (3.0, 1.0))])
    scene = with_agent(scene, 0, weights=Weights(wall=0.0))
    solved(scene)


def test_an_agent_may_be_on_its_goal_already() -> None:
    _, curves = solved(make_scene("idle", ROOM, [], [((4.0, 3.0), (4.0, 3.0)), *CROSSING[:1]]))
    assert len(curves[0]) >= 2


def test_ends_nearer_than_the_margin_are_served() -> None:
    near = 0.6 * 1.01
    journeys = [((1.0, 3.0), (7.0, 3.0)), ((1.0 + near, 3.0), (7.0, 3.0 + near))]
    solved(make_scene("close", ROOM, [], journeys))


def test_one_moment_is_found_in_the_right_place_for_many_radii() -> None:
    count = 24
    radii = np.linspace(0.1, 0.2, count)
    rows = np.linspace(0.5, 11.5, count)
    journeys = [((1.0, row), (7.0, row)) for row in rows]
    scene = make_scene("many", rectangle(0, 0, 8, 12), [], journeys, radii=radii.tolist())
    problem, _ = solved(scene)
    required = requirement(problem, 1.05)
    class_of, distance = classes(problem, required)
    assert len(distance) == MAX_CLASSES
    kept = distance[class_of]
    off = ~np.eye(count, dtype=bool)
    assert (kept[off] >= problem.distance[off]).all()


def reasons(scene: Scene) -> dict[str, tuple[tuple[str, ...], bool]]:
    with pytest.raises(SeedingError) as refused:
        find_seed(
            PlanningProblem.from_scene(scene, build_free_space(scene)), progress=lambda line: None
        )
    found = refused.value.reasons
    assert len(str(refused.value).splitlines()) == len(found)
    return {reason.kind: (reason.agents, reason.proven) for reason in found}


def test_starts_that_touch_are_a_proven_reason() -> None:
    journeys = [((1.0, 3.0), (7.0, 3.0)), ((1.5, 3.0), (7.0, 5.0))]
    assert reasons(make_scene("x", ROOM, [], journeys))["start"] == (("a0", "a1"), True)


def test_goals_that_touch_are_a_proven_reason_for_those_who_stay() -> None:
    journeys = [((1.0, 3.0), (7.0, 3.0)), ((1.0, 5.0), (7.0, 3.5))]
    assert reasons(make_scene("x", ROOM, [], journeys))["goal"] == (("a0", "a1"), True)
    solved(make_scene("x", ROOM, [], journeys, stay=False))


def test_a_wall_between_start_and_goal_is_a_proven_reason() -> None:
    wall = rectangle(3.5, 0.55, 4.5, 7)
    scene = make_scene("x", ROOM, [wall], CROSSING[:1])
    assert reasons(scene)["not connected"] == (("a0",), True)


def test_too_few_layers_are_named() -> None:
    scene = make_scene("x", ROOM, [], CROSSING)
    scene = replace(scene, seeding=replace(scene.seeding, layers=1, time_limit=2.0))
    _, result = search(scene)
    assert not result.clear
    assert {reason.kind for reason in result.reasons} == {"layers"}


def test_a_swap_in_a_lane_without_a_pocket_is_given_up_soon() -> None:
    lane = rectangle(0, 0, 6, 0.8)
    journeys = [((1.0, 0.4), (5.0, 0.4)), ((5.0, 0.4), (1.0, 0.4))]
    _, result = search(make_scene("x", lane, [], journeys, horizon=20.0))
    assert not result.clear
    (reason,) = result.reasons
    assert reason.kind == "blocked"
    assert reason.agents == ("a0", "a1")
    assert result.tries < 1000


def test_a_jam_of_many_says_who_touches_where_and_when() -> None:
    lane = rectangle(0, 0, 12, 0.8)
    x = [1.0, 2.0, 3.0, 9.0, 10.0, 11.0]
    journeys = [((a, 0.4), (b, 0.4)) for a, b in zip(x, x[::-1], strict=True)]
    scene = make_scene("x", lane, [], journeys, horizon=20.0)
    scene = replace(scene, seeding=replace(scene.seeding, time_limit=0.5))
    _, result = search(scene)
    assert not result.clear
    reason = result.reasons[0]
    assert reason.kind == "touching"
    assert not reason.proven
    assert reason.place is not None
    assert 0.0 <= reason.place[0] <= 12.0
    assert reason.times is not None
    assert 0.0 <= reason.times[0] <= reason.times[1] <= 20.0
