"""All rods at once, with an index (`Occupancy`) that answers quickly whether a new segment would be clear.

The index lists in every cell of space-time the agents whose rods pass through. Entering a rod only adds
to it: what an agent has left behind costs a little time but never an answer. Positions are in
(x, y, c t), m.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.axes import TIME, in_metres, in_seconds
from stplan.compiled import inlined, inner, kernel
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.grid import Cells, Query, cells_of_box, make_cells, make_query
from stplan.geometry.growable import with_room
from stplan.geometry.segments import Point, space_time_point, squared_distance
from stplan.geometry.wall_distances import clear_of_walls
from stplan.problem.clearance import STRICT
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement
from stplan.seeding.elastic_bands.bands import waypoint_knots

# Room for knots that moves add, over what the curves need at first.
SPARE_KNOTS = 8
# Cells for every segment of the curves, at most.
CELLS_PER_SEGMENT = 8


class Occupancy(NamedTuple):
    """Which agents' rods pass through which cells, as linked lists that grow.

    Attributes:
        cells: where.
        heads: (total,) first entry of every cell, -1 without any.
        entries: (n, 2) agent, and the next entry of the same cell or -1.
        used: (1,) entries in use.
    """

    cells: Cells
    heads: IntArray
    entries: IntArray
    used: IntArray


class RodField(NamedTuple):
    """Rods (A agents, room for K knots each), what they have to keep, and the index.

    Attributes:
        knots: (A, K, 3), of which the first `counts` (A,) are in use.
        pinned: (A, K) knots on waypoints.
        tops: (A,) where an agent's tail ends, -inf without a tail.
        required, wall_gaps: (A, A) and (A,) distances to exceed, m; negative where nothing is asked.
        widest: (A,) largest distance an agent has to keep from anybody.
        occupancy: the index.
        walls: None in the open plane.
        query, wall_query: working memory of questions to the index and to the walls, if any.
        stamps, clock: (A,), (1,) who was compared during the present question.
    """

    knots: FloatArray
    counts: IntArray
    pinned: BoolArray
    tops: FloatArray
    required: FloatArray
    wall_gaps: FloatArray
    widest: FloatArray
    occupancy: Occupancy
    walls: BoundaryGrid | None
    query: Query
    wall_query: Query | None
    stamps: IntArray
    clock: IntArray

    def with_rods(self, agents: IntArray) -> RodField:
        """The field with the rods of `agents` entered into its index."""
        return self.with_entries(enter_rods(self, agents))

    def with_entries(self, entries: IntArray) -> RodField:
        """The field with other `entries` of its index."""
        return self._replace(occupancy=self.occupancy._replace(entries=entries))

    def curve(self, problem: PlanningProblem, agent: int) -> FloatArray:
        """An agent's curve in (x, y, t), ends exact to the last bit."""
        path = problem.paths[agent]
        if path is not None:
            return path.copy()
        curve = in_seconds(self.knots[agent, : self.counts[agent]], problem.time_scale)
        curve[0] = [*problem.starts[agent], problem.start_times[agent]]
        arrival = min(curve[-1, TIME], problem.max_times[agent])
        preferred = problem.preferred_times[agent]
        if abs(arrival - preferred) <= 1e-9 * abs(preferred):
            arrival = preferred
        curve[-1] = [*problem.goals[agent], arrival]
        return curve


def build_field(
    problem: PlanningProblem, curves: Sequence[FloatArray], required: Requirement, room: int = 0
) -> RodField:
    """The field of `curves` with room for at least `room` knots an agent."""
    counts = np.array([len(curve) for curve in curves], dtype=np.int64)
    knots = np.zeros((len(curves), max(int(counts.max()) + SPARE_KNOTS, room), 3))
    pinned = np.zeros(knots.shape[:2], dtype=bool)
    for agent, curve in enumerate(curves):
        knots[agent, : len(curve)] = in_metres(curve, problem.time_scale)
        if problem.paths[agent] is None:
            pinned[agent, waypoint_knots(problem.waypoints[agent], curve)] = True
    top = problem.time_scale * problem.final_time
    wanted = required.rods * STRICT
    wanted[~problem.collides] = -1.0
    widest = wanted.max(axis=1)
    everything = np.vstack([knots[a, :n] for a, n in enumerate(counts)])
    low, high = everything.min(axis=0), everything.max(axis=0)
    high[TIME] = max(high[TIME], top)
    num_segments = int(counts.sum())
    size = max(float(np.median(widest)), 1e-6 * float((high - low).max()))
    cells = make_cells(low, high, size, CELLS_PER_SEGMENT * num_segments + 64)
    heeds = problem.heeds_walls & (problem.boundary is not None)
    walls = problem.boundary
    field = RodField(
        knots=knots,
        counts=counts,
        pinned=pinned,
        tops=np.where(problem.stays, top, -np.inf),
        required=wanted,
        wall_gaps=np.where(heeds, required.walls * STRICT, -1.0),
        widest=widest,
        occupancy=Occupancy(
            cells=cells,
            heads=np.full(cells.total, -1, dtype=np.int64),
            entries=np.empty((8 * num_segments + 1024, 2), dtype=np.int64),
            used=np.zeros(1, dtype=np.int64),
        ),
        walls=walls,
        query=make_query(cells),
        wall_query=None if walls is None else make_query(walls.grid.cells),
        stamps=np.zeros(len(curves), dtype=np.int64),
        clock=np.zeros(1, dtype=np.int64),
    )
    return field.with_rods(np.arange(len(curves)))


@kernel
def enter_rods(field: RodField, agents: IntArray) -> IntArray:
    """Enter the rods of `agents` into the index; returns its entries, which may have grown."""
    entries = field.occupancy.entries
    for k in range(len(agents)):
        entries = enter_rod(field, entries, agents[k])
    return entries


@inner
def enter_rod(field: RodField, entries: IntArray, agent: int) -> IntArray:
    """Enter an agent's rod and its tail; returns the index's `entries`, which may have grown."""
    cells, heads, used = field.occupancy.cells, field.occupancy.heads, field.occupancy.used
    knots, count, top = field.knots[agent], field.counts[agent], field.tops[agent]
    for i in range(count):
        p, q = _segment(knots, count, top, i)
        pieces = num_pieces(p, q, cells.size)
        for k in range(pieces):
            _box_of_piece(p, q, k, pieces, 0.0, field.query)
            for r in range(cells_of_box(cells, field.query)):
                first, past = field.query.runs[r, 0], field.query.runs[r, 1]
                entries = with_room(entries, used[0] + past - first)
                for cell in range(first, past):
                    entry = heads[cell]
                    while entry >= 0 and entries[entry, 0] != agent:
                        entry = entries[entry, 1]
                    if entry < 0:
                        entries[used[0], 0] = agent
                        entries[used[0], 1] = heads[cell]
                        heads[cell] = used[0]
                        used[0] += 1
    return entries


@inlined
def with_entries(field: RodField, entries: IntArray) -> RodField:
    """The field with other `entries` of its index."""
    occupancy = field.occupancy
    return RodField(
        field.knots, field.counts, field.pinned, field.tops, field.required, field.wall_gaps,
        field.widest, Occupancy(occupancy.cells, occupancy.heads, entries, occupancy.used),
        field.walls, field.query, field.wall_query, field.stamps, field.clock,
    )  # fmt: skip


@inlined
def _segment(knots: FloatArray, count: int, top: float, i: int) -> tuple[Point, Point]:
    """Segment i of a rod; that of the last knot is the tail up to `top`, or the knot itself."""
    p = space_time_point(knots, i)
    if i < count - 1:
        return p, space_time_point(knots, i + 1)
    return p, (p[0], p[1], max(p[2], top))


@inlined
def num_pieces(p: Point, q: Point, longest: float) -> int:
    """Into how many pieces no longer than `longest` (m) along an axis a segment is cut."""
    extent = max(abs(q[0] - p[0]), abs(q[1] - p[1]), abs(q[2] - p[2]))
    return int(extent / longest) + 1


@inlined
def _box_of_piece(p: Point, q: Point, k: int, pieces: int, reach: float, query: Query) -> None:
    """Ask with the box around piece k of the segment p q, `reach` (m) wider on every side."""
    for x in range(len(p)):
        head = p[x] + (q[x] - p[x]) * (k / pieces)
        tail = p[x] + (q[x] - p[x]) * ((k + 1) / pieces)
        query.low[x] = min(head, tail) - reach
        query.high[x] = max(head, tail) + reach


@inner
def segment_clear(field: RodField, agent: int, p: FloatArray, q: FloatArray) -> bool:
    """Whether the segment p q would keep an agent's rod clear of all others and of the walls."""
    if not clear_of_walls(p, q, field.wall_gaps[agent], field.walls, field.wall_query):
        return False
    cells, heads, entries = field.occupancy.cells, field.occupancy.heads, field.occupancy.entries
    field.clock[0] += 1
    now = field.clock[0]
    head, tail = (p[0], p[1], p[2]), (q[0], q[1], q[2])
    pieces = num_pieces(head, tail, cells.size)
    for k in range(pieces):
        _box_of_piece(head, tail, k, pieces, field.widest[agent], field.query)
        for r in range(cells_of_box(cells, field.query)):
            for cell in range(field.query.runs[r, 0], field.query.runs[r, 1]):
                entry = heads[cell]
                while entry >= 0:
                    other = entries[entry, 0]
                    entry = entries[entry, 1]
                    gap = field.required[agent, other]
                    if field.stamps[other] == now or gap <= 0.0:
                        continue
                    field.stamps[other] = now
                    count, top = field.counts[other], field.tops[other]
                    if not _clear_of_rod(field.knots[other], count, top, head, tail, gap):
                        return False
    return True


@inner
def _clear_of_rod(
    knots: FloatArray, count: int, top: float, p: Point, q: Point, gap: float
) -> bool:
    """Whether the segment p q (p before q) is further than `gap` from one rod."""
    low = 0
    high = count - 1
    while low < high:
        middle = (low + high) // 2
        if knots[min(middle + 1, count - 1), TIME] >= p[TIME] - gap:
            high = middle
        else:
            low = middle + 1
    west, east = min(p[0], q[0]) - gap, max(p[0], q[0]) + gap
    south, north = min(p[1], q[1]) - gap, max(p[1], q[1]) + gap
    for j in range(low, count):
        if knots[j, TIME] > q[TIME] + gap:
            break
        u, v = _segment(knots, count, top, j)
        if min(u[0], v[0]) > east or max(u[0], v[0]) < west:
            continue
        if min(u[1], v[1]) > north or max(u[1], v[1]) < south:
            continue
        if squared_distance(p, q, u, v) <= gap * gap:
            return False
    return True
