"""What a foreign file holds, whatever its format: shapes in m, and the crowd where there is one.

A reader turns bytes into a `Drawing` in the units of the file, y upwards; `moved` brings it to metres.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import shapely

from stplan.amounts import LARGEST
from stplan.arrays import FloatArray, Point
from stplan.errors import SceneError
from stplan.maps.files import FileContent
from stplan.maps.formats.crossings import shapes_tangle
from stplan.maps.repair import whole_shape

# A file has at most so many shapes, and so many corners in all of them.
MOST_SHAPES = 500_000
# No coordinate of a file is further from its origin, whatever its unit.
FURTHEST = 1e12
MOST_CORNERS = 2_000_000
_TANGLED = "has outlines that cross each other or themselves tens of thousands of times"


class FormatError(SceneError):
    """A foreign file that cannot be used; the message goes after its name, `line` says where."""

    def __init__(self, text: str, line: int | None = None) -> None:
        super().__init__(text)
        self.text, self.line = text, line


@dataclass(frozen=True)
class FileOptions:
    """How a foreign file is to be read; None is what the format or its reader thinks best.

    Attributes:
        scale: m a unit of the file.
        origin: where the file's (0, 0) comes to lie, m.
        flip: axes along which the drawing is mirrored in place: x, y, both or none ("").
        simplify: how far corners may be cut off the free space, m.
        weld: gaps between ends of walls up to this width are closed, m.
        thickness: of walls drawn as lines, m; of lanes where there are only lanes.
        layers: names of what blocks the way; empty is all.
        floor: names of what can be walked on; empty is as the format has it.
        threshold: how light a pixel is at least to be free, 0 (black) to 1 (white).
        level: the storey.
        doors: whether doors are open.
    """

    scale: float | None = None
    origin: Point = (0.0, 0.0)
    flip: str = ""
    simplify: float | None = None
    weld: float | None = None
    thickness: float | None = None
    layers: tuple[str, ...] = ()
    floor: tuple[str, ...] = ()
    threshold: float | None = None
    level: str | None = None
    doors: bool = True


@dataclass(frozen=True)
class DrawnAgent:
    """An agent of a foreign file; what it leaves open is None. Lengths as the drawing's, s, kg."""

    id: str
    start: Point
    goal: Point | None = None
    radius: float | None = None
    start_time: float | None = None
    max_time: float | None = None
    max_speed: float | None = None
    mass: float | None = None
    vanishes: bool | None = None
    weights: Mapping[str, float] = field(default_factory=dict)
    friends: tuple[str, ...] = ()


@dataclass(frozen=True)
class Flow:
    """Agents that appear somewhere in one region and leave in another.

    Attributes:
        sources, goals: names of regions; no goals are anywhere on the floor.
        count: how many, None where the file does not say.
    """

    sources: tuple[str, ...]
    goals: tuple[str, ...]
    count: int | None = None
    radius: float | None = None
    max_speed: float | None = None
    vanishes: bool = True


@dataclass(frozen=True)
class Drawing:
    """What was read of a foreign file.

    Attributes:
        floors: polygons that can be walked on; united. Empty where only walls are drawn.
        blocked: polygons that cannot.
        walls: polylines (n, 2) without thickness.
        unit: m a unit of these shapes, where the reader knows it.
        tolerance: how far corners may be cut off unless asked otherwise, in units.
        margin: free room around everything drawn, where there is no floor, in units; None: the walls
            enclose the floor.
        agents, flows, regions: the crowd, and the places it is described with.
        spots: named places.
        grid: side of a cell, in units, where the file is a grid.
        height: of the whole grid, in units.
        names: layers, groups or levels to choose from.
        notes: what was left out.
        mended: what is not simple, and is mended.
    """

    floors: tuple[Any, ...] = ()
    blocked: tuple[Any, ...] = ()
    walls: tuple[FloatArray, ...] = ()
    unit: float = 1.0
    tolerance: float = 0.0
    margin: float | None = None
    agents: tuple[DrawnAgent, ...] = ()
    flows: tuple[Flow, ...] = ()
    regions: Mapping[str, Any] = field(default_factory=dict)
    spots: Mapping[str, Point] = field(default_factory=dict)
    grid: float | None = None
    height: float | None = None
    names: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    mended: tuple[str, ...] = ()

    @property
    def shapes(self) -> list[Any]:
        """Everything with an extent, as shapely geometries."""
        lines = [shapely.linestrings(line) for line in self.walls]
        places = [shapely.Point(agent.start) for agent in self.agents]
        places += [shapely.Point(agent.goal) for agent in self.agents if agent.goal is not None]
        return [*self.floors, *self.blocked, *lines, *self.regions.values(), *places]

    @property
    def has_map(self) -> bool:
        """Whether it says anything about walls or floors."""
        return bool(self.floors or self.blocked or self.walls)


def bounds_of(drawing: Drawing) -> FloatArray:
    """(4,) xmin, ymin, xmax, ymax of everything drawn, zeros where there is nothing."""
    shapes = drawing.shapes
    return shapely.total_bounds(np.array(shapes, dtype=object)) if shapes else np.zeros(4)


def moved(drawing: Drawing, options: FileOptions, box: FloatArray | None = None) -> Drawing:
    """The drawing in metres where `options` want it: mirrored, scaled, shifted, in this order.

    Args:
        box: (4,) what is mirrored in place; default: the drawing's own bounds.

    Raises:
        FormatError: something is not finite or absurdly far away.
    """
    scale = drawing.unit if options.scale is None else options.scale
    shapes = drawing.shapes
    if sum(int(shapely.get_num_coordinates(shape)) for shape in shapes) > MOST_CORNERS:
        raise FormatError(f"has more than {MOST_CORNERS} corners")
    check_crossings(shapes)
    box = bounds_of(drawing) if box is None else box
    signs = np.array([-1.0 if options.flip in (axis, "both") else 1.0 for axis in "xy"])
    middle = box[:2] + box[2:]
    shift = np.where(signs < 0, middle, 0.0) * scale + options.origin

    def place(points: FloatArray) -> FloatArray:
        return points * (signs * scale) + shift

    def point(at: Point) -> Point:
        x, y = place(np.array(at, dtype=np.float64)).tolist()
        return x, y

    def transformed(geometries: Sequence[Any]) -> tuple[Any, ...]:
        return tuple(shapely.transform(geometry, place) for geometry in geometries)

    result = replace(
        drawing,
        floors=transformed(drawing.floors),
        blocked=transformed(drawing.blocked),
        walls=tuple(place(line) for line in drawing.walls),
        unit=1.0,
        tolerance=drawing.tolerance * scale,
        margin=None if drawing.margin is None else drawing.margin * scale,
        agents=tuple(_moved_agent(agent, point, scale) for agent in drawing.agents),
        flows=tuple(
            replace(
                flow, radius=_scaled(flow.radius, scale), max_speed=_scaled(flow.max_speed, scale)
            )
            for flow in drawing.flows
        ),
        regions=dict(zip(drawing.regions, transformed([*drawing.regions.values()]), strict=True)),
        spots={name: point(at) for name, at in drawing.spots.items()},
        grid=_scaled(drawing.grid, scale),
        height=_scaled(drawing.height, scale),
    )
    bounds = bounds_of(result)
    if not np.isfinite(bounds).all() or np.abs(bounds).max() > LARGEST:
        raise FormatError("has places that are not finite or absurdly far away")
    return result


def check_crossings(shapes: Sequence[Any]) -> None:
    """Raise FormatError where outlines cross so often that nothing can be made of them in good time."""
    if shapes_tangle(shapes):
        raise FormatError(_TANGLED)


def _moved_agent(agent: DrawnAgent, point: Callable[[Point], Point], scale: float) -> DrawnAgent:
    return replace(
        agent,
        start=point(agent.start),
        goal=None if agent.goal is None else point(agent.goal),
        radius=_scaled(agent.radius, scale),
        max_speed=_scaled(agent.max_speed, scale),
    )


def _scaled(length: float | None, scale: float) -> float | None:
    return None if length is None else length * scale


def finite(value: Any, what: str, line: int | None = None) -> float:
    """A number of a foreign file; raises FormatError where it is none or not finite."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = float("nan")
    if isinstance(value, bool) or not abs(number) <= FURTHEST:
        raise FormatError(f"{what} is {str(value)[:40]!r}; a finite number is expected", line)
    return number


def repaired(
    shapes: Sequence[Any], what: str, *, blocked: bool = False
) -> tuple[tuple[Any, ...], tuple[str, ...]]:
    """Polygons made valid, those without area left out, and what was mended for it.

    What is in doubt is not free, as `stplan.maps.repair` has it.

    Args:
        what: they are, for messages.
        blocked: whether they are in the way; else they are floor.
    """
    array = np.array(list(shapes), dtype=object)
    if not len(array):
        return (), ()
    if len(array) > MOST_SHAPES:
        raise FormatError(f"has more than {MOST_SHAPES} shapes")
    if not (np.abs(shapely.bounds(array[~shapely.is_empty(array)])) <= FURTHEST).all():
        raise FormatError(f"has {what} with corners that are not finite or absurdly far away")
    bad = ~shapely.is_valid(array)
    notes = []
    if bad.any():
        check_crossings(array[bad])
        whole = [whole_shape(shape, blocked=blocked) for shape in array[bad]]
        array[bad] = [one.area for one in whole]
        fault = next((one.faults[0] for one in whole if one.faults), "has holes that meet its edge")
        notes.append(f"{int(bad.sum())} {what} are not simple, of which the first {fault}")
    parts = shapely.get_parts(array)
    parts = parts[shapely.get_type_id(parts) == shapely.GeometryType.POLYGON]
    return tuple(parts[shapely.area(parts) > 0]), tuple(notes)


@dataclass(frozen=True)
class ForeignFormat:
    """A way to read foreign files.

    Attributes:
        name: as docs/formats.md has it.
        suffixes: endings of its files, with dots.
        read: (file, options, opener of files beside it) -> what it holds.
        options: those of `FileOptions` beyond scale, origin, flip, simplify, weld and thickness.
        claims: whether the content is of this format, where several share an ending.
        mentions: names of the files beside it that it consists of.
    """

    name: str
    suffixes: tuple[str, ...]
    read: Callable[[FileContent, FileOptions, Beside], Drawing]
    options: frozenset[str] = frozenset()
    claims: Callable[[bytes], bool] | None = None
    mentions: Callable[[FileContent], tuple[str, ...]] | None = None


# The file of a name that another file mentions.
Beside = Callable[[str], FileContent]
