"""Walls hide others, and whoever may be hidden is braked for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.certify.play import certify_play
from stplan.errors import SceneError
from stplan.problem.continuation import curves_of
from stplan.problem.world_lines import WorldLines
from stplan.replanning.execution import plan
from stplan.replanning.rounds import play
from stplan.replanning.sight import Blinds, Hiding
from stplan.scene import parse_scene
from stplan.scene.model import Scene
from stplan.seeding.search.shortest_ways import WayFinder
from stplan.world import build_free_space

PILLARS = """\
{rectangle: [0, 0, 12, 8], obstacles: [{rectangle: [3, 2, 5, 3.5]}, {rectangle: [7, 2, 9, 3.5]},
  {circle: {center: [4.7, 5.5], radius: 0.6}}, {line: [[8, 5], [8, 7]]}]}"""
CORNERS = (
    "{rectangle: [0, 0, 12, 8], "
    "obstacles: [{rectangle: [0, 2.2, 4.5, 8]}, {rectangle: [7.5, 2.2, 12, 8]}]}"
)
SPOTS = {
    PILLARS: [(x, y) for x in (1, 6, 11) for y in (1, 4, 7)],
    CORNERS: [(1, 1), (2.5, 1), (4, 1), (8, 1), (9.5, 1), (11, 1), (6, 3), (6, 4.5), (6, 6.5)],
}


def hall(walls: str, *agents: str, horizon: float = 10.0) -> Scene:
    lines = "\n".join(f"  - {{{agent}}}" for agent in agents)
    return parse_scene(
        f"stplan: 1\nname: hall\nhorizon: {horizon}\nmap: {walls}\n"
        f"defaults: {{radius: 0.3, max_speed: 2, perception: {{radius: 9, line_of_sight: true}}}}\n"
        f"agents:\n{lines}\n"
    )


def encounter(seed: int, walls: str, horizon: float = 8.0) -> Scene:
    """Five agents that cross a hall anyhow."""
    rng = np.random.default_rng(seed)
    starts, goals = rng.permutation(SPOTS[walls])[:5], rng.permutation(SPOTS[walls])[:5]
    return hall(
        walls,
        *(
            f"id: a{k}, start: [{x}, {y}], goal: [{u}, {v}], max_speed: {rng.uniform(0.5, 3.0):.2f}, "
            f"max_acceleration: {rng.uniform(0.6, 4.0):.2f}, radius: {rng.uniform(0.2, 0.4):.2f}"
            for k, ((x, y), (u, v)) in enumerate(zip(starts, goals, strict=True))
        ),
        horizon=horizon,
    )


def executed(scene: Scene) -> tuple[str, ...]:
    """What the certificate finds in what was executed, but for who is not yet at its goal."""
    space = build_free_space(scene)
    played = play(scene, space)
    ends = [
        replace(a, goal=tuple(c[-1, :2].tolist()))
        for a, c in zip(scene.agents, played.curves, strict=True)
    ]
    lines = WorldLines.from_curves([agent.id for agent in scene.agents], list(played.curves))
    return certify_play(replace(scene, agents=tuple(ends)), space, lines).violations


@pytest.mark.parametrize("walls", SPOTS, ids=("pillars", "corners"))
@pytest.mark.parametrize("radius", [0.15, 0.4])
def test_nobody_who_is_hidden_is_nearer_than_it_says(walls: str, radius: float) -> None:
    """The bound from the corners in sight stays below the shortest way to whoever is hidden."""
    space = build_free_space(hall(walls, "id: a, start: [1, 1], goal: [2, 1]"))
    blinds, finder, rng = Blinds.of(space, radius), WayFinder(space), np.random.default_rng(1)
    points = rng.uniform((0, 0), (12, 8), (2000, 2))
    points = points[space.clearance(points) > radius]
    near = points[rng.permutation(len(points))]
    # Around corners bounds are tight, so most pairs are taken from there.
    bends = space.boundary_vertices
    close = [near[np.hypot(*(near - bend).T) < 1.2][:8] for bend in bends]
    pairs = [(p, q) for some in close for p in some for q in some if (p != q).any()]
    pairs += list(zip(points[:40], near[:40], strict=True))
    heads, tails = (np.array([pair[k] for pair in pairs]) for k in range(2))
    hidden = ~blinds.clear(heads, tails)
    assert hidden.sum() > 5
    bounds = blinds.ways_to_hidden(heads[hidden], radius, np.inf)
    tight = 0
    for p, q, bound in zip(heads[hidden], tails[hidden], bounds, strict=True):
        way = finder.way(np.array([p, q]), 1e-4)
        if way is not None:
            length = np.hypot(*np.diff(way.points, axis=0).T).sum()
            assert bound <= length + 1e-3
            tight += bound > 0.5 * length
    assert tight > 3


def test_ways_past_corners_are_short() -> None:
    scene = hall(
        CORNERS, "id: a, start: [1, 1], goal: [11, 1]", "id: b, start: [6, 6], goal: [6, 5]"
    )
    hiding = Hiding(scene, build_free_space(scene), np.array([[0, 0.6], [0.6, 0]]))
    ahead = np.linspace([4.2, 1.8], [5.4, 1.8], 13)
    back = np.linspace([4.2, 1.8], [4.2, 0.4], 7)
    assert not hiding.allows(0, ahead[None])[0]
    assert hiding.allows(0, ahead[None, :2])[0]
    assert not hiding.allows(0, np.concatenate([back, ahead])[None])[0]
    everybody = replace(
        scene, agents=tuple(replace(one, line_of_sight=False) for one in scene.agents)
    )
    free = Hiding(everybody, build_free_space(scene), np.array([[0, 0.6], [0.6, 0]]))
    assert free.allows(0, ahead[None])[0]
    # Whoever sees through walls is careful too, for the sake of who does not.
    half = replace(scene, agents=(everybody.agents[0], scene.agents[1]))
    careful = Hiding(half, build_free_space(scene), np.array([[0, 0.6], [0.6, 0]]))
    assert not careful.allows(0, ahead[None])[0]
    seen = careful.seen(np.array([[4.2, 1.8], [5.0, 6.0]]))
    assert seen.tolist() == [[True, True], [False, True]]


@pytest.mark.parametrize("walls", SPOTS, ids=("pillars", "corners"))
@pytest.mark.parametrize("seed", range(2))
def test_nobody_touches_who_comes_round_a_corner(seed: int, walls: str) -> None:
    assert executed(encounter(seed, walls, horizon=3.0)) == ()


@pytest.mark.claims
def test_nobody_touches_anybody_in_drawn_encounters_round_corners() -> None:
    for seed in range(60):
        for walls in SPOTS:
            assert executed(encounter(seed, walls)) == (), (seed, walls)


def test_who_is_behind_a_wall_does_not_exist_until_it_comes_out() -> None:
    hare = "id: hare, start: [6, 7], goal: [6, %g], max_speed: 0.5"
    fox = "id: fox, start: [2, 1], goal: {pursue: hare}"
    stands, goes = (
        curves_of(plan(hall(CORNERS, fox, hare % y, horizon=20)).trajectories)["fox"]
        for y in (6.5, 1.2)
    )
    assert (stands[:, :2] == stands[0, :2]).all()
    assert np.hypot(*(goes[-1, :2] - goes[0, :2])) > 2.0


def test_pairs_that_keep_more_than_walls_do_are_refused() -> None:
    text = (
        "stplan: 1\nhorizon: 9\nmap: {rectangle: [0, 0, 9, 9]}\ndefaults: {max_speed: 1}\nagents:\n"
    )
    text += (
        "  - {id: a, start: [1, 1], goal: [8, 1], perception: {radius: 5, line_of_sight: true}}\n"
    )
    text += "  - {id: b, start: [1, 5], goal: [8, 5]}\npairs: [{between: [a, b], distance: %g}]\n"
    assert parse_scene(text % 0.6).agents[0].line_of_sight
    with pytest.raises(
        SceneError, match=r"agents\[0\]\.perception\.line_of_sight: a and b keep 0\.7"
    ):
        parse_scene(text % 0.7)
    plain = text.replace(", line_of_sight: true", "") % 0.6
    blind = text.replace("true", "false") % 0.6
    assert parse_scene(plain).content_hash == parse_scene(blind).content_hash
    assert parse_scene(plain).content_hash != parse_scene(text % 0.6).content_hash
