"""Building plans of Open-RMF (``.building.yaml``): walls, doors, floors and named spots of a storey.

Vertices are pixels of a drawing, y downwards, measured by `measurements`; or metres where the coordinate
system says so.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from stplan.arrays import FloatArray, Point
from stplan.maps.files import FileContent
from stplan.maps.formats.drawing import (
    Beside,
    Drawing,
    DrawnAgent,
    FileOptions,
    ForeignFormat,
    FormatError,
    finite,
    repaired,
)
from stplan.maps.formats.json_tree import mapping, members
from stplan.maps.formats.yaml_file import read_yaml_mapping

# What no scene has, by the key of a storey.
_LEFT_OUT = {
    "lanes": "lanes",
    "models": "models of furniture",
    "human_lanes": "lanes of people",
    "ramps": "ramps",
    "zones": "zones",
}
# m a pixel where a storey has no measurement, as the editor takes it.
_PIXEL = 0.05


def read_building(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """A storey. Floors less its holes can be walked on; without floors, what its walls enclose."""
    del beside
    tree = read_yaml_mapping(file)
    levels = mapping(tree, "levels")
    name = options.level or next(iter(levels), "")
    if name not in levels:
        known = ", ".join(list(levels)[:20])
        raise FormatError(f"has no level {name!r}; it has: {known or 'none'}")
    level = _Level(name, levels[name], metric=_metric(tree))
    floors, mended = repaired(level.areas("floors"), "floors")
    holes, more = repaired(level.areas("holes"), "holes", blocked=True)
    doors = level.lines("doors")
    walls = level.lines("walls") + ([] if options.doors else doors)
    left = [
        f"{count} {what}"
        for key, what in _LEFT_OUT.items()
        if (count := len(members(level.tree, key)))
    ]
    lifts = tree.get("lifts")
    if lifts and isinstance(lifts, dict | list):
        left.append(f"{len(lifts)} lifts")
    notes: tuple[str, ...] = ()
    if doors:
        notes += (f"{len(doors)} doors are taken for {'open' if options.doors else 'closed'}",)
    if len(levels) > 1 and options.level is None:
        others = ", ".join(one for one in list(levels)[1:20])
        notes += (f"is read on the level {name}; map.level chooses among the others: {others}",)
    return Drawing(
        floors=floors, blocked=holes, walls=tuple(walls), unit=level.unit, spots=level.spots,
        agents=level.robots, names=tuple(levels), mended=mended + more,
        notes=(*notes, f"{', '.join(left)} were left out") if left else notes,
    )  # fmt: skip


def _metric(tree: dict[str, Any]) -> bool:
    system = tree.get("coordinate_system", "reference_image")
    if system not in ("reference_image", "cartesian_meters"):
        raise FormatError(
            f"has the coordinate system {str(system)[:40]!r}; reference_image or cartesian_meters is expected"
        )
    return bool(system == "cartesian_meters")


class _Level:
    """A storey: its vertices, and shapes that refer to them by number."""

    def __init__(self, name: str, tree: Any, *, metric: bool) -> None:
        self.path = f"levels.{name}."
        self.tree = tree
        vertices = members(tree, "vertices", self.path)
        places = []
        self.spots: dict[str, Point] = {}
        robots: list[DrawnAgent] = []
        for k, vertex in enumerate(vertices):
            if not isinstance(vertex, list) or len(vertex) < 2:
                raise FormatError(f"{self.path}vertices[{k}] is no vertex [x, y, ...]")
            x, y = (finite(value, f"{self.path}vertices[{k}]") for value in vertex[:2])
            at = (x, y if metric else -y)
            places.append(at)
            label = vertex[3] if len(vertex) > 3 and isinstance(vertex[3], str) else ""
            if label:
                self.spots[label] = at
            settings = vertex[4] if len(vertex) > 4 and isinstance(vertex[4], dict) else {}
            robot = settings.get("spawn_robot_name")
            if (
                isinstance(robot, list)
                and len(robot) == 2
                and isinstance(robot[1], str)
                and robot[1]
            ):
                robots.append(DrawnAgent(robot[1], at))
        self.places = np.array(places, dtype=np.float64).reshape(-1, 2)
        self.robots = tuple(robots)
        self.unit = 1.0 if metric else self._pixel()

    def lines(self, key: str) -> list[FloatArray]:
        """(2, 2) of everything under `key` that begins with two vertices."""
        entries = members(self.tree, key, self.path)
        return [self._places(entry, f"{self.path}{key}[{k}]", 2) for k, entry in enumerate(entries)]

    def areas(self, key: str) -> list[shapely.Polygon]:
        """The polygons under `key`."""
        found = []
        for k, entry in enumerate(members(self.tree, key, self.path)):
            path = f"{self.path}{key}[{k}]"
            corners = members(entry, "vertices", f"{path}.")
            if len(corners) > 2:
                found.append(shapely.Polygon(self._places(corners, path, len(corners))))
        return found

    def _places(self, numbers: Any, path: str, count: int) -> FloatArray:
        if not isinstance(numbers, list) or len(numbers) < count:
            raise FormatError(f"{path} names fewer than {count} vertices")
        for number in numbers[:count]:
            if (
                isinstance(number, bool)
                or not isinstance(number, int)
                or not 0 <= number < len(self.places)
            ):
                raise FormatError(
                    f"{path} names the vertex {str(number)[:40]!r}, which is not there"
                )
        return self.places[numbers[:count]]

    def _pixel(self) -> float:
        """m a pixel, the mean of what is measured."""
        found = []
        for k, entry in enumerate(members(self.tree, "measurements", self.path)):
            path = f"{self.path}measurements[{k}]"
            ends = self._places(entry, path, 2)
            distance = (
                entry[2].get("distance") if len(entry) > 2 and isinstance(entry[2], dict) else None
            )
            if not isinstance(distance, list) or len(distance) != 2:
                raise FormatError(f"{path} has no distance")
            length = float(np.hypot(*(ends[1] - ends[0])))
            if length > 0 and finite(distance[1], f"{path}.distance") > 0:
                found.append(float(distance[1]) / length)
        return float(np.mean(found)) if found else _PIXEL


BUILDING = ForeignFormat(
    "building plan", (".yaml", ".yml"), read_building, frozenset({"level", "doors"}),
    lambda content: b"levels" in content,
)  # fmt: skip
