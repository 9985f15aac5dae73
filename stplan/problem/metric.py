"""The space-time metric where a scene leaves it to the program: `time_scale: auto`.

Rods further apart than R in (x, y, c t) keep discs apart, but a follower at speed v keeps
R sqrt(1 + v^2 / c^2): what the metric costs falls with (v / c)^2, and is next to nothing from c = 5 v on. A
larger c costs time, because rods get longer, and relaxation parts nearly vertical rods slowly. So c is chosen
twice: from the speeds that agents need if nobody is in their way, for seeding, and from those of the seed,
which hurries and waits, for what follows. Curves that are clear stay clear when c grows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stplan.problem.clearance import near_pairs
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.shortest_ways import shortest_lengths
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene

# c over the median speed that agents need, where nobody has to go around walls, and elsewhere: there
# agents hurry and wait, some five times as fast as they would have to.
OPEN_SHARE, WALLED_SHARE = 4.0, 16.0
# c over the median speed that agents need where some are friends, who are drawn together in space-time: what
# that costs depends on the metric, so it is that of the speeds themselves.
FRIENDS_SHARE = 1.0
# c over the median top speed, where arrivals are to be early: a follower keeps a thirtieth more than R.
HASTE_SHARE = 4.0
# c over the speed that most segments of a seed stay below.
SEED_SHARE, SEGMENTS_BELOW = 3.0, 0.95
# c for the seed's sake is at most so many times what it was.
MOST_GROWTH = 4.0
# Ways longer than straight by this share go around walls.
BENT = 1e-3
# What cannot be moved (starts, prescribed motion) is to be so many times R apart, if a larger c helps: c
# grows by this factor at most so often.
APART, GROWTH, MOST_STEPS = 1.05, 1.5, 16


def with_metric(problem: PlanningProblem) -> PlanningProblem:
    """The problem with the metric for seeding, where its scene leaves that open."""
    if problem.scene.metric != "auto":
        return problem
    if problem.interactions.grouping.any():
        return _fixed_apart(_at(problem, _needed(problem, FRIENDS_SHARE, FRIENDS_SHARE)))
    if problem.scene.minimise != "energy":
        return _fixed_apart(_at(problem, HASTE_SHARE * _top_speed(problem)))
    return _fixed_apart(_at(problem, _needed(problem, OPEN_SHARE, WALLED_SHARE)))


def sharpened(problem: PlanningProblem, lines: WorldLines) -> PlanningProblem:
    """The problem with the metric for optimising clear `lines`; as it is where a scene states its own."""
    if problem.scene.metric == "stated" or problem.interactions.grouping.any():
        return problem
    if problem.scene.minimise != "energy":
        # What is planned is as fast as may be, whatever its seed is.
        return problem
    steps = [
        np.diff(curve, axis=0)
        for curve, path in zip(lines.curves(), problem.paths, strict=True)
        if path is None
    ]
    if not steps:
        return problem
    step = np.vstack(steps)
    speeds = np.hypot(step[:, 0], step[:, 1]) / step[:, 2]
    wanted = SEED_SHARE * float(np.quantile(speeds, SEGMENTS_BELOW))
    now = problem.time_scale
    return _at(problem, min(max(wanted, now), MOST_GROWTH * now))


def _needed(problem: PlanningProblem, open_share: float, walled_share: float) -> float:
    """c over the speeds that agents need, straight on or around walls; as it is where nobody moves."""
    lengths = np.array([legs.sum() for legs in shortest_lengths(problem)])
    straight = np.array([np.hypot(*np.diff(stops, axis=0).T).sum() for stops in problem.stops])
    moving = ~problem.prescribed & (lengths > 0.0)
    if not moving.any():
        return problem.time_scale
    available = problem.preferred_times - problem.start_times
    speed = float(np.median(lengths[moving] / available[moving]))
    bent = bool((lengths > (1.0 + BENT) * straight)[moving].any())
    return (walled_share if bent else open_share) * speed


def _top_speed(problem: PlanningProblem) -> float:
    """The median of the agents' top speeds; c as it is where nobody has one."""
    limits = [agent.max_speed for agent in problem.scene.agents if agent.max_speed is not None]
    return float(np.median(limits)) if limits else problem.time_scale


def _fixed_apart(problem: PlanningProblem) -> PlanningProblem:
    """The problem with the least metric, from its own on, that keeps starts and given paths apart."""
    best, fewest = problem, _touching(problem)
    for _ in range(MOST_STEPS):
        if not fewest:
            break
        problem = _at(problem, GROWTH * problem.time_scale)
        touching = _touching(problem)
        if touching < fewest:
            best, fewest = problem, touching
    return best


def _touching(problem: PlanningProblem) -> int:
    """Pairs of starts and prescribed motions that are not far enough apart."""
    pieces = []
    for agent, path in enumerate(problem.paths):
        start = [*problem.starts[agent], problem.time_scale * problem.start_times[agent]]
        pieces.append([np.array([start, start]) if path is None else problem.rod(agent, path)])
    pairs, gaps = near_pairs(problem, pieces, problem.distance, APART)
    return int((gaps <= APART * problem.distance[pairs[:, 0], pairs[:, 1]]).sum())


def _at(problem: PlanningProblem, time_scale: float) -> PlanningProblem:
    """The problem with c, in its frame, at `time_scale`; turns are measured as they were."""
    written = problem.written
    outside = time_scale * written.frame.speed
    return replace(
        problem,
        scene=_scene_at(problem.scene, time_scale),
        written=replace(written, scene=_scene_at(written.scene, outside)),
    )


def _scene_at(scene: Scene, time_scale: float) -> Scene:
    turning = scene.turning_scale
    return replace(scene, time_scale=time_scale, metric="chosen", turning=turning)
