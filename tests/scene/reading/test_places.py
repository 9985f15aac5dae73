"""Goals that are places, crowds that start in them, and what is wrong with them."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.errors import SceneError
from stplan.planner import prepare
from stplan.scene import parse_scene
from stplan.scene.model import Scene
from stplan.scene.places import Place

HALL = """\
stplan: 1
horizon: 40
map: {rectangle: [0, 0, 10, 6]}
places:
  hall: {rectangle: [0, 0, 5, 6]}
  east: {line: [[9, 1], [9, 5]]}
  pond: {circle: {center: [7, 3], radius: 1}}
agents:
"""


def hall(*agents: str) -> Scene:
    """A scene with places and these entries of agents."""
    return parse_scene(HALL + "".join(f"  - {agent}\n" for agent in agents))


def faults(*agents: str) -> list[str]:
    """What is wrong with such a scene, from the path on."""
    with pytest.raises(SceneError) as error:
        hall(*agents)
    return [message.partition(": ")[2] for message in error.value.messages]


def test_a_goal_is_a_point_or_places() -> None:
    scene = hall(
        "{id: a, start: [1, 1], goal: {place: east}}",
        "{id: b, start: [1, 2], goal: {any: [pond, east]}}",
        "{id: c, start: [1, 3], goal: {rectangle: [6, 0, 9, 1]}}",
        "{id: d, start: [1, 4], goal: [9, 4]}",
    )
    east = Place("east", ((9.0, 1.0), (9.0, 5.0)), area=False)
    assert scene.agents[0].goal_places == (east,)
    assert [place.name for place in scene.agents[1].goal_places] == ["pond", "east"]
    assert scene.agents[2].goal_places[0].points[2] == (9.0, 1.0)
    assert scene.agents[3].goal_places == ()
    assert [place.name for place in scene.places] == ["hall", "east", "pond"]
    # A disc is a polygon inside it.
    assert np.hypot(*(np.array(scene.places[2].points) - [7, 3]).T).max() <= 1 + 1e-12


def test_starts_are_drawn_and_the_same_again() -> None:
    crowd = "{id: p, count: 12, start: {place: hall}, goal: {place: east}, radius: 0.25}"
    fixed = "{id: q, start: [1, 1], goal: [9, 1], radius: 0.25}"
    scene = hall(crowd, fixed)
    assert [agent.id for agent in scene.agents[:2]] == ["p-1", "p-2"]
    starts = np.array([agent.start for agent in scene.agents])
    assert ((starts >= 0.25) & (starts <= [5, 5.75])).all()
    gaps = np.hypot(*(starts[:, None] - starts[None]).transpose(2, 0, 1))
    assert gaps[np.triu_indices(13, 1)].min() > 0.5
    assert scene.content_hash == hall(crowd, fixed).content_hash
    other = parse_scene(HALL + f"  - {crowd}\n  - {fixed}\n", overrides=["seeding.rng_seed=1"])
    assert other.agents[0].start != scene.agents[0].start


def test_a_full_place_is_filled_on_a_lattice() -> None:
    scene = hall(
        "{id: p, count: 70, start: {rectangle: [0, 0, 4, 5]}, goal: {place: east}, radius: 0.24}"
    )
    starts = np.array([agent.start for agent in scene.agents])
    gaps = np.hypot(*(starts[:, None] - starts[None]).transpose(2, 0, 1))
    assert gaps[np.triu_indices(70, 1)].min() > 0.48


def test_a_crowd_is_assigned_to_points() -> None:
    scene = hall(
        "{id: p, count: 2, start: {points: [[1, 1], [1, 2]]}, goal: {assign: [[9, 2], [9, 1], [9, 3]]}}"
    )
    assert scene.assignments[0].members == (0, 1)
    assert len(scene.assignments[0].points) == 3
    assert scene.agents[1].start == (1.0, 2.0)


def test_what_is_wrong_is_said_where_it_stands() -> None:
    assert faults("{id: a, start: [1, 1], goal: {place: eats}}") == [
        "agents[0].goal.place: is 'eats', which is none of the scene's places; did you mean 'east'?"
    ]
    (fault,) = faults("{id: a, start: [1, 1], goal: {place: east, line: [[1, 1], [2, 2]]}}")
    assert fault.startswith("agents[0].goal: has place and line of")
    (fault,) = faults("{id: a, start: [1, 1], goal: {palce: east}}")
    assert fault == "agents[0].goal.palce: unknown key; did you mean 'place'?"
    (fault,) = faults(
        "{id: p, count: 300, start: {place: hall}, goal: {place: east}, radius: 0.25}"
    )
    assert fault.startswith(
        "agents[0]: place hall has no room for 300 agents of 0.25 m to start; the last "
    )
    (fault,) = faults("{id: p, count: 3, start: {points: [[1, 1]]}, goal: {assign: [[9, 1]]}}")[:1]
    assert "a list of 1; one of 3" in fault
    wide = "{id: p, count: 1, start: {rectangle: [0, 0, 0.5, 0.5]}, goal: [9, 1], radius: 0.6}"
    assert "has no point that a disc of 0.6 m can stand on" in faults(wide)[0]


def test_faults_of_places_themselves() -> None:
    text = "stplan: 1\nhorizon: 9\nplaces: {a: {rectangle: [1, 0, 0, 1]}, b: {}, c: {disc: 3}}\n"
    with pytest.raises(SceneError) as error:
        parse_scene(text + "agents: [{id: a, start: [0, 0], goal: {place: b}}]\n")
    assert any("places.c.disc: unknown key" in message for message in error.value.messages)
    with pytest.raises(SceneError) as error:
        parse_scene(
            text.replace(", c: {disc: 3}", "")
            + "agents: [{id: a, start: [0, 0], goal: {place: b}}]\n"
        )
    messages = "\n".join(error.value.messages)
    assert "places.a.rectangle: reaches from xmin 1 to xmax 0" in messages
    with pytest.raises(SceneError, match=r"places.a.polygon: crosses or touches itself; a simple"):
        parse_scene(
            "stplan: 1\nhorizon: 9\nplaces: {a: {polygon: [[0, 0], [1, 1], [1, 0], [0, 1.5]]}}\n"
            "agents: [{id: a, start: [0, 0], goal: {place: a}}]\n"
        )
    assert "places.b: has none of rectangle, polygon, circle and line" in messages


def test_hashes_of_scenes_without_places_stay() -> None:
    plain = parse_scene(
        "stplan: 1\nhorizon: 9\ntime_scale: 1\nagents: [{id: a, start: [0, 0], goal: [1, 1]}]\n"
    )
    named = parse_scene(
        "stplan: 1\nhorizon: 9\ntime_scale: 1\nplaces: {x: {rectangle: [0, 0, 1, 1]}}\n"
        "agents: [{id: a, start: [0, 0], goal: [1, 1]}]\n"
    )
    before = "b8dd06f67d6776d5b514455d92e3c2fe50a85b8fdf7236b34e2ee35caa565fbb"
    assert plain.content_hash == before
    assert named.content_hash != plain.content_hash


def test_a_stream_appears_one_after_another() -> None:
    stream = "{id: s, source: {place: hall}, goal: {place: east}, rate: 0.5, during: [2, 12]"
    scene = hall(stream + ", allowed_time: 15}")
    assert [agent.start_time for agent in scene.agents] == [2, 4, 6, 8, 10]
    assert [agent.max_time for agent in scene.agents] == [17, 19, 21, 23, 25]
    random = hall(stream + ", arrivals: poisson}")
    times = [agent.start_time for agent in random.agents]
    assert times == sorted(times)
    assert all(2 < time < 12 for time in times)
    assert {agent.max_time for agent in random.agents} == {40}
    assert times == [agent.start_time for agent in hall(stream + ", arrivals: poisson}").agents]


def test_faults_of_streams() -> None:
    stream = "{id: s, source: {place: hall}, goal: {place: east}, rate: 0.5, during: "
    assert faults(stream + "[9, 2]}") == [
        "agents[0].during: reaches from 9 s to 2 s; a later end is expected"
    ]
    assert "lets nobody in" in faults(stream + "[2, 2.1], arrivals: poisson}")[0]
    (fault,) = faults(stream + "[2, 9], allowed_time: 5, max_time: 30}")
    assert fault.startswith("agents[0].allowed_time: cannot be said beside max_time")
    (fault,) = faults(stream.replace("hall", "hell") + "[2, 9]}")
    assert fault.startswith("agents[0].source.place: is 'hell'")


ALONE = "{id: a, start: [1, 1], goal: "
STREAM = "{id: s, source: {place: hall}, goal: {place: east}, "


@pytest.mark.parametrize(
    ("agent", "message"),
    [
        (
            ALONE + "{rectangle: [20, 0, 22, 2]}}",
            "agents[0].goal: the place has no point that a disc of 0.2 m can reach",
        ),
        (
            ALONE + "{line: [[0, 0.1], [9, 0.1]]}}",
            "agents[0].goal: the place has no point that a disc of 0.2 m can reach",
        ),
        (ALONE + "{any: []}}", "agents[0].goal.any: is a list of 0; at least 1"),
        (ALONE + "{any: [east, est]}}", "agents[0].goal.any[1]: is 'est', which is none"),
        (ALONE + "east}", "agents[0].goal: is 'east'; a point [x, y] in m is expected"),
        (ALONE + "{polygon: []}}", "agents[0].goal.polygon: is a list of 0; at least 3"),
        (
            ALONE + "{polygon: [[6, 1], [7, 1], [8, 1]]}}",
            "agents[0].goal.polygon: has no area",
        ),
        (ALONE + "{line: [[6, 1], [6, 1]]}}", "agents[0].goal.line: is a single point"),
        (
            ALONE + "[9, 1], waypoints: [{place: pond, at: [1, 1]}]}",
            "agents[0].waypoints[0]: has both at and place",
        ),
        (
            ALONE + "[9, 1], waypoints: [{place: pond, window: [9, 3]}]}",
            "agents[0].waypoints[0].window: reaches from 9 s to 3 s",
        ),
        (STREAM + "rate: 0, during: [0, 9]}", "agents[0].rate: is 0; more than 0 is expected"),
        (STREAM + "rate: -1, during: [0, 9]}", "agents[0].rate: is -1; more than 0 is expected"),
        (STREAM + "rate: .inf, during: [0, 9]}", "agents[0].rate: is inf; a finite number"),
        (STREAM + "rate: 1}", "agents[0].during: is missing"),
        (STREAM + "rate: 1, during: [40, 50]}", "start_time: is 40 s; less than the horizon 40 s"),
        (
            "{id: p, count: 2, start: {place: hall}, goal: {assign: [[9, 1], [19, 1]]}}",
            "agents[0][1].goal: (19, 1) lies outside the free space of the map",
        ),
    ],
)
def test_what_nobody_means_is_refused_where_it_stands(agent: str, message: str) -> None:
    with pytest.raises(SceneError) as error:
        prepare(
            parse_scene(
                HALL.replace("agents:", "defaults: {radius: 0.2}\nagents:") + f"  - {agent}\n"
            )
        )
    first = error.value.messages[0]
    assert first.startswith("scene:10:")
    assert message in first
