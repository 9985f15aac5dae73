"""Repulsive curves: rods in space-time that minimise a tangent-point energy, as long as their length allows.

The energy of Yu, Schumacher and Crane (2021), exponents 2 and 4.5, with one point a segment: the sum over
pairs of segments I, J that share no knot, of |T_I x d|^2 / |d|^4.5 l_I l_J, d between their middles. It falls
for ever as curves move apart, so that a bound on their lengths is what ends it. Knots stay at equal times,
ends stay in place.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

from stplan.arrays import BoolArray, FloatArray
from stplan.bench.rivals.task import Motion, Task

PACKAGE = "scipy"
NAME = "repulsive curves"

BETA = 4.5
SEGMENTS = 16
# Straight rods may meet, where the energy has no derivative; they are shaken by this part of their lengths.
JITTER = 0.01
# The budget is spent in so many steps, each from where the one before has ended.
STAGES = 4
# Lengths of rods over those of straight ones.
BUDGET = 1.1
ITERATIONS = 200


def drive(task: Task) -> Motion:
    """As if the plane were open, over the time that the longest straight way takes."""
    lengths = np.hypot(*(task.goals - task.starts).T)
    duration = BUDGET * float(lengths.max()) / task.speed
    curves = repel(task.starts, task.goals, np.full(len(lengths), duration), 1.0, BUDGET)
    return Motion(curves, np.ones(len(curves), dtype=bool))


def repel(
    starts: FloatArray,
    goals: FloatArray,
    durations: FloatArray,
    time_scale: float,
    budget: float,
    segments: int = SEGMENTS,
) -> list[FloatArray]:
    """Curves (n, 3) of agents that set out at 0 s, of the least energy with rods that long.

    Args:
        starts, goals: (A, 2) m.
        durations: (A,) s.
        time_scale: m/s.
        budget: length of every rod over that of the straight one.
    """
    count = len(starts)
    share = np.linspace(0.0, 1.0, segments + 1)
    rods = np.empty((count, segments + 1, 3))
    rods[..., :2] = starts[:, None] + share[:, None] * (goals - starts)[:, None]
    rods[..., 2] = time_scale * share * durations[:, None]
    straight = np.linalg.norm(rods[:, -1] - rods[:, 0], axis=1)
    unit = float(straight.mean())
    rods /= unit
    inner = (count, segments - 1, 2)
    rods[:, 1:-1, :2] += np.random.default_rng(0).uniform(-JITTER, JITTER, inner)
    problem = _Bounded(rods, _strangers(count, segments))
    for stage in range(1, STAGES + 1):
        problem.spread(straight / unit * (1.0 + (budget - 1.0) * stage / STAGES))
    ended = problem.rods * unit
    ended[..., 2] /= time_scale
    ended[:, -1, 2] = durations
    return list(ended)


class _Bounded:
    """Rods (A, n, 3) whose inner knots move in the plane, their lengths bounded."""

    def __init__(self, rods: FloatArray, apart: BoolArray) -> None:
        self.rods = rods
        self._apart = apart

    def spread(self, most: FloatArray) -> None:
        """Move to the least energy with lengths (A,) of at most `most`."""
        lengths = {
            "type": "ineq",
            "fun": lambda x: most - np.linalg.norm(self._steps(x), axis=2).sum(axis=1),
            "jac": self._shortening,
        }
        found = minimize(  # type: ignore[call-overload]
            self._energy, self.rods[:, 1:-1, :2].ravel(), jac=True, method="SLSQP",
            constraints=lengths, options={"maxiter": ITERATIONS, "ftol": 1e-8},
        )  # fmt: skip
        self.rods = self._placed(found.x)

    def _placed(self, x: FloatArray) -> FloatArray:
        moved = self.rods.copy()
        moved[:, 1:-1, :2] = x.reshape(len(moved), -1, 2)
        return moved

    def _steps(self, x: FloatArray) -> FloatArray:
        return np.diff(self._placed(x), axis=1)

    def _energy(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Its logarithm, which is least at the same place and never steep."""
        value, slope = tangent_point_energy(self._placed(x), self._apart)
        return float(np.log(value)), slope[:, 1:-1, :2].ravel() / value

    def _shortening(self, x: FloatArray) -> FloatArray:
        step = self._steps(x)
        along = step / np.linalg.norm(step, axis=2, keepdims=True)
        own = (along[:, 1:] - along[:, :-1])[..., :2]
        count = len(own)
        rows = np.zeros((count, *own.shape))
        rows[np.arange(count), np.arange(count)] = own
        return rows.reshape(count, -1)


def _strangers(count: int, segments: int) -> BoolArray:
    """(S, S) pairs of segments that share no knot."""
    owner = np.repeat(np.arange(count), segments)
    place = np.tile(np.arange(segments), count)
    near = np.abs(np.subtract.outer(place, place)) <= 1
    return ~(np.equal.outer(owner, owner) & near)


def tangent_point_energy(rods: FloatArray, apart: BoolArray) -> tuple[float, FloatArray]:
    """The energy of rods (A, n, 3), and its derivative of the same shape.

    Args:
        apart: (S, S) the pairs of segments that count, S = A (n - 1).
    """
    edge = np.diff(rods, axis=1).reshape(-1, 3)
    middle = (0.5 * (rods[:, 1:] + rods[:, :-1])).reshape(-1, 3)
    length = np.linalg.norm(edge, axis=1)
    i, j = np.nonzero(apart)
    away = middle[i] - middle[j]
    squared = (away**2).sum(axis=1)
    along = (edge[i] * away).sum(axis=1)
    across = squared - along**2 / length[i] ** 2
    falls = squared ** (-BETA / 2)
    both = length[i] * length[j]
    value = across * falls * both
    by_away = (2.0 * falls * both)[:, None] * (away - (along / length[i] ** 2)[:, None] * edge[i])
    by_away -= (BETA * value / squared)[:, None] * away
    by_edge = (falls * length[j] / length[i])[:, None] * (
        (across + 2.0 * along**2 / length[i] ** 2)[:, None] * edge[i]
        - (2.0 * along)[:, None] * away
    )
    by_other = (value / length[j] ** 2)[:, None] * edge[j]
    by_middle, by_length = np.zeros_like(middle), np.zeros_like(edge)
    np.add.at(by_middle, i, by_away)
    np.subtract.at(by_middle, j, by_away)
    np.add.at(by_length, i, by_edge)
    np.add.at(by_length, j, by_other)
    shape = (len(rods), -1, 3)
    by_middle, by_length = by_middle.reshape(shape), by_length.reshape(shape)
    slope = np.zeros_like(rods)
    slope[:, 1:] += 0.5 * by_middle + by_length
    slope[:, :-1] += 0.5 * by_middle - by_length
    return float(value.sum()), slope
