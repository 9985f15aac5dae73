"""Who is near some of many agents, looked for around these alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.costs.formulation import Formulation
from stplan.geometry.rod_distances import segment_distances
from stplan.geometry.rod_neighbours import near_segments
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.restriction import Piece, surroundings
from stplan.problem.surroundings import Surroundings
from stplan.scene.interactions import pair_clearances

# Stretches of a rod out of view no longer than so many segments are not left out.
SHORT_GAP = 2
# Two agents that keep apart.
APART = np.array([[False, True], [True, False]])
# What an agent takes of the room towards another one that is moved at the same time.
SHARE = 0.5


class NearSegments(NamedTuple):
    """Pairs of segments of agents asked about and others, near each other.

    Attributes:
        own: (N,) segments of the one.
        other: (N,) of the other.
    """

    own: IntArray
    other: IntArray


class Boxes(NamedTuple):
    """What every agent's rod stays within, in (x, y, c t).

    Attributes:
        low, high: (A, 3) m.
    """

    low: FloatArray
    high: FloatArray

    def renewed(self, agents: IntArray, boxes: Boxes) -> Boxes:
        """With the `boxes` of some `agents` in the place of theirs."""
        low, high = self.low.copy(), self.high.copy()
        low[agents], high[agents] = boxes
        return Boxes(low, high)


class Surveyor:
    """Looks around agents of `problem`."""

    def __init__(self, problem: PlanningProblem, formulation: Formulation) -> None:
        self._problem = problem
        self._rods, self._layout = formulation.rods, formulation.layout
        self._range = formulation.scales.pair_reach
        self._wish = pair_clearances(problem.scene)
        self._furthest, self._widest = (
            float(array.max(where=problem.collides, initial=0.0))
            for array in (problem.distance, self._range)
        )
        self._wished = 0.0 if self._wish is None else float(self._wish.max())
        self._partners = _partners(problem)
        # The segment in which each agent stands on its goal, -1 where it does not.
        self._tails = np.full(problem.num_agents, -1)
        own = self._rods.num_curve_segments
        self._tails[self._rods.agents[own:]] = np.arange(own, len(self._rods.segments))

    def with_partners(self, agents: IntArray) -> IntArray:
        """`agents`, and those whose motion is prescribed that they meet or are drawn to."""
        partners = [other for agent in agents.tolist() for other in self._partners.get(agent, ())]
        return np.unique(np.append(agents, np.array(partners, dtype=np.int64)))

    def boxes(self, knots: FloatArray, agents: IntArray) -> Boxes:
        """Boxes around the rods of `agents` (B,) alone, (B, 3) each."""
        scale = np.array([1.0, 1.0, self._rods.time_scale])
        rows, starts = _rows(self._layout.first[agents], self._layout.num_segments[agents] + 1)
        low = scale * np.minimum.reduceat(knots[rows], starts)
        high = scale * np.maximum.reduceat(knots[rows], starts)
        tails = self._tails[agents]
        stays = tails >= 0
        high[stays, 2] = np.maximum(high[stays, 2], self._ends(knots, tails[stays])[:, 1, 2])
        return Boxes(low, high)

    def near(
        self, knots: FloatArray, agents: IntArray, view: float, boxes: Boxes | None = None
    ) -> NearSegments:
        """Segments of others that come nearer than they keep, and `view` ranges more.

        Of `agents` those are asked about that plan. `boxes` are those of all agents, where they are known.
        """
        rods, problem = self._rods, self._problem
        inside = np.zeros(problem.num_agents, dtype=bool)
        inside[agents] = True
        asked = inside & ~problem.prescribed
        if boxes is None:
            boxes = self.boxes(knots, np.arange(problem.num_agents))
        chosen = self._around(knots, boxes, asked, ~inside, view)
        mine = asked[rods.agents[chosen]]
        if mine.all() or not mine.any():
            none = np.empty(0, dtype=np.int64)
            return NearSegments(none, none)
        ends = self._ends(knots, chosen).reshape(-1, 3)
        segments = np.arange(2 * len(chosen)).reshape(-1, 2)
        # As two agents, those asked about and all others, within the furthest reach of all pairs; what
        # each pair keeps is looked up of those found alone: squares of all in the box are large.
        pairs = near_segments(
            ends, segments, np.where(mine, 0, 1), APART, np.full((2, 2), self._furthest_view(view)),
            mine,
        )  # fmt: skip
        gaps = segment_distances(ends, segments, pairs)
        own, other = chosen[pairs].T
        who = rods.agents[own], rods.agents[other]
        near = problem.collides[who] & (gaps < self._reach(view, who))
        return NearSegments(own[near], other[near])

    def pairs_in_view(self, knots: FloatArray, view: float) -> IntArray:
        """(N, 2) pairs a < b of agents that come nearer than they keep and `view` ranges more, each once."""
        rods, problem = self._rods, self._problem
        pairs = near_segments(
            rods.positions(knots), rods.segments, rods.agents, problem.collides, self._reach(view)
        )
        first, second = rods.agents[pairs].T
        codes = np.unique(first * problem.num_agents + second)
        return np.column_stack(np.divmod(codes, problem.num_agents)).astype(np.int64)

    def around(
        self,
        knots: FloatArray,
        agents: IntArray,
        view: float,
        beside: IntArray | None = None,
        strength: float = 1.0,
        boxes: Boxes | None = None,
    ) -> Surroundings | None:
        """What is in view of `agents`; None where nobody is. `boxes` as for `near`.

        From agents `beside` they keep half of what is between them as well. Barriers around those who plan,
        too, are `strength` times as strong.
        """
        near = self.near(knots, agents, view, boxes)
        pieces = self._pieces(knots, np.unique(near.other))
        if not pieces:
            return None
        found = surroundings(self._problem, agents, pieces, self._layout.num_segments, self._wish)
        owners = np.unique([piece.agent for piece in pieces])
        if strength != 1.0:
            found = _strengthened(found, ~self._problem.prescribed[owners], strength)
        if beside is None or not len(beside):
            return found
        return _shared(found, *self._gaps(knots, near, agents, owners, beside))

    def _furthest_view(self, view: float) -> float:
        """No pair keeps more, with `view` ranges more, m."""
        return self._furthest + view * self._widest + (self._wished if view else 0.0)

    def _reach(self, view: float, pairs: tuple[IntArray, ...] | None = None) -> FloatArray:
        """What all pairs or some keep, and `view` ranges more, m."""
        problem, chosen = self._problem, ... if pairs is None else pairs
        reach: FloatArray = problem.distance[chosen] + view * self._range[chosen]
        return reach if self._wish is None or not view else reach + self._wish[chosen]

    def _around(
        self, knots: FloatArray, boxes: Boxes, asked: BoolArray, others: BoolArray, view: float
    ) -> IntArray:
        """Segments of agents `asked` about, and those of `others` within reach of the box around them.

        Of all agents only the boxes around their rods are looked at.
        """
        low, high = boxes
        reach = self._furthest_view(view)
        least = low[asked].min(axis=0, initial=np.inf) - reach
        greatest = high[asked].max(axis=0, initial=-np.inf) + reach
        within = (low <= greatest).all(axis=1) & (high >= least).all(axis=1)
        chosen = self._segments_of(np.flatnonzero(asked | (others & within)))
        ends = self._ends(knots, chosen)
        low, high = ends.min(axis=1), ends.max(axis=1)
        within = (low <= greatest).all(axis=1) & (high >= least).all(axis=1)
        return chosen[asked[self._rods.agents[chosen]] | within]

    def _segments_of(self, agents: IntArray) -> IntArray:
        """All segments of `agents`, sorted."""
        # Every agent before one has a knot more than segments.
        first, counts = self._layout.first[agents] - agents, self._layout.num_segments[agents]
        tails = self._tails[agents]
        return np.concatenate([_rows(first, counts)[0], np.sort(tails[tails >= 0])])

    def _ends(self, knots: FloatArray, segments: IntArray) -> FloatArray:
        """(N, 2, 3) both ends of `segments` in (x, y, c t), m."""
        rods = self._rods
        index = rods.segments[segments]
        moving = index < rods.num_knots
        ends = np.empty((*index.shape, 3))
        ends[moving] = knots[index[moving]] * [1.0, 1.0, rods.time_scale]
        ends[~moving] = rods.fixed_points[index[~moving] - rods.num_knots]
        return ends

    def _pieces(self, knots: FloatArray, near: IntArray) -> list[Piece]:
        """The stretches of curves with segments `near`."""
        rods, layout = self._rods, self._layout
        own = rods.num_curve_segments
        tails = set(rods.agents[near[near >= own]].tolist())
        seen: dict[int, list[int]] = {agent: [] for agent in tails}
        for segment in near[near < own].tolist():
            agent = int(layout.agent_of_segment[segment])
            seen.setdefault(agent, []).append(int(layout.segment[segment] - layout.first[agent]))
        pieces = []
        for agent in sorted(seen):
            last = int(layout.num_segments[agent]) - 1
            curve = knots[layout.first[agent] : layout.last[agent] + 1]
            segments = sorted({*seen[agent], *([last] if agent in tails else [])})
            for run in _runs(segments):
                stretch = curve[run[0] : run[-1] + 2].copy()
                pieces.append(Piece(agent, stretch, agent in tails and run[-1] == last))
        return pieces

    def _gaps(
        self,
        knots: FloatArray,
        near: NearSegments,
        agents: IntArray,
        owners: IntArray,
        beside: IntArray,
    ) -> tuple[IntArray, IntArray, FloatArray]:
        """Places of pairs of one of `agents` and one `beside` in view, and their rods' distance (N,)."""
        rods = self._rods
        own, other = rods.agents[near.own], rods.agents[near.other]
        kept = np.isin(other, beside)
        pairs = np.column_stack([near.own[kept], near.other[kept]])
        distance = segment_distances(rods.positions(knots), rods.segments, pairs)
        row = np.searchsorted(agents, own[kept])
        column = len(agents) + np.searchsorted(owners, other[kept])
        codes, place = np.unique(row * (len(agents) + len(owners)) + column, return_inverse=True)
        least = np.full(len(codes), np.inf)
        np.minimum.at(least, place, distance)
        row, column = np.divmod(codes, len(agents) + len(owners))
        return row, column, least


def _rows(first: IntArray, counts: IntArray) -> tuple[IntArray, IntArray]:
    """Runs of so many (B,) rows from `first` (B,) on, one after another, and where each begins."""
    starts = np.cumsum(counts) - counts
    rows: IntArray = np.arange(counts.sum()) + np.repeat(first - starts, counts)
    return rows, starts


def _shared(found: Surroundings, row: IntArray, column: IntArray, gap: FloatArray) -> Surroundings:
    """`found` with a share of what is between pairs to be kept as well."""
    distance = found.interactions.distance.copy()
    kept = distance[row, column]
    distance[row, column] = kept + (1.0 - SHARE) * np.maximum(gap - kept, 0.0)
    distance[column, row] = distance[row, column]
    return replace(found, interactions=replace(found.interactions, distance=distance))


def _strengthened(found: Surroundings, which: BoolArray, strength: float) -> Surroundings:
    """`found` with stronger barriers around those of `which` (B,)."""
    weight = found.interactions.collision_weight.copy()
    owners = len(weight) - len(which) + np.flatnonzero(which)
    weight[:, owners] *= strength
    weight[owners, :] *= strength
    return replace(found, interactions=replace(found.interactions, collision_weight=weight))


def _partners(problem: PlanningProblem) -> dict[int, list[int]]:
    """Whom with prescribed motion every agent that plans meets or is drawn to."""
    prescribed = problem.prescribed
    found: dict[int, list[int]] = {}
    if not prescribed.any():
        return found
    pairs = [(one.first, one.second) for one in problem.meetings]
    first, second = np.nonzero(problem.interactions.grouping > 0.0)
    pairs += zip(first.tolist(), second.tolist(), strict=True)
    for pair in pairs:
        for agent, other in (pair, pair[::-1]):
            if prescribed[other] and not prescribed[agent]:
                found.setdefault(agent, []).append(other)
    return found


def _runs(segments: Sequence[int]) -> list[list[int]]:
    """Increasing indices cut where more than `SHORT_GAP` are left out."""
    runs: list[list[int]] = []
    for segment in segments:
        if runs and segment - runs[-1][-1] <= SHORT_GAP + 1:
            runs[-1].append(segment)
        else:
            runs.append([segment])
    return runs
