"""Runs written without planning: what is seen does not depend on how curves came about."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stplan.arrays import FloatArray
from stplan.files.json_file import json_bytes
from stplan.files.trajectories import write_files
from stplan.problem.world_lines import WorldLines
from stplan.scene import load_scene

HALL = """\
stplan: 1
name: hall
description: "two cross, one waits </script>"
map:
  rectangle: [-5.0, -3.0, 5.0, 3.0]
  obstacles: [{rectangle: [-1.0, 2.0, 1.0, 3.0]}]
horizon: 12.0
defaults: {radius: 0.3}
agents:
  - {id: ann, start: [-4.0, 0.0], goal: [4.0, 0.0], preferred_time: 7.0, weights: {arrival: 1.0}}
  - {id: ben, start: [0.0, -2.5], goal: [0.0, 1.5], waypoints: [[0.0, -1.0]], radius: 0.4}
  - {id: cat, start: [4.0, -2.0], goal: [-4.0, -2.5], start_time: 1.0, after_arrival: vanish}
"""
# What happens there while ben waits for ann, and later.
EVENTS = """\
events:
  - {at: 1.0, agent: cat, max_speed: 9, because: the <b> door closes}
  - {at: 6.0, agent: cat, max_speed: 0.5}
"""
# ann is in the middle of the map at 4 s; ben waits for her there, from 1.5 s to 5 s.
CURVES = [
    np.array([[-4.0, 0.0, 0.0], [4.0, 0.0, 8.0]]),
    np.array([[0.0, -2.5, 0.0], [0.0, -1.0, 1.5], [0.0, -0.9, 5.0], [0.0, 1.5, 7.0]]),
    np.array([[4.0, -2.0, 1.0], [-1.0, -2.4, 6.0], [-4.0, -2.5, 9.0]]),
]


def hall_run(folder: Path) -> Path:
    """The run of three agents in a hall, with its scene beside it and bent initial curves."""
    return write_run(folder, HALL, CURVES)


def many_run(folder: Path, count: int) -> Path:
    """Agents on parallel tracks in the open plane."""
    agents = [
        f"  - {{id: a{k}, start: [0, {k}], goal: [60, {k}], radius: 0.35}}" for k in range(count)
    ]
    text = "\n".join(["stplan: 1", "name: many", "horizon: 40", "agents:", *agents, ""])
    steps = np.linspace(0.0, 1.0, 5)
    curves = [
        np.column_stack([60 * steps, np.full(5, float(k)), (20 + k % 9) * steps])
        for k in range(count)
    ]
    return write_run(folder, text, curves)


def write_run(folder: Path, text: str, curves: list[FloatArray]) -> Path:
    """Write a scene and a run of it into `folder` and return the run's folder."""
    source = folder / "scene.yaml"
    source.parent.mkdir(parents=True, exist_ok=True)
    source.write_text(text)
    scene = load_scene(source)
    lines = WorldLines.from_curves([agent.id for agent in scene.agents], curves)
    bent = lines.knots + np.array([0.0, 0.05, 0.0])
    report = {
        "scene": {"name": scene.name, "source": str(source), "hash": scene.content_hash},
    }
    run = folder / scene.name
    files = {"trajectories": lines, "seed": lines.with_knots(bent)}
    write_files(run, scene, files, {"report.json": json_bytes(report)})
    return run
