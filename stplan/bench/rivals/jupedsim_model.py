"""JuPedSim's collision-free speed model: pedestrians who slow down rather than touch."""

from __future__ import annotations

import numpy as np
import shapely

from stplan.bench.rivals.task import Motion, Task

PACKAGE = "jupedsim"
NAME = "JuPedSim, collision-free speed"

STEP = 0.01
# Every so many steps a frame is kept; half the side (m) of the square that stands for a goal.
EVERY, GOAL_SIZE = 5, 0.1
# Headway (s) that a walker keeps; the model's default of 1 s is for crowds at rest.
TIME_GAP = 0.5
# In the open plane the model still needs a floor: so much (m) beyond starts and goals.
ROOM = 15.0


def drive(task: Task) -> Motion:
    """Simulate until everyone has left by its own exit, or `time_limit` seconds of the agents' time."""
    import jupedsim

    simulation = jupedsim.Simulation(
        model=jupedsim.CollisionFreeSpeedModel(), geometry=_floor(task), dt=STEP
    )
    numbers: dict[int, int] = {}
    for agent, (start, goal) in enumerate(zip(task.starts, task.goals, strict=True)):
        square = shapely.box(*(goal - GOAL_SIZE), *(goal + GOAL_SIZE))
        stage = simulation.add_exit_stage(square)
        journey = simulation.add_journey(jupedsim.JourneyDescription([stage]))
        numbers[
            simulation.add_agent(
                jupedsim.CollisionFreeSpeedModelAgentParameters(
                    position=tuple(start.tolist()),
                    journey_id=journey,
                    stage_id=stage,
                    radius=float(task.radii[agent]),
                    desired_speed=task.speed,
                    time_gap=TIME_GAP,
                )
            )
        ] = agent
    rows: list[list[list[float]]] = [[[*start, 0.0]] for start in task.starts.tolist()]
    while simulation.agent_count() and simulation.elapsed_time() < task.time_limit:
        simulation.iterate(EVERY)
        for walker in simulation.agents():
            rows[numbers[walker.id]].append([*walker.position, simulation.elapsed_time()])
    left = {numbers[walker.id] for walker in simulation.agents()}
    arrived = np.array([agent not in left for agent in range(len(rows))])
    return Motion([np.array(own) for own in rows], arrived)


def _floor(task: Task) -> shapely.Geometry:
    if task.free_space is not None:
        return task.free_space.polygon
    places = np.vstack([task.starts, task.goals])
    return shapely.box(*(places.min(axis=0) - ROOM), *(places.max(axis=0) + ROOM))
