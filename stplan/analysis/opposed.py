"""What two agents pay at least that go through a lane in opposite directions and cannot pass each other.

Take the first passage of agent i from one end of the lane to the other, and that of j. Were both on it at one
instant, one would be behind the other along the lane first and before it in the end; in between they would
be side by side, for which there is no room. So one has left the lane, at an instant f, before the other one
enters it by the same end, at an instant e >= f. Let i go first. By f it has covered its way P to that end,
and s_i more by e, as it is aside then (`least_asides`); from e on j covers its way Q on from there, and s_j
more from f on, as it is aside then. So they pay at least

    min_{f <= e} max(C_i(P; f), C_i(P + s_i; e)) + max(D_j(s_j + Q; f), D_j(Q; e)),

with C(l; t) what it takes to cover l until t and D(l; t) what it takes from t on (`hurried`), or the same
with j first. C falls and D rises with time, so that their values at the ends of cells bound all between.
"""

from __future__ import annotations

import numpy as np

from stplan.analysis.queues import Passers, hurried
from stplan.arrays import FloatArray

# Cells of the time that f and e are in.
CELLS = 256


def opposed_bound(low: Passers, high: Passers, room: tuple[bool, bool]) -> float:
    """What both pay at least together, J s; inf where neither can go first.

    Args:
        low, high: the two agents at both ends of the lane; the first one goes from `low` to `high`.
        room: whether the first one finds room before `low` while the other one is there, and the second
            one beyond `high`. Who does not cannot go second, unless it may start later.
    """
    later = low.begin[0] > low.begin[1], low.begin[1] > low.begin[0]
    options = [
        _in_order(passers, first)
        for passers, first, possible in (
            (high, 0, room[1] or later[1]),
            (low, 1, room[0] or later[0]),
        )
        if possible
    ]
    return min(options, default=np.inf)


def _in_order(passers: Passers, first: int) -> float:
    """The same where the agent `first` has left by the gate before the other one enters by it."""
    edges = np.linspace(float(passers.begin.min()), float(passers.end.max()), CELLS + 1)
    lows, highs = edges[:-1], edges[1:]
    gone = np.arange(2) == first
    i, j = passers.only(gone), passers.only(~gone)

    def until(length: FloatArray) -> FloatArray:
        return hurried(i, length[:, None], highs[None, :] - i.begin[:, None])[0]

    def since(length: FloatArray) -> FloatArray:
        return hurried(j, length[:, None], j.end[:, None] - lows[None, :])[0]

    ahead = np.maximum(until(i.before)[:, None], until(i.before + i.aside)[None, :])
    behind = np.maximum(since(j.aside + j.after)[:, None], since(j.after)[None, :])
    return float((ahead + behind)[np.triu_indices(CELLS)].min())
