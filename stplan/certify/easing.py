"""Agents that start too near each other and are eased apart: from when on they are clear of each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.amounts import amount
from stplan.arrays import FloatArray, IntArray
from stplan.certify.local_frame import LocalFrame
from stplan.problem.continuation import piece_of, place_at
from stplan.problem.world_lines import WorldLines
from stplan.scene.interactions import PairSettings
from stplan.scene.model import Scene

# Pairs are clear when they are further apart than they have to be by this share of it.
CLEAR = 1e-6


@dataclass(frozen=True)
class EasedPair:
    """Two agents that start too near each other.

    Attributes:
        apart: between their centres at the start, m.
        needed: what they have to exceed, m.
        clear: from when on they do, s; None where they never do.
    """

    who: tuple[str, str]
    apart: float
    needed: float
    clear: float | None

    def __str__(self) -> str:
        """In words."""
        when = "never clear" if self.clear is None else f"clear from {amount(self.clear)} s on"
        return (
            f"{' and '.join(self.who)} start {amount(self.apart)} m apart, too near: {when} "
            f"(more than {amount(self.needed)} m)"
        )


def too_near_at_start(scene: Scene) -> tuple[IntArray, FloatArray]:
    """Pairs (P, 2) that start at one time nearer than they may, and what they have to exceed (P,), m."""
    starts = np.array([agent.start for agent in scene.agents])
    times = np.array([agent.start_time for agent in scene.agents])
    settings = PairSettings(scene)
    gaps = np.hypot(*np.moveaxis(starts[:, None] - starts[None], -1, 0))
    near = gaps <= 2.0 * settings.half_distances().max()
    pairs = np.argwhere(np.triu(settings.colliding() & near & (times[:, None] == times[None, :])))
    needs = settings.distances(pairs)
    close = gaps[pairs[:, 0], pairs[:, 1]] <= needs
    return pairs[close].astype(np.int64), needs[close]


def eased_pairs(
    scene: Scene, lines: WorldLines, frame: LocalFrame
) -> tuple[IntArray, tuple[EasedPair, ...]]:
    """Pairs (P, 2) of `scene` that `lines`, in scene order, ease apart, and how; none unless allowed."""
    if scene.overlap != "ease":
        return np.empty((0, 2), dtype=np.int64), ()
    pairs, needs = too_near_at_start(scene)
    found = []
    for (a, b), need in zip(pairs.tolist(), needs.tolist(), strict=True):
        one, other = lines.curve(a), lines.curve(b)
        apart = float(np.hypot(*(one[0, :2] - other[0, :2])))
        clear = _clear_from(one, other, need * (1.0 + CLEAR) + 2.0 * frame.rounding)
        names = scene.agents[a].id, scene.agents[b].id
        found.append(EasedPair(names, apart, need, clear))
    return pairs, tuple(found)


def rest_of(lines: WorldLines, pair: tuple[int, int], begin: float) -> WorldLines:
    """The curves of two agents from a time on; who has arrived by then stands."""
    curves = []
    for a in pair:
        curve = lines.curve(a)
        end = float(curve[-1, 2])
        if begin < end:
            curves.append(piece_of(curve, begin, end))
        else:
            place = place_at(curve, begin)
            curves.append(np.vstack([place, place + np.array([0.0, 0.0, 1.0])]))
    return WorldLines.from_curves([lines.agent_ids[a] for a in pair], curves)


def _clear_from(one: FloatArray, other: FloatArray, need: float) -> float | None:
    """When two curves that begin together are first `need` m apart, s; None where they never are."""
    times = np.union1d(one[:, 2], other[:, 2])
    places = [
        np.column_stack([np.interp(times, curve[:, 2], curve[:, axis]) for axis in range(2)])
        for curve in (one, other)
    ]
    offset = places[0] - places[1]
    far = np.hypot(*offset.T) >= need
    if not far.any():
        return None
    k = int(far.argmax())
    if k == 0:
        return float(times[0])
    # Within the last of these steps the offset leaves the disc once, for it begins inside.
    head, step = offset[k - 1], offset[k] - offset[k - 1]
    square, mixed = float(step @ step), float(head @ step)
    root = np.sqrt(max(mixed**2 - square * (float(head @ head) - need**2), 0.0))
    share = min((root - mixed) / square, 1.0)
    return float(times[k - 1] + share * (times[k] - times[k - 1]))
