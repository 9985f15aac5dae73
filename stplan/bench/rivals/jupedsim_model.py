"""JuPedSim's collision-free speed model: pedestrians who slow down rather than touch.

What is judged is the trajectory file that it writes, read as `stplan check` reads such files.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import shapely

from stplan.bench.rivals.task import Motion, Task
from stplan.files.trajectories import read_trajectories
from stplan.scene.model import Scene
from stplan.world import FreeSpace

PACKAGE = "jupedsim"
NAME = "JuPedSim, collision-free speed"

STEP = 0.01
# Every so many steps a frame is kept; half the side (m) of the square that stands for a goal.
EVERY, GOAL_SIZE = 5, 0.1
# How far (m) a line on which all vanish reaches to either side.
EXIT_DEPTH = 0.1
# Headway (s) that a walker keeps; the model's default of 1 s is for crowds at rest.
TIME_GAP = 0.5
# In the open plane the model still needs a floor: so much (m) beyond starts and goals.
ROOM = 15.0


def drive(task: Task) -> Motion:
    """Simulate until everyone has left by its own exit, or `time_limit` seconds of the agents' time."""
    squares = [shapely.box(*(goal - GOAL_SIZE), *(goal + GOAL_SIZE)) for goal in task.goals]
    speeds = [task.pace(agent) for agent in range(len(squares))]
    return _simulated(task.scene, _floor(task), squares, speeds, task.time_limit)


def leave(scene: Scene, free_space: FreeSpace, speed: float, time_limit: float) -> Motion:
    """The same where all of `scene` leave by one line, the place in which they vanish."""
    (place,) = scene.agents[0].goal_places
    behind = place.shape().buffer(EXIT_DEPTH, cap_style="flat").intersection(free_space.polygon)
    exits = [shapely.convex_hull(behind)] * len(scene.agents)
    return _simulated(scene, free_space.polygon, exits, [speed] * len(exits), time_limit)


def _simulated(
    scene: Scene,
    floor: shapely.Geometry,
    exits: Sequence[shapely.Geometry],
    speeds: Sequence[float],
    time_limit: float,
) -> Motion:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "walkers.sqlite"
        walkers, left = _written(file, scene, floor, exits, speeds, time_limit)
        lines = read_trajectories(file)
    curves = dict(zip(map(int, lines.agent_ids), lines.curves(), strict=True))
    arrived = np.array([walker not in left for walker in walkers])
    return Motion([curves[walker] for walker in walkers], arrived)


def _written(
    file: Path,
    scene: Scene,
    floor: shapely.Geometry,
    exits: Sequence[shapely.Geometry],
    speeds: Sequence[float],
    time_limit: float,
) -> tuple[list[int], set[int]]:
    """Simulate into a trajectory file; the numbers of all walkers, and of those who have not left in time."""
    import jupedsim

    writer = jupedsim.SqliteTrajectoryWriter(output_file=file, every_nth_frame=EVERY)
    simulation = jupedsim.Simulation(
        model=jupedsim.CollisionFreeSpeedModel(), geometry=floor, dt=STEP, trajectory_writer=writer
    )
    walkers: list[int] = []
    journeys: dict[bytes, tuple[int, int]] = {}
    for agent, (one, area) in enumerate(zip(scene.agents, exits, strict=True)):
        if area.wkb not in journeys:
            stage = simulation.add_exit_stage(area)
            journeys[area.wkb] = (
                stage,
                simulation.add_journey(jupedsim.JourneyDescription([stage])),
            )
        stage, journey = journeys[area.wkb]
        walkers.append(
            simulation.add_agent(
                jupedsim.CollisionFreeSpeedModelAgentParameters(
                    position=one.start,
                    journey_id=journey,
                    stage_id=stage,
                    radius=one.radius,
                    desired_speed=speeds[agent],
                    time_gap=TIME_GAP,
                )
            )
        )
    while simulation.agent_count() and simulation.elapsed_time() < time_limit:
        simulation.iterate(EVERY)
    left = {walker.id for walker in simulation.agents()}
    writer.close()
    return walkers, left


def _floor(task: Task) -> shapely.Geometry:
    if task.free_space is not None:
        return task.free_space.polygon
    places = np.vstack([task.starts, task.goals])
    return shapely.box(*(places.min(axis=0) - ROOM), *(places.max(axis=0) + ROOM))
