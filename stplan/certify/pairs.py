"""Whether every pair of agents keeps its distance, and which pairs come closest.

Where there are few pairs, each is listed. Where there are many, only those that come near each other are
looked at, and of them the tightest are listed: of all others it is proven that they keep further apart.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stplan.amounts import distinct, place
from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.certify.easing import EasedPair, eased_pairs, rest_of
from stplan.certify.local_frame import LocalFrame
from stplan.certify.near_pairs import near_pairs
from stplan.certify.pair_clearance import NearestMoments, nearest_moments, nearest_moments_of
from stplan.certify.tightest import Tightest, Unlisted
from stplan.problem.world_lines import WorldLines
from stplan.scene.interactions import PairSettings
from stplan.scene.model import Scene

# Up to so many pairs (200 agents) are listed one by one.
LISTED = 20_000
# Of more pairs, so many are listed, and so many too near each other are named.
TIGHTEST = 1_000
# Pairs are near that leave less than this share of the largest distance to be kept; where there are none, the
# reach grows by the factor.
FIRST_REACH, FURTHER = 0.5, 4.0


@dataclass(frozen=True)
class PairFindings:
    """What is said of pairs: rows, what is not listed, how many are not demanded, broken promises.

    Attributes:
        eased: those that start too near each other, where that is allowed.
    """

    spots: tuple[Tightest, ...]
    unlisted: Unlisted | None
    ignored: int
    violations: list[str]
    eased: tuple[EasedPair, ...] = ()


def check_pairs(
    scene: Scene, lines: WorldLines, leaves: FloatArray, frame: LocalFrame
) -> PairFindings:
    """Distances of all pairs that have to keep one.

    Args:
        lines: in scene order, their places in `frame`.
        leaves: (A,) until when each agent is present, s.
    """
    settings = PairSettings(scene)
    wanted = settings.colliding()
    pairs, eased = eased_pairs(scene, lines, frame)
    rests = [
        _from_clear(scene, lines, leaves, (a, b), one, frame)
        for (a, b), one in zip(pairs.tolist(), eased, strict=True)
    ]
    wanted[pairs[:, 0], pairs[:, 1]] = wanted[pairs[:, 1], pairs[:, 0]] = False
    demanded = int(np.count_nonzero(wanted)) // 2
    ignored = len(wanted) * (len(wanted) - 1) // 2 - demanded - len(pairs)
    if demanded <= LISTED:
        found = nearest_moments(lines, leaves, wanted)
        needs = settings.distances(found.pairs)
        rows = np.flatnonzero(np.isfinite(found.distance))
        unlisted, named = None, rows
    else:
        found, needs, reach = _near(settings, lines, leaves, wanted, frame)
        clearance = found.distance - needs
        order = np.argsort(clearance, kind="stable")
        order = order[clearance[order] <= reach]
        rows = named = order[:TIGHTEST]
        following = clearance[order[TIGHTEST]] if len(order) > TIGHTEST else reach
        unlisted = Unlisted(demanded - len(rows), float(following - frame.rounding))
    broken = _too_near(found.distance, needs, frame)
    spots = _spots(scene, found, needs, rows, frame)
    sentences = [
        _sentence(spot, float(found.distance[k]), float(needs[k]), frame)
        for spot, k in zip(spots, named.tolist(), strict=True)
        if broken[k]
    ]
    more = int(broken.sum()) - len(sentences)
    if more:
        sentences.append(f"{more} further pairs of agents are too near each other")
    spots += tuple(spot for spot, _ in rests if spot is not None)
    sentences += [sentence for _, sentence in rests if sentence]
    return PairFindings(spots, unlisted, ignored, sentences, eased)


def _from_clear(
    scene: Scene,
    lines: WorldLines,
    leaves: FloatArray,
    pair: tuple[int, int],
    eased: EasedPair,
    frame: LocalFrame,
) -> tuple[Tightest | None, str]:
    """The tightest spot of a pair from the moment it is clear, and what is wrong with it, or ""."""
    if eased.clear is None:
        return None, str(eased)
    ends = leaves[list(pair)]
    if (ends <= eased.clear).any():
        return None, ""
    found = nearest_moments_of(
        rest_of(lines, pair, eased.clear), ends, np.array([[0, 1]], dtype=np.int64)
    )
    needs = np.array([eased.needed])
    row = replace(found, pairs=np.array([pair]))
    (spot,) = _spots(scene, row, needs, np.array([0]), frame)
    if not _too_near(found.distance, needs, frame)[0]:
        return spot, ""
    return spot, _sentence(spot, float(found.distance[0]), eased.needed, frame)


def _near(
    settings: PairSettings,
    lines: WorldLines,
    leaves: FloatArray,
    wanted: BoolArray,
    frame: LocalFrame,
) -> tuple[NearestMoments, FloatArray, float]:
    """The pairs that come near each other, their distances to be kept, and what all others keep on top."""
    halves = settings.half_distances()
    reach = FIRST_REACH * 2.0 * float(halves.max())
    # No two places of the frame are further apart.
    furthest = 2.0 * float(np.hypot(*np.abs(lines.knots[:, :2]).max(axis=0)))
    while True:
        pairs: IntArray = near_pairs(lines, leaves, wanted, halves + 0.5 * reach, frame.rounding)
        found = nearest_moments_of(lines, leaves, pairs)
        needs = settings.distances(pairs)
        if (found.distance - needs <= reach).any() or reach > furthest:
            return found, needs, reach
        reach *= FURTHER


def _too_near(distance: FloatArray, needs: FloatArray, frame: LocalFrame) -> BoolArray:
    """Which pairs are not proven to be further apart; a sum of radii is rounded, too."""
    return distance <= np.nextafter(needs, np.inf) + frame.rounding


def _spots(
    scene: Scene, found: NearestMoments, needs: FloatArray, rows: IntArray, frame: LocalFrame
) -> tuple[Tightest, ...]:
    clearance = found.distance[rows] - needs[rows]
    columns = (found.pairs[rows], clearance, found.instant[rows], frame.outside(found.middle[rows]))
    return tuple(
        Tightest((scene.agents[a].id, scene.agents[b].id), gap, when, (x, y))
        for (a, b), gap, when, (x, y) in zip(*(column.tolist() for column in columns), strict=True)
    )


def _sentence(spot: Tightest, gap: float, needed: float, frame: LocalFrame) -> str:
    first, second = spot.who
    apart, least = distinct(gap, needed, digits=6)
    sentence = (
        f"{first} and {second}: {apart} m apart at t = {spot.time:.6g} s, "
        f"{place(*spot.place)}; more than {least} m is needed"
    )
    return (
        sentence if gap <= needed else f"{sentence}, by more than rounding ({frame.rounding:.2g} m)"
    )
