"""Broad phase: which segments of different agents' rods come near each other in space-time.

Segments are cut into pieces no longer than twice the reach, every piece is kept in the grid's cell of
its middle, and only the cells around are compared, so the work grows linearly with the number of
segments at constant density. The answer is exact and sorted, whatever the cell size.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import inlined, kernel
from stplan.geometry.allocation import new_integer_rows, new_integers, new_number_rows
from stplan.geometry.grid import Cells, cell_along, cells_of_box, make_cells, make_query
from stplan.geometry.growable import with_room
from stplan.geometry.segments import space_time_point, squared_distance
from stplan.geometry.sorting import counting_sort, sorted_pairs
from stplan.threads import shares, together

# Pieces this many reaches long keep the number of comparisons least: with pieces of length p, a
# neighbourhood holds about (p + reach)^3 / p of them, and there are 1 / p to ask.
PIECE = 2.0
CELLS_A_PIECE = 8


class CutSegments(NamedTuple):
    """S segments and into how many pieces each is cut.

    Attributes:
        start, end: (S, 3) in (x, y, c t), m.
        half: (S,) half the length of a piece, m.
        pieces: (S,).
        agents: (S,) owners.
        asked: (S,) whether pairs with this one are asked for.
    """

    start: FloatArray
    end: FloatArray
    half: FloatArray
    pieces: IntArray
    agents: IntArray
    asked: BoolArray


def near_segments(
    positions: FloatArray,
    segments: IntArray,
    agents: IntArray,
    collides: BoolArray,
    reach: FloatArray,
    asked: BoolArray | None = None,
    *,
    factor: float = 1.0,
    skin: float = 0.0,
) -> IntArray:
    """Pairs of segments of colliding agents nearer than `factor` times the pair's reach, and the skin.

    Args:
        positions: (P, 3) points in (x, y, c t), m.
        segments: (S, 2) indices of end points.
        agents: (S,) owner of every segment.
        collides: (A, A) which pairs are asked for.
        reach: (A, A) in m.
        asked: (S,) only pairs with one of these segments, all by default.
        skin: m.

    Returns:
        (N, 2) indices i, j of segments with agents[i] < agents[j], sorted.
    """
    if not collides.any():
        return np.empty((0, 2), dtype=np.int64)
    # Of thousands of agents another square of all pairs takes as long as all the rest.
    furthest = factor * float(reach.max(where=collides, initial=-np.inf)) + skin
    start = positions[segments[:, 0]]
    end = positions[segments[:, 1]]
    length = np.sqrt(((end - start) ** 2).sum(axis=1))
    # A scene of hardly any reach is not cut finer than its segments ask for.
    piece = max(PIECE * furthest, 0.1 * float(np.median(length)), 1e-9)
    pieces = np.maximum(np.ceil(length / piece), 1).astype(np.int64)
    low, high = np.minimum(start, end).min(axis=0), np.maximum(start, end).max(axis=0)
    most = CELLS_A_PIECE * int(pieces.sum()) + 1024
    cells = make_cells(low, high, piece + furthest, most)
    everyone = np.ones(len(segments), dtype=bool)
    cut = CutSegments(
        np.ascontiguousarray(start), np.ascontiguousarray(end), 0.5 * length / pieces, pieces,
        agents, everyone if asked is None else asked,
    )  # fmt: skip
    found = together(
        _near_pairs,
        [(cut, collides, reach, factor, skin, cells, *share) for share in shares(pieces)],
    )
    return found[0] if len(found) == 1 else _sorted(np.vstack(found), len(segments))


@kernel
def _sorted(pairs: IntArray, num_segments: int) -> IntArray:
    return sorted_pairs(pairs, num_segments)


@kernel
def _near_pairs(
    cut: CutSegments,
    collides: BoolArray,
    reach: FloatArray,
    factor: float,
    skin: float,
    cells: Cells,
    head: int,
    tail: int,
) -> IntArray:
    """(N, 2) near pairs, sorted, of which segments `head` to `tail` find the other one."""
    middles, places = _middles(cut, cells)
    starts, order = counting_sort(places, cells.total)
    # In the order of the cells, those of a run lie side by side.
    around = np.empty_like(middles)
    segment = np.empty_like(order)
    for k in range(len(order)):
        segment[k] = places[order[k], 1]
        for x in range(3):
            around[k, x] = middles[order[k], x]
    start, end, half, agents = cut.start, cut.end, cut.half, cut.agents
    query = make_query(cells)
    last_hit = new_integers(len(start))
    for i in range(len(start)):
        last_hit[i] = -1
    found = new_integer_rows(8 * len(start) + 64, 2)
    count = 0
    nearest = cells.size * cells.size
    for k in range(len(middles)):
        i = places[k, 1]
        if i < head or i >= tail or not cut.asked[i]:
            continue
        p = agents[i]
        x, y, z = middles[k, 0], middles[k, 1], middles[k, 2]
        for axis in range(3):
            query.low[axis] = middles[k, axis] - cells.size
            query.high[axis] = middles[k, axis] + cells.size
        for r in range(cells_of_box(cells, query)):
            begin, past = starts[query.runs[r, 0]], starts[query.runs[r, 1]]
            found = with_room(found, count + past - begin)
            for b in range(begin, past):
                dx, dy, dz = x - around[b, 0], y - around[b, 1], z - around[b, 2]
                squared = dx * dx + dy * dy + dz * dz
                if squared > nearest:
                    continue
                j = segment[b]
                q = agents[j]
                # Two that are asked for find each other once, from the lower agent.
                if p == q or (p > q and cut.asked[j]) or not collides[p, q] or last_hit[j] == i:
                    continue
                limit = factor * reach[p, q] + skin
                room = limit + half[i] + half[j]
                if squared > room * room:
                    continue
                if squared_distance(
                    space_time_point(start, i), space_time_point(end, i),
                    space_time_point(start, j), space_time_point(end, j),
                ) < limit * limit:  # fmt: skip
                    last_hit[j] = i
                    found[count, 0] = i if p < q else j
                    found[count, 1] = j if p < q else i
                    count += 1
    return sorted_pairs(found[:count], len(start))


@inlined
def _middles(cut: CutSegments, cells: Cells) -> tuple[FloatArray, IntArray]:
    """Middles (P, 3) of all pieces, segment by segment, and the cell and segment of each (P, 2)."""
    total = 0
    for i in range(len(cut.pieces)):
        total += cut.pieces[i]
    middles = new_number_rows(total, 3)
    places = new_integer_rows(total, 2)
    at = 0
    for i in range(len(cut.pieces)):
        for k in range(cut.pieces[i]):
            share = (k + 0.5) / cut.pieces[i]
            cell = 0
            for x in range(3):
                middles[at, x] = cut.start[i, x] + share * (cut.end[i, x] - cut.start[i, x])
                cell = cell * cells.shape[x] + cell_along(cells, middles[at, x], x)
            places[at, 0] = cell
            places[at, 1] = i
            at += 1
    return middles, places
