"""Agents that have nothing to do with each other are optimised apart.

All agents of one program share the length of its steps and the moment it ends. One that runs into its limits
again and again would hold up others that it never meets, and its cost would drown theirs. So agents are
optimised in connected components of who is in view of whom, who has to meet and who is drawn together. Where
components have come into view of each other they are joined and followed once more.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from stplan.arrays import IntArray
from stplan.callbacks import Progress, Stop
from stplan.optimize.continuation import LiveLine, Optimisation, OuterIteration
from stplan.optimize.parts import DividedProblem, Part
from stplan.problem.planning_problem import PlanningProblem
from stplan.status import Status

# Components are looked for so often at most; joined ones leave out the first values of mu.
MOST_ROUNDS, LATER_BEGIN = 3, 2
# The worst last.
_ORDER = (Status.CONVERGED, Status.LIMIT, Status.FAILED, Status.INTERRUPTED)


def components(parts: DividedProblem) -> list[IntArray]:
    """Agents that plan, those together who have to do with each other.

    Lone ones that ask for nothing but a cheap way are one component: none of them holds up another.
    """
    problem = parts.problem
    plain: list[IntArray] = []
    rest: list[IntArray] = []
    for one in connected(problem, parts.in_view()):
        lone = len(one) == 1 and _is_plain(problem, int(one[0]))
        (plain if lone else rest).append(one)
    return rest + ([np.sort(np.concatenate(plain))] if plain else [])


def _is_plain(problem: PlanningProblem, agent: int) -> bool:
    """Whether an agent has no limits, no times and no turns to mind."""
    own = problem.scene.agents[agent]
    limited = own.max_speed is not None or own.max_acceleration is not None
    weighed = own.weights.arrival > 0.0 or own.weights.acceleration > 0.0
    return not (limited or weighed or own.visits)


def optimise_components(
    parts: DividedProblem,
    found: Sequence[IntArray],
    *,
    progress: Progress,
    stop: Stop,
    live: LiveLine | None = None,
) -> Optimisation:
    """All components, again where they have joined."""
    problem, seed_costs = parts.problem, parts.costs(parts.formulation.scales.mu)
    runs: list[Optimisation] = []
    failed = False
    known: list[set[int]] = []
    last = problem.scene.solver.outer_iterations - 1
    for turn in range(MOST_ROUNDS):
        new = [one for one in found if not any(set(one.tolist()) <= group for group in known)]
        if not new or stop():
            break
        for number, component in enumerate(new, start=1):
            heading = f"part {number} of {len(new)}"
            begin = 0 if turn == 0 else min(LATER_BEGIN, last)
            done = parts.optimise(Part(component, begin), _headed(live, heading))
            if done is None:
                failed = True
                continue
            runs.append(done)
            ids = ", ".join(problem.agent_ids[agent] for agent in component[:3].tolist())
            more = f" and {len(component) - 3} more" if len(component) > 3 else ""
            progress(f"{heading} ({ids}{more})  {done.iterations} iterations  {done.status}")
        known = [set(one.tolist()) for one in found]
        found = components(parts)
    statuses = [run.status for run in runs] + ([Status.FAILED] if failed else [])
    if stop():
        statuses.append(Status.INTERRUPTED)
    status = max(statuses, key=_ORDER.index, default=Status.FAILED)
    return parts.optimisation(status, _together(runs, status), seed_costs)


def _together(runs: Sequence[Optimisation], status: Status) -> list[OuterIteration]:
    """Outer iterations of several runs as those of one, the last ones side by side."""
    count = max((len(run.outer_iterations) for run in runs), default=0)
    entries = []
    for back in range(count, 0, -1):
        same = [run.outer_iterations[-back] for run in runs if len(run.outer_iterations) >= back]
        worst = max((one.status for one in same), key=_ORDER.index)
        entries.append(
            OuterIteration(
                number=count - back + 1,
                mu=max(one.mu for one in same),
                iterations=sum(one.iterations for one in same),
                rebuilds=sum(one.rebuilds for one in same),
                objective=sum(one.objective for one in same),
                clearance=min(one.clearance for one in same),
                status=status if back == 1 else worst,
            )
        )
    return entries


def _headed(live: LiveLine | None, heading: str) -> LiveLine | None:
    if live is None:
        return None

    def headed(line: Callable[[], str]) -> None:
        live(lambda: f"{heading}  {line()}")

    return headed


def connected(problem: PlanningProblem, related: IntArray) -> list[IntArray]:
    """Agents that plan, those together who are `related` pairs (N, 2), have to meet or are drawn together."""
    planning = ~problem.prescribed
    meetings = np.array([[one.first, one.second] for one in problem.meetings], dtype=np.int64)
    joined = [related, meetings.reshape(-1, 2)]
    if any(rule.grouping for rule in problem.scene.pairs):
        joined.append(np.argwhere(problem.interactions.grouping > 0.0))
    pairs = np.vstack(joined)
    rows, columns = pairs[planning[pairs].all(axis=1)].T
    label = np.arange(problem.num_agents)
    while True:
        # Everybody takes the least label among those it is joined to, and theirs.
        least = label.copy()
        np.minimum.at(least, rows, label[columns])
        np.minimum.at(least, columns, label[rows])
        least = least[least]
        if np.array_equal(least, label):
            break
        label = least
    members: dict[int, list[int]] = {}
    for agent in np.flatnonzero(planning).tolist():
        members.setdefault(int(label[agent]), []).append(agent)
    return [np.array(one, dtype=np.int64) for one in members.values()]
