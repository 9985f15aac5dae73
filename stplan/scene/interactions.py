"""Who interacts with whom, at which distance and how strongly, as arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import BoolArray, FloatArray
from stplan.scene.model import Meet, Scene


@dataclass(frozen=True)
class Interactions:
    """Symmetric (A, A) arrays over pairs of agents; diagonals are off.

    Attributes:
        collides: the pair must keep its distance (both weights 0, or `collide: false`, is off).
        distance: R_ab in m, the comfort distance (r_a + r_b unless overridden).
        collision_weight: K^C_ab, the mean of both agents' weights.
        grouping: K^G_ab >= 0, 0 where the pair is not grouped.
    """

    collides: BoolArray
    distance: FloatArray
    collision_weight: FloatArray
    grouping: FloatArray


def scene_interactions(scene: Scene) -> Interactions:
    """Arrays of all pair settings of `scene`, later rules winning over earlier ones."""
    radii = np.array([agent.radius for agent in scene.agents])
    weights = np.array([agent.weights.collision for agent in scene.agents])
    distance = radii[:, None] + radii[None, :]
    collision_weight = (weights[:, None] + weights[None, :]) / 2
    collides = np.ones(distance.shape, dtype=bool)
    grouping = np.zeros_like(distance)
    for rule in scene.pairs:
        for rows, columns in ((rule.left, rule.right), (rule.right, rule.left)):
            where = np.ix_(rows, columns)
            if rule.distance is not None:
                distance[where] = rule.distance
            if rule.grouping is not None:
                grouping[where] = rule.grouping
            if rule.collide is not None:
                collides[where] = rule.collide
    collides &= collision_weight > 0
    np.fill_diagonal(collides, False)
    np.fill_diagonal(grouping, 0.0)
    return Interactions(collides, distance, collision_weight, grouping)


@dataclass(frozen=True)
class Meeting:
    """Agents `first` < `second` have to meet as `meet` says."""

    first: int
    second: int
    meet: Meet


def scene_meetings(scene: Scene) -> tuple[Meeting, ...]:
    """Every pair that has to meet, sorted; of several rules about a pair the last counts."""
    found: dict[tuple[int, int], Meet] = {}
    for rule in scene.pairs:
        if rule.meet is None:
            continue
        for a in rule.left:
            for b in rule.right:
                if a != b:
                    found[min(a, b), max(a, b)] = rule.meet
    return tuple(Meeting(a, b, meet) for (a, b), meet in sorted(found.items()))
