"""The elastic bands of all agents as flat arrays, and the curves they start from.

Moving segments come first, then those of prescribed paths, then the tails of agents that stay. All
positions are in (x, y, c t), m.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.axes import PLACE, TIME, in_metres, in_seconds
from stplan.problem.clearance import crosses_boundary
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.verification import PLACE_TOLERANCE
from stplan.seeding.elastic_bands.block_tridiagonal import FIXED, FREE, PINNED
from stplan.seeding.shortcutting.resampling import resample_curve


class Bands(NamedTuple):
    """A agents' bands; only `positions` and `rest_rises` change.

    Attributes:
        positions: (P, 3) knots of the curves agent by agent, then the ends of the tails.
        hold: (P,) FREE, PINNED or FIXED.
        first_knot, num_knots: (A,) an agent's knots.
        segments: (S, 2) indices of positions.
        agents: (S,) owner of every segment.
        first_segment: (A,) where a moving agent's segments begin.
        num_moving: how many segments move.
        radii: (A,) in m.
        ceilings: (A,) latest c t of a band's end, m.
        rest_rises: (A,) rise in c t that tension leaves a segment where the end may slide, m.
    """

    positions: FloatArray
    hold: IntArray
    first_knot: IntArray
    num_knots: IntArray
    segments: IntArray
    agents: IntArray
    first_segment: IntArray
    num_moving: int
    radii: FloatArray
    ceilings: FloatArray
    rest_rises: FloatArray

    @staticmethod
    def build(problem: PlanningProblem, curves: Sequence[FloatArray]) -> Bands:
        """Bands along `curves`, one an agent; prescribed paths as they are."""
        fixed = problem.prescribed
        count = np.array([len(curve) for curve in curves], dtype=np.int64)
        first = np.cumsum(count) - count
        tails = np.flatnonzero(problem.stays)
        ends = np.column_stack(
            [problem.goals[tails], np.full(len(tails), problem.time_scale * problem.final_time)]
        )
        agents = np.concatenate([np.flatnonzero(~fixed), np.flatnonzero(fixed)]).astype(np.int64)
        heads = [first[a] + np.arange(count[a] - 1) for a in agents]
        head = np.concatenate([*heads, first[tails] + count[tails] - 1])
        tail = np.concatenate([*(own + 1 for own in heads), count.sum() + np.arange(len(tails))])
        rises = problem.time_scale * (problem.preferred_times - problem.start_times)
        first_segment = np.zeros(len(curves), dtype=np.int64)
        first_segment[agents] = np.cumsum(count[agents] - 1) - (count[agents] - 1)
        sliding = may_slide(problem)
        knots = [in_metres(curve, problem.time_scale) for curve in curves]
        return Bands(
            positions=np.ascontiguousarray(np.vstack([*knots, ends])),
            hold=np.concatenate(
                [_hold(problem, a, curve, sliding[a]) for a, curve in enumerate(curves)]
                + [np.full(len(tails), FIXED)]
            ).astype(np.int64),
            first_knot=first,
            num_knots=count,
            segments=np.column_stack([head, tail]).astype(np.int64),
            agents=np.concatenate([np.repeat(agents, count[agents] - 1), tails]).astype(np.int64),
            first_segment=first_segment,
            num_moving=int((count[~fixed] - 1).sum()),
            radii=problem.radii,
            ceilings=problem.time_scale * problem.max_times,
            rest_rises=np.where(sliding, rises / np.maximum(count - 1, 1), 0.0),
        )

    def knots(self, agent: int) -> FloatArray:
        """An agent's positions, a view."""
        begin = self.first_knot[agent]
        return self.positions[begin : begin + self.num_knots[agent]]

    def curves(self, problem: PlanningProblem) -> list[FloatArray]:
        """All curves in (x, y, t), ends exact to the last bit."""
        result = []
        for agent, path in enumerate(problem.paths):
            if path is not None:
                result.append(path.copy())
                continue
            curve = in_seconds(self.knots(agent), problem.time_scale)
            last = self.first_knot[agent] + self.num_knots[agent] - 1
            curve[0] = [*problem.starts[agent], problem.start_times[agent]]
            arrival = min(curve[-1, TIME], problem.max_times[agent])
            if self.hold[last] == FIXED:
                arrival = problem.preferred_times[agent]
            curve[-1] = [*problem.goals[agent], arrival]
            result.append(curve)
        return result


def may_slide(problem: PlanningProblem) -> BoolArray:
    """(A,) agents whose arrival may move: earlier where the rod ends with it, or both ways."""
    return ~problem.prescribed & (~problem.stays | (problem.preferred_times < problem.max_times))


def _hold(problem: PlanningProblem, agent: int, curve: FloatArray, slides: bool) -> IntArray:
    """What of every knot may move, where the end `slides` or does not."""
    if problem.paths[agent] is not None:
        return np.full(len(curve), FIXED, dtype=np.int64)
    hold = np.full(len(curve), FREE, dtype=np.int64)
    hold[waypoint_knots(problem.waypoints[agent], curve)] = PINNED
    hold[0] = FIXED
    hold[-1] = PINNED if slides else FIXED
    return hold


def waypoint_knots(waypoints: FloatArray, curve: FloatArray) -> IntArray:
    """Indices of the knots that lie on the waypoints, in order; a missed one is left out."""
    found = []
    after = 0
    for point in waypoints:
        hits = np.flatnonzero(np.abs(curve[after:, PLACE] - point).max(axis=1) <= PLACE_TOLERANCE)
        if len(hits):
            after += int(hits[0])
            found.append(after)
    return np.array(found, dtype=np.int64)


def straight_curves(problem: PlanningProblem) -> list[FloatArray]:
    """Constant speed along straight lines through the waypoints, arriving when preferred."""
    curves = []
    for agent, path in enumerate(problem.paths):
        if path is not None:
            curves.append(path.copy())
            continue
        start, goal = problem.starts[agent], problem.goals[agent]
        places = np.vstack([start, problem.waypoints[agent], goal])
        length = np.hypot(*np.diff(places, axis=0).T)
        # Legs of no length still take time: a tenth of an even share.
        length = np.maximum(length, max(0.1 * float(length.mean()), 1e-9))
        part = np.concatenate([[0.0], np.cumsum(length)]) / length.sum()
        begin, end = problem.start_times[agent], problem.preferred_times[agent]
        curves.append(np.column_stack([places, begin + part * (end - begin)]))
        curves[-1][-1, TIME] = end
    return curves


def initial_curves(
    problem: PlanningProblem,
    given: Sequence[FloatArray] | None,
    num_knots: int,
    rng: np.random.Generator,
) -> list[FloatArray]:
    """`given` curves (or straight ones) with `num_knots` knots, each bent a little.

    A bow sideways and a shift in time, at most one radius each, break symmetries; neither moves
    ends or waypoints, and a bow through a wall is left out.
    """
    bases = straight_curves(problem) if given is None else given
    bows = rng.uniform(-1.0, 1.0, (problem.num_agents, 2))
    curves = []
    for agent, base in enumerate(bases):
        if problem.paths[agent] is not None:
            curves.append(problem.paths[agent])
            continue
        curve = resample_curve(_until(base, float(problem.preferred_times[agent])), num_knots)
        curves.append(_bent(problem, agent, curve, bows[agent]))
    return [np.asarray(curve) for curve in curves]


def _until(curve: FloatArray, arrival: float) -> FloatArray:
    """`curve` stretched in time so that it ends at `arrival`."""
    times = curve[:, TIME]
    begin = times[0]
    result = curve.copy()
    result[:, TIME] = begin + (times - begin) * ((arrival - begin) / (times[-1] - begin))
    result[-1, TIME] = arrival
    return result


def _bent(problem: PlanningProblem, agent: int, curve: FloatArray, bow: FloatArray) -> FloatArray:
    """`curve` with a bow of bow[0] and a shift in c t of bow[1] radii on every leg."""
    stops = [0, *waypoint_knots(problem.waypoints[agent], curve).tolist(), len(curve) - 1]
    sideways = np.zeros((len(curve), 2))
    later = np.zeros(len(curve))
    radius = float(problem.radii[agent])
    for head, tail in pairwise(stops):
        leg = curve[head : tail + 1]
        if tail - head < 2:
            continue
        duration = leg[-1, TIME] - leg[0, TIME]
        wave = np.sin(np.pi * (leg[:, TIME] - leg[0, TIME]) / duration)
        wave[-1] = 0.0
        chord = leg[-1, PLACE] - leg[0, PLACE]
        length = float(np.hypot(*chord))
        if length > 1e-9:
            normal = np.array([-chord[1], chord[0]]) / length
            sideways[head : tail + 1] = radius * bow[0] * wave[:, None] * normal
        # The slope of the wave must not turn time round.
        most = 0.25 * duration
        shift = np.clip(radius * bow[1] / problem.time_scale, -most, most)
        later[head : tail + 1] = shift * wave
    result = curve.copy()
    result[:, TIME] += later
    bent = result.copy()
    bent[:, PLACE] += sideways
    if crosses_boundary(problem, agent, bent) and not crosses_boundary(problem, agent, result):
        return result
    return bent
