"""Scenes of very many agents: read in time, overlaps found in all of them."""

from __future__ import annotations

import time

import numpy as np
import pytest

from stplan.errors import SceneError
from stplan.scene import parse_scene, scene_interactions
from tests.scene.samples import agents_text, refusals


def crowd(count: int) -> str:
    return "stplan: 1\nhorizon: 20\nagents:\n" + "".join(
        f"  - id: a{k}\n    start: [{k}.0, 0.0]\n    goal: [{k}.0, 5.0]\n    radius: 0.2\n"
        "    weights: {kinetic: 1.0, acceleration: 0, arrival: 0, collision: 1, wall: 1}\n"
        for k in range(count)
    )


def test_a_thousand_agents_are_read_in_time():
    text = crowd(1000)
    began = time.process_time()
    scene = parse_scene(text)
    assert time.process_time() - began < 3.0
    assert len(scene.agents) == 1000


def test_overlaps_are_found_in_every_block_of_rows():
    text = crowd(1200)
    for old, new in (("a700", "a699"), ("a1199", "a3")):
        k, other = old[1:], new[1:]
        text = text.replace(f"start: [{k}.0, 0.0]", f"start: [{other}.0, 0.1]")
    with pytest.raises(SceneError) as refused:
        parse_scene(text)
    assert [message.split(": ")[1:3] for message in refused.value.messages] == [
        [
            f"agents[{k}].start",
            f"is 0.1 m from the start of '{other}', and both start at once; "
            "more than 0.4 m is expected of agents that collide",
        ]
        for k, other in ((700, "a699"), (1199, "a3"))
    ]


def test_too_many_agents():
    text = "stplan: 1\nhorizon: 9\nagents: [" + "{id: a}, " * 10_001 + "]"
    with pytest.raises(SceneError, match=r"agents: is a list of 10001; at most 10000 is expected"):
        parse_scene(text)


def test_overlaps_agree_with_the_arrays_of_pairs():
    """The blocks of rows decide as `scene_interactions` does, rule by rule."""
    generator = np.random.default_rng(3)
    for _ in range(20):
        places = generator.uniform(0, 3, (6, 2)).round(2)
        rules = "".join(
            f"  - {{between: [{generator.choice(['a0', 'a1', 'all', '[a2, a3]'])}, "
            f"{generator.choice(['a4', '[a1, a5]', 'all'])}], {what}}}\n"
            for what in ("distance: 0.2", "collide: false", "distance: 1.5", "collide: true")
            if generator.random() < 0.7
        )
        agents = "".join(
            f"  - {{id: a{k}, start: [{x}, {y}], goal: [{9 * k}, 50], radius: 0.3}}\n"
            for k, (x, y) in enumerate(places)
        )
        apart = "".join(
            f"  - {{id: a{k}, start: [{9 * k}, 0], goal: [{9 * k}, 50], radius: 0.3}}\n"
            for k in range(6)
        )
        head = "stplan: 1\nhorizon: 9\n" + (f"pairs:\n{rules}" if rules else "")
        pairs = scene_interactions(parse_scene(f"{head}agents:\n{apart}"))
        gap = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
        near = np.tril(pairs.collides & (gap <= pairs.distance), -1).any(axis=1)
        try:
            parse_scene(f"{head}agents:\n{agents}")
            found = []
        except SceneError as error:
            found = [message.split(": ")[1] for message in error.messages]
        assert found == [f"agents[{k}].start" for k in np.nonzero(near)[0]]


def test_a_crowd_on_one_spot_is_told_briefly():
    agents = (f"id: a{k}, start: [0, 0], goal: [9, {k}]" for k in range(300))
    assert len(refusals(agents_text(*agents))) < 300
