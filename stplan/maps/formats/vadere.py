"""Scenarios of Vadere (``.scenario``): bounds, obstacles, sources and targets, pedestrians, in m."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from stplan.maps.files import FileContent
from stplan.maps.formats.drawing import (
    Beside,
    Drawing,
    DrawnAgent,
    FileOptions,
    Flow,
    ForeignFormat,
    FormatError,
    finite,
    repaired,
)
from stplan.maps.formats.json_tree import mapping, members, place, read_json_tree, ring

MOST_AGENTS = 100_000
_LEFT_OUT = ("stairs", "targetChangers", "absorbingAreas", "measurementAreas", "aerosolClouds",
             "droplets")  # fmt: skip


def read_scenario(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """The topography: its bounds less their frame and the obstacles."""
    del options, beside
    tree = read_json_tree(file.content)
    path = ""
    for key in ("scenario", "vadere"):
        if isinstance(tree.get(key), dict):
            tree, path = tree[key], f"{path}{key}."
    topography = mapping(tree, "topography", path)
    path += "topography."
    attributes = mapping(topography, "attributes", path)
    floor = _shape(
        {"type": "RECTANGLE", **mapping(attributes, "bounds", path)}, f"{path}attributes.bounds"
    )
    frame = finite(attributes.get("boundingBoxWidth", 0.0), f"{path}attributes.boundingBoxWidth")
    if attributes.get("bounded", True) and frame > 0:
        floor = shapely.buffer(floor, -frame, join_style="mitre")
    blocked, mended = repaired(
        [
            _shape(_member(obstacle, "shape", f"{path}obstacles[{k}]"), f"{path}obstacles[{k}].shape")
            for k, obstacle in enumerate(members(topography, "obstacles", path))
        ],
        "obstacles", blocked=True,
    )  # fmt: skip
    if floor.is_empty:
        raise FormatError(f"{path}attributes.bounds leave no room inside their frame")
    regions = _regions(topography, path)
    pedestrian = topography.get("attributesPedestrian")
    radius, speed = (
        finite(pedestrian[key], f"{path}attributesPedestrian.{key}")
        if isinstance(pedestrian, dict) and key in pedestrian
        else None
        for key in ("radius", "maximumSpeed")
    )
    left = [
        f"{len(members(topography, key, path))} {key}"
        for key in _LEFT_OUT
        if members(topography, key, path)
    ]
    if topography.get("teleporter"):
        left.append("a teleporter")
    return Drawing(
        floors=(floor,), blocked=blocked, regions=regions, mended=mended,
        notes=(f"{', '.join(left)} were left out",) if left else (),
        agents=_pedestrians(topography, path, regions, radius),
        flows=_flows(topography, path, regions, radius, speed),
    )  # fmt: skip


def _regions(topography: dict[str, Any], path: str) -> dict[str, Any]:
    """Sources and targets by name."""
    found = {}
    for key, word in (("sources", "source"), ("targets", "target")):
        for k, entry in enumerate(members(topography, key, path)):
            name = f"{word}-{_member(entry, 'id', f'{path}{key}[{k}]')}"
            shape = _shape(_member(entry, "shape", f"{path}{key}[{k}]"), f"{path}{key}[{k}].shape")
            found[name] = shapely.make_valid(shape)
    return found


def _flows(
    topography: dict[str, Any], path: str, regions: dict[str, Any], radius: float | None,
    speed: float | None,
) -> tuple[Flow, ...]:  # fmt: skip
    flows = []
    for k, source in enumerate(members(topography, "sources", path)):
        spawner = _optional(source, "spawner")
        count = (
            spawner.get("eventElementCount")
            if isinstance(spawner, dict)
            else _optional(source, "spawnNumber")
        )
        goals = tuple(
            name for one in members({"targetIds": _optional(source, "targetIds")}, "targetIds")
            if (name := f"target-{one}") in regions
        )  # fmt: skip
        number = (
            None
            if count is None
            else int(finite(count, f"{path}sources[{k}]: the number of agents"))
        )
        name = f"source-{_member(source, 'id', f'{path}sources[{k}]')}"
        flows.append(Flow((name,), goals, number, radius, speed))
    return tuple(flows)


def _pedestrians(
    topography: dict[str, Any], path: str, regions: dict[str, Any], radius: float | None
) -> tuple[DrawnAgent, ...]:
    """Those that stand there already, each on its way to the middle of its first target."""
    agents = []
    standing = members(topography, "dynamicElements", path)
    if len(standing) > MOST_AGENTS:
        raise FormatError(f"has more than {MOST_AGENTS} pedestrians")
    for k, entry in enumerate(standing):
        if not isinstance(entry, dict) or "position" not in entry:
            continue
        at = place(entry["position"], f"{path}dynamicElements[{k}].position")
        targets = members(entry, "targetIds", f"{path}dynamicElements[{k}].")
        goal = regions.get(f"target-{targets[0]}") if targets else None
        own = entry.get("attributes")
        size = own.get("radius", radius) if isinstance(own, dict) else radius
        middle = None if goal is None else shapely.point_on_surface(goal)
        agents.append(
            DrawnAgent(
                f"p{k + 1}", at, None if middle is None else (middle.x, middle.y),
                None if size is None else finite(size, f"{path}dynamicElements[{k}].radius"),
                vanishes=True,
            )
        )  # fmt: skip
    return tuple(agents)


def _member(entry: Any, key: str, path: str) -> Any:
    if not isinstance(entry, dict) or key not in entry:
        # Pedestrians and newer versions keep what they are in `attributes`.
        inner = entry.get("attributes") if isinstance(entry, dict) else None
        if isinstance(inner, dict) and key in inner:
            return inner[key]
        raise FormatError(f"{path} has no {key}")
    return entry[key]


def _optional(entry: Any, key: str) -> Any:
    """What is under a key, there or among the `attributes`; None where it is neither."""
    inner = entry.get("attributes") if isinstance(entry, dict) else None
    found = entry.get(key) if isinstance(entry, dict) else None
    return inner.get(key) if found is None and isinstance(inner, dict) else found


def _shape(shape: Any, path: str) -> Any:
    """A rectangle, polygon or circle."""
    kind = shape.get("type") if isinstance(shape, dict) else None
    if kind == "RECTANGLE":
        x, y, width, height = (
            finite(shape.get(key), f"{path}.{key}") for key in ("x", "y", "width", "height")
        )
        return shapely.box(x, y, x + width, y + height)
    if kind == "POLYGON":
        return shapely.Polygon(ring(shape.get("points"), f"{path}.points"))
    if kind == "CIRCLE":
        centre = place(shape.get("center"), f"{path}.center")
        return disc(centre, finite(shape.get("radius"), f"{path}.radius"))
    raise FormatError(
        f"{path} is of the type {str(kind)[:40]!r}; a rectangle, polygon or circle is expected"
    )


def disc(centre: tuple[float, float], radius: float) -> shapely.Polygon:
    """A polygon around a disc, so that nobody gets closer to it than drawn."""
    angles = 2 * np.pi * np.arange(64) / 64
    reach = radius / np.cos(np.pi / 64)
    return shapely.Polygon(
        np.array(centre) + reach * np.column_stack([np.cos(angles), np.sin(angles)])
    )


VADERE = ForeignFormat(
    "Vadere scenario", (".scenario", ".json"), read_scenario,
    claims=lambda content: b'"topography"' in content,
)  # fmt: skip
