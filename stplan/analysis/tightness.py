"""What is tight: the pairs and the walls that leave least room, exactly, over continuous time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stplan.analysis.crowd import Crowd
from stplan.arrays import IntArray
from stplan.certify.certificate import Certificate
from stplan.certify.near_pairs import near_pairs
from stplan.certify.pair_clearance import nearest_moments_of
from stplan.certify.wall_clearance import time_at, wall_distances

# A clearance is tight below this share of the distance that is kept.
TIGHT = 0.1
# Of more pairs than this only those are looked at whose clearance is at some time below so many median radii.
MOST_PAIRS, REACH = 200_000, 4.0


@dataclass(frozen=True)
class TightSpot:
    """A least clearance (m) of two agents, or of one and the walls; when (s) and where (m).

    Attributes:
        needed: the distance of centres, or to the wall, that has to be kept.
        place: halfway between the centres, or on the path.
    """

    who: tuple[str, ...]
    clearance: float
    needed: float
    time: float
    place: tuple[float, float]

    @property
    def share(self) -> float:
        """The clearance as a share of what is needed."""
        return self.clearance / self.needed


def certified_spots(
    crowd: Crowd, certificate: Certificate
) -> tuple[list[TightSpot], list[TightSpot]]:
    """What the certificate of the crowd's curves found of pairs and of walls, in its order."""
    row = {agent_id: a for a, agent_id in enumerate(crowd.lines.agent_ids)}
    pairs = []
    for spot in certificate.pairs:
        a, b = (row[name] for name in spot.who)
        needed = float(crowd.distance[a, b])
        pairs.append(TightSpot(spot.who, spot.clearance, needed, spot.time, spot.place))
    walls = []
    for spot in certificate.walls:
        needed = float(crowd.radii[row[spot.who[0]]])
        walls.append(TightSpot(spot.who, spot.clearance, needed, spot.time, spot.place))
    return pairs, walls


def pairs_to_look_at(crowd: Crowd) -> IntArray:
    """(P, 2) pairs a < b that keep their distance: all of them, in large crowds those that come near."""
    wanted = np.triu(crowd.collides, 1)
    if np.count_nonzero(wanted) <= MOST_PAIRS:
        return np.argwhere(wanted)
    halves = 0.5 * (crowd.distance.max(axis=1) + REACH * float(np.median(crowd.radii)))
    return near_pairs(crowd.lines, crowd.leaves, crowd.collides, halves)


def pair_spots(crowd: Crowd) -> list[TightSpot]:
    """The tightest spot of every pair to look at that is there together, tightest first."""
    found = nearest_moments_of(crowd.lines, crowd.leaves, pairs_to_look_at(crowd))
    together = np.isfinite(found.distance)
    a, b = found.pairs[together].T
    needs = crowd.distance[a, b]
    clearance = found.distance[together] - needs
    columns = (a, b, clearance, needs, found.instant[together], found.middle[together])
    ids = crowd.lines.agent_ids
    spots = [
        TightSpot((ids[first], ids[second]), gap, needed, when, (x, y))
        for first, second, gap, needed, when, (x, y) in zip(
            *(column.tolist() for column in columns), strict=True
        )
    ]
    return sorted(spots, key=lambda spot: spot.clearance)


def wall_spots(crowd: Crowd) -> list[TightSpot]:
    """The tightest spot of every agent that heeds walls, tightest first."""
    heeding = np.flatnonzero(crowd.heeds_walls).tolist()
    if crowd.free_space is None or not heeding:
        return []
    curves = [crowd.lines.curve(a) for a in heeding]
    found = wall_distances(crowd.free_space, curves)
    spots = []
    for a, curve, distance, place in zip(
        heeding, curves, found.distance.tolist(), found.place, strict=True
    ):
        who, radius = (crowd.lines.agent_ids[a],), float(crowd.radii[a])
        x, y = place.tolist()
        spots.append(TightSpot(who, distance - radius, radius, time_at(curve, place), (x, y)))
    return sorted(spots, key=lambda spot: spot.clearance)


def tightest(spots: Sequence[TightSpot]) -> list[TightSpot]:
    """Those of `spots` that are tight, by their share of what is needed."""
    tight = [spot for spot in spots if spot.share < TIGHT]
    return sorted(tight, key=lambda spot: spot.share)
