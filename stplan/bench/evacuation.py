"""A room that empties through a door: our fastest plan beside a simulation of the same people.

The certificate's code says of both who touches whom: a simulation is as fast as it is because some do, or
as slow as it is because nobody dares to.
"""

from __future__ import annotations

import time
from dataclasses import replace
from importlib.util import find_spec

import numpy as np

from stplan.bench.comparison import OURS, Performance, measured
from stplan.bench.families_crowds import grid_room
from stplan.bench.rivals import jupedsim_model
from stplan.bench.rivals.task import Motion
from stplan.callbacks import Progress
from stplan.certify.pair_clearance import nearest_moments
from stplan.certify.wall_clearance import wall_distances
from stplan.errors import SeedingError
from stplan.planner import plan
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene
from stplan.world import FreeSpace, build_free_space

NAME = "room"
COUNT, SPEED = 60, 1.3
# How long may be simulated, s.
TIME_LIMIT = 120.0
# Discs that overlap by no more than rounding (m) do not touch.
ROUNDING = 1e-9


def fastest_room(count: int) -> Scene:
    """The full room of `count` agents, to be left as fast as can be."""
    scene = grid_room(count, 0)
    agents = tuple(replace(agent, max_speed=SPEED) for agent in scene.agents)
    return replace(
        scene,
        agents=agents,
        minimise="makespan",
        horizon_rule="auto",
        metric="auto",
        time_scale=1.0,
    )


def outcomes(count: int = COUNT, *, progress: Progress) -> list[Performance]:
    """Ours first, then JuPedSim where it is installed."""
    scene = fastest_room(count)
    free_space = build_free_space(scene)
    found = [our_outcome(scene, free_space, progress=progress)]
    if find_spec(jupedsim_model.PACKAGE) and free_space is not None:
        progress(f"{NAME}: {jupedsim_model.NAME}")
        began = time.perf_counter()
        motion = jupedsim_model.leave(scene, free_space, SPEED, TIME_LIMIT)
        seconds = time.perf_counter() - began
        note = touches(scene, free_space, motion)
        blank = Performance(NAME, jupedsim_model.NAME, count)
        found.append(measured(blank, scene, free_space, motion, seconds, note))
    return found


def our_outcome(scene: Scene, free_space: FreeSpace | None, *, progress: Progress) -> Performance:
    """The certified plan, and what no plan is below."""
    blank = Performance(NAME, OURS, len(scene.agents))
    began = time.perf_counter()
    try:
        found = plan(scene, progress=progress)
    except SeedingError:
        return replace(blank, note="no plan")
    seconds = time.perf_counter() - began
    gap = found.report.arrivals
    if found.trajectories is None or gap is None or not found.certificate.holds:
        return replace(blank, seconds=seconds, note="no certified plan")
    motion = Motion(list(found.trajectories.curves()), np.ones(blank.agents, dtype=bool))
    note = f"{touches(scene, free_space, motion)}; certified; no plan before {gap.least:.2f} s"
    return measured(blank, scene, free_space, motion, seconds, note)


def touches(scene: Scene, free_space: FreeSpace | None, motion: Motion) -> str:
    """Who touches whom, in words."""
    text = f"{touching_pairs(scene, motion)} pairs touch"
    if free_space is None:
        return text
    radii = np.array([agent.radius for agent in scene.agents])
    gaps = wall_distances(free_space, motion.curves).distance - radii
    return f"{text}, {int((gaps < -ROUNDING).sum())} agents touch a wall"


def touching_pairs(scene: Scene, motion: Motion) -> int:
    """How many pairs overlap at some instant, of agents who are there until the end of their curves."""
    count = len(motion.curves)
    lines = WorldLines.from_curves([agent.id for agent in scene.agents], motion.curves)
    leaves = np.array([curve[-1, 2] for curve in motion.curves])
    found = nearest_moments(lines, leaves, np.triu(np.ones((count, count), dtype=bool), 1))
    radii = np.array([agent.radius for agent in scene.agents])
    return int((found.distance < radii[found.pairs].sum(axis=1) - ROUNDING).sum())
