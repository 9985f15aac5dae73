"""Where a run is measured: lines and areas, as the command line says them or as places of the scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from stplan.arrays import Point
from stplan.errors import UsageError
from stplan.scene.places import Place

# Places of more corners are no straight lines.
ENDS = 2


@dataclass(frozen=True)
class Probe:
    """A straight line (two points, m), or a convex area (its corners)."""

    name: str
    points: tuple[Point, ...]
    area: bool


def probes_of(lines: Sequence[str], areas: Sequence[str], places: Sequence[Place]) -> list[Probe]:
    """The `lines` and `areas` of the command line; without any, the places of the scene.

    An area of four numbers is a rectangle from corner to corner. Polylines are measured piece by piece.

    Raises:
        UsageError: one is none.
    """
    found = [
        Probe(f"line-{k}", _points("--line", text, (ENDS,)), area=False)
        for k, text in enumerate(lines, start=1)
    ]
    for k, text in enumerate(areas, start=1):
        points = _points("--area", text)
        if len(points) == ENDS:
            (west, south), (east, north) = points
            points = ((west, south), (east, south), (east, north), (west, north))
        found.append(Probe(f"area-{k}", points, area=True))
    if found:
        return found
    for k, place in enumerate(places, start=1):
        name = place.name or f"place-{k}"
        if place.area:
            found.append(Probe(name, place.points, area=True))
            continue
        pieces = list(zip(place.points, place.points[1:], strict=False))
        for number, piece in enumerate(pieces, start=1):
            title = name if len(pieces) == 1 else f"{name}-{number}"
            found.append(Probe(title, piece, area=False))
    return found


def _points(option: str, text: str, counts: Sequence[int] = ()) -> tuple[Point, ...]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    points = tuple(zip(numbers[::2], numbers[1::2], strict=False))
    fits = len(points) in counts if counts else len(points) >= ENDS
    if len(numbers) % 2 or not fits or not all(map(math.isfinite, numbers)):
        shape = "x1,y1,x2,y2" if counts else "xmin,ymin,xmax,ymax or x1,y1,x2,y2,x3,y3,..."
        raise UsageError(f"{option} {text!r}: expected {shape}, in m")
    return points
