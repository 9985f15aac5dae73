"""Compiled moves that make clear curves cheaper; every accepted one is proven clear.

A constant-speed chord never costs more kinetic energy than the piece it replaces, a knot on the
chord of its neighbours is where energy is least, and an even speed costs least along a given path.
All moves change one agent with everybody else held still, in (x, y, c t).
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import kernel
from stplan.seeding.shortcutting.rod_field import RodField, enter, segment_clear

# The greedy shortcut gives up on a knot after so many blocked chords in a row.
LOOK_AHEAD = 4
# A knot moved in time keeps at least this part of its neighbours' span on either side.
LEAST_PART = 0.02
# Shortcuts span up to this part of a curve's duration.
LONGEST_SHORTCUT = 0.6
# How often, and how much, a blocked move of a knot is shortened.
STEPS = 3
SHORTENED = 0.35


@kernel
def polish_round(
    field: RodField,
    order: IntArray,
    draws: FloatArray,
    arrivals: FloatArray,
) -> None:
    """One round over the agents of `order`.

    `draws` (A, tries, 2) are uniform in [0, 1); `arrivals` (A,) is the c t towards which an
    agent's arrival is put off.
    """
    aim = np.empty(3)
    for agent in order:
        _drop_knots(field, agent)
        for k in range(draws.shape[1]):
            _shortcut(field, agent, draws[agent, k, 0], draws[agent, k, 1])
        last = field.counts[agent] - 1
        for i in range(1, last):
            _relax_knot(field, agent, i, aim)
        # A later arrival is slower, hence cheaper, and shortens a tail.
        if field.knots[agent, last, 2] < arrivals[agent]:
            aim[:] = field.knots[agent, last]
            aim[2] = arrivals[agent]
            _move_towards(field, agent, last, aim)


@kernel
def _drop_knots(field: RodField, agent: int) -> None:
    """From every kept knot walk straight to the furthest one that can be reached clear."""
    knots = field.knots[agent]
    pinned = field.pinned[agent]
    count = field.counts[agent]
    kept = 0
    i = 0
    while i < count - 1:
        best = i + 1
        for j in range(i + 2, count):
            if pinned[j - 1] or j - best > LOOK_AHEAD:
                break
            if segment_clear(field, agent, knots[i], knots[j]):
                best = j
        if best > i + 1:
            enter(field, agent, knots[i], knots[best])
        kept += 1
        # Knots move down only (kept <= best), so those still to be looked at are untouched.
        knots[kept] = knots[best]
        pinned[kept] = pinned[best]
        i = best
    field.counts[agent] = kept + 1


@kernel
def piece_at(field: RodField, agent: int, height: float, point: FloatArray) -> int:
    """Fill `point` (3,) with the curve's place at c t = `height`; returns the segment's index."""
    knots = field.knots[agent]
    low = 0
    high = field.counts[agent] - 2
    while low < high:
        middle = (low + high) // 2
        if knots[middle + 1, 2] < height:
            low = middle + 1
        else:
            high = middle
    part = (height - knots[low, 2]) / (knots[low + 1, 2] - knots[low, 2])
    part = min(max(part, 0.0), 1.0)
    for x in range(2):
        point[x] = knots[low, x] + part * (knots[low + 1, x] - knots[low, x])
    point[2] = height
    return low


@kernel
def _shortcut(field: RodField, agent: int, where: float, how_long: float) -> None:
    """Replace a random piece by its constant-speed chord where that is clear."""
    count = field.counts[agent]
    knots = field.knots[agent]
    pinned = field.pinned[agent]
    if count < 3 or count + 2 > knots.shape[0]:
        return
    low, high = knots[0, 2], knots[count - 1, 2]
    middle = low + (high - low) * where
    half = 0.5 * (high - low) * LONGEST_SHORTCUT * how_long**1.5
    begin = np.empty(3)
    end = np.empty(3)
    i = piece_at(field, agent, max(low, middle - half), begin)
    j = piece_at(field, agent, min(high, middle + half), end)
    if j <= i:
        return
    for k in range(i + 1, j + 1):
        if pinned[k]:
            return
    # Ends that all but coincide with a knot are moved onto it: no slivers.
    sliver = 1e-3 * (high - low) / count
    if begin[2] - knots[i, 2] < sliver:
        begin[:] = knots[i]
    if knots[j + 1, 2] - end[2] < sliver:
        end[:] = knots[j + 1]
    if end[2] <= begin[2] or not segment_clear(field, agent, begin, end):
        return
    rest = knots[j + 1 : count].copy()
    rest_pinned = pinned[j + 1 : count].copy()
    at = i + 1
    if begin[2] > knots[i, 2]:
        knots[at] = begin
        pinned[at] = False
        at += 1
    if end[2] < rest[0, 2]:
        knots[at] = end
        pinned[at] = False
        at += 1
    knots[at : at + len(rest)] = rest
    pinned[at : at + len(rest)] = rest_pinned
    field.counts[agent] = at + len(rest)
    enter(field, agent, begin, end)


@kernel
def _relax_knot(field: RodField, agent: int, i: int, aim: FloatArray) -> None:
    """Move a knot to where energy is least between its neighbours: in place, then in time."""
    before, knot, after = (
        field.knots[agent, i - 1], field.knots[agent, i], field.knots[agent, i + 1],
    )  # fmt: skip
    span = after[2] - before[2]
    if not field.pinned[agent, i]:
        # On the chord of its neighbours, at its own time.
        part = (knot[2] - before[2]) / span
        for x in range(2):
            aim[x] = before[x] + part * (after[x] - before[x])
        aim[2] = knot[2]
        _move_towards(field, agent, i, aim)
    # Equal speed on both sides, at its own place.
    first = np.hypot(knot[0] - before[0], knot[1] - before[1])
    second = np.hypot(after[0] - knot[0], after[1] - knot[1])
    part = first / max(first + second, 1e-12)
    part = min(max(part, LEAST_PART), 1.0 - LEAST_PART)
    aim[0] = knot[0]
    aim[1] = knot[1]
    aim[2] = before[2] + part * span
    _move_towards(field, agent, i, aim)


@kernel
def _move_towards(field: RodField, agent: int, i: int, aim: FloatArray) -> None:
    """Move knot i (not the first) towards `aim` (3,), as far as both its segments are clear."""
    knots = field.knots[agent]
    is_last = i == field.counts[agent] - 1
    moved = aim.copy()
    step = 1.0
    for _ in range(STEPS):
        if moved[0] == knots[i, 0] and moved[1] == knots[i, 1] and moved[2] == knots[i, 2]:
            return
        if segment_clear(field, agent, knots[i - 1], moved) and (
            is_last or segment_clear(field, agent, moved, knots[i + 1])
        ):
            knots[i] = moved
            enter(field, agent, knots[i - 1], moved)
            if not is_last:
                enter(field, agent, moved, knots[i + 1])
            return
        step *= SHORTENED
        for x in range(3):
            moved[x] = knots[i, x] + step * (aim[x] - knots[i, x])
