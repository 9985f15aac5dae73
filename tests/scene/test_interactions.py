"""Pair settings against the rules applied pair by pair, and who is present until when."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.errors import SceneError
from stplan.scene import Scene, parse_scene, scene_interactions
from stplan.scene.interactions import PairSettings
from stplan.scene.presence import present_until

COUNT = 12


def crowd(rules: str) -> Scene:
    """Agents far apart, every third without a weight on collisions."""
    agents = "\n".join(
        f"  - {{id: a{k}, start: [{9 * k}, 0], goal: [{9 * k}, 9], radius: {0.1 + 0.01 * k}, "
        f"weights: {{collision: {k % 3}}}, after_arrival: {'stay' if k % 2 else 'vanish'}}}"
        for k in range(COUNT)
    )
    return parse_scene(f"stplan: 1\nhorizon: 20\npairs: [{rules}]\nagents:\n{agents}\n")


RULES = """{between: [all, all], collide: false}, {between: [[a1, a2, a5], all], collide: true},
 {between: [[a1, a4], [a4, a7]], distance: 0.7, grouping: 2}, {between: [a4, a7], distance: 0.5},
 {between: [a0, [a3, a4]], collision: 2.5}, {between: [a0, a3], collide: true}"""


def test_pair_by_pair() -> None:
    scene = crowd(RULES)
    settings = PairSettings(scene)
    rows, columns = np.array([7, 1, 4, 0]), np.array([4, 2, 1, 9, 7, 3])
    found = settings.between(rows, columns)
    for r, a in enumerate(rows.tolist()):
        for c, b in enumerate(columns.tolist()):
            first, second = scene.agents[a], scene.agents[b]
            distance, grouping, collides = first.radius + second.radius, 0.0, True
            weight = None
            for rule in scene.pairs:
                here = (a in rule.left and b in rule.right) or (b in rule.left and a in rule.right)
                if here:
                    distance = rule.distance or distance
                    grouping = rule.grouping or grouping
                    weight = rule.collision or weight
                    collides = collides if rule.collide is None else rule.collide
            weight = weight or (first.weights.collision + second.weights.collision) / 2
            assert found.distance[r, c] == distance
            assert found.grouping[r, c] == (0 if a == b else grouping)
            assert found.collision_weight[r, c] == weight
            assert found.collides[r, c] == (a != b and collides and weight > 0)
    whole = scene_interactions(scene)
    assert (whole.collides[np.ix_(rows, columns)] == found.collides).all()
    assert (whole.collides == whole.collides.T).all()
    assert (whole.distance == whole.distance.T).all()


def test_a_pair_that_collides_again_cannot_meet_closer() -> None:
    rules = "{between: [all, all], collide: false}, {between: [a1, a2], collide: true},"
    assert crowd(f"{rules} {{between: [a1, a4], meet: {{within: 0.1}}}}").pairs[-1].meet is not None
    with pytest.raises(
        SceneError, match=r"'a1' and 'a2' meet within 0\.1 m, but keep more than 0\.23"
    ):
        crowd(f"{rules} {{between: [a1, [a4, a2]], meet: {{within: 0.1}}}}")


def test_staying_agents_are_present_until_the_end() -> None:
    arrivals = np.linspace(1.0, 5.0, COUNT)
    leaves = present_until(np.arange(COUNT) % 2 == 1, arrivals, 20.0)
    assert leaves[1::2].tolist() == [20.0] * (COUNT // 2)
    assert leaves[::2].tolist() == arrivals[::2].tolist()


def test_collision_of_every_agent_or_of_every_pair_says_the_same() -> None:
    head = "stplan: 1\nhorizon: 9\n"
    sam = "  - {id: sam, start: [0, 0], goal: [9, 0]}"
    agents = f"agents:\n{sam}\n  - {{id: ann, start: [9, 2], goal: [0, 2]}}\n"
    by_agent = parse_scene(f"{head}defaults: {{weights: {{collision: 2}}}}\n{agents}")
    by_pair = parse_scene(f"{head}{agents}pairs: [{{between: [all, all], collision: 2}}]\n")
    weights = [scene_interactions(one).collision_weight for one in (by_agent, by_pair)]
    assert weights[0][0, 1] == 2.0
    assert np.array_equal(weights[0][[0, 1], [1, 0]], weights[1][[0, 1], [1, 0]])
