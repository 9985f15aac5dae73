"""Agents that touch where neither of them can give way. Lengths in m, times in s."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stplan.arrays import BoolArray, FloatArray
from stplan.scene.model import Scene
from stplan.scene.reading.faults import Fault

# Rows of the matrix of pairs that are looked at together, so that 10 000 agents fit into memory.
ROWS = 512


def overlap_faults(scene: Scene) -> list[Fault]:
    """One fault for every agent that overlaps an earlier one, with the first such as witness.

    Looked at are starts of one start time, and goals on which both agents stay.
    """
    times = np.array([agent.start_time for agent in scene.agents])
    stays = np.array([agent.after_arrival == "stay" for agent in scene.agents])
    starts = np.array([agent.start for agent in scene.agents])
    goals = np.array([agent.goal for agent in scene.agents])
    faults: list[Fault] = []
    for first, distance in _pair_distances(scene):
        rows = slice(first, first + distance.shape[0])
        # Only pairs with an earlier agent, so that each pair is met once.
        earlier = np.arange(len(times))[None, :] < np.arange(first, rows.stop)[:, None]
        together = earlier & (times[rows, None] == times[None, :])
        faults += _close(scene, "start", starts, together, distance, first)
        together = earlier & stays[rows, None] & stays[None, :]
        faults += _close(scene, "goal", goals, together, distance, first)
    return faults


def _pair_distances(scene: Scene) -> Iterator[tuple[int, FloatArray]]:
    """(first row, block of rows) of the (A, A) comfort distances; -1 where a pair is off."""
    radii = np.array([agent.radius for agent in scene.agents])
    weights = np.array([agent.weights.collision for agent in scene.agents])
    rules = [
        (np.array(rows), np.array(columns), rule.distance, rule.collide)
        for rule in scene.pairs
        if rule.distance is not None or rule.collide is not None
        for rows, columns in ((rule.left, rule.right), (rule.right, rule.left))
    ]
    for first in range(0, len(radii), ROWS):
        rows = slice(first, min(first + ROWS, len(radii)))
        distance = radii[rows, None] + radii[None, :]
        on = (weights[rows, None] > 0) | (weights[None, :] > 0)
        collide = np.ones_like(on)
        for left, right, rule_distance, rule_collide in rules:
            here = left[(left >= rows.start) & (left < rows.stop)] - first
            where = np.ix_(here, right)
            if rule_distance is not None:
                distance[where] = rule_distance
            if rule_collide is not None:
                collide[where] = rule_collide
        distance[~(on & collide)] = -1.0
        yield first, distance


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
        what = "both start at once" if key == "start" else "both stay on their goals"
        faults.append(
            (
                f"{scene.agent_path(first + int(row))}.{key}",
                f"is {gap[row, other]:.4g} m from the {key} of '{scene.agents[other].id}'{also}, "
                f"and {what}; more than {distance[row, other]:.4g} m is expected "
                "of agents that collide",
            )
        )
    return faults
