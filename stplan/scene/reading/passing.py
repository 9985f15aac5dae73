"""Waypoints that are places: where in them agents pass, chosen before anything is planned. Lengths in m.

Of the points that a disc can stand on, the one nearest to the straight line from the stop before to the stop
after is taken; of agents that end in places, the stop after is the nearest point of these.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from stplan.amounts import amount
from stplan.arrays import Point
from stplan.scene.format.agents import SharedFields, WaypointFile
from stplan.scene.model import Agent, Scene
from stplan.scene.places import Place
from stplan.scene.reading.faults import Hints
from stplan.scene.reading.patterns import Listed
from stplan.scene.reading.places import Places
from stplan.scene.reading.regions import OFF_WALLS, floor_of, region_of
from stplan.schema.mapping import Fault

# By number of an agent and of a waypoint: the place, and where the file says it.
Passed = Mapping[tuple[int, int], tuple[Place, str]]


def passed_places(
    listed: Sequence[Listed], defaults: SharedFields | None, places: Places, hints: Hints
) -> Passed:
    """The waypoints of the file that are places which are known."""
    found = {}
    for a, one in enumerate(listed):
        if one.agent is None or one.agent.path is not None:
            continue
        own = one.agent.waypoints is not None or defaults is None
        entries = one.agent.waypoints if own or defaults is None else defaults.waypoints
        for k, entry in enumerate(entries or []):
            if isinstance(entry, WaypointFile) and entry.place is not None:
                path = one.place("waypoints") if own else "defaults.waypoints"
                place = places.named(entry.place, f"{path}[{k}].place", [], hints)
                if place is not None:
                    found[a, k] = place, f"{path}[{k}].place"
    return found


def with_passed_points(scene: Scene, passed: Passed, faults: list[Fault]) -> Scene:
    """`scene` with a point for every waypoint that is a place; with new faults it must not be used."""
    if not passed:
        return scene
    known = len(faults)
    floor = floor_of(scene, faults)
    if len(faults) > known:
        return scene
    agents = list(scene.agents)
    for (a, k), (place, path) in sorted(passed.items(), key=lambda item: item[0]):
        agent = agents[a]
        room = OFF_WALLS * agent.radius if agent.weights.wall > 0 else 0.0
        region = region_of(place, floor, room)
        if region.is_empty:
            text = f"is {place}, which has no point that a disc of {amount(agent.radius)} m can stand on"
            faults.append((path, text))
            continue
        unsettled = {other for owner, other in passed if owner == a and other > k}
        point = _nearest_to_way(agent, k, unsettled, region)
        points = (*agent.waypoints[:k], point, *agent.waypoints[k + 1 :])
        agents[a] = replace(agent, waypoints=points)
    return replace(scene, agents=tuple(agents))


def _nearest_to_way(agent: Agent, k: int, unsettled: set[int], region: object) -> Point:
    """The point of `region` nearest to the way past waypoint `k`; waypoints `unsettled` are left out."""
    import shapely

    before = agent.start if k == 0 else agent.waypoints[k - 1]
    later = [
        point for other, point in enumerate(agent.waypoints) if other > k and other not in unsettled
    ]
    if later:
        after = later[0]
    elif agent.goal_places:
        ends = shapely.union_all([place.shape() for place in agent.goal_places])
        after = _ends(shapely.shortest_line(ends, shapely.points(before)))[0]
    else:
        after = agent.goal
    way = shapely.linestrings(np.array([before, after]))
    if before == after:
        way = shapely.points(before)
    crossing = shapely.intersection(region, way)
    if not shapely.is_empty(crossing):
        return _ends(shapely.shortest_line(shapely.centroid(crossing), crossing))[-1]
    return _ends(shapely.shortest_line(region, way))[0]


def _ends(line: object) -> list[Point]:
    import shapely

    return [(float(x), float(y)) for x, y in shapely.get_coordinates(line)]
