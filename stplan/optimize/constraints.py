"""What fixes, bounds and orders the knots of a problem."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.formulation import TimedConstraints
from stplan.nlp.constraints import UNBOUNDED, Constraints
from stplan.optimize.free_ends import as_bounds, ends_freely, free_ends
from stplan.problem.layout import KnotLayout
from stplan.problem.planning_problem import PlanningProblem

# Smallest duration of a segment over the mean one; and over the seed's own, where that is shorter.
LEAST_DURATION_SHARE = 1e-3
SEED_DURATION_SHARE = 0.1
# Largest duration of a segment over the mean one where acceleration is limited; and by how much longer
# segments of the seed may grow.
LONGEST_SHARE = 2.0
SPARE_SHARE = 0.01


def build_constraints(
    problem: PlanningProblem,
    layout: KnotLayout,
    seed: FloatArray,
    timed: TimedConstraints,
    *,
    free_times: bool = False,
) -> Constraints:
    """Bounds around `seed` (M, 3): fixed starts, goals, waypoints and paths; latest arrivals.

    Agents that vanish in a place may end anywhere in it. With `free_times`, visits and meetings are bound
    in place only.
    """
    lower = np.full(seed.shape, -UNBOUNDED)
    upper = np.full(seed.shape, UNBOUNDED)
    for a in range(problem.num_agents):
        first, last = layout.first[a], layout.last[a]
        own = slice(first, last + 1)
        if problem.prescribed[a]:
            lower[own] = upper[own] = seed[own]
            continue
        lower[first] = upper[first] = seed[first]
        if problem.scene.agents[a].starts_as_given:
            # Any other end of the first segment would give it another velocity or another duration.
            lower[first + 1] = upper[first + 1] = seed[first + 1]
        if not ends_freely(problem, a):
            lower[last, :2] = upper[last, :2] = seed[last, :2]
        upper[last, 2] = problem.max_times[a]
    planes = as_bounds(free_ends(problem, layout, seed), lower, upper)
    lower[timed.places, :2] = upper[timed.places, :2] = seed[timed.places, :2]
    step = seed[layout.segment + 1, 2] - seed[layout.segment, 2]
    mean = ((seed[layout.last, 2] - seed[layout.first, 2]) / layout.num_segments)[
        layout.agent_of_segment
    ]
    least = np.minimum(LEAST_DURATION_SHARE * mean, SEED_DURATION_SHARE * step)
    irregular = np.array([agent.weights.regularity == 0.0 for agent in problem.scene.agents])
    guarded = irregular[layout.agent_of_segment]
    launched = [agent.starts_as_given for agent in problem.scene.agents]
    first = np.searchsorted(layout.segment, layout.first[launched])
    guarded[first] = False
    dwelling = np.searchsorted(layout.segment, timed.stays[:, 0])
    share = _greatest_shares(problem, layout, step)
    share[dwelling] = share[first] = np.inf
    if free_times:
        no_links = np.empty((0, 2), dtype=np.int64)
        return Constraints(lower, upper, least, np.flatnonzero(guarded), no_links, share, planes)
    windowed, window = timed.windowed, timed.window
    lower[windowed, 2] = np.maximum(lower[windowed, 2], window[:, 0])
    upper[windowed, 2] = np.minimum(upper[windowed, 2], window[:, 1])
    least[dwelling] = timed.dwell
    guarded[dwelling] = True
    return Constraints(lower, upper, least, np.flatnonzero(guarded), timed.links, share, planes)


def _greatest_shares(problem: PlanningProblem, layout: KnotLayout, step: FloatArray) -> FloatArray:
    """(S,) parts of an agent's duration that its segments may last, given the seed's `step` (S,) in s.

    A long segment would hide how fast an agent has to speed up: where acceleration is limited, none lasts
    longer than twice the mean, or hardly longer than in the seed.
    """
    limited = np.array([agent.max_acceleration is not None for agent in problem.scene.agents])
    whole = np.bincount(layout.agent_of_segment, step, layout.num_agents)
    own = np.maximum(
        LONGEST_SHARE / layout.num_segments[layout.agent_of_segment],
        (1.0 + SPARE_SHARE) * step / whole[layout.agent_of_segment],
    )
    return np.where(limited[layout.agent_of_segment], own, np.inf)
