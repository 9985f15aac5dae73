"""What groups of agents have to pay beyond what each would pay alone, because they are in each other's way.

Every agent is in one group at most, so what groups pay more adds up to what all pay alone. But for those who
have to meet, only agents whose least cost alone is that of an even pace from start to goal until their latest
arrival are in groups: those without waypoints, with one goal, that do not mind when they arrive.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from stplan.analysis.evasions import MOST, Movers, evading_groups
from stplan.analysis.gates import Gate, find_gates
from stplan.analysis.lanes import find_lanes, opposed_in
from stplan.analysis.meetings import meeting_bound
from stplan.analysis.opposed import opposed_bound
from stplan.analysis.queues import Passers, least_asides, queue_bound
from stplan.arrays import FloatArray, IntArray, Point
from stplan.problem.planning_problem import PlanningProblem

# Share by which bounds are made smaller, against rounding here and in what a certificate lets pass.
ROUNDING = 1e-8
# Gates are looked at that agents at an even pace keep busy for more than this share of the time, and only
# so many; of those that the same agents pass only the busiest one.
BUSY, MOST_TRIED = 0.25, 3
# What groups pay more than alone counts from this share on.
NEGLIGIBLE = 1e-6


@dataclass(frozen=True)
class Together:
    """What some agents pay at least beyond what they would pay alone.

    Attributes:
        kind: what makes them.
        agents: (n,) sorted.
        extra: J s.
        place: where, m.
        width: of the gate or lane, m; None where they cross each other's ways or meet.
    """

    kind: Literal["gate", "lane", "crossing", "meeting"]
    agents: IntArray
    extra: float
    place: Point
    width: float | None = None

    def as_dict(self, names: Sequence[str]) -> dict[str, Any]:
        """For the report."""
        return {
            "kind": self.kind,
            "agents": [names[a] for a in self.agents.tolist()],
            "extra": self.extra,
            "place": list(self.place),
            **({} if self.width is None else {"width": self.width}),
        }


def joint_bounds(
    problem: PlanningProblem, legs: Sequence[FloatArray], least: FloatArray
) -> tuple[Together, ...]:
    """Groups of agents and what each pays at least beyond what its agents would pay alone.

    Args:
        legs: (w + 1,) lower bounds of the ways of every agent between its stops, m.
        least: (A,) what each would pay alone, J s.
    """
    meetings = _disjoint(_meetings(problem, least), _members([]))
    paced = np.setdiff1d(_even_paced(problem), _members(meetings))
    gates = find_gates(problem, paced.tolist(), legs)
    asked = [own for own in (_passers(problem, gate) for gate in gates) if own is not None]
    pairs = _opposed(problem, paced, legs)
    options = [_best_queues(problem, asked)]
    options[0] += _disjoint(pairs, _members(options[0]))
    if pairs:
        lanes = _disjoint(pairs, _members([]))
        rest = [queue.without(_members(lanes)) for queue in asked]
        options.append(lanes + _best_queues(problem, [own for own in rest if own.crowded]))
    found = max(options, key=lambda groups: sum(group.extra for group in groups))
    crossings = _crossings(problem, np.setdiff1d(paced, _members(found)), legs)
    return (*meetings, *found, *crossings)


def _members(groups: Sequence[Together]) -> IntArray:
    """(n,) agents of all `groups`."""
    return np.concatenate([np.empty(0, dtype=np.int64), *(group.agents for group in groups)])


def _disjoint(groups: Sequence[Together], taken: IntArray) -> list[Together]:
    """Those of `groups` that add most, without agents in common and without those `taken`."""
    found: list[Together] = []
    for group in sorted(groups, key=lambda group: -group.extra):
        if not np.isin(group.agents, taken).any():
            found.append(group)
            taken = np.append(taken, group.agents)
    return found


def _meetings(problem: PlanningProblem, least: FloatArray) -> list[Together]:
    """Pairs that have to meet."""
    found = []
    for one in problem.meetings:
        pair = np.array([one.first, one.second])
        bound = meeting_bound(problem, one.first, one.second, one.meet.within)
        alone = float(least[pair].sum())
        extra = 0.0 if bound is None else (1.0 - ROUNDING) * bound - alone
        if extra > NEGLIGIBLE * alone:
            middle = 0.25 * (problem.starts[pair] + problem.goals[pair]).sum(axis=0)
            x, y = problem.frame.points(middle[None])[0].tolist()
            found.append(Together("meeting", pair, extra * problem.frame.cost, (x, y)))
    return found


def _opposed(
    problem: PlanningProblem, agents: IntArray, legs: Sequence[FloatArray]
) -> list[Together]:
    """Pairs of `agents` that go through a lane in opposite directions."""
    found = []
    for lane in find_lanes(problem, agents.tolist()):
        for pair in opposed_in(problem, lane, agents.tolist(), legs):
            low, high = (_at_gate(problem, gate) for gate in pair.gates)
            alone = float(low.alone.sum())
            extra = (1.0 - ROUNDING) * opposed_bound(low, high, pair.room) - alone
            if np.isfinite(extra) and extra > NEGLIGIBLE * alone:
                x, y = problem.frame.points(pair.middle[None])[0].tolist()
                found.append(
                    Together(
                        "lane",
                        np.sort(pair.agents),
                        extra * problem.frame.cost,
                        (x, y),
                        pair.gates[0].width * problem.frame.length,
                    )
                )
    return found


def _crossings(
    problem: PlanningProblem, agents: IntArray, legs: Sequence[FloatArray]
) -> list[Together]:
    """Groups of those `agents` who start and arrive at the same times and cross each other's ways."""
    times = np.column_stack([problem.start_times, problem.max_times])[agents]
    found: list[Together] = []
    for both in np.unique(times, axis=0):
        mine = agents[(times == both).all(axis=1)]
        if len(mine) > MOST:
            continue
        pairs = np.ix_(mine, mine)
        weights = np.array([problem.scene.agents[a].weights.kinetic for a in mine.tolist()])
        movers = Movers(
            starts=problem.starts[mine],
            goals=problem.goals[mine],
            stiffness=weights * problem.masses[mine],
            vanishes=~problem.stays[mine],
            distance=np.where(problem.collides[pairs], problem.distance[pairs], 0.0),
            duration=float(both[1] - both[0]),
        )
        ways = np.array([float(legs[a].sum()) for a in mine.tolist()])
        alone = 0.5 * movers.stiffness * ways**2 / movers.duration
        for group, evading in evading_groups(movers):
            own = float(alone[group].sum())
            extra = (1.0 - ROUNDING) * (float(movers.straight[group].sum()) + evading) - own
            if extra > NEGLIGIBLE * own:
                middle = 0.5 * (movers.starts[group] + movers.goals[group]).mean(axis=0)
                x, y = problem.frame.points(middle[None])[0].tolist()
                found.append(Together("crossing", mine[group], extra * problem.frame.cost, (x, y)))
    return found


@dataclass(frozen=True)
class _Queue:
    """Agents that keep clear of each other and pass a gate."""

    gate: Gate
    passers: Passers

    @property
    def load(self) -> float:
        """Share of the time that they keep the gate busy at an even pace."""
        own = self.passers
        busy = own.aside * (own.end - own.begin) / own.whole
        return float(busy.sum() / (own.end.max() - own.begin.min()))

    @property
    def crowded(self) -> bool:
        """Whether there are two or more."""
        return len(self.gate.agents) > 1

    def without(self, agents: IntArray) -> _Queue:
        """The same for all but `agents`."""
        kept = ~np.isin(self.gate.agents, agents)
        return _Queue(self.gate.only(kept), self.passers.only(kept))


def _best_queues(problem: PlanningProblem, queues: list[_Queue]) -> list[Together]:
    """Of `queues` those that add most, one after another, without agents in common."""
    found: list[Together] = []
    tried = 0
    while queues and tried < MOST_TRIED:
        best, most = None, NEGLIGIBLE
        busiest: dict[bytes, _Queue] = {}
        for queue in sorted(queues, key=lambda queue: -queue.load):
            busiest.setdefault(queue.gate.agents.tobytes(), queue)
        for queue in [*busiest.values()][: MOST_TRIED - tried]:
            if queue.load < BUSY:
                break
            tried += 1
            alone = float(queue.passers.alone.sum())
            extra = (1.0 - ROUNDING) * queue_bound(queue.passers) - alone
            if extra > most * alone:
                best, most = queue, extra / alone
        if best is None:
            break
        gate = best.gate
        x, y = problem.frame.points(gate.ends.mean(axis=0)[None])[0].tolist()
        extra = most * float(best.passers.alone.sum()) * problem.frame.cost
        found.append(
            Together("gate", gate.agents, extra, (x, y), gate.width * problem.frame.length)
        )
        rest = [queue.without(gate.agents) for queue in queues]
        queues = [queue for queue in rest if queue.crowded]
    return found


def _even_paced(problem: PlanningProblem) -> IntArray:
    """Agents that move at an even pace from start to goal until their latest arrival if they are alone."""
    assigned = {a for one in problem.scene.assignments for a in one.members}
    return np.array(
        [
            a
            for a, agent in enumerate(problem.scene.agents)
            if agent.path is None
            and not agent.waypoints
            and not agent.goal_places
            and a not in assigned
            and (agent.preferred_time is None or agent.weights.arrival <= 0.0)
            and agent.weights.kinetic > 0.0
        ],
        dtype=np.int64,
    )


def _passers(problem: PlanningProblem, gate: Gate) -> _Queue | None:
    """Those who pass `gate` one at a time and all keep clear of each other; None if there are not two."""
    clear = np.zeros(len(gate.agents), dtype=bool)
    for k, agent in enumerate(gate.agents.tolist()):
        clear[k] = problem.collides[agent, gate.agents[clear]].all()
    gate = gate.only(clear)
    while len(gate.agents) > 1:
        own = _at_gate(problem, gate)
        if (own.aside > 0.0).all():
            return _Queue(gate, own)
        gate = gate.only(own.aside > 0.0)
    return None


def _at_gate(problem: PlanningProblem, gate: Gate) -> Passers:
    """The agents of `gate`."""
    who = gate.agents
    weights = np.array([problem.scene.agents[a].weights.kinetic for a in who.tolist()])
    return Passers(
        stiffness=0.5 * weights * problem.masses[who],
        begin=problem.start_times[who],
        end=problem.max_times[who],
        aside=least_asides(gate, problem.radii[who], problem.distance[np.ix_(who, who)]),
        before=gate.before,
        after=gate.after,
        whole=gate.whole,
    )
