"""All rods at once, with an index that answers quickly whether a new segment would be clear.

The index is a uniform grid over (x, y, c t) whose cells list the agents whose rods pass through.
Moves only add entries: one left behind costs a little time but never an answer. Positions are in
(x, y, c t), m.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import kernel
from stplan.geometry.rod_distances import clear_of_walls
from stplan.geometry.segments import squared_distance
from stplan.problem.clearance import STRICT
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement
from stplan.seeding.elastic_bands.bands import waypoint_knots

# Room for knots that moves add, and for entries of the index, over what the curves need at first.
SPARE_KNOTS = 8
SPARE_ENTRIES = 4
# Cells for every segment of the curves, at most.
CELLS_PER_SEGMENT = 8


class RodField(NamedTuple):
    """Rods (A agents, room for K knots each), what they have to keep, and the index.

    Attributes:
        knots: (A, K, 3), of which the first `counts` (A,) are in use.
        pinned: (A, K) knots on waypoints.
        tops: (A,) where an agent's tail ends, -inf without a tail.
        required, walls: (A, A) and (A,) distances to exceed, m; negative where nothing is asked.
        widest: (A,) largest distance an agent has to keep from anybody.
        origin, cell, shape: corner (3,), side and numbers (3,) of the cells.
        heads, links, tenants: linked lists of the agents in every cell.
        used: (2,) entries in use, and whether they ran out (then nothing counts as clear).
        stamps, clock: (A,), (1,) who was compared during the present question.
        edges, wall_origin, wall_cell, wall_shape, wall_starts, wall_members: a `BoundaryGrid`.
    """

    knots: FloatArray
    counts: IntArray
    pinned: BoolArray
    tops: FloatArray
    required: FloatArray
    walls: FloatArray
    widest: FloatArray
    origin: FloatArray
    cell: float
    shape: IntArray
    heads: IntArray
    links: IntArray
    tenants: IntArray
    used: IntArray
    stamps: IntArray
    clock: IntArray
    edges: FloatArray
    wall_origin: FloatArray
    wall_cell: float
    wall_shape: IntArray
    wall_starts: IntArray
    wall_members: IntArray

    def curve(self, problem: PlanningProblem, agent: int) -> FloatArray:
        """An agent's curve in (x, y, t), ends exact to the last bit."""
        path = problem.paths[agent]
        if path is not None:
            return path.copy()
        curve = self.knots[agent, : self.counts[agent]] / [1.0, 1.0, problem.time_scale]
        curve[0] = [*problem.starts[agent], problem.start_times[agent]]
        arrival = min(curve[-1, 2], problem.max_times[agent])
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
        knots[agent, : len(curve)] = curve * [1.0, 1.0, problem.time_scale]
        if problem.paths[agent] is None:
            pinned[agent, waypoint_knots(problem.waypoints[agent], curve)] = True
    top = problem.time_scale * problem.final_time
    wanted = np.where(problem.collides, required.rods * STRICT, -1.0)
    widest = wanted.max(axis=1)
    everything = np.vstack([knots[a, :n] for a, n in enumerate(counts)])
    origin = everything.min(axis=0)
    high = everything.max(axis=0)
    high[2] = max(high[2], top)
    num_segments = int(counts.sum())
    cell = max(float(np.median(widest)), 1e-6 * float((high - origin).max()), 1e-9)
    while True:
        shape = ((high - origin) / cell).astype(np.int64) + 1
        if shape.astype(float).prod() <= CELLS_PER_SEGMENT * num_segments + 64:
            break
        cell *= 1.26
    walls = problem.boundary
    field = RodField(
        knots=knots,
        counts=counts,
        pinned=pinned,
        tops=np.where(problem.stays, top, -np.inf),
        required=wanted,
        walls=np.where(problem.heeds_walls & (walls is not None), required.walls * STRICT, -1.0),
        widest=widest,
        origin=origin,
        cell=cell,
        shape=shape,
        heads=np.full(int(shape.prod()), -1, dtype=np.int64),
        links=np.empty(0, dtype=np.int64),
        tenants=np.empty(0, dtype=np.int64),
        used=np.zeros(2, dtype=np.int64),
        stamps=np.zeros(len(curves), dtype=np.int64),
        clock=np.zeros(1, dtype=np.int64),
        edges=np.zeros((0, 4)) if walls is None else walls.edges,
        wall_origin=np.zeros(2) if walls is None else walls.origin,
        wall_cell=1.0 if walls is None else walls.cell,
        wall_shape=np.ones(2, dtype=np.int64) if walls is None else walls.shape,
        wall_starts=np.zeros(2, dtype=np.int64) if walls is None else walls.starts,
        wall_members=np.zeros(0, dtype=np.int64) if walls is None else walls.members,
    )
    entries = 8 * num_segments + 1024
    while True:
        field.heads.fill(-1)
        field.used.fill(0)
        field = field._replace(
            links=np.empty(SPARE_ENTRIES * entries, dtype=np.int64),
            tenants=np.empty(SPARE_ENTRIES * entries, dtype=np.int64),
        )
        enter_all(field)
        if field.used[1] == 0 and field.used[0] <= entries:
            return field
        entries *= 2


@kernel
def enter_all(field: RodField) -> None:
    """Enter every rod with its tail into an empty index."""
    for agent in range(len(field.counts)):
        last = field.counts[agent] - 1
        for i in range(last):
            enter(field, agent, field.knots[agent, i], field.knots[agent, i + 1])
        if field.tops[agent] > field.knots[agent, last, 2]:
            top = field.knots[agent, last].copy()
            top[2] = field.tops[agent]
            enter(field, agent, field.knots[agent, last], top)


@kernel
def cell_of(field: RodField, value: float, axis: int) -> int:
    """The cell along an axis, points outside moved to the rim."""
    place = int(np.floor((value - field.origin[axis]) / field.cell))
    return int(min(max(place, 0), field.shape[axis] - 1))


@kernel
def num_pieces(p: FloatArray, q: FloatArray, longest: float) -> int:
    """Into how many pieces no longer than `longest` (m) along an axis a segment is cut."""
    extent = max(abs(q[0] - p[0]), abs(q[1] - p[1]), abs(q[2] - p[2]))
    return int(extent / longest) + 1


@kernel
def enter(field: RodField, agent: int, p: FloatArray, q: FloatArray) -> None:
    """Enter the segment p q of an agent's rod into the index."""
    pieces = num_pieces(p, q, field.cell)
    low = np.empty(3, np.int64)
    high = np.empty(3, np.int64)
    for k in range(pieces):
        for x in range(3):
            head = p[x] + (q[x] - p[x]) * (k / pieces)
            tail = p[x] + (q[x] - p[x]) * ((k + 1) / pieces)
            low[x] = cell_of(field, min(head, tail), x)
            high[x] = cell_of(field, max(head, tail), x)
        for ix in range(low[0], high[0] + 1):
            for iy in range(low[1], high[1] + 1):
                for iz in range(low[2], high[2] + 1):
                    cell = (ix * field.shape[1] + iy) * field.shape[2] + iz
                    entry = field.heads[cell]
                    while entry >= 0 and field.tenants[entry] != agent:
                        entry = field.links[entry]
                    if entry >= 0:
                        continue
                    free = field.used[0]
                    if free == len(field.links):
                        field.used[1] = 1
                        return
                    field.used[0] = free + 1
                    field.tenants[free] = agent
                    field.links[free] = field.heads[cell]
                    field.heads[cell] = free


@kernel
def segment_clear(field: RodField, agent: int, p: FloatArray, q: FloatArray) -> bool:
    """Whether the segment p q would keep an agent's rod clear of all others and of the walls."""
    if field.used[1] > 0 or not clear_of_walls(
        p, q, field.walls[agent], field.edges, field.wall_origin, field.wall_cell,
        field.wall_shape, field.wall_starts, field.wall_members,
    ):  # fmt: skip
        return False
    field.clock[0] += 1
    now = field.clock[0]
    pieces = num_pieces(p, q, field.cell)
    reach = field.widest[agent]
    low = np.empty(3, np.int64)
    high = np.empty(3, np.int64)
    for k in range(pieces):
        for x in range(3):
            head = p[x] + (q[x] - p[x]) * (k / pieces)
            tail = p[x] + (q[x] - p[x]) * ((k + 1) / pieces)
            low[x] = cell_of(field, min(head, tail) - reach, x)
            high[x] = cell_of(field, max(head, tail) + reach, x)
        for ix in range(low[0], high[0] + 1):
            for iy in range(low[1], high[1] + 1):
                for iz in range(low[2], high[2] + 1):
                    entry = field.heads[(ix * field.shape[1] + iy) * field.shape[2] + iz]
                    while entry >= 0:
                        other = field.tenants[entry]
                        entry = field.links[entry]
                        if field.stamps[other] == now or field.required[agent, other] <= 0.0:
                            continue
                        field.stamps[other] = now
                        if not _clear_of_rod(field, other, p, q, field.required[agent, other]):
                            return False
    return True


@kernel
def _clear_of_rod(field: RodField, other: int, p: FloatArray, q: FloatArray, gap: float) -> bool:
    """Whether the segment p q (p before q) is further than `gap` from one rod."""
    knots = field.knots[other]
    count = field.counts[other]
    low = 0
    high = count - 1
    while low < high:
        middle = (low + high) // 2
        if knots[min(middle + 1, count - 1), 2] >= p[2] - gap:
            high = middle
        else:
            low = middle + 1
    west, east = min(p[0], q[0]) - gap, max(p[0], q[0]) + gap
    south, north = min(p[1], q[1]) - gap, max(p[1], q[1]) + gap
    for j in range(low, count):
        if knots[j, 2] > q[2] + gap:
            break
        x0, y0, z0 = knots[j, 0], knots[j, 1], knots[j, 2]
        if j < count - 1:
            x1, y1, z1 = knots[j + 1, 0], knots[j + 1, 1], knots[j + 1, 2]
        else:
            # The last knot stands for the tail, or for itself without one.
            x1, y1, z1 = x0, y0, max(field.tops[other], z0)
        if min(x0, x1) > east or max(x0, x1) < west or min(y0, y1) > north or max(y0, y1) < south:
            continue
        if squared_distance(
            p[0], p[1], p[2], q[0], q[1], q[2], x0, y0, z0, x1, y1, z1
        ) <= gap * gap:  # fmt: skip
            return False
    return True
