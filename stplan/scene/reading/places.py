"""Places of a file: shapes are checked, names looked up."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from stplan.arrays import Point
from stplan.maps.obstacles import exactly_one
from stplan.maps.rings import polyline, read_ring, rectangle_ring
from stplan.scene.format.places import (
    SHAPES,
    CrowdGoalFile,
    GoalPlaceFile,
    PlaceFile,
    StartPlaceFile,
)
from stplan.scene.places import Place
from stplan.scene.reading.faults import Hints
from stplan.schema.mapping import Fault

# Corners of the polygon inscribed in a disc: everywhere in it is in the disc.
CIRCLE_CORNERS = 64


@dataclass(frozen=True)
class Places:
    """The places of a file by name.

    Attributes:
        known: those that could be read.
        complete: whether all could be, so that an unknown name is a fault.
        resolved: what was found for which path of the file: of a crowd everybody asks for the same.
    """

    known: Mapping[str, Place] = field(default_factory=dict)
    complete: bool = True
    resolved: dict[str, tuple[Place, ...]] = field(default_factory=dict)

    def of_start(
        self, entry: StartPlaceFile, path: str, faults: list[Fault], hints: Hints
    ) -> tuple[Place, ...]:
        """The place that a start is drawn from, empty with new faults."""
        if path not in self.resolved:
            chosen = exactly_one(entry, ("place", *SHAPES), path, faults)
            found = () if chosen is None else self._found(entry, chosen, path, faults, hints)
            self.resolved[path] = found
        return self.resolved[path]

    def of_goal(
        self, entry: GoalPlaceFile, path: str, faults: list[Fault], hints: Hints
    ) -> tuple[Place, ...]:
        """The places of which one is a goal, empty with new faults (and for points to be assigned)."""
        if path not in self.resolved:
            keys: tuple[str, ...] = ("place", "any", *SHAPES)
            if isinstance(entry, CrowdGoalFile):
                keys = (*keys, "assign")
            chosen = exactly_one(entry, keys, path, faults)
            found: tuple[Place, ...] = ()
            if chosen == "any":
                every = [
                    self.named(name, f"{path}.any[{k}]", faults, hints)
                    for k, name in enumerate(entry.any or [])
                ]
                found = tuple(dict.fromkeys(place for place in every if place is not None))
            elif chosen is not None and chosen != "assign":
                found = self._found(entry, chosen, path, faults, hints)
            self.resolved[path] = found
        return self.resolved[path]

    def _found(
        self,
        entry: StartPlaceFile | GoalPlaceFile,
        chosen: str,
        path: str,
        faults: list[Fault],
        hints: Hints,
    ) -> tuple[Place, ...]:
        if chosen != "place" or entry.place is None:
            return (compile_place("", entry, path, faults),)
        place = self.named(entry.place, f"{path}.place", faults, hints)
        return () if place is None else (place,)

    def named(self, name: str, path: str, faults: list[Fault], hints: Hints) -> Place | None:
        """The place of a name; None with a new fault where there is none, or where it could not be read."""
        if name not in self.known and self.complete:
            text = f"is '{name}', which is none of the scene's places"
            hint = hints(name, self.known)
            faults.append((path, text + (hint or "; the name of one is expected")))
        return self.known.get(name)


def compile_places(entries: Mapping[str, PlaceFile], faults: list[Fault]) -> Places:
    """The places of a file; with new `faults` they must not be used."""
    found = {}
    for name, entry in entries.items():
        path = f"places.{name}"
        if exactly_one(entry, SHAPES, path, faults):
            found[name] = compile_place(name, entry, path, faults)
    return Places(found, complete=len(found) == len(entries))


def compile_place(name: str, entry: PlaceFile, path: str, faults: list[Fault]) -> Place:
    """The place of an entry with one shape; with new `faults` it must not be used."""
    if entry.line is not None:
        return Place(name, polyline(entry.line, f"{path}.line", faults), area=False)
    if entry.circle is not None:
        (x, y), radius = entry.circle.center, entry.circle.radius
        angles = [2 * math.pi * k / CIRCLE_CORNERS for k in range(CIRCLE_CORNERS)]
        ring = tuple((x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles)
        return Place(name, ring, area=True)
    if entry.polygon is not None:
        return Place(name, _simple_ring(entry.polygon, f"{path}.polygon", faults), area=True)
    corners = entry.rectangle or [0, 0, 1, 1]
    return Place(name, rectangle_ring(corners, f"{path}.rectangle", faults), area=True)


def _simple_ring(
    points: Sequence[Sequence[float]], path: str, faults: list[Fault]
) -> tuple[Point, ...]:
    """The corners of a ring that does not cross itself."""
    import shapely

    before = len(faults)
    ring = read_ring(points, path, faults, repair=True)
    if len(faults) == before and not shapely.is_valid(shapely.Polygon(ring)):
        faults.append((path, "crosses or touches itself; a simple ring is expected"))
    return ring
