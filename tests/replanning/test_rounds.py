"""Scenes whose goals move, played round by round."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.analysis.chases import chases
from stplan.certify.play import certify_play
from stplan.errors import SeedingError, StoppedError, UsageError
from stplan.files.csv_file import csv_bytes
from stplan.files.json_file import json_bytes
from stplan.planned import Plan
from stplan.planner import improve, prepare
from stplan.problem.continuation import curves_of
from stplan.problem.ends import ending_as
from stplan.problem.world_lines import WorldLines
from stplan.replanning.execution import check, plan
from stplan.replanning.rounds import play
from stplan.scene import parse_scene
from stplan.scene.model import Scene
from stplan.world import build_free_space

ROOM = """
stplan: 1
name: room
horizon: {horizon}
map: {{rectangle: [0, 0, 12, 8], obstacles: [{{rectangle: [5, 3, 7, 5]}}]}}
places: {{den: {{rectangle: [10, 6, 12, 8]}}}}
defaults: {{radius: 0.3, max_speed: 1.5, max_acceleration: 3}}
agents:
{agents}
"""


def room(*agents: str, horizon: float = 6.0) -> Scene:
    lines = "\n".join(f"  - {{{agent}}}" for agent in agents)
    return parse_scene(ROOM.format(agents=lines, horizon=horizon))


FOX = "id: fox, start: [1, 1], goal: {pursue: hare}, max_speed: 2.5"
HARE = "id: hare, start: [4, 1], goal: {evade: fox}"
SLOW = HARE + ", max_speed: 0.5"


@pytest.fixture(scope="module")
def hunt() -> tuple[Scene, Plan]:
    scene = room(FOX, SLOW, "id: owl, start: [11, 1], goal: [11, 2]")
    return scene, plan(scene)


def moved(lines: WorldLines, **changes: np.ndarray) -> WorldLines:
    curves = curves_of(lines) | changes
    return WorldLines.from_curves(list(curves), list(curves.values()))


def test_who_is_caught_leaves_at_that_moment(hunt) -> None:
    scene, found = hunt
    assert found.trajectories is not None
    curves = curves_of(found.trajectories)
    (capture,) = found.report.chases.captures
    assert (capture.prey, capture.pursuer) == ("hare", "fox")
    assert curves["hare"][-1, 2] == capture.time < 6.0
    there = [np.interp(capture.time, curves["fox"][:, 2], curves["fox"][:, x]) for x in range(2)]
    assert np.hypot(*(curves["hare"][-1, :2] - there)) == pytest.approx(0.9)
    assert curves["fox"][-1, 2] == 6.0
    assert found.status == "played"
    assert found.exit_status == 0
    assert check(scene, found.trajectories).holds


def test_whoever_has_nobody_left_to_pursue_stands(hunt) -> None:
    fox = curves_of(hunt[1].trajectories)["fox"]
    assert (fox[-8:, :2] == fox[-1, :2]).all()


def test_who_has_a_point_for_a_goal_gets_there(hunt) -> None:
    assert curves_of(hunt[1].trajectories)["owl"][-1].tolist() == [11.0, 2.0, 6.0]


def test_played_twice_gives_the_same_bytes(hunt) -> None:
    scene, found = hunt
    again = plan(scene)
    assert csv_bytes(again.trajectories) == csv_bytes(found.trajectories)
    assert json_bytes(again.report.as_dict()) == json_bytes(found.report.as_dict())


def test_the_faster_one_is_never_caught() -> None:
    """It runs around the pillar, where a slower one in a corner would be caught."""
    found = plan(room(FOX.replace("2.5", "1.0"), HARE.replace("[4, 1]", "[11, 7]"), horizon=15))
    assert not found.report.chases.captures
    (evasion,) = found.report.chases.evasions
    assert evasion.distance > 0.9
    hare = curves_of(found.trajectories)["hare"]
    assert np.hypot(*np.diff(hare[:, :2], axis=0).T).sum() > 5.0


def test_whoever_follows_stays_near() -> None:
    guard = "id: guard, start: [1, 3], goal: {follow: guest, within: 1.2}"
    found = plan(room("id: guest, start: [1, 1], goal: [9, 7], max_speed: 1", guard, horizon=15))
    (escort,) = found.report.chases.escorts
    assert escort.since is not None
    assert escort.since < 2.0
    assert escort.share > 0.95
    assert found.certificate.holds


def test_whoever_evades_to_places_goes_there() -> None:
    found = plan(
        room(FOX.replace("2.5", "1"), "id: hare, start: [4, 6], goal: {evade: fox, places: [den]}")
    )
    x, y, _ = curves_of(found.trajectories)["hare"][-1]
    assert x >= 10.0
    assert y >= 6.0


def test_whoever_cannot_get_to_its_goal_is_named() -> None:
    with pytest.raises(SeedingError, match=r"owl: not at the goal by 3 s"):
        plan(room(FOX, SLOW, "id: owl, start: [11, 1], goal: [1, 7]", horizon=3))


def test_stopped_before_the_end_there_is_nothing() -> None:
    with pytest.raises(StoppedError):
        plan(room(FOX, HARE), stop=lambda: True)


def test_agents_without_a_limit_of_acceleration_play_too() -> None:
    scene = parse_scene(
        ROOM.format(agents=f"  - {{{FOX}}}\n  - {{{SLOW}}}", horizon=6).replace(
            ", max_acceleration: 3", ""
        )
    )
    assert plan(scene).report.chases.captures


def test_a_scene_that_is_played_is_neither_prepared_nor_improved(hunt) -> None:
    scene, found = hunt
    with pytest.raises(UsageError, match="goals that move"):
        prepare(scene)
    with pytest.raises(UsageError, match="past improvement"):
        improve(found, None)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "change", "sentence"),
    [
        ("hare", lambda c: c[:-3], "hare: leaves at"),
        ("owl", lambda c: c[:-3], "owl: leaves at"),
        ("fox", lambda c: c[:-3], "fox: leaves at"),
        ("hare", lambda c: np.vstack([c, c[-1] + [0, 0, 0.1]]), "is within 0.9 m of fox at"),
        ("fox", lambda c: c + np.where(c[:, 2:] > 0.3, [0.5, 0.0, 0.0], 0.0), "acceleration"),
        ("owl", lambda c: c + np.array([0.1, 0.0, 0.0]), "owl: starts at"),
        ("owl", lambda c: c[:1], "at least two"),
    ],
)
def test_what_was_not_played_so_is_found(hunt, name, change, sentence) -> None:
    scene, found = hunt
    curve = curves_of(found.trajectories)[name]
    certificate = check(scene, moved(found.trajectories, **{name: change(curve)}))
    assert not certificate.holds
    assert any(sentence in one for one in certificate.violations), certificate.violations


def test_who_is_caught_is_not_in_the_way_afterwards(hunt) -> None:
    """The certificate is about those who are there: the pursuer may go where its prey was."""
    scene, found = hunt
    shown = ending_as(scene, found.trajectories)
    assert [agent.after_arrival for agent in shown.agents] == ["stay", "vanish", "stay"]
    assert chases(scene, found.trajectories) == found.report.chases


@pytest.mark.parametrize("seed", range(3))
def test_crowds_that_chase_each_other_are_certified(seed: int) -> None:
    """Whatever they want, nobody touches anybody: eight agents in a small room, each after the next."""
    rng = np.random.default_rng(seed)
    spots = np.array([(x, y) for x in (1, 3, 9, 11) for y in (1, 3, 5, 7)], dtype=float)
    starts = rng.permutation(spots)[:8] + rng.uniform(-0.3, 0.3, (8, 2))
    kinds = ["{{pursue: a{0}}}", "{{evade: a{0}}}", "{{follow: a{0}, within: 1}}"]
    agents = [
        f"id: a{k}, start: [{x:.3f}, {y:.3f}], goal: {kinds[(k + seed) % 3].format((k + 1) % 8)}, "
        f"max_speed: {rng.uniform(0.5, 2.5):.2f}"
        for k, (x, y) in enumerate(starts)
    ]
    scene = room(*agents, horizon=8)
    found = plan(scene)
    assert found.certificate.holds
    everybody = replace(scene, agents=scene.agents)
    assert certify_play(everybody, build_free_space(scene), found.trajectories).holds


def encounter(seed: int, sight: tuple[float, float]) -> Scene:
    """Six agents that cross a hall anyhow, each with a sight of its own."""
    rng = np.random.default_rng(seed)
    starts = rng.permutation([(x, y) for x in (1, 3, 9, 11) for y in (1, 4, 7)])[:6]
    goals = rng.permutation([(x, y) for x in (1, 3, 9, 11) for y in (1, 4, 7)])[:6]
    return room(
        *(
            f"id: a{k}, start: [{x}, {y}], goal: [{u}, {v}], max_speed: {rng.uniform(0.5, 2.5):.2f}, "
            f"perception: {{radius: {rng.uniform(*sight):.2f}}}"
            for k, ((x, y), (u, v)) in enumerate(zip(starts, goals, strict=True))
        ),
        horizon=6,
    )


def executed(scene: Scene) -> tuple[str, ...]:
    """What the certificate finds in what was executed, but for who is not yet at its goal."""
    space = build_free_space(scene)
    played = play(scene, space)
    ends = [
        replace(a, goal=tuple(c[-1, :2].tolist()))
        for a, c in zip(scene.agents, played.curves, strict=True)
    ]
    names = [agent.id for agent in scene.agents]
    lines = WorldLines.from_curves(names, list(played.curves))
    return certify_play(replace(scene, agents=tuple(ends)), space, lines).violations


@pytest.mark.parametrize("sight", [(0.7, 1.2), (1.0, 4.0)])
@pytest.mark.parametrize("seed", range(3))
def test_nobody_touches_whom_it_has_not_seen(seed: int, sight: tuple[float, float]) -> None:
    assert executed(encounter(seed, sight)) == ()


@pytest.mark.claims
def test_nobody_touches_anybody_in_a_thousand_encounters() -> None:
    rng = np.random.default_rng(0)
    for seed in range(1000):
        short = float(rng.uniform(0.7, 3.0))
        assert executed(encounter(seed, (short, short + 2.0))) == (), seed


def test_who_arrives_with_the_end_of_the_play_has_braked() -> None:
    rng = np.random.default_rng(0)
    short = [float(rng.uniform(0.7, 3.0)) for _ in range(144)][-1]
    assert executed(encounter(143, (short, short + 2.0))) == ()


def test_who_is_not_seen_does_not_exist() -> None:
    """A pursuer that sees no prey stands, and one that sees it goes."""
    far = "id: fox, start: [1, 1], goal: {pursue: hare}, perception: {radius: %g}"
    hare = "id: hare, start: [11, 7], goal: [11, 6]"
    stands, goes = (curves_of(plan(room(far % r, hare)).trajectories)["fox"] for r in (4, 14))
    assert (stands[:, :2] == stands[0, :2]).all()
    assert np.hypot(*(goes[-1, :2] - goes[0, :2])) > 5.0


def test_short_sight_makes_slow() -> None:
    """Whoever sees 1.4 m of others with whom it keeps 0.6 m stops within 0.4 m, from 1.2 m/s at most."""
    scene = encounter(0, (1.4, 1.4000001))
    speeds = [
        np.hypot(*np.diff(curve[:, :2], axis=0).T).max() / curve[1, 2]
        for curve in play(scene, build_free_space(scene)).curves
    ]
    assert 0.2 < max(speeds) < 1.2


def test_how_far_one_sees_is_part_of_the_meaning() -> None:
    hashes = {encounter(0, (r, r + 1e-6)).content_hash for r in (1.0, 2.0)}
    assert len(hashes) == 2


HEAD_ON = """\
stplan: 1
horizon: 30
map: {rectangle: [0, 0, 10, 6]}
defaults: {max_speed: 1.3, perception: {radius: 1.5}}
agents:
  - {id: a, start: [1, 3], goal: [9, 3]}
  - {id: b, start: [9, 3.1], goal: [1, 3.1]}
  - {id: c, start: [5, 1], goal: [5, 5]}
"""


def test_who_stand_face_to_face_go_around_each_other() -> None:
    found = plan(parse_scene(HEAD_ON))
    assert found.exit_status == 0
    assert found.certificate.holds
