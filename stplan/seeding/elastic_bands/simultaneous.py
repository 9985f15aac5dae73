"""Which agents of a sweep can be moved at the same time, to the same places as one after another.

In a sweep an agent is moved with regard to those near it, as they are by then. So it waits for those of its
neighbours that come before it, and for nobody else: agents fall into rounds, each after the last round with
one of these, and those of one round have nothing to do with each other.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import IntArray
from stplan.compiled import kernel
from stplan.geometry.allocation import new_integer_rows, new_integers
from stplan.geometry.growable import with_room
from stplan.geometry.sorting import counting_sort
from stplan.seeding.elastic_bands.band_neighbours import Neighbours

# Rounds of fewer agents are moved together with the next ones, one agent after another.
SMALL = 24


def rounds(order: IntArray, near: Neighbours) -> list[tuple[IntArray, bool]]:
    """Agents of `order` in rounds to be moved one after another, and whether those of each may at once.

    Args:
        near: agents near every agent, both ways.
    """
    starts, sorted_agents = _rounds(order, near.rows, near.members)
    sizes = np.diff(starts)
    found: list[tuple[IntArray, bool]] = []
    begin = 0
    for size, past in zip(sizes.tolist(), starts[1:].tolist(), strict=True):
        if size >= SMALL:
            if begin < past - size:
                found.append((sorted_agents[begin : past - size], False))
            found.append((sorted_agents[past - size : past], True))
            begin = past
    if begin < len(sorted_agents):
        found.append((sorted_agents[begin:], False))
    return found


@kernel
def near_agents(
    agents: IntArray, rows: IntArray, members: IntArray, count: int
) -> tuple[IntArray, IntArray]:
    """Who is near each of `count` agents, from what is near their segments, owned by `agents` (S,).

    Rows and members as of `Neighbours`, some members twice.
    """
    pairs = new_integer_rows(8 * count + 64, 2)
    last = new_integers(count)
    for a in range(count):
        last[a] = -1
    total = 0
    for i in range(len(agents)):
        a = agents[i]
        pairs = with_room(pairs, total + rows[i + 1] - rows[i])
        for k in range(rows[i], rows[i + 1]):
            b = agents[members[k]]
            if last[b] != a:
                last[b] = a
                pairs[total, 0] = a
                pairs[total, 1] = b
                total += 1
    starts, found = counting_sort(pairs[:total], count)
    for k in range(total):
        found[k] = pairs[found[k], 1]
    return starts, found


@kernel
def _rounds(order: IntArray, rows: IntArray, members: IntArray) -> tuple[IntArray, IntArray]:
    """Where each round begins, and the past of the last one, in the agents of `order` sorted by rounds."""
    rounds = new_integers(len(rows) - 1)
    for a in range(len(rounds)):
        rounds[a] = -1
    placed = new_integer_rows(len(order), 1)
    most = 0
    for k in range(len(order)):
        a = order[k]
        latest = 0
        for n in range(rows[a], rows[a + 1]):
            # Who comes later, or does not move, has no round yet.
            latest = max(latest, rounds[members[n]] + 1)
        rounds[a] = latest
        placed[k, 0] = latest
        most = max(most, latest)
    starts, found = counting_sort(placed, most + 1)
    for k in range(len(order)):
        found[k] = order[found[k]]
    return starts, found
