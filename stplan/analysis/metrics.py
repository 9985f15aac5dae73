"""Figures that tell how good curves are, computed apart from the optimiser's costs."""

from __future__ import annotations

from typing import Any

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Agent, Scene


def kinetic_energy(agent: Agent, curve: FloatArray) -> float:
    """sum 1/2 m |dx|^2 / dt of a curve (n + 1, 3), in J s."""
    step = np.diff(curve, axis=0)
    return float((0.5 * agent.mass * (step[:, :2] ** 2).sum(axis=1) / step[:, 2]).sum())


def straight_bound(agent: Agent) -> float:
    """Least kinetic energy of an agent alone in the open plane: straight (by waypoints), in J s."""
    stops = np.array([agent.start, *agent.waypoints, agent.goal])
    length = float(np.hypot(*np.diff(stops, axis=0).T).sum())
    return 0.5 * agent.mass * length**2 / (agent.max_time - agent.start_time)


def turning(curve: FloatArray, time_scale: float) -> float:
    """sum 1/2 theta^2 of the turns of a curve in (x, y, c t), in square radians."""
    step = np.diff(curve * [1.0, 1.0, time_scale], axis=0)
    u, v = step[:-1], step[1:]
    sine = np.sqrt((np.cross(u, v) ** 2).sum(axis=1))
    return float(0.5 * (np.arctan2(sine, (u * v).sum(axis=1)) ** 2).sum())


def metrics(scene: Scene, lines: WorldLines) -> dict[str, Any]:
    """Figures of the whole plan and of every agent, for the report."""
    rows: list[dict[str, Any]] = []
    energy = bound = 0.0
    for agent, curve in zip(scene.agents, lines.curves(), strict=True):
        step = np.diff(curve, axis=0)
        lengths = np.hypot(step[:, 0], step[:, 1])
        own = kinetic_energy(agent, curve)
        if agent.path is None:
            energy += agent.weights.kinetic * own
            bound += agent.weights.kinetic * straight_bound(agent)
        rows.append(
            {
                "agent": agent.id,
                "arrival_time": float(curve[-1, 2]),
                "path_length": float(lengths.sum()),
                "greatest_speed": float((lengths / step[:, 2]).max()),
                "kinetic_energy": own,
                "turning": turning(curve, scene.time_scale),
            }
        )
    return {
        "kinetic_over_straight": energy / bound if bound > 0 else None,
        "turning": float(sum(row["turning"] for row in rows)),
        "latest_arrival": max(row["arrival_time"] for row in rows),
        "agents": rows,
    }
