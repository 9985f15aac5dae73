"""Families of scenes that grow with the number of agents."""

from __future__ import annotations

from stplan.bench.families_open import (
    agent,
    circle,
    crossing_flows,
    crowd,
    energy,
    lanes,
    open_field,
    scattered,
    scene,
    straight_energy,
)

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
