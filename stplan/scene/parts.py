"""A scene of some of its agents."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from stplan.scene.model import Agent, Scene


def part_of(scene: Scene, kept: Sequence[int], agents: Sequence[Agent]) -> Scene:
    """`scene` of `agents` alone, which stand for those that are `kept` (indices); nobody is assigned."""
    place = {a: index for index, a in enumerate(kept)}
    rules = []
    for rule in scene.pairs:
        left = tuple(place[a] for a in rule.left if a in place)
        right = tuple(place[a] for a in rule.right if a in place)
        if left and right:
            rules.append(replace(rule, left=left, right=right))
    paths = tuple(scene.agent_path(a) for a in kept)
    return replace(
        scene,
        agents=tuple(agents),
        pairs=tuple(rules),
        assignments=(),
        agent_paths=paths,
        changes=(),
    )
