"""RVO2: reciprocal velocity obstacles, one small step at a time, along each agent's shortest way."""

from __future__ import annotations

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.bench.rivals.task import Motion, Task, next_stop

PACKAGE = "pyrvo"
NAME = "RVO2"

STEP = 0.05
NEIGHBOURS, NEIGHBOUR_DISTANCE = 10, 15.0
LOOK_AHEAD, LOOK_AHEAD_WALLS = 5.0, 1.0
# Distance (m) at which a corner counts as turned and a goal as reached.
NEAR_CORNER, NEAR_GOAL = 0.3, 0.05
# The library's own examples shake velocities (m/s) so that symmetry does not lock everyone.
SHAKE = 1e-4


def drive(task: Task) -> Motion:
    """Simulate until everyone stands on its goal, or `time_limit` seconds of the agents' time."""
    import pyrvo

    simulator = pyrvo.RVOSimulator(
        STEP, NEIGHBOUR_DISTANCE, NEIGHBOURS, LOOK_AHEAD, LOOK_AHEAD_WALLS, 0.5, task.speed
    )
    for agent, start in enumerate(task.starts):
        number = simulator.add_agent(tuple(start.tolist()))
        simulator.set_agent_radius(number, float(task.radii[agent]))
    for ring in _walls(task):
        simulator.add_obstacle([tuple(corner) for corner in ring.tolist()])
    simulator.process_obstacles()
    rng = np.random.default_rng(0)
    heading = [1] * len(task.ways)
    frames = [task.starts]
    arrival = np.full(len(task.ways), np.inf)
    while np.isinf(arrival).any() and len(frames) * STEP < task.time_limit:
        places = frames[-1]
        for agent, way in enumerate(task.ways):
            heading[agent] = next_stop(way, heading[agent], places[agent], NEAR_CORNER)
            wish = _wish(way[heading[agent]] - places[agent], task.pace(agent))
            wish += rng.uniform(-SHAKE, SHAKE, 2)
            simulator.set_agent_pref_velocity(agent, tuple(wish.tolist()))
        simulator.do_step()
        found = (simulator.get_agent_position(agent) for agent in range(len(task.ways)))
        frames.append(np.array([[place.x, place.y] for place in found]))
        there = np.hypot(*(frames[-1] - task.goals).T) < NEAR_GOAL
        arrival[there & np.isinf(arrival)] = (len(frames) - 1) * STEP
    return Motion(_curves(np.array(frames), arrival), np.isfinite(arrival))


def _wish(way: FloatArray, speed: float) -> FloatArray:
    """Velocity towards the next stop, no further than it within a step."""
    distance = float(np.hypot(*way))
    return way * (min(speed, distance / STEP) / max(distance, 1e-12))


def _walls(task: Task) -> list[FloatArray]:
    """Rings of the boundary with the solid on their left, as the library wants them."""
    if task.free_space is None:
        return []
    rings = []
    for part in shapely.get_parts(task.free_space.polygon):
        oriented = shapely.orient_polygons(part, exterior_cw=True)
        rings += [np.asarray(ring.coords)[:-1] for ring in (oriented.exterior, *oriented.interiors)]
    return rings


def _curves(frames: FloatArray, arrival: FloatArray) -> list[FloatArray]:
    """One (n, 3) curve an agent, up to its arrival."""
    times = STEP * np.arange(len(frames))
    return [
        np.column_stack([frames[:, agent], times])[times <= arrival[agent] + STEP / 2]
        for agent in range(frames.shape[1])
    ]
