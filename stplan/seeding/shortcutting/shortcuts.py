"""Shortcutting and retiming: clear curves made cheaper and even, every step of it proven clear.

First everything is stretched in time towards the preferred arrivals (a uniform stretch never
brings rods closer), then shortcuts, moved knots and later arrivals lower the kinetic cost, and last
the curves get knots of even durations: very uneven ones would stall the optimiser.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.arrays import FloatArray
from stplan.callbacks import Stop
from stplan.deadline import passed
from stplan.problem.kinetic_cost import total_kinetic_cost
from stplan.problem.planning_problem import LEAST_AUTO_KNOTS, PlanningProblem
from stplan.problem.requirement import Requirement, held_requirement
from stplan.problem.verification import verify
from stplan.seeding.shortcutting.resampling import resample_curve
from stplan.seeding.shortcutting.retiming import even_knots
from stplan.seeding.shortcutting.rod_field import build_field
from stplan.seeding.shortcutting.shortcut_kernels import shortcut_round

# Knots an agent gets by default: enough for the bends of its shortened curve, but no more than these.
MOST_AUTO_KNOTS = 100
KNOTS_PER_BEND = 2
# Durations allowed, as parts of the mean: as even as the bends permit.
EVENNESS = ((0.5, 2.0), (0.42, 2.5), (0.3, 3.0), (0.15, 5.0), (0.05, 10.0))
# Rounds of shortcuts at most, each one as long as the last lowered the kinetic cost by this part.
MOST_ROUNDS = 8
WORTHWHILE = 0.005
# Random shortcuts tried for every agent in every round; more only leave more knots behind.
TRIES = 20
# The clock is looked at after so many agents of a round.
CHUNK = 8
# Retiming may use up this part of the clearance over R: on a curve pulled taut against its
# requirement no knot could move.
SLACK = 0.2


def prepare_seed(
    problem: PlanningProblem,
    curves: Sequence[FloatArray],
    required: Requirement,
    *,
    num_knots: int | None = None,
    rng_seed: int = 0,
    stopped: Stop = passed,
) -> list[FloatArray]:
    """`curves` shortened and retimed, with `num_knots` knots an agent (None follows the bends).

    The curves have to be clear. They are shortened up to `held_requirement` of what is `required`, and
    `SLACK` of what that asks over R may go into retiming. Prescribed paths stay as they are. A curve
    may keep more knots than asked for where its bends cannot be had with fewer. Once `stopped`, the
    curves are clear, but as far as they have come.
    """
    held = held_requirement(problem, curves, required)
    shortened = take_shortcuts(problem, curves, held, rng_seed=rng_seed, stopped=stopped)
    # Of thousands of agents squares of all pairs take most of the memory: no more of them than needed.
    rods = held.rods
    rods -= problem.distance
    rods *= 1.0 - SLACK
    rods += problem.distance
    eased = Requirement(rods, problem.radii + (1.0 - SLACK) * (held.walls - problem.radii))
    retimed = retime(problem, shortened, eased, num_knots, stopped=stopped)
    if not verify(problem, retimed, eased):
        return retimed
    # Only rounding could bring us here; the curves as they came are still clear.
    return resample(problem, curves, num_knots)


def take_shortcuts(
    problem: PlanningProblem,
    curves: Sequence[FloatArray],
    required: Requirement,
    *,
    rng_seed: int = 0,
    rounds: int = MOST_ROUNDS,
    stopped: Stop = passed,
) -> list[FloatArray]:
    """Cheaper curves than the clear `curves`, with few knots and as clear as is `required`.

    After `rounds` of it at most, or once `stopped`, they are as far as whole rounds have come.
    """
    rng = np.random.default_rng(rng_seed)
    current = stretch(problem, curves, required)
    movable = np.flatnonzero(~problem.prescribed)
    cost = total_kinetic_cost(problem.masses, current)
    for turn in range(rounds):
        if stopped():
            break
        field = build_field(problem, current, required)
        order = movable if turn % 2 == 0 else movable[::-1].copy()
        draws = rng.random((problem.num_agents, TRIES, 2))
        arrivals = problem.time_scale * problem.preferred_times
        for first in range(0, len(order), CHUNK):
            entries = shortcut_round(field, order[first : first + CHUNK], draws, arrivals)
            field = field.with_entries(entries)
            if stopped():
                return current
        current = [field.curve(problem, agent) for agent in range(problem.num_agents)]
        before, cost = cost, total_kinetic_cost(problem.masses, current)
        if before - cost <= WORTHWHILE * before:
            break
    return current


def stretch(
    problem: PlanningProblem, curves: Sequence[FloatArray], required: Requirement
) -> list[FloatArray]:
    """The curves slowed down towards their preferred arrivals, as far as that is proven clear.

    All agents share one factor, which cannot bring rods closer where all start together; then each
    its own. Prescribed paths, unequal starts and tails are why it is proven and not taken for granted.
    """
    current = [np.array(curve) for curve in curves]
    movable = np.flatnonzero(~problem.prescribed)
    if not len(movable):
        return current
    lasts = np.array([current[agent][-1, 2] for agent in movable])
    begins = problem.start_times[movable]
    own = np.maximum(
        (problem.preferred_times[movable] - begins) / np.maximum(lasts - begins, 1e-300), 1.0
    )
    shared = np.full(len(own), own.min())
    for factors in (own, shared, 1.0 + 0.5 * (shared - 1.0), 1.0 + 0.25 * (shared - 1.0)):
        if factors.max() <= 1.0 + 1e-9:
            continue
        slower = list(current)
        for agent, factor in zip(movable, factors, strict=True):
            slower[agent] = _stretched(problem, int(agent), current[agent], float(factor))
        if not verify(problem, slower, required):
            return slower
    return current


def _stretched(
    problem: PlanningProblem, agent: int, curve: FloatArray, factor: float
) -> FloatArray:
    """One curve slowed down by `factor` from its start on."""
    begin, preferred = problem.start_times[agent], problem.preferred_times[agent]
    result = curve.copy()
    result[:, 2] = begin + factor * (curve[:, 2] - begin)
    result[0, 2] = begin
    if abs(result[-1, 2] - preferred) <= 1e-9 * abs(preferred):
        result[-1, 2] = preferred
    return result


def resample(
    problem: PlanningProblem, curves: Sequence[FloatArray], num_knots: int | None = None
) -> list[FloatArray]:
    """The same curves with `num_knots` knots each (None follows the bends), prescribed paths as is."""
    return [
        curve.copy() if path is not None else resample_curve(curve, num_knots or _auto_knots(curve))
        for curve, path in zip(curves, problem.paths, strict=True)
    ]


def retime(
    problem: PlanningProblem,
    curves: Sequence[FloatArray],
    required: Requirement,
    num_knots: int | None = None,
    *,
    stopped: Stop = passed,
) -> list[FloatArray]:
    """Clear curves with exactly `num_knots` knots of about equal durations, as clear as is `required`.

    Every duration is at least half the mean where the bends permit, less where they do not; where
    nothing helps, or once `stopped`, all old knots stay and new ones go between them.
    """
    wanted = [num_knots or _auto_knots(curve) for curve in curves]
    field = build_field(problem, curves, required, room=max(wanted))
    result = []
    for agent, path in enumerate(problem.paths):
        evened = (
            path is None
            and not stopped()
            and any(
                even_knots(field, agent, wanted[agent], shortest, longest)
                for shortest, longest in EVENNESS
            )
        )
        curve = field.curve(problem, agent)
        if evened:
            field = field.with_rods(np.array([agent]))
        elif path is None:
            curve = resample_curve(curve, wanted[agent])
        result.append(curve)
    return result


def _auto_knots(curve: FloatArray) -> int:
    """Enough knots for the bends of a shortened curve."""
    return int(np.clip(KNOTS_PER_BEND * len(curve) + 16, LEAST_AUTO_KNOTS, MOST_AUTO_KNOTS))
