"""Distances in rational arithmetic: what every computed one is compared with."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np

Point = tuple[Fraction, Fraction]


def rational(values) -> list[Fraction]:
    """The numbers that floats stand for."""
    return [Fraction(float(value)) for value in values]


def _at(curve: list[list[Fraction]], time: Fraction) -> Point:
    for first, second in pairwise(curve):
        if time <= second[2]:
            part = (time - first[2]) / (second[2] - first[2])
            return (
                first[0] + part * (second[0] - first[0]),
                first[1] + part * (second[1] - first[1]),
            )
    return curve[-1][0], curve[-1][1]


def squared_to_origin(start: Point, end: Point) -> Fraction:
    """Squared distance of the origin to a segment."""
    step = (end[0] - start[0], end[1] - start[1])
    squared = step[0] ** 2 + step[1] ** 2
    part = Fraction(0)
    if squared:
        part = min(
            max(-(start[0] * step[0] + start[1] * step[1]) / squared, Fraction(0)), Fraction(1)
        )
    return (start[0] + part * step[0]) ** 2 + (start[1] + part * step[1]) ** 2


def squared_pair_distance(first, second, first_leaves, second_leaves) -> Fraction | None:
    """Squared least distance of two moving agents, None where they are never present together."""
    curves = [[rational(knot) for knot in curve] for curve in (first, second)]
    begin = max(curve[0][2] for curve in curves)
    end = min(rational([first_leaves, second_leaves]))
    if begin > end:
        return None
    knots = {knot[2] for curve in curves for knot in curve if begin <= knot[2] <= end}
    times = sorted(knots | {begin, end})
    apart = []
    for time in times:
        a, b = _at(curves[0], time), _at(curves[1], time)
        apart.append((a[0] - b[0], a[1] - b[1]))
    ends = apart[1:] or apart
    return min(squared_to_origin(a, b) for a, b in zip(apart, ends, strict=False))


def _minus(a: Point, b: Point) -> Point:
    return a[0] - b[0], a[1] - b[1]


def _side(a: Point, b: Point, c: Point) -> Fraction:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def squared_segment_distance(a: Point, b: Point, c: Point, d: Point) -> Fraction:
    """Squared distance of the segments from a to b and from c to d."""
    if _side(a, b, c) * _side(a, b, d) < 0 and _side(c, d, a) * _side(c, d, b) < 0:
        return Fraction(0)
    return min(
        squared_to_origin(_minus(c, a), _minus(d, a)),
        squared_to_origin(_minus(c, b), _minus(d, b)),
        squared_to_origin(_minus(a, c), _minus(b, c)),
        squared_to_origin(_minus(a, d), _minus(b, d)),
    )


def within(computed: float, squared: Fraction, bound: float) -> bool:
    """Whether a computed distance is off the root of an exact square by at most `bound`."""
    low = max(Fraction(computed) - Fraction(bound), Fraction(0))
    return low**2 <= squared <= (Fraction(computed) + Fraction(bound)) ** 2


def adversarial_curve(rng: np.random.Generator, size: float, knots: int) -> np.ndarray:
    """A curve of steps from tiny to large, with pauses, at times as uneven."""
    steps = rng.normal(size=(knots, 2)) * size * 10.0 ** rng.integers(-9, 1, (knots, 1))
    steps[rng.random(knots) < 0.2] = 0.0
    times = np.cumsum(10.0 ** rng.uniform(-6.0, 1.0, knots))
    return np.column_stack([np.cumsum(steps, axis=0), times])
