"""``--set KEY=VALUE`` changes a scene before it is validated."""

from __future__ import annotations

import pytest

from stplan.scene import parse_scene
from tests.scene.samples import PAIR, edited, refusals, scene_text


@pytest.mark.parametrize(
    ("override", "read", "value"),
    [
        ("solver.mu=0.1", lambda s: s.solver.mu, 0.1),
        ("solver.mu=1e-3", lambda s: s.solver.mu, 1e-3),
        ("solver.mu=auto", lambda s: s.solver.mu, None),
        ("solver.barrier_range=inf", lambda s: s.solver.barrier_range, float("inf")),
        ("agents[0].radius=0.4", lambda s: s.agents[0].radius, 0.4),
        ("agents.ann.radius=0.4", lambda s: s.agents[1].radius, 0.4),
        ("agents.ann.weights.wall=0", lambda s: s.agents[1].weights.wall, 0.0),
        ("agents[0].goal[1]=3", lambda s: s.agents[0].goal, (10.0, 3.0)),
        ("agents[0].goal=[1, 2]", lambda s: s.agents[0].goal, (1.0, 2.0)),
        ("defaults.mass=80", lambda s: s.agents[0].mass, 80.0),
        ("horizon=30", lambda s: s.agents[0].max_time, 30.0),
        ("name=other", lambda s: s.name, "other"),
        ("description='a = b'", lambda s: s.description, "a = b"),
        ("pairs=[{between: [sam, ann], grouping: 2}]", lambda s: s.pairs[0].grouping, 2.0),
    ],
)
def test_override(override, read, value):
    assert read(parse_scene(PAIR, overrides=[override])) == value


def test_every_way_to_name_a_place():
    scene = parse_scene(
        scene_text(),
        overrides=[
            "solver.mu=0.1",
            "agents[0].radius=0.4",
            "agents.ann.radius=0.2",
            "agents.sam.weights.wall=0",
            "agents[1].goal[0]=6",
            "agents.sam.waypoints=[[1, 1]]",
            "name=other",
            "horizon=3e1",
        ],
    )
    assert scene.solver.mu == 0.1
    assert [agent.radius for agent in scene.agents] == [0.4, 0.2]
    assert scene.agents[0].weights.wall == 0
    assert scene.agents[1].goal == (6, 2)
    assert scene.agents[0].waypoints == ((1, 1),)
    assert (scene.name, scene.horizon) == ("other", 30)


def test_later_overrides_win():
    scene = parse_scene(PAIR, overrides=["solver={mu: 1, knots: 9}", "solver.mu=2"])
    assert (scene.solver.mu, scene.solver.knots) == (2.0, 9)
    assert parse_scene(PAIR, overrides=["horizon=1", "horizon=2"]).horizon == 2.0


def test_whole_mappings_are_replaced():
    assert (
        parse_scene(scene_text(top="solver: {mu: 2}"), overrides=["solver={knots: 9}"]).solver.mu
        is None
    )


def test_an_id_may_hold_dots():
    text = edited("id: sam", "id: robot.1")
    assert parse_scene(text, overrides=["agents.robot.1.mass=5"]).agents[0].mass == 5.0


def test_aliases_are_set_one_by_one():
    text = edited("radius: 0.3\n", "weights: &w {wall: 1}\n")
    text = edited("radius: 0.3\n", "weights: *w\n", text)
    scene = parse_scene(text, overrides=["agents.sam.weights.wall=3"])
    assert [agent.weights.wall for agent in scene.agents] == [3.0, 1.0]


def test_later_faults_are_told_with_the_override():
    scene = parse_scene(PAIR, overrides=["agents.ann.start=[4, 4]"])
    assert scene.located("agents[1].start", "lies in a wall") == (
        "--set agents.ann.start=[4, 4]: agents[1].start: lies in a wall"
    )
    assert scene.located("agents[1].goal", "lies in a wall") == (
        "pair:11:5: agents[1].goal: lies in a wall"
    )


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("solver.mu", "KEY=VALUE is expected, as in solver.mu=0.1"),
        ("=1", "KEY=VALUE is expected, as in solver.mu=0.1"),
        ("solver..mu=1", "KEY=VALUE is expected, as in solver.mu=0.1"),
        ("agents[-1].radius=1", "KEY=VALUE is expected, as in solver.mu=0.1"),
        ("solver.mux=0.1", "solver.mux: unknown key; did you mean 'mu'?"),
        ("solver.mu=-1", "solver.mu: is -1; more than 0 is expected"),
        ("slover.mu=1", "slover: unknown key; did you mean 'solver'?"),
        ("agents.sma.radius=1", "agents has no entry 'sma'; did you mean 'sam'?"),
        ("agents[7].radius=1", "agents has 2 entries, counted from 0"),
        (
            "agents[0].radius=",
            "agents[0].radius: is empty; a number is expected (leave the key out for its default)",
        ),
        ("horizon=[1", "not valid YAML: did not find expected ',' or ']'"),
        ("horizon=&a [*a]", "the alias *a stands inside what it names"),
        ("name.x=1", "name is 'pair', which has no 'x'"),
        (
            "agents.sam.id=yes",
            "agents[0].id: is true; text is expected "
            "(YAML reads an unquoted yes as true; in quotes it is text)",
        ),
        ("agents=3", "agents: is 3; a list is expected"),
        ("map={mesh: x.obj}", "map.mesh: there is no file 'x.obj' beside the scene"),
        (
            "agents.sam.max_time=-3",
            "agents[0].max_time: max_time -3 s is not after start_time 0 s; a later one is expected",
        ),
        ("solver={a: 1, a: 2}", "this key stands here twice, first in line 1, column 2"),
    ],
)
def test_refused(override, message):
    assert refusals(PAIR, overrides=(override,)) == [f"--set {override}: {message}"]


@pytest.mark.parametrize(
    "override",
    [
        "",
        "=",
        "=1",
        "horizon",
        ".=1",
        "solver]]mu=1",
        "solver..mu=1",
        "agents[2].radius=1",
        "agents[-1].radius=1",
        "agents[99999999999999999999].radius=1",
        f"agents[{'9' * 5000}].radius=1",
        "agents[0].start[7]=1",
        "horizon.x=1",
        "solver[0]=1",
        "horizon=[1",
        "horizon=.nan",
        "horizon=1\n---\n2",
        "horizon='5'",
        "horizon=true",
        "agents.sam.id=ann",
        "agents=[]",
        "a." * 5000 + "b=1",
    ],
)
def test_blamed_on_the_override(override):
    messages = refusals(scene_text(), overrides=[override])
    assert all("--set" in message or message.startswith("scene.yaml:") for message in messages)


def test_long_overrides_are_shortened():
    (message,) = refusals(PAIR, overrides=(f"name={'X' * 1000}",))
    assert message.startswith(f"--set name={'X' * 192}...: name: is ")


def test_all_bad_overrides_are_told_at_once():
    assert len(refusals(PAIR, overrides=("a", "agents.x.mass=1", "horizon=["))) == 3
    assert len(refusals(PAIR, overrides=("horizon=x", "solver.mu=x"))) == 2


def test_faults_of_file_and_override_together():
    messages = refusals(scene_text("radius: 0"), overrides=["solver.knots=1"])
    assert len(messages) == 2
    assert sum(message.startswith("scene.yaml:4:") for message in messages) == 1
    assert sum("--set solver.knots=1" in message for message in messages) == 1
