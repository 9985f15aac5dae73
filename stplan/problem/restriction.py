"""A part of a problem: some agents, and the rods of others around them; or a problem with more around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.rods import FixedRods
from stplan.problem.surroundings import Surroundings
from stplan.scene.interactions import Interactions, Meeting


@dataclass(frozen=True)
class Piece:
    """A stretch of an agent's curve that others keep clear of.

    Attributes:
        agent: whose.
        curve: (n, 3), at least two knots.
        stays: whether the agent stands on its goal afterwards.
    """

    agent: int
    curve: FloatArray
    stays: bool


def restricted(problem: PlanningProblem, agents: IntArray) -> PlanningProblem:
    """`problem` of its `agents` alone, increasing, with the rules and meetings among them."""
    place = {agent: index for index, agent in enumerate(agents.tolist())}
    rules = []
    for rule in problem.scene.pairs:
        left, right = (
            tuple(place[one] for one in side if one in place) for side in (rule.left, rule.right)
        )
        if left and right:
            rules.append(replace(rule, left=left, right=right))
    square = np.ix_(agents, agents)
    whole, chosen = problem.interactions, agents.tolist()
    return replace(
        problem,
        scene=replace(
            problem.scene,
            agents=tuple(problem.scene.agents[agent] for agent in chosen),
            pairs=tuple(rules),
            # Whoever stays is there as long as in the whole.
            horizon=problem.final_time,
        ),
        agent_ids=tuple(problem.agent_ids[agent] for agent in chosen),
        starts=problem.starts[agents],
        goals=problem.goals[agents],
        start_times=problem.start_times[agents],
        max_times=problem.max_times[agents],
        preferred_times=problem.preferred_times[agents],
        radii=problem.radii[agents],
        masses=problem.masses[agents],
        stays=problem.stays[agents],
        interactions=Interactions(
            whole.collides[square],
            whole.distance[square],
            whole.collision_weight[square],
            whole.grouping[square],
        ),
        meetings=tuple(
            Meeting(place[one.first], place[one.second], one.meet)
            for one in problem.meetings
            if one.first in place and one.second in place
        ),
        heeds_walls=problem.heeds_walls[agents],
        waypoints=tuple(problem.waypoints[agent] for agent in chosen),
        paths=tuple(problem.paths[agent] for agent in chosen),
    )


def with_obstacles(problem: PlanningProblem, obstacles: Sequence[Piece]) -> PlanningProblem:
    """`problem`, and behind its agents `obstacles` that move as they do.

    Obstacles have nothing to do with each other.
    """
    count = problem.num_agents
    chosen = np.append(
        np.arange(count), np.array([piece.agent for piece in obstacles], dtype=np.int64)
    )
    place: dict[int, list[int]] = {}
    for index, agent in enumerate(chosen.tolist()):
        place.setdefault(agent, []).append(index)
    standing = tuple(
        replace(
            problem.scene.agents[piece.agent],
            id=f"{problem.agent_ids[piece.agent]} {number}",
            path=tuple(map(tuple, piece.curve.tolist())),
            waypoints=(),
            visits=(),
            max_speed=None,
            max_acceleration=None,
            start_velocity=None,
            start_duration=0.0,
        )
        for number, piece in enumerate(obstacles)
    )
    rules = tuple(
        replace(
            rule,
            left=tuple(index for one in rule.left for index in place[one]),
            right=tuple(index for one in rule.right for index in place[one]),
            meet=None,
        )
        for rule in problem.scene.pairs
    )
    square = np.ix_(chosen, chosen)
    whole = problem.interactions
    collides, grouping = whole.collides[square], whole.grouping[square]
    collides[count:, count:] = False
    grouping[count:, count:] = 0.0
    first = np.array([piece.curve[0] for piece in obstacles]).reshape(-1, 3)
    last = np.array([piece.curve[-1] for piece in obstacles]).reshape(-1, 3)
    stays = np.array([piece.stays for piece in obstacles], dtype=bool)
    return replace(
        problem,
        scene=replace(problem.scene, agents=problem.scene.agents + standing, pairs=rules),
        agent_ids=problem.agent_ids + tuple(agent.id for agent in standing),
        starts=np.vstack([problem.starts, first[:, :2]]),
        goals=np.vstack([problem.goals, last[:, :2]]),
        start_times=np.append(problem.start_times, first[:, 2]),
        max_times=np.append(problem.max_times, last[:, 2]),
        preferred_times=np.append(problem.preferred_times, last[:, 2]),
        radii=problem.radii[chosen],
        masses=problem.masses[chosen],
        stays=np.append(problem.stays, stays),
        interactions=Interactions(
            collides, whole.distance[square], whole.collision_weight[square], grouping
        ),
        heeds_walls=problem.heeds_walls[chosen],
        waypoints=problem.waypoints + (np.empty((0, 2)),) * len(obstacles),
        paths=problem.paths + tuple(piece.curve for piece in obstacles),
    )


def surroundings(
    problem: PlanningProblem,
    agents: IntArray,
    pieces: Sequence[Piece],
    num_segments: IntArray,
    wish: FloatArray | None,
) -> Surroundings:
    """What is around `agents` of `problem`: stretches of others' curves.

    Args:
        pieces: by agent, in the order of time; only the last one of an agent stays.
        num_segments: (A,) of the whole curves of all agents of `problem`.
        wish: (A, A) clearances that pairs of `problem` wish for, None without any.
    """
    owners = np.array(sorted({piece.agent for piece in pieces}), dtype=np.int64)
    everyone = np.concatenate([agents, owners])
    square, count = np.ix_(everyone, everyone), len(agents)
    whole = problem.interactions
    collides, grouping = whole.collides[square], whole.grouping[square]
    fixed = np.append(problem.prescribed[agents], np.ones(len(owners), dtype=bool))
    alone = fixed[:, None] & fixed[None, :]
    alone[:count, :count] = False
    for array in (collides, grouping):
        array[alone] = 0
    weights = [problem.scene.agents[owner].weights.clearance for owner in owners.tolist()]
    return Surroundings(
        rods=_fixed_rods(problem, owners, pieces, num_segments[owners]),
        interactions=Interactions(
            collides, whole.distance[square], whole.collision_weight[square], grouping
        ),
        wish=None if wish is None else wish[square],
        clearance_weights=np.array(weights, dtype=np.float64),
    )


def _fixed_rods(
    problem: PlanningProblem, owners: IntArray, pieces: Sequence[Piece], num_segments: IntArray
) -> FixedRods:
    scale = problem.time_scale
    counts = np.array([len(piece.curve) for piece in pieces], dtype=np.int64)
    number = np.searchsorted(owners, [piece.agent for piece in pieces]).astype(np.int64)
    past = np.cumsum(counts)
    within = np.arange(counts.sum()) + 1
    first = np.setdiff1d(within, past) - 1
    staying = np.array([piece.stays for piece in pieces], dtype=bool)
    own = [piece.curve * [1.0, 1.0, scale] for piece in pieces]
    ends = np.array([piece.curve[-1] for piece in pieces]).reshape(-1, 3)[staying]
    ends[:, 2] = scale * problem.final_time
    tails = np.column_stack([past[staying] - 1, counts.sum() + np.arange(staying.sum())])
    return FixedRods(
        points=np.vstack([*own, ends]),
        segments=np.column_stack([first, first + 1]),
        agents=np.repeat(number, counts - 1),
        tails=tails.astype(np.int64),
        tail_agents=number[staying],
        num_segments=num_segments,
    )
