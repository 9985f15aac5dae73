"""Compiled moves that make clear curves cheaper; every accepted one is proven clear.

A constant-speed chord never costs more kinetic energy than the piece it replaces, a knot on the
chord of its neighbours is where energy is least, and an even speed costs least along a given path.
All moves change one agent with everybody else held still, in (x, y, c t).
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.axes import TIME
from stplan.compiled import inlined, inner, kernel
from stplan.geometry.allocation import new_numbers
from stplan.seeding.shortcutting.rod_field import RodField, enter_rod, segment_clear, with_entries

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
def shortcut_round(
    field: RodField, order: IntArray, draws: FloatArray, arrivals: FloatArray
) -> IntArray:
    """One round over the agents of `order`; the entries of the field's index, which may have grown.

    `draws` (A, tries, 2) are uniform in [0, 1); `arrivals` (A,) is the c t towards which an
    agent's arrival is put off.
    """
    aim = new_numbers(3)
    moved = new_numbers(3)
    for agent in order:
        _drop_knots(field, agent)
        for k in range(draws.shape[1]):
            _shortcut(field, agent, draws[agent, k, 0], draws[agent, k, 1])
        knots = field.knots[agent]
        last = field.counts[agent] - 1
        for i in range(1, last):
            # In place, then in time.
            if not field.pinned[agent, i]:
                _aim_at_chord(knots, i, aim)
                _move_towards(field, agent, i, aim, moved)
            _aim_at_even_speed(knots, i, aim)
            _move_towards(field, agent, i, aim, moved)
        # A later arrival is slower, hence cheaper, and shortens a tail.
        if knots[last, TIME] < arrivals[agent]:
            _copy(knots[last], aim)
            aim[TIME] = arrivals[agent]
            _move_towards(field, agent, last, aim, moved)
        # Others meet the agent where it is now; its own moves ask about others only.
        field = with_entries(field, enter_rod(field, field.occupancy.entries, agent))
    return field.occupancy.entries


@inlined
def _copy(source: FloatArray, target: FloatArray) -> None:
    """Copy a point (3,)."""
    for x in range(3):
        target[x] = source[x]


@inlined
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
        kept += 1
        # Knots move down only (kept <= best), so those still to be looked at are untouched.
        _copy(knots[best], knots[kept])
        pinned[kept] = pinned[best]
        i = best
    field.counts[agent] = kept + 1


@inner
def _piece_at(knots: FloatArray, count: int, height: float, point: FloatArray) -> int:
    """Fill `point` (3,) with a curve's place at c t = `height`; returns the segment's index."""
    low = 0
    high = count - 2
    while low < high:
        middle = (low + high) // 2
        if knots[middle + 1, TIME] < height:
            low = middle + 1
        else:
            high = middle
    part = (height - knots[low, TIME]) / (knots[low + 1, TIME] - knots[low, TIME])
    part = min(max(part, 0.0), 1.0)
    for x in range(len(point) - 1):
        point[x] = knots[low, x] + part * (knots[low + 1, x] - knots[low, x])
    point[TIME] = height
    return low


@inlined
def _shortcut(field: RodField, agent: int, where: float, how_long: float) -> None:
    """Replace a random piece by its constant-speed chord where that is clear."""
    count = field.counts[agent]
    knots = field.knots[agent]
    pinned = field.pinned[agent]
    if count < 3 or count + 2 > knots.shape[0]:
        return
    low, high = knots[0, TIME], knots[count - 1, TIME]
    middle = low + (high - low) * where
    half = 0.5 * (high - low) * LONGEST_SHORTCUT * how_long**1.5
    begin = new_numbers(knots.shape[1])
    end = new_numbers(knots.shape[1])
    i = _piece_at(knots, count, max(low, middle - half), begin)
    j = _piece_at(knots, count, min(high, middle + half), end)
    if j <= i:
        return
    for k in range(i + 1, j + 1):
        if pinned[k]:
            return
    # Ends that all but coincide with a knot are moved onto it: no slivers.
    sliver = 1e-3 * (high - low) / count
    if begin[TIME] - knots[i, TIME] < sliver:
        _copy(knots[i], begin)
    if knots[j + 1, TIME] - end[TIME] < sliver:
        _copy(knots[j + 1], end)
    if end[TIME] <= begin[TIME] or not segment_clear(field, agent, begin, end):
        return
    starts_between = begin[TIME] > knots[i, TIME]
    ends_between = end[TIME] < knots[j + 1, TIME]
    # Where knot j + 1 comes to lie.
    at = i + 1 + int(starts_between) + int(ends_between)
    _shift(knots, pinned, j + 1, count, at)
    if starts_between:
        _copy(begin, knots[i + 1])
        pinned[i + 1] = False
    if ends_between:
        _copy(end, knots[at - 1])
        pinned[at - 1] = False
    field.counts[agent] = count + at - (j + 1)


@inlined
def _shift(knots: FloatArray, pinned: BoolArray, first: int, past: int, to: int) -> None:
    """Move knots first..past - 1 and whether they are pinned so that the first comes to `to`."""
    for step in range(past - first):
        # From the end that is not overwritten before it is read.
        k = step if to <= first else past - first - 1 - step
        _copy(knots[first + k], knots[to + k])
        pinned[to + k] = pinned[first + k]


@inlined
def _aim_at_chord(knots: FloatArray, i: int, aim: FloatArray) -> None:
    """On the chord of the neighbours of knot i, at its own time."""
    span = knots[i + 1, TIME] - knots[i - 1, TIME]
    part = (knots[i, TIME] - knots[i - 1, TIME]) / span
    for x in range(len(aim) - 1):
        aim[x] = knots[i - 1, x] + part * (knots[i + 1, x] - knots[i - 1, x])
    aim[TIME] = knots[i, TIME]


@inlined
def _aim_at_even_speed(knots: FloatArray, i: int, aim: FloatArray) -> None:
    """At the place of knot i, at the time when speed is equal on both sides."""
    before, knot, after = knots[i - 1], knots[i], knots[i + 1]
    first = np.hypot(knot[0] - before[0], knot[1] - before[1])
    second = np.hypot(after[0] - knot[0], after[1] - knot[1])
    part = first / max(first + second, 1e-12)
    part = min(max(part, LEAST_PART), 1.0 - LEAST_PART)
    for x in range(len(aim) - 1):
        aim[x] = knot[x]
    aim[TIME] = before[TIME] + part * (after[TIME] - before[TIME])


@inner
def _move_towards(field: RodField, agent: int, i: int, aim: FloatArray, moved: FloatArray) -> None:
    """Move knot i (not the first) towards `aim` (3,), as far as both its segments are clear.

    `moved` (3,) is working memory.
    """
    knots = field.knots[agent]
    is_last = i == field.counts[agent] - 1
    _copy(aim, moved)
    step = 1.0
    for _ in range(STEPS):
        same = True
        for x in range(len(moved)):
            same = same and moved[x] == knots[i, x]
        if same:
            return
        if segment_clear(field, agent, knots[i - 1], moved) and (
            is_last or segment_clear(field, agent, moved, knots[i + 1])
        ):
            _copy(moved, knots[i])
            return
        step *= SHORTENED
        for x in range(len(moved)):
            moved[x] = knots[i, x] + step * (aim[x] - knots[i, x])
