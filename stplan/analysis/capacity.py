"""How soon agents can be through a gate that all of them have to pass, at their greatest speeds.

Let tau_1 <= ... <= tau_n be passages of a gate, one of every agent, and a_(k) the k-th smallest of their
earliest ones. Then tau_k >= a_(k). Where only one fits through at a time, whoever passes next was s_i away
when the last one passed (`least_asides`), or was not there yet: g = min s_i / v_i lie between them at least.

And however wide the gate is, discs on it are apart: the chords that they cut from it add up to its width w at
most. A disc that crosses it at v adds pi r^2 / v to the integral of chords over time, half of it before its
(last) passage and half of it after. So from when the first one touches the gate until tau_k

    w (tau_k - begin) >= sum of the k smallest pi r^2 / v - what is missing at tau_k.

Those that passed and have not left the gate since are beyond it by 0 <= s < r and lack mu(s / r) pi r^2 /
(2 v), where mu(x) = (4 / pi) int_x^1 sqrt(1 - u^2) du falls from 1 to 0 and mu <= sqrt(1 - x^2). Neighbours
i and j on the gate with s_j = s_i + d are sqrt((r_i + r_j)^2 - d^2) >= r_i + r_j mu(d / r_j) from each
other along it, the outermost ones r_i mu at least from its ends. So sum r_i mu_i <= w / 2, and pi w / 4 max
(r / v) at most is missing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.analysis.gates import HAIR, Gate, find_gates
from stplan.analysis.queues import least_asides
from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.problem.planning_problem import PlanningProblem

# Gates are looked at up to so many times the largest radius wide.
WIDEST = 16.0
# Share by which durations are made smaller, against rounding.
ROUNDING = 1e-8


@dataclass(frozen=True)
class Passing:
    """When agents can be through a gate.

    Attributes:
        agents: (n,) who passes it.
        passages: (n,) the k-th passage is no earlier, s.
        tails: (n,) how long every agent takes at least from its passage to its arrival, s.
    """

    agents: IntArray
    passages: FloatArray
    tails: FloatArray

    @property
    def total(self) -> float:
        """Least sum of their arrivals, s."""
        return float(self.passages.sum() + self.tails.sum())

    @property
    def makespan(self) -> float:
        """They have not all arrived before this, s."""
        return float(self.passages[-1] + self.tails.min())


def passings(problem: PlanningProblem, whole: list[FloatArray]) -> list[Passing]:
    """Every gate that several agents of limited speed have to pass, and when they can be through.

    Args:
        whole: lower bounds of the ways of every agent between its stops, m.
    """
    if problem.free_space is None:
        return []
    assigned = {a for one in problem.scene.assignments for a in one.members}
    limited = [
        a
        for a, agent in enumerate(problem.scene.agents)
        if agent.path is None
        and not agent.waypoints
        and agent.max_speed is not None
        and a not in assigned
    ]
    found = (_passing(problem, gate) for gate in find_gates(problem, limited, whole, WIDEST))
    return [one for one in found if one is not None]


def _passing(problem: PlanningProblem, gate: Gate) -> Passing | None:
    """Those who keep clear of each other and begin and end off the gate; None if there are not two."""
    clear = _off(problem, gate)
    for k, agent in enumerate(gate.agents.tolist()):
        others = gate.agents[clear & (np.arange(len(clear)) < k)]
        apart = problem.distance[agent, others] >= problem.radii[agent] + problem.radii[others]
        clear[k] &= bool((problem.collides[agent, others] & apart).all())
    gate = gate.only(clear)
    who = gate.agents
    if len(who) < 2:
        return None
    speeds = np.array([problem.scene.agents[a].max_speed for a in who.tolist()], dtype=np.float64)
    earliest = np.sort(problem.start_times[who] + gate.before / speeds)
    asides = least_asides(gate, problem.radii[who], problem.distance[np.ix_(who, who)])
    gap = float((asides / speeds).min())
    passages = np.maximum(earliest, _by_area(problem, gate, speeds))
    for k in range(1, len(who)):
        passages[k] = max(passages[k], passages[k - 1] + gap)
    begin = problem.start_times[who].min()
    passages = begin + (1.0 - ROUNDING) * (passages - begin)
    placed = np.array([bool(problem.scene.agents[a].goal_places) for a in who.tolist()])
    tails = np.where(placed, _end_distances(problem, gate), gate.after) / speeds
    return Passing(who, passages, (1.0 - ROUNDING) * tails)


def _by_area(problem: PlanningProblem, gate: Gate, speeds: FloatArray) -> FloatArray:
    """(n,) when the k-th agent passes at the earliest, by the room that discs take on the gate, s."""
    radii = problem.radii[gate.agents]
    missing = 0.25 * np.pi * gate.width * float((radii / speeds).max())
    taken = np.cumsum(np.sort(np.pi * radii**2 / speeds)) - missing
    off = _distances(gate, problem.starts[gate.agents]) - radii
    touched = float((problem.start_times[gate.agents] + off / speeds).min())
    return touched + np.maximum(taken, 0.0) / gate.width


def _off(problem: PlanningProblem, gate: Gate) -> BoolArray:
    """(n,) whose disc is off the gate where it starts and wherever it may end."""
    radii = problem.radii[gate.agents] * (1.0 + HAIR)
    begins = _distances(gate, problem.starts[gate.agents])
    return (begins > radii) & (_end_distances(problem, gate) > radii)


def _end_distances(problem: PlanningProblem, gate: Gate) -> FloatArray:
    """(n,) distance to the gate of the goal, or of the nearest place, of those who pass it, m."""
    import shapely

    ends = _distances(gate, problem.goals[gate.agents])
    line = shapely.linestrings(gate.ends)
    for k, a in enumerate(gate.agents.tolist()):
        places = problem.scene.agents[a].goal_places
        if places:
            ends[k] = min(shapely.distance(place.shape(), line) for place in places)
    return ends


def _distances(gate: Gate, points: FloatArray) -> FloatArray:
    """(n,) distance of `points` (n, 2) to the gate, m."""
    along = gate.ends[1] - gate.ends[0]
    share = np.clip((points - gate.ends[0]) @ along / gate.width**2, 0.0, 1.0)
    return np.hypot(*(points - gate.ends[0] - share[:, None] * along).T)
