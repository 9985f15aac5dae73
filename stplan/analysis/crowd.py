"""Agents and their curves as arrays: all that the questions of this room need.

A crowd comes from a prepared problem, or from curves and radii alone where the scene is lost.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import BoolArray, FloatArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene.presence import present_until
from stplan.world import FreeSpace


@dataclass(frozen=True)
class Crowd:
    """What moves, and what it has to keep; A agents in the order of the curves.

    Attributes:
        lines: the curves.
        radii: (A,) m.
        stays: (A,) whether an agent stands on its goal after it has arrived.
        final_time: until when those who stay are there, s.
        collides, distance: (A, A) who keeps which distance (m) from whom.
        heeds_walls: (A,).
        free_space: the map, None where there is none or it is lost.
        preferred: (A,) wanted arrival in s, NaN where there is none.
        prescribed: (A,) whose motion is given: they neither choose nor wait.
        unhurried: (A,) who may be slow for reasons of their own: to set off, or to visit a waypoint.
    """

    lines: WorldLines
    radii: FloatArray
    stays: BoolArray
    final_time: float
    collides: BoolArray
    distance: FloatArray
    heeds_walls: BoolArray
    free_space: FreeSpace | None
    preferred: FloatArray
    prescribed: BoolArray
    unhurried: BoolArray

    @staticmethod
    def of_problem(problem: PlanningProblem, lines: WorldLines) -> Crowd:
        """The agents of `problem` on `lines`, which may stand in another order."""
        place = {agent_id: a for a, agent_id in enumerate(problem.agent_ids)}
        order = np.array([place[agent_id] for agent_id in lines.agent_ids], dtype=np.int64)
        agents = [problem.scene.agents[a] for a in order]
        square = np.ix_(order, order)
        wished = [agent.preferred_time for agent in agents]
        slow = [bool(agent.visits) or agent.max_acceleration is not None for agent in agents]
        return Crowd(
            lines=lines,
            radii=problem.radii[order],
            stays=problem.stays[order],
            final_time=problem.final_time,
            collides=problem.collides[square],
            distance=problem.distance[square],
            heeds_walls=problem.heeds_walls[order],
            free_space=problem.free_space,
            preferred=np.array([np.nan if time is None else time for time in wished]),
            prescribed=problem.prescribed[order],
            unhurried=np.array(slow, dtype=bool),
        )

    @staticmethod
    def of_discs(lines: WorldLines, radii: FloatArray) -> Crowd:
        """Discs of which nothing else is known: nobody may touch anybody, and all stay."""
        count = lines.num_agents
        arrivals = lines.knots[lines.offsets[1:] - 1, 2]
        return Crowd(
            lines=lines,
            radii=radii,
            stays=np.ones(count, dtype=bool),
            final_time=float(arrivals.max()),
            collides=~np.eye(count, dtype=bool),
            distance=radii[:, None] + radii[None, :],
            heeds_walls=np.ones(count, dtype=bool),
            free_space=None,
            preferred=np.full(count, np.nan),
            prescribed=np.zeros(count, dtype=bool),
            unhurried=np.zeros(count, dtype=bool),
        )

    @property
    def num_agents(self) -> int:
        """Number of agents A."""
        return self.lines.num_agents

    @property
    def arrivals(self) -> FloatArray:
        """(A,) when each agent arrives, s."""
        times: FloatArray = self.lines.knots[self.lines.offsets[1:] - 1, 2]
        return times

    @property
    def leaves(self) -> FloatArray:
        """(A,) until when each agent is there, s."""
        return present_until(self.stays, self.arrivals, self.final_time)
