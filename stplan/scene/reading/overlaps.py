"""Agents that touch where neither of them can give way. Lengths in m, times in s."""

from __future__ import annotations

import numpy as np

from stplan.amounts import distinct
from stplan.arrays import BoolArray, FloatArray
from stplan.scene.interactions import PairSettings
from stplan.scene.model import Scene
from stplan.schema.mapping import Fault

# Rows of the matrix of pairs that are looked at together, so that 10 000 agents fit into memory.
ROWS = 512


def overlap_faults(scene: Scene) -> list[Fault]:
    """One fault for every agent that overlaps an earlier one, with the first such as witness.

    Looked at are starts of one start time, unless they are eased apart, and goals on which both agents stay.
    """
    times = np.array([agent.start_time for agent in scene.agents])
    # Those whose goals are places get spots of their own.
    stays = np.array(
        [
            agent.after_arrival == "stay" and not agent.goal_places and agent.moving_goal is None
            for agent in scene.agents
        ]
    )
    starts = np.array([agent.start for agent in scene.agents])
    goals = np.array([agent.goal for agent in scene.agents])
    faults: list[Fault] = []
    settings = PairSettings(scene)
    everyone = np.arange(len(times))
    for first in range(0, len(times), ROWS):
        rows = everyone[first : first + ROWS]
        pairs = settings.between(rows, everyone)
        distance = np.where(pairs.collides, pairs.distance, -1.0)
        # Only pairs with an earlier agent, so that each pair is met once.
        earlier = everyone[None, :] < rows[:, None]
        together = earlier & (times[rows, None] == times[None, :])
        if scene.overlap == "refuse":
            faults += _close(scene, "start", starts, together, distance, first)
        together = earlier & stays[rows, None] & stays[None, :]
        faults += _close(scene, "goal", goals, together, distance, first)
    return faults


def _close(
    scene: Scene,
    key: str,
    points: FloatArray,
    together: BoolArray,
    distance: FloatArray,
    first: int,
) -> list[Fault]:
    here = points[first : first + distance.shape[0]]
    gap = np.hypot(here[:, None, 0] - points[None, :, 0], here[:, None, 1] - points[None, :, 1])
    close = together & (gap <= distance)
    faults = []
    for row in np.nonzero(close.any(axis=1))[0]:
        other = int(np.argmax(close[row]))
        more = int(close[row].sum()) - 1
        also = f" (and too near {more} more)" if more else ""
        apart, needed = distinct(float(gap[row, other]), float(distance[row, other]))
        what = "both start at once" if key == "start" else "both stay on their goals"
        faults.append(
            (
                f"{scene.agent_path(first + int(row))}.{key}",
                f"is {apart} m from the {key} of '{scene.agents[other].id}'{also}, "
                f"and {what}; more than {needed} m is expected "
                "of agents that collide",
            )
        )
    return faults
