"""Curves slowed down where they exceed limits of motion, as far as everybody stays clear.

A limit of speed or acceleration at a few knots is kept once the segments between them last long enough. So
durations grow where limits are exceeded, by no more than that takes, until all are kept: out of an even pace
comes one that speeds up and brakes. Whether agents are still clear of each other is asked then; where they
are not, all slow down alike, which never brings those nearer who set out together.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from stplan.arrays import BoolArray, FloatArray
from stplan.costs.limit import Limiting, MotionLimit
from stplan.costs.terms.acceleration_limit import AccelerationLimit, RestLimit
from stplan.costs.terms.speed_limit import SpeedLimit
from stplan.problem.layout import KnotLayout
from stplan.problem.planning_problem import PlanningProblem

# Limits are kept to this share.
KEPT = 0.95
# How often durations grow, and by which factor at most at a time.
MOST_ROUNDS, MOST_GROWTH = 1000, 1.5
# Of the segments at a change of velocity those are lengthened that have so much of the greatest speed.
FAST = 0.9


def slowed(
    problem: PlanningProblem,
    layout: KnotLayout,
    knots: FloatArray,
    limits: Sequence[Limiting],
    clear: Callable[[FloatArray], bool],
    *,
    alike: bool = False,
) -> FloatArray | None:
    """Clear `knots` (M, 3) with later times, at which all `limits` are kept; None where that fails.

    `clear` says whether knots are. Each slows down where it has to, or all `alike` throughout.
    """
    motion = [
        (term, 1.0 if isinstance(term, SpeedLimit) else 0.5)
        for term in limits
        if isinstance(term, SpeedLimit | AccelerationLimit | RestLimit)
    ]
    movable = ~problem.prescribed[layout.agent_of_segment]
    found = _lengthened(layout, knots, motion, movable, alike)
    if found is None or (found[layout.last, 2] > problem.max_times).any():
        return None
    return found if all(term.is_kept(found) for term in limits) and clear(found) else None


def _lengthened(
    layout: KnotLayout,
    knots: FloatArray,
    motion: Sequence[tuple[MotionLimit, float]],
    movable: BoolArray,
    alike: bool,
) -> FloatArray | None:
    """`knots` with durations at which `motion` is kept; None where that takes too long.

    Each limit comes with the power of its share that times have to grow by.
    """
    step = np.where(movable, knots[layout.segment + 1, 2] - knots[layout.segment, 2], 0.0)
    factors = np.ones(len(step))
    found = knots
    for _ in range(MOST_ROUNDS):
        growth = np.ones(len(step))
        for term, power in motion:
            _demand(term, power, layout, found, growth)
        growth = np.where(movable, np.minimum(growth, MOST_GROWTH), 1.0)
        if growth.max(initial=1.0) <= 1.0:
            return found
        factors *= growth.max() if alike else growth
        # Durations that stay are added up as they were: nobody's times change by rounding alone.
        longer = np.cumsum((factors - 1.0) * step)
        before = np.append(0.0, longer)[layout.first - np.arange(layout.num_agents)]
        found = knots.copy()
        found[layout.segment + 1, 2] += longer - before[layout.agent_of_segment]
    return None


def _demand(
    term: MotionLimit, power: float, layout: KnotLayout, knots: FloatArray, growth: FloatArray
) -> None:
    """Enter into `growth` (S,) what the fast segments at every limit that is exceeded have to grow by."""
    shares = term.shares(knots) / KEPT
    over = shares > 1.0 + 1e-9
    starts = term.stencils[over, :-1]
    step = knots[starts + 1] - knots[starts]
    speed = np.hypot(step[..., 0], step[..., 1]) / step[..., 2]
    fast = speed >= FAST * speed.max(axis=1, keepdims=True, initial=0.0)
    wanted = np.where(fast, shares[over, None] ** power, 1.0)
    np.maximum.at(growth, starts - layout.agent_of_knot[starts], wanted)
