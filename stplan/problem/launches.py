"""Agents that start in motion, as a problem of agents that start anyhow.

Seeders choose any first segment. So whoever has a `start_velocity` is sent along it for a short while, its
launch, and its way is looked for from where that ends. Launches are there for everybody else as prescribed
motion; in the end they are put before the curves that were found.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from stplan.arrays import FloatArray
from stplan.errors import SeedingError
from stplan.geometry.rod_distances import segment_distances
from stplan.problem.clearance import STRICT, wall_clearance
from stplan.problem.planning_problem import LEAST_AUTO_KNOTS, PlanningProblem
from stplan.problem.restriction import Piece, with_obstacles
from stplan.reasons import Reason

# Launches last as long as a mean segment, where nothing says for how long, and are halved so often where they
# would touch something.
HALVINGS = 30


@dataclass(frozen=True)
class Launches:
    """Launches of the agents of `whole` that start in motion.

    Attributes:
        pieces: the launch (2, 3) of each of them, by its index.
    """

    whole: PlanningProblem
    pieces: Mapping[int, FloatArray]

    @staticmethod
    def of(problem: PlanningProblem, fixed: Collection[int] | None = None) -> Launches | None:
        """Launches that touch nothing; None where everybody starts anyhow.

        Args:
            fixed: whose launches last as long as they are to, those with a `start_duration` by default.

        Raises:
            SeedingError: an agent can only touch something next.
        """
        agents = problem.scene.agents
        moving = [a for a, agent in enumerate(agents) if agent.start_velocity is not None]
        if not moving:
            return None
        if fixed is None:
            fixed = {a for a in moving if agents[a].start_duration > 0.0}
        knots = problem.scene.solver.knots or LEAST_AUTO_KNOTS
        lasts = (problem.preferred_times - problem.start_times) / knots
        given = np.array([agent.start_duration for agent in agents])
        lasts = np.where(given > 0.0, given, lasts)
        for _ in range(HALVINGS):
            pieces = {a: _launch(problem, a, float(lasts[a])) for a in moving}
            bad = _touching(problem, pieces)
            if not bad:
                return Launches(problem, pieces)
            if all(a in fixed for a in bad):
                break
            lasts[[a for a in bad if a not in fixed]] *= 0.5
        raise SeedingError([Reason("not clear", tuple(problem.agent_ids[a] for a in bad))])

    @staticmethod
    def of_curves(problem: PlanningProblem, curves: Sequence[FloatArray]) -> Launches | None:
        """The first segments of clear `curves` as launches; None where everybody starts anyhow."""
        agents = problem.scene.agents
        pieces = {
            a: np.array(curves[a][:2])
            for a, agent in enumerate(agents)
            if agent.start_velocity is not None
        }
        return Launches(problem, pieces) if pieces else None

    @cached_property
    def problem(self) -> PlanningProblem:
        """All agents from where their launches end, then the launches."""
        whole, count = self.whole, self.whole.num_agents
        agents = list(whole.scene.agents)
        starts, times = whole.starts.copy(), whole.start_times.copy()
        for a, piece in self.pieces.items():
            starts[a], times[a] = piece[-1, :2], piece[-1, 2]
            x, y, t = piece[-1].tolist()
            agents[a] = replace(agents[a], start=(x, y), start_time=t)
        launched = replace(
            whole,
            scene=replace(whole.scene, agents=tuple(agents)),
            starts=starts,
            start_times=times,
        )
        obstacles = [Piece(a, piece, False) for a, piece in self.pieces.items()]
        found = with_obstacles(launched, obstacles)
        collides = found.collides.copy()
        for number, a in enumerate(self.pieces, start=count):
            collides[a, number] = collides[number, a] = False
        return replace(found, interactions=replace(found.interactions, collides=collides))

    def joined(self, curves: Sequence[FloatArray]) -> list[FloatArray]:
        """Curves of `problem` as those of `whole`: each behind its launch."""
        return [
            np.vstack([self.pieces[a][:1], curve]) if a in self.pieces else curve
            for a, curve in enumerate(curves[: self.whole.num_agents])
        ]

    def parted(self, curves: Sequence[FloatArray]) -> list[FloatArray]:
        """Curves of `whole` that begin with the launches as those of `problem`."""
        rest = [curve[1:] if a in self.pieces else curve for a, curve in enumerate(curves)]
        return [*rest, *self.pieces.values()]

    def owner(self, name: str) -> str:
        """Whom an agent of `problem` stands for."""
        if name not in self.problem.agent_ids:
            return name
        place = self.problem.agent_ids.index(name)
        own = (
            place
            if place < self.whole.num_agents
            else list(self.pieces)[place - self.whole.num_agents]
        )
        return self.whole.agent_ids[own]


def _launch(problem: PlanningProblem, agent: int, lasts: float) -> FloatArray:
    velocity = np.array(problem.scene.agents[agent].start_velocity)
    start = np.append(problem.starts[agent], problem.start_times[agent])
    return np.vstack([start, start + np.append(lasts * velocity, lasts)])


def _touching(problem: PlanningProblem, pieces: Mapping[int, FloatArray]) -> list[int]:
    """Agents whose `pieces` come too near to a wall, another piece, or somebody's start."""
    bad = {
        a
        for a, piece in pieces.items()
        if wall_clearance(problem, a, piece) <= problem.radii[a] * STRICT
    }
    ends = np.repeat(np.column_stack([problem.starts, problem.start_times])[:, None], 2, axis=1)
    for a, piece in pieces.items():
        ends[a] = piece
    positions = np.ascontiguousarray((ends * [1.0, 1.0, problem.time_scale]).reshape(-1, 3))
    segments = np.arange(len(positions)).reshape(-1, 2)
    moves = np.zeros(problem.num_agents, dtype=bool)
    moves[list(pieces)] = True
    first, second = np.nonzero(np.triu(problem.collides & (moves[:, None] | moves[None, :])))
    pairs = np.ascontiguousarray(np.column_stack([first, second]).astype(np.int64))
    gaps = segment_distances(positions, segments, pairs)
    near = pairs[gaps <= problem.distance[first, second] * STRICT]
    return sorted(bad | {int(a) for a in near.ravel() if moves[a]})
