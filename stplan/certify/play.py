"""The certificate of a scene whose goals move: what any scene promises, and that captures are right.

Where robots have tasks, all of these are done.

Everybody is there until the end of the play, but for who is caught: its curve ends at the very moment at
which a pursuer has come near enough, and not later. Who is caught need not come to rest, and its last
segment counts as long as the one before.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stplan.amounts import amount, distinct
from stplan.arrays import FloatArray
from stplan.certify.certificate import Certificate, certify
from stplan.certify.ends import agents_that_differ
from stplan.certify.motion import motion_peaks, place_tolerance, time_tolerance
from stplan.certify.tasks import done_tasks
from stplan.problem.continuation import curves_of
from stplan.problem.ends import ending_as, last_moment
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Agent, Scene
from stplan.scene.moving_goals import captures

if TYPE_CHECKING:
    from stplan.world import FreeSpace


def certify_play(scene: Scene, space: FreeSpace | None, lines: WorldLines) -> Certificate:
    """Check `lines` (in any order) against a `scene` whose goals move."""
    missing = agents_that_differ(scene, lines)
    curves = curves_of(lines)
    for name, curve in curves.items():
        if len(curve) < 2 or not np.isfinite(curve).all() or (np.diff(curve[:, 2]) <= 0).any():
            missing.append(f"{name}: needs at least two finite knots whose times increase")
    if missing:
        return Certificate(tuple(missing), (), (), 0, 0)
    end = last_moment(lines)
    shown = ending_as(scene, lines)
    caught = {name for name, curve in curves.items() if curve[-1, 2] < end}
    free = [
        replace(agent, max_acceleration=None) if agent.id in caught else agent
        for agent in shown.agents
    ]
    found = certify(replace(shown, agents=tuple(free)), space, lines)
    if found.violations and not (found.pairs or found.walls):
        return found
    peaks = {(peak.agent, peak.limit): peak for peak in found.limits}
    for agent in shown.agents:
        if agent.id in caught:
            own = motion_peaks(agent, _uncut(curves[agent.id]), comes_to_rest=False)
            peaks |= {(peak.agent, peak.limit): peak for peak in own}
    broken = [str(peak) for peak in peaks.values() if not peak.holds]
    sentences = [*found.violations, *broken, *_broken_captures(scene, curves, end)]
    sentences += done_tasks(scene, curves)[1]
    return replace(found, violations=tuple(dict.fromkeys(sentences)), limits=tuple(peaks.values()))


def _uncut(curve: FloatArray) -> FloatArray:
    """A curve whose last segment, cut short by a capture, lasts at least as long as the one before."""
    step = np.diff(curve, axis=0)
    longer = max(1.0, float(step[max(len(step) - 2, 0), 2] / step[-1, 2]))
    return np.vstack([curve[:-1], curve[-2] + longer * step[-1]])


def _broken_captures(scene: Scene, curves: dict[str, FloatArray], end: float) -> list[str]:
    """A sentence for everybody who leaves uncaught, or should have left before it does."""
    agents = scene.agents
    sentences = []
    hunted: dict[int, list[tuple[Agent, float]]] = {}
    for a, b, capture in captures(scene):
        hunted.setdefault(b, []).append((agents[a], capture))
    for b, agent in enumerate(agents):
        curve = curves[agent.id]
        leaves, tolerance = float(curve[-1, 2]), place_tolerance(agent, curve)
        held = leaves >= end
        for pursuer, capture in hunted.get(b, []):
            other = curves[pursuer.id]
            last = min(leaves, float(other[-1, 2]))
            times = np.union1d(curve[:, 2], other[:, 2])
            times = times[(times >= max(curve[0, 2], other[0, 2])) & (times <= last)]
            gap = _at(curve, times) - _at(other, times)
            when = first_within(gap, times, capture - tolerance)
            if when is not None and when < leaves - time_tolerance(curve):
                early, late = distinct(when, leaves)
                sentences.append(
                    f"{agent.id}: is within {amount(capture)} m of {pursuer.id} at {early} s, "
                    f"and there until {late} s"
                )
            held |= other[-1, 2] >= leaves and np.hypot(*gap[-1]) <= capture + tolerance
        if not held:
            sentences.append(f"{agent.id}: leaves at {amount(leaves)} s, caught by nobody")
    return sentences


def _at(curve: FloatArray, times: FloatArray) -> FloatArray:
    return np.column_stack([np.interp(times, curve[:, 2], curve[:, x]) for x in range(2)])


def first_within(offsets: FloatArray, times: FloatArray, reach: float) -> float | None:
    """When offsets (n, 2), linear between `times` (n,), are first no longer than `reach`; None if never."""
    if np.hypot(*offsets[0]) <= reach:
        return float(times[0])
    heads, step = offsets[:-1], np.diff(offsets, axis=0)
    a = (step**2).sum(axis=1)
    b = (heads * step).sum(axis=1)
    c = (heads**2).sum(axis=1) - reach**2
    root = b**2 - a * c
    enters = (root >= 0.0) & (b < 0.0) & (a > 0.0)
    share = np.where(enters, (-b - np.sqrt(np.maximum(root, 0.0))) / np.where(a > 0.0, a, 1.0), 2.0)
    inside = np.flatnonzero((share >= 0.0) & (share <= 1.0))
    if not len(inside):
        return None
    k = int(inside[0])
    return float(times[k] + share[k] * (times[k + 1] - times[k]))
