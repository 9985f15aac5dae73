"""Whether a scene fits its map: every fixed point inside, with room for the radius."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import shapely

from stplan.amounts import amount, distinct, place
from stplan.arrays import FloatArray
from stplan.deadline import heed
from stplan.errors import SceneError
from stplan.scene.model import Agent, Scene
from stplan.scene.places import Place
from stplan.world.erosion import eroded
from stplan.world.free_space import FreeSpace, build_free_space, warnings_of
from stplan.world.packing import overfull_places

if TYPE_CHECKING:
    from stplan.world.places import StandingRoom

# Erosions are computed with this share less than the radius, so that "not connected" is never claimed
# because of the rounding of offset curves.
EROSION_SAFETY = 1e-3
# Gaps of a mesh up to this share of the radius pass for cracks.
CRACK_SHARE = 0.1


def fixed_points(agent: Agent) -> list[tuple[str, tuple[float, float]]]:
    """Key and place of every point an agent must be at: start, goal, waypoints, a given path.

    A goal that is a place is none.
    """
    if agent.path is not None:
        return [(f"path[{k}]", (x, y)) for k, (x, y, _) in enumerate(agent.path)]
    points = [("start", agent.start)]
    if not agent.goal_places:
        points.append(("goal", agent.goal))
    return points + [(f"waypoints[{k}]", point) for k, point in enumerate(agent.waypoints)]


def fitted_free_space(scene: Scene) -> FreeSpace | None:
    """The free space of `scene`, into which its agents fit; None in the open plane.

    Raises:
        SceneError: the map is faulty, or some agents stand outside it or too near its walls.
    """
    free_space = build_free_space(scene)
    faults = check_scene_in_world(scene, free_space)
    if faults:
        # Perhaps that is why.
        raise SceneError([*faults, *warnings_of(scene, free_space)])
    return free_space


def check_scene_in_world(scene: Scene, free_space: FreeSpace | None) -> list[str]:
    """One located message for everything that does not fit.

    Fixed points outside the free space or too near its walls, places that nobody can be in, or not so many.
    """
    faults = [] if free_space is None else _misplaced_points(scene, free_space)
    if any(agent.goal_places for agent in scene.agents):
        from stplan.world.places import StandingRoom

        room = StandingRoom(free_space)
        unreachable = _unreachable_places(scene, room)
        faults += unreachable or overfull_places(scene, room)
    return faults


def _misplaced_points(scene: Scene, free_space: FreeSpace) -> list[str]:
    entries = [
        (a, key, point)
        for a, agent in enumerate(scene.agents)
        if agent.weights.wall > 0
        for key, point in fixed_points(agent)
    ]
    paths = [f"{scene.agent_path(a)}.{key}" for a, key, _ in entries]
    for task in scene.tasks:
        # A shared task is for whoever is free, so also for the largest.
        able = [
            a
            for a, agent in enumerate(scene.agents)
            if task.agent in (None, agent.id) and agent.weights.wall > 0
        ]
        if able:
            entries.append((max(able, key=lambda a: scene.agents[a].radius), "", task.at))
            paths.append(task.path)
    if not entries:
        return []
    clearances = free_space.clearance(np.array([point for _, _, point in entries]))
    messages: dict[str, None] = {}
    for (a, _, point), path, clearance in zip(entries, paths, clearances.tolist(), strict=True):
        radius = scene.agents[a].radius
        if clearance > radius:
            continue
        where = place(*point)
        room, needed = distinct(clearance, radius)
        fault = (
            f"{where} lies outside the free space of the map, by {amount(-clearance)} m"
            if clearance < 0
            else f"{where} is {room} m from a wall, but the radius is {needed} m"
        )
        text = scene.located(path, f"{fault}; more than the radius is expected")
        messages.setdefault(text)
    return list(messages)


def _unreachable_places(scene: Scene, room: StandingRoom) -> list[str]:
    """One located message for every goal that is a place in which an agent can be nowhere."""
    empty: dict[tuple[Place, float], bool] = {}
    messages: dict[str, None] = {}
    for a, agent in enumerate(scene.agents):
        radius = agent.radius if agent.weights.wall > 0 else 0.0
        for part in agent.goal_places:
            if (part, radius) not in empty:
                empty[part, radius] = room.within(part, radius).is_empty
        if agent.goal_places and all(empty[part, radius] for part in agent.goal_places):
            which = " and ".join(dict.fromkeys(str(part) for part in agent.goal_places))
            verb = "has" if len(agent.goal_places) == 1 else "have"
            text = f"{which} {verb} no point that a disc of {amount(radius)} m can reach"
            path = f"{scene.entry_path(a)}.goal"
            messages.setdefault(scene.located(path, text))
    return list(messages)


def cut_off_agents(
    free_space: FreeSpace | None, stops: Sequence[FloatArray], radii: FloatArray
) -> list[int]:
    """Agents whose stops (n, 2) are certainly not connected at their radius (A,), m.

    Agents without stops are left out. The free space is eroded by slightly less than the radius.
    """
    if free_space is None:
        return []
    shrunk: dict[float, shapely.STRtree] = {}
    found = []
    for agent, (points, radius) in enumerate(zip(stops, radii.tolist(), strict=True)):
        if len(points) == 0:
            continue
        if radius not in shrunk:
            heed()
            shrunk[radius] = _parts(free_space, radius)
        if not _connected(shrunk[radius], points):
            found.append(agent)
    return found


def widest_passage(free_space: FreeSpace, stops: FloatArray, radius: float) -> float:
    """The widest radius below `radius` (m) that connects all `stops` (n, 2), by bisection.

    0 where they lie in separate parts of the map.
    """
    low, high = 0.0, radius
    if not _connected(shapely.STRtree(shapely.get_parts(free_space.polygon)), stops):
        return 0.0
    for _ in range(20):
        heed()
        middle = (low + high) / 2
        if _connected(_parts(free_space, middle), stops):
            low = middle
        else:
            high = middle
    return low


def widest_crack(free_space: FreeSpace, stops: FloatArray, radius: float) -> float:
    """How wide the cracks of a mesh are that alone keep `stops` (n, 2) apart at `radius` (m); m.

    0 where the map is no mesh, or more than cracks is in the way: gaps wider than CRACK_SHARE radii.
    """
    if free_space.triangles is None:
        return 0.0
    low, high = 0.0, CRACK_SHARE * radius
    if not _connected_across(free_space, stops, radius, high):
        return 0.0
    while high - low > 0.02 * high:
        heed()
        middle = (low + high) / 2 if low else high / 10
        if _connected_across(free_space, stops, radius, middle):
            high = middle
        else:
            low = middle
    return high


def _connected_across(
    free_space: FreeSpace, stops: FloatArray, radius: float, width: float
) -> bool:
    """Whether `stops` are connected where gaps up to `width` (m) are closed."""
    closed = shapely.buffer(free_space.polygon, width / 2, join_style="mitre")
    shrunk = eroded(closed, radius * (1 - EROSION_SAFETY) + width / 2, quad_segs=32)
    return _connected(shapely.STRtree(shapely.get_parts(shrunk)), stops)


def _parts(free_space: FreeSpace, radius: float) -> shapely.STRtree:
    shrunk = eroded(free_space.polygon, radius * (1 - EROSION_SAFETY), quad_segs=32)
    return shapely.STRtree(shapely.get_parts(shrunk))


def _connected(parts: shapely.STRtree, stops: FloatArray) -> bool:
    reach = parts.query(shapely.points(stops), predicate="intersects")
    common = set(reach[1][reach[0] == 0].tolist())
    for k in range(1, len(stops)):
        common &= set(reach[1][reach[0] == k].tolist())
    return bool(common)
