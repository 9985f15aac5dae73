"""Small scenes and world lines, built in memory."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Agent, Scene, SeedingSettings, SolverSettings, Weights


def scene_of(
    agent_ids: Sequence[str], name: str = "tiny", source: Path | None = None, horizon: float = 5.0
) -> Scene:
    agents = tuple(
        Agent(
            id=agent_id,
            start=(0.0, float(number)),
            goal=(4.0, float(number)),
            start_time=0.0,
            max_time=horizon,
            preferred_time=None,
            radius=0.25 + 0.125 * number,
            mass=70.0 + number,
            after_arrival="stay",
            waypoints=(),
            weights=Weights(),
        )
        for number, agent_id in enumerate(agent_ids)
    )
    return Scene(
        name=name,
        description="",
        source=source,
        content_hash="0123",
        map=None,
        horizon=horizon,
        time_scale=1.5,
        agents=agents,
        pairs=(),
        seeding=SeedingSettings(),
        solver=SolverSettings(),
    )


def straight_lines(scene: Scene, num_knots: int = 3) -> WorldLines:
    curves = [
        np.linspace([*agent.start, agent.start_time], [*agent.goal, agent.max_time], num_knots)
        for agent in scene.agents
    ]
    return WorldLines.from_curves([agent.id for agent in scene.agents], curves)


def random_lines(agent_ids: Sequence[str], rng: np.random.Generator) -> WorldLines:
    """Wild but strictly increasing in time, with numbers of many magnitudes."""
    curves = []
    for _ in agent_ids:
        count = int(rng.integers(2, 7))
        curve = rng.normal(size=(count, 3)) * 10.0 ** rng.integers(-12, 9, size=(count, 3))
        curve[:, 2] = np.cumsum(rng.uniform(0.01, 1.0, size=count))
        curves.append(curve)
    return WorldLines.from_curves(agent_ids, curves)
