"""Which segments of colliding rods come near each other."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.costs.contacts.contact_set import ContactList, ContactSet
from stplan.costs.contacts.smooth_minimum import NEGLIGIBLE
from stplan.geometry.contacts import measure
from stplan.geometry.rod_distances import segment_distances
from stplan.geometry.rod_neighbours import near_segments
from stplan.problem.rods import Rods

# Past this share of moved knots the list is made anew, which costs less than to mend it.
MANY = 0.3


class BroadPhase(Protocol):
    """Finds near pairs of segments of different rods."""

    def __call__(
        self,
        positions: FloatArray,
        segments: IntArray,
        agents: IntArray,
        collides: BoolArray,
        reach: FloatArray,
        asked: BoolArray | None = None,
        *,
        skin: float = 0.0,
    ) -> IntArray:
        """(N, 2) pairs i, j with agents[i] < agents[j] nearer than `reach` (A, A) and `skin` in m, sorted
        unless only those with a segment that is `asked` (S,) for are wanted.
        """
        ...


def brute_force(
    positions: FloatArray,
    segments: IntArray,
    agents: IntArray,
    collides: BoolArray,
    reach: FloatArray,
    asked: BoolArray | None = None,
    *,
    skin: float = 0.0,
) -> IntArray:
    """All pairs are looked at: quadratic, for small scenes and for reaches without end."""
    i, j = np.triu_indices(len(agents), 1)
    i, j = np.where(agents[i] <= agents[j], i, j), np.where(agents[i] <= agents[j], j, i)
    keep = (agents[i] != agents[j]) & collides[agents[i], agents[j]]
    if asked is not None:
        keep &= asked[i] | asked[j]
    pairs = np.column_stack([i[keep], j[keep]])
    limit = reach[agents[pairs[:, 0]], agents[pairs[:, 1]]] + skin
    if not np.isinf(limit).all():
        pairs = pairs[segment_distances(positions, segments, pairs) < limit]
    return pairs


@dataclass(frozen=True)
class RodCandidates:
    """Pairs of segments of colliding agents whose rods' distance may be felt.

    Attributes:
        rods: segments and tails.
        collides: (A, A).
        reach: (A, A) m, the distance from which on a pair feels nothing; inf where there is none.
        broad_phase: finds near pairs of segments.
        sharpness: (A * A,) 1/m of smooth minima, in which distant contacts do not weigh; None where
            every contact is felt on its own.
        negligible: contacts further than this over alpha beyond the nearest do not weigh.
    """

    rods: Rods
    collides: BoolArray
    reach: FloatArray
    broad_phase: BroadPhase = near_segments
    sharpness: FloatArray | None = None
    negligible: float = NEGLIGIBLE

    @cached_property
    def axis_scale(self) -> FloatArray:
        """(1, 1, c)."""
        return np.array([1.0, 1.0, self.rods.time_scale])

    def positions(self, knots: FloatArray) -> FloatArray:
        """(M + T, 3) positions of knots and tail ends."""
        return self.rods.positions(knots)

    def find(self, knots: FloatArray, skin: float) -> ContactList:
        """Pairs of segments nearer than what is felt, and the skin."""
        positions = self.positions(knots)
        contacts = self._contacts(self._near(positions, skin))
        if self.sharpness is not None:
            contacts = weighty(contacts, positions, self.sharpness, skin, self.negligible)
        return contacts

    def renew(self, old: ContactSet, knots: FloatArray, moved: BoolArray) -> ContactSet:
        """Only around knots that have `moved`: mostly few slide far along their own rods.

        Everybody stays within half a skin of the place that the list knows, so it misses nobody.
        """
        if self.sharpness is not None or not self._finite or moved.mean() > MANY:
            return ContactSet.fresh(self, knots, old.skin)
        around = np.where(moved[:, None], knots, old.around)
        ends = np.append(moved, np.zeros(len(self.rods.fixed_points), dtype=bool))
        touched: BoolArray = ends[self.rods.segments].max(axis=1)
        pairs = self._segment_of_point[old.contacts.points[:, ::2]]
        kept = pairs[~touched[pairs].max(axis=1)]
        pairs = np.vstack([kept, self._near(self.positions(around), old.skin, touched)])
        pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
        return ContactSet(self, around, old.skin, self._contacts(pairs))

    @cached_property
    def _finite(self) -> bool:
        finite = np.isfinite(self.reach)
        return bool(finite.all() or (finite | ~self.collides).all())

    @cached_property
    def _segment_of_point(self) -> IntArray:
        """(P,) the segment that begins at a position; every segment and tail has a beginning of its own."""
        begins = self.rods.segments[:, 0]
        result = np.full(int(self.rods.segments.max(initial=0)) + 1, -1)
        result[begins] = np.arange(len(begins))
        return result

    def _near(self, positions: FloatArray, skin: float, asked: BoolArray | None = None) -> IntArray:
        rods = self.rods
        find = self.broad_phase if self._finite else brute_force
        asked = rods.moving if asked is None else asked
        return find(
            positions, rods.segments, rods.agents, self.collides, self.reach, asked, skin=skin
        )

    def _contacts(self, pairs: IntArray) -> ContactList:
        segments, agents = self.rods.segments, self.rods.agents
        first, second = agents[pairs[:, 0]], agents[pairs[:, 1]]
        points = np.hstack([segments[pairs[:, 0]], segments[pairs[:, 1]]])
        return ContactList.grouped(points, first * len(self.reach) + second)


def weighty(
    contacts: ContactList,
    positions: FloatArray,
    sharpness: FloatArray,
    skin: float,
    negligible: float = NEGLIGIBLE,
) -> ContactList:
    """The contacts that weigh in their group's smooth minimum, now or after moving by half a skin.

    Args:
        sharpness: 1/m by key.
    """
    if not len(contacts.points):
        return contacts
    distance = measure(positions, contacts.points).distance
    least = np.minimum.reduceat(distance, contacts.starts[:-1])
    limit = least + negligible / sharpness[contacts.keys] + 2 * skin
    return contacts.kept(distance < limit[contacts.members])
