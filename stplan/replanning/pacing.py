"""Those who are planned anew keep their ways where they can, and only change when they are where."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import least_requirement, requirement
from stplan.seeding.shortcutting.pacing import paced
from stplan.seeding.shortcutting.shortcuts import prepare_seed

# Orders of a group that are tried.
TRIES = 12


def paced_curves(
    problem: PlanningProblem,
    group: Sequence[int],
    curves: Mapping[int, FloatArray],
    ways: Mapping[int, FloatArray],
) -> dict[int, FloatArray] | None:
    """Clear curves of a `group` along its `ways`, one after another, shortened; None where there are none.

    Args:
        problem: in which all others are prescribed `curves`.
        ways: (n, 2) of each of the group, over its waypoints.
    """
    margins = (
        requirement(problem, problem.scene.seeding.margin),
        least_requirement(problem),
    )
    for required in margins:
        for order in _Orders(group, problem.scene.seeding.rng_seed):
            found: dict[int, FloatArray] = {}
            for place, agent in enumerate(order.agents):
                whole = _all(problem, curves, found)
                rest = order.agents[place + 1 :]
                curve = paced(problem, whole, agent, ways[agent], required, rest)
                if curve is None:
                    order.late = agent
                    break
                found[agent] = curve
            else:
                ready = prepare_seed(
                    problem,
                    _all(problem, curves, found),
                    required,
                    num_knots=problem.scene.solver.knots,
                    rng_seed=problem.scene.seeding.rng_seed,
                )
                return {agent: ready[agent] for agent in group}
    return None


@dataclass
class _Order:
    """Who is planned before whom; `late` is who found nothing any more."""

    agents: list[int]
    late: int | None = None


class _Orders:
    """Orders of a `group`: who came too late goes first next time, or a drawn one."""

    def __init__(self, group: Sequence[int], rng_seed: int) -> None:
        self._group, self._rng = list(group), np.random.default_rng(rng_seed)

    def __iter__(self) -> Iterator[_Order]:
        """At most so many as are worth it."""
        known: set[tuple[int, ...]] = set()
        agents = self._group
        for _ in range(TRIES):
            if tuple(agents) in known:
                agents = [int(a) for a in self._rng.permutation(self._group)]
            if tuple(agents) in known:
                continue
            known.add(tuple(agents))
            order = _Order(agents)
            yield order
            if order.late is not None:
                agents = [order.late, *(a for a in agents if a != order.late)]


def even_pace(problem: PlanningProblem, agent: int, way: FloatArray) -> FloatArray:
    """The curve of an agent along its `way` (n, 2) at constant speed."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))])
    begin, end = problem.start_times[agent], problem.preferred_times[agent]
    share = along / along[-1] if along[-1] > 0.0 else np.linspace(0.0, 1.0, len(way))
    kept = np.concatenate([[True], np.diff(share) > 0.0])
    return np.column_stack([way, begin + (end - begin) * share])[kept]


def _all(
    problem: PlanningProblem, curves: Mapping[int, FloatArray], found: Mapping[int, FloatArray]
) -> list[FloatArray]:
    """Everybody's curve; of who has none, that from its start to its goal."""
    starts = np.column_stack([problem.starts, problem.start_times])
    ends = np.column_stack([problem.goals, problem.max_times])
    return [
        found[a] if a in found else curves[a] if a in curves else np.vstack([starts[a], ends[a]])
        for a in range(problem.num_agents)
    ]
