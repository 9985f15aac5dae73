"""A part of a problem: some agents plan, some others move as they are told, the rest is not there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.scene.interactions import Interactions, Meeting


@dataclass(frozen=True)
class Piece:
    """A part of an agent's curve that others keep clear of.

    Attributes:
        agent: whose.
        curve: (n, 3), at least two knots.
        stays: whether the agent stands on its goal afterwards.
    """

    agent: int
    curve: FloatArray
    stays: bool


def restricted(
    problem: PlanningProblem, agents: IntArray, obstacles: Sequence[Piece]
) -> PlanningProblem:
    """`problem` of its `agents` alone, then of `obstacles` that move as they do.

    Obstacles have nothing to do with each other. Meetings are kept among `agents`.
    """
    owners = np.array([piece.agent for piece in obstacles], dtype=np.int64)
    chosen = np.concatenate([agents, owners])
    count = len(agents)
    place: dict[int, list[int]] = {}
    for index, agent in enumerate(chosen.tolist()):
        place.setdefault(agent, []).append(index)
    moving = [problem.scene.agents[agent] for agent in agents]
    standing = [
        replace(
            problem.scene.agents[piece.agent],
            id=f"{problem.agent_ids[piece.agent]} {number}",
            path=tuple(map(tuple, piece.curve.tolist())),
            waypoints=(),
            visits=(),
            max_speed=None,
            max_acceleration=None,
            start_velocity=None,
        )
        for number, piece in enumerate(obstacles)
    ]
    rules = []
    for rule in problem.scene.pairs:
        left = tuple(index for one in rule.left for index in place.get(one, ()))
        right = tuple(index for one in rule.right for index in place.get(one, ()))
        if left and right:
            rules.append(replace(rule, left=left, right=right, meet=None))
    square = np.ix_(chosen, chosen)
    whole = problem.interactions
    collides, grouping = whole.collides[square].copy(), whole.grouping[square].copy()
    collides[count:, count:] = False
    grouping[count:, count:] = 0.0
    ends = [(piece.curve[0], piece.curve[-1]) for piece in obstacles]
    return replace(
        problem,
        scene=replace(problem.scene, agents=tuple(moving + standing), pairs=tuple(rules)),
        agent_ids=tuple(agent.id for agent in moving + standing),
        starts=np.vstack([problem.starts[agents], *(first[None, :2] for first, _ in ends)]),
        goals=np.vstack([problem.goals[agents], *(last[None, :2] for _, last in ends)]),
        start_times=np.append(problem.start_times[agents], [first[2] for first, _ in ends]),
        max_times=np.append(problem.max_times[agents], [last[2] for _, last in ends]),
        preferred_times=np.append(problem.preferred_times[agents], [last[2] for _, last in ends]),
        radii=problem.radii[chosen],
        masses=problem.masses[chosen],
        stays=np.append(problem.stays[agents], [piece.stays for piece in obstacles]).astype(bool),
        interactions=Interactions(
            collides, whole.distance[square], whole.collision_weight[square], grouping
        ),
        meetings=tuple(
            Meeting(place[one.first][0], place[one.second][0], one.meet)
            for one in problem.meetings
            if place.get(one.first, [count])[0] < count
            and place.get(one.second, [count])[0] < count
        ),
        heeds_walls=problem.heeds_walls[chosen],
        waypoints=tuple(
            problem.waypoints[agent] if index < count else np.empty((0, 2))
            for index, agent in enumerate(chosen.tolist())
        ),
        paths=tuple([problem.paths[agent] for agent in agents] + [one.curve for one in obstacles]),
    )
