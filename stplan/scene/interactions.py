"""Who interacts with whom, at which distance and how strongly, as arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.scene.model import Meet, Scene


@dataclass(frozen=True)
class Interactions:
    """Arrays over pairs of agents, symmetric (A, A) for those of a scene; no agent is paired with itself.

    Attributes:
        collides: the pair must keep its distance (both weights 0, or `collide: false`, is off).
        distance: R_ab in m, the comfort distance (r_a + r_b unless overridden).
        collision_weight: K^C_ab, the mean of both agents' weights unless overridden.
        grouping: K^G_ab >= 0, 0 where the pair is not grouped.
    """

    collides: BoolArray
    distance: FloatArray
    collision_weight: FloatArray
    grouping: FloatArray

    def equals(self, other: Interactions) -> bool:
        """Whether all arrays are the same."""
        return all(np.array_equal(one, vars(other)[name]) for name, one in vars(self).items())


class PairSettings:
    """What every pair of agents of `scene` has set, later rules winning over earlier ones."""

    def __init__(self, scene: Scene) -> None:
        self._radii = np.array([agent.radius for agent in scene.agents])
        self._weights = np.array([agent.weights.collision for agent in scene.agents])
        self._rules = [
            (np.array(rule.left, dtype=np.int64), np.array(rule.right, dtype=np.int64), rule)
            for rule in scene.pairs
            if any(
                value is not None
                for value in (rule.distance, rule.grouping, rule.collide, rule.collision)
            )
        ]

    def between(self, rows: IntArray, columns: IntArray) -> Interactions:
        """(R, C) settings of agents `rows` (R,) with agents `columns` (C,), each named once."""
        # Of thousands of agents making room for a square takes longest: each is made once.
        distance = np.add.outer(self._radii[rows], self._radii[columns])
        weight = np.add.outer(self._weights[rows], self._weights[columns])
        weight /= 2
        collides = np.ones(distance.shape, dtype=bool)
        drawn = any(rule.grouping is not None for _, _, rule in self._rules)
        # Of many agents a square that says nothing would take more memory than all the rest.
        grouping = np.zeros_like(distance) if drawn else np.broadcast_to(0.0, distance.shape)
        row_of, column_of = self._places(rows), self._places(columns)
        for left, right, rule in self._rules:
            for one, other in ((left, right), (right, left)):
                r, c = row_of[one], column_of[other]
                where = np.ix_(r[r >= 0], c[c >= 0])
                if rule.distance is not None:
                    distance[where] = rule.distance
                if rule.grouping is not None:
                    grouping[where] = rule.grouping
                if rule.collide is not None:
                    collides[where] = rule.collide
                if rule.collision is not None:
                    weight[where] = rule.collision
        collides &= weight > 0
        same = rows[:, None] == columns[None, :]
        collides[same] = False
        if drawn:
            grouping[same] = 0.0
        return Interactions(collides, distance, weight, grouping)

    def colliding(self) -> BoolArray:
        """`Interactions.collides` of all agents, (A, A), without the rest."""
        count = len(self._radii)
        collides = np.ones((count, count), dtype=bool)
        careless = self._weights <= 0
        minds = ~(careless[:, None] & careless[None, :])
        for left, right, rule in self._rules:
            if rule.collide is not None:
                collides[np.ix_(left, right)] = collides[np.ix_(right, left)] = rule.collide
            if rule.collision is not None:
                minds[np.ix_(left, right)] = minds[np.ix_(right, left)] = True
        collides &= minds
        np.fill_diagonal(collides, False)
        return collides

    def distances(self, pairs: IntArray) -> FloatArray:
        """`Interactions.distance` of `pairs` (P, 2) alone, (P,) in m."""
        first, second = pairs.T
        distance = self._radii[first] + self._radii[second]
        for left, right, rule in self._rules:
            if rule.distance is not None:
                one, other = (np.zeros(len(self._radii), dtype=bool) for _ in range(2))
                one[left] = other[right] = True
                where = one[first] & other[second] | other[first] & one[second]
                distance[where] = rule.distance
        return distance

    def half_distances(self) -> FloatArray:
        """(A,) in m; no pair has to keep more than the sum of both."""
        halves = self._radii.copy()
        for left, right, rule in self._rules:
            if rule.distance is not None:
                members = np.union1d(left, right)
                halves[members] = np.maximum(halves[members], 0.5 * rule.distance)
        return halves

    def _places(self, chosen: IntArray) -> IntArray:
        """(A,) where each agent stands in `chosen`, -1 where it does not."""
        places = np.full(len(self._radii), -1, dtype=np.int64)
        places[chosen] = np.arange(len(chosen))
        return places


def scene_interactions(scene: Scene) -> Interactions:
    """Arrays of all pair settings of `scene`."""
    everyone = np.arange(len(scene.agents))
    return PairSettings(scene).between(everyone, everyone)


def pair_clearances(scene: Scene) -> FloatArray | None:
    """(A, A) clearance in m that pairs wish for beyond their distance; None where nobody wishes for any."""
    own = np.array([agent.clearance for agent in scene.agents])
    rules = [rule for rule in scene.pairs if rule.clearance is not None]
    if not own.any() and not rules:
        return None
    wish: FloatArray = np.maximum(own[:, None], own[None, :])
    for rule in rules:
        wish[np.ix_(rule.left, rule.right)] = rule.clearance
        wish[np.ix_(rule.right, rule.left)] = rule.clearance
    return wish


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
