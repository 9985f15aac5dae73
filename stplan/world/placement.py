"""Whether a scene fits its map: every fixed point inside, with room for the radius."""

from __future__ import annotations

import numpy as np
import shapely

from stplan.scene.model import Agent, Scene
from stplan.world.erosion import eroded
from stplan.world.free_space import FreeSpace

# Erosions are computed with this share less than the radius, so that "not connected" is never claimed
# because of the rounding of offset curves.
EROSION_SAFETY = 1e-3


def fixed_points(agent: Agent) -> list[tuple[str, tuple[float, float]]]:
    """Key and place of every point an agent must be at: start, goal, waypoints, a given path."""
    if agent.path is not None:
        return [(f"path[{k}]", (x, y)) for k, (x, y, _) in enumerate(agent.path)]
    points = [("start", agent.start), ("goal", agent.goal)]
    return points + [(f"waypoints[{k}]", point) for k, point in enumerate(agent.waypoints)]


def check_scene_in_world(scene: Scene, free_space: FreeSpace | None) -> list[str]:
    """One located message for every fixed point outside the free space or too near its walls."""
    if free_space is None:
        return []
    entries = [
        (a, key, point)
        for a, agent in enumerate(scene.agents)
        if agent.weights.wall > 0
        for key, point in fixed_points(agent)
    ]
    if not entries:
        return []
    room = free_space.clearance(np.array([point for _, _, point in entries]))
    messages = []
    for (a, key, point), clearance in zip(entries, room.tolist(), strict=True):
        radius = scene.agents[a].radius
        if clearance > radius:
            continue
        where = f"({point[0]:g}, {point[1]:g})"
        fault = (
            f"{where} lies outside the free space of the map, by {-clearance:.4g} m"
            if clearance <= 0
            else f"{where} is {clearance:.4g} m from a wall, but the radius is {radius:g} m"
        )
        messages.append(
            scene.located(
                f"{scene.agent_path(a)}.{key}", f"{fault}; more than the radius is expected"
            )
        )
    return messages


def disconnected_agents(scene: Scene, free_space: FreeSpace | None) -> list[tuple[int, str]]:
    """Agents that cannot reach their goal at their radius, each with a sentence that says why.

    Only certain cases: the free space is eroded by slightly less than the radius.
    """
    if free_space is None:
        return []
    eroded: dict[float, shapely.STRtree] = {}
    found = []
    for a, agent in enumerate(scene.agents):
        if agent.weights.wall == 0 or agent.path is not None:
            continue
        stops = np.array([agent.start, *agent.waypoints, agent.goal])
        if agent.radius not in eroded:
            eroded[agent.radius] = _parts(free_space, agent.radius)
        if _connected(eroded[agent.radius], stops):
            continue
        found.append((a, _why(free_space, agent, stops)))
    return found


def _parts(free_space: FreeSpace, radius: float) -> shapely.STRtree:
    shrunk = eroded(free_space.polygon, radius * (1 - EROSION_SAFETY), quad_segs=32)
    return shapely.STRtree(shapely.get_parts(shrunk))


def _connected(parts: shapely.STRtree, stops: np.ndarray) -> bool:
    reach = parts.query(shapely.points(stops), predicate="intersects")
    first = set(reach[1][reach[0] == 0].tolist())
    return all(bool(first & set(reach[1][reach[0] == k].tolist())) for k in range(1, len(stops)))


def _why(free_space: FreeSpace, agent: Agent, stops: np.ndarray) -> str:
    """The widest radius that gets through, by bisection."""
    low, high = 0.0, agent.radius
    if not _connected(shapely.STRtree(shapely.get_parts(free_space.polygon)), stops):
        return f"{agent.id}: its start and goal lie in separate parts of the map"
    for _ in range(20):
        middle = (low + high) / 2
        if _connected(_parts(free_space, middle), stops):
            low = middle
        else:
            high = middle
    return (
        f"{agent.id}: no way from start to goal at its radius; the widest lets a radius of "
        f"{low:.3g} m through, the agent's is {agent.radius:g} m"
    )
