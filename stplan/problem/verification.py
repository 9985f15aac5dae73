"""The proof that curves are clear: what is wrong with them, if anything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.clearance import STRICT, rod_clearances, wall_clearance
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement, least_requirement

# A waypoint counts as passed, a prescribed path as followed, within this distance (m).
PLACE_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Fault:
    """What is wrong with the curves of `agents` (ids)."""

    agents: tuple[str, ...]
    what: str

    def __str__(self) -> str:
        """Who, and what."""
        return f"{' and '.join(self.agents)}: {self.what}"


def verify(
    problem: PlanningProblem, curves: Sequence[FloatArray], required: Requirement | None = None
) -> list[Fault]:
    """What is wrong with `curves`, one an agent; nothing proves them a clear seed.

    Ends and waypoints exact, times rising, arrival no later than `max_times`, rods and walls
    further than `required` (default: R and r).
    """
    ids = problem.agent_ids
    if len(curves) != problem.num_agents:
        return [Fault(ids, f"{len(curves)} curves for {problem.num_agents} agents")]
    faults = [
        Fault((ids[agent],), what)
        for agent, curve in enumerate(curves)
        for what in _shape_faults(problem, agent, curve)
    ]
    if faults:
        return faults
    wanted = least_requirement(problem) if required is None else required
    for a, b, gap in rod_clearances(problem, curves, wanted.rods, reach=1.01).violations:
        what = f"rods {gap:.6g} m apart, not over {wanted.rods[a, b]:.6g} m"
        faults.append(Fault((ids[a], ids[b]), what))
    for agent, curve in enumerate(curves):
        limit = float(wanted.walls[agent])
        gap = wall_clearance(problem, agent, curve, 1.01 * limit)
        if gap <= limit * STRICT:
            faults.append(Fault((ids[agent],), f"{gap:.6g} m from a wall, not over {limit:.6g} m"))
    return faults


def _shape_faults(problem: PlanningProblem, agent: int, curve: FloatArray) -> list[str]:
    """What is wrong with one curve on its own."""
    if curve.ndim != 2 or curve.shape[1] != 3 or len(curve) < 2 or not np.isfinite(curve).all():
        return ["needs at least two finite knots"]
    faults = []
    if (np.diff(curve[:, 2]) <= 0).any():
        faults.append("time does not increase")
    if tuple(curve[0]) != (*problem.starts[agent], problem.start_times[agent]):
        faults.append("does not start at its start")
    if tuple(curve[-1, :2]) != tuple(problem.goals[agent]):
        faults.append("does not end at its goal")
    if curve[-1, 2] > problem.max_times[agent]:
        faults.append(f"arrives at {curve[-1, 2]} s, after {problem.max_times[agent]} s")
    if faults:
        return faults
    path = problem.paths[agent]
    if path is not None:
        times = np.union1d(path[:, 2], curve[:, 2])
        for x in range(2):
            ours = np.interp(times, curve[:, 2], curve[:, x])
            given = np.interp(times, path[:, 2], path[:, x])
            if np.abs(ours - given).max() > PLACE_TOLERANCE:
                return ["leaves its prescribed path"]
    after = 0
    for number, point in enumerate(problem.waypoints[agent], start=1):
        hits = np.flatnonzero(np.abs(curve[after:, :2] - point).max(axis=1) <= PLACE_TOLERANCE)
        if not len(hits):
            return [f"has no knot on waypoint {number} in order"]
        after += int(hits[0])
    return []
