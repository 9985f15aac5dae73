"""Families of scenes that grow with the number of agents."""

from __future__ import annotations

from collections.abc import Sequence

from stplan.arrays import FloatArray
from stplan.bench.families_open import (
    agent,
    circle,
    crossing_flows,
    crowd,
    lanes,
    open_field,
    scattered,
    scene,
)
from stplan.bench.families_open import straight_kinetic_cost as straight_energy
from stplan.problem.kinetic_cost import total_kinetic_cost
from stplan.scene.model import Scene

__all__ = [
    "agent",
    "circle",
    "crossing_flows",
    "crowd",
    "energy",
    "lanes",
    "open_field",
    "scattered",
    "scene",
    "straight_energy",
]


def energy(scene: Scene, curves: Sequence[FloatArray]) -> float:
    """Kinetic cost of `curves`, J s."""
    return total_kinetic_cost([agent.mass for agent in scene.agents], curves)
