"""Lists of contacts, and how far around which knots each is complete."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class ContactList:
    """C contacts sorted by group.

    Attributes:
        points: (C, 4) indices of positions, see `stplan.geometry.contacts`.
        keys: (G,) what each group is (a pair of agents, an agent), increasing.
        starts: (G + 1,) first contact of every group.
        members: (C,) group of every contact.
    """

    points: IntArray
    keys: IntArray
    starts: IntArray
    members: IntArray

    @staticmethod
    def grouped(points: IntArray, key_of_contact: IntArray) -> ContactList:
        """Sort contacts by key, keeping the order inside a group."""
        order = np.argsort(key_of_contact, kind="stable")
        ordered = key_of_contact[order]
        new = _differ(ordered)
        first = np.flatnonzero(new)
        starts = np.append(first, len(order)).astype(np.int64)
        members = np.cumsum(new) - 1
        return ContactList(np.ascontiguousarray(points[order]), ordered[first], starts, members)

    def kept(self, keep: BoolArray) -> ContactList:
        """The contacts with `keep` (C,), in the same order."""
        return ContactList.grouped(self.points[keep], self.keys[self.members[keep]])


def distinct(codes: IntArray) -> IntArray:
    """`codes` (n,), each once, sorted: many times as fast as `np.unique`."""
    ordered = np.sort(codes)
    return ordered[_differ(ordered)]


def _differ(ordered: IntArray) -> BoolArray:
    """(n,) which entries differ from the one before."""
    new = np.ones(len(ordered), dtype=bool)
    np.not_equal(ordered[1:], ordered[:-1], out=new[1:])
    return new


class Candidates(Protocol):
    """Broad phase: who may matter to whom."""

    @property
    def axis_scale(self) -> FloatArray:
        """(3,) derivative of a position's axis by the knot's (1, 1, c; or 1, 1, 0 in the plane)."""
        ...

    def positions(self, knots: FloatArray) -> FloatArray:
        """(P, 3) positions in m, the knots first."""
        ...

    def find(self, knots: FloatArray, skin: float) -> ContactList:
        """Every contact that may matter while no position moves by more than skin / 2."""
        ...

    def renew(self, old: ContactSet, knots: FloatArray, moved: BoolArray) -> ContactSet:
        """The set after some knots have `moved` (M,) too far for the `old` one."""
        ...


@dataclass(frozen=True)
class ContactSet:
    """A list of contacts and where it is complete: a value, replaced as the iterate moves on.

    Attributes:
        candidates: where contacts come from.
        around: (M, 3) knots that the list is good around.
        skin: it misses nobody while no position moves by more than half of this, m.
        contacts: the list.
    """

    candidates: Candidates
    around: FloatArray
    skin: float
    contacts: ContactList

    @staticmethod
    def fresh(candidates: Candidates, knots: FloatArray, skin: float) -> ContactSet:
        """The set made anew around `knots` (M, 3)."""
        return ContactSet(candidates, knots.copy(), skin, candidates.find(knots, skin))

    def moved(self, knots: FloatArray) -> BoolArray:
        """(M,) knots too far from where the list is good."""
        step = (knots - self.around) * self.candidates.axis_scale
        far: BoolArray = 4.0 * (step**2).sum(axis=1) > self.skin**2
        return far

    def renewed(self, knots: FloatArray) -> ContactSet:
        """A set that is complete at `knots`: this one where it is, with fresh contacts where not."""
        moved = self.moved(knots)
        return self.candidates.renew(self, knots, moved) if moved.any() else self
