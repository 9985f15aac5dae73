"""Homotopy classes of plans: who goes around whom how often, and who passes a place first.

An optimisation keeps the class of its seed, so two seeds of one class lead to much the same plan and only the
cheaper one is worth optimising. The signature of a plan has two numbers for every colliding pair:

- the winding number of the relative position p_b(t) - p_a(t): the angle it turns through, less the smallest
  angle between its ends, in whole turns;
- who is first where both pass the same places: the sign of the sum of sign(t_b - t_a) over common squares
  of the plane, 0 where they share none.

Both are read from samples, so a signature is a label, not a proof.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.problem.planning_problem import PlanningProblem

# Instants at which relative positions are looked at.
INSTANTS = 128
# Squares of the plane are this share of the smallest distance of a pair wide.
SQUARE = 0.5


def signature(problem: PlanningProblem, curves: Sequence[FloatArray]) -> bytes:
    """The class of `curves`, one (n, 3) an agent: equal bytes are the same class."""
    first, second = np.nonzero(np.triu(problem.collides))
    winding = _winding_numbers(curves, first, second)
    order = _orders(problem, curves, first, second)
    return np.concatenate([winding, order]).astype(np.int8).tobytes()


def _winding_numbers(curves: Sequence[FloatArray], first: IntArray, second: IntArray) -> IntArray:
    """(P,) whole turns of one agent's position about the other's."""
    begin = min(float(curve[0, 2]) for curve in curves)
    end = max(float(curve[-1, 2]) for curve in curves)
    times = np.linspace(begin, end, INSTANTS)
    positions = np.stack(
        [np.stack([np.interp(times, c[:, 2], c[:, axis]) for axis in (0, 1)], 1) for c in curves]
    )
    step = positions[second] - positions[first]
    angle = np.unwrap(np.arctan2(step[..., 1], step[..., 0]), axis=1)
    swept = angle[:, -1] - angle[:, 0]
    # From the ends alone, which all curves of a problem share: half a turn has no smaller side.
    heads, tails = step[:, 0] @ [1.0, 1j], step[:, -1] @ [1.0, 1j]
    smallest = np.angle(tails * heads.conj())
    return np.rint((swept - smallest) / (2.0 * np.pi)).astype(np.int64)


def _orders(
    problem: PlanningProblem, curves: Sequence[FloatArray], first: IntArray, second: IntArray
) -> IntArray:
    """(P,) 1 where the first agent is mostly earlier at common places, -1 where later, 0 at none."""
    if not len(first):
        return np.empty(0, dtype=np.int64)
    square = SQUARE * float(problem.distance[first, second].min())
    visits = [_first_visits(curve, square) for curve in curves]
    result = np.zeros(len(first), dtype=np.int64)
    for k, (a, b) in enumerate(zip(first.tolist(), second.tolist(), strict=True)):
        _, own, other = np.intersect1d(
            visits[a][0], visits[b][0], assume_unique=True, return_indices=True
        )
        result[k] = np.sign(np.sign(visits[b][1][other] - visits[a][1][own]).sum())
    return result


def _first_visits(curve: FloatArray, square: float) -> tuple[IntArray, FloatArray]:
    """Squares (n,) that a curve comes through, as numbers, and when it first does (n,), s."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(curve[:, :2], axis=0).T))])
    # Waiting leaves no trace: only the first knot of those at one place counts.
    moves = np.concatenate([[True], np.diff(along) > 0.0])
    at = np.linspace(0.0, along[-1], 2 + int(2.0 * along[-1] / square))
    x, y, times = (np.interp(at, along[moves], curve[moves, axis]) for axis in range(3))
    cells = np.floor(np.column_stack([x, y]) / square).astype(np.int64)
    codes = (cells[:, 0] << 32) + cells[:, 1]
    places, earliest = np.unique(codes, return_index=True)
    return places, times[earliest]
