"""Scenes of Menge (``.xml``): obstacles and agents in m, and the goal sets of its behaviours."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import shapely
from shapely.affinity import rotate

from stplan.arrays import FloatArray, Point
from stplan.maps.files import FileContent
from stplan.maps.formats.drawing import (
    Beside,
    Drawing,
    DrawnAgent,
    FileOptions,
    ForeignFormat,
    FormatError,
    repaired,
)
from stplan.maps.formats.vadere import disc
from stplan.maps.formats.xml_tree import Element, read_xml

MOST_AGENTS = 100_000
# Free room around everything, m: the plane of Menge has no end.
_MARGIN = 2.0


def read_scene(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """Counterclockwise obstacles are solid, a clockwise one around everything is the outline of the floor."""
    del options, beside
    root = read_xml(file.content)
    if root.tag == "BFSM":
        return Drawing(regions=dict(_goals(root)))
    for group in root.all("ObstacleSet"):
        kind = group.attributes.get("type", "explicit")
        if kind != "explicit":
            raise FormatError(
                f"has obstacles of the type {kind[:40]!r}; explicit is expected", group.line
            )
    blocked: list[Any] = []
    walls: list[FloatArray] = []
    outlines: list[Any] = []
    for obstacle in root.all("Obstacle"):
        corners = np.array([[v.number("p_x"), v.number("p_y")] for v in obstacle.all("Vertex")])
        if len(corners) < 2:
            raise FormatError("has an obstacle of fewer than 2 corners", obstacle.line)
        if obstacle.attributes.get("closed", "1") not in ("1", "true") or len(corners) == 2:
            walls.append(corners)
        elif shapely.LinearRing(corners).is_ccw:
            blocked.append(shapely.Polygon(corners))
        else:
            outlines.append(shapely.Polygon(corners))
    agents = _agents(root)
    solid, mended = repaired(blocked, "obstacles", blocked=True)
    floors, more = repaired(outlines, "outlines")
    everything = [
        *solid,
        *map(shapely.linestrings, walls),
        *(shapely.Point(one.start) for one in agents),
    ]
    around = [floor for floor in floors if all(floor.covers(shape) for shape in everything)]
    if len(around) < len(floors):
        # From inside they are walls too, whatever the side they are drawn from.
        walls += [
            np.asarray(shapely.get_coordinates(floor.exterior))
            for floor in floors
            if floor not in around
        ]
    return Drawing(
        floors=tuple(around), blocked=solid, walls=tuple(walls), agents=agents, mended=mended + more,
        margin=_MARGIN,
    )  # fmt: skip


def _agents(root: Element) -> tuple[DrawnAgent, ...]:
    profiles = {
        profile.attributes.get("name", ""): profile.first("Common")
        for profile in root.all("AgentProfile")
    }
    agents: list[DrawnAgent] = []
    for group in root.all("AgentGroup"):
        selector = group.first("ProfileSelector")
        common = profiles.get(selector.attributes.get("name", "") if selector else "")
        radius, speed = (
            None if common is None or key not in common.attributes else common.number(key)
            for key in ("r", "max_speed")
        )
        generator = group.first("Generator")
        for at in () if generator is None else _places(generator):
            agents.append(
                DrawnAgent(f"a{len(agents) + 1}", at, radius=radius, max_speed=speed or None)
            )
            if len(agents) > MOST_AGENTS:
                raise FormatError(f"has more than {MOST_AGENTS} agents", group.line)
    return tuple(agents)


def _places(generator: Element) -> Iterator[Point]:
    """Where a generator puts its agents."""
    kind = generator.attributes.get("type", "")
    if kind == "explicit":
        yield from ((agent.number("p_x"), agent.number("p_y")) for agent in generator.all("Agent"))
        return
    if kind != "rect_grid":
        raise FormatError(
            f"has a generator of the type {kind[:40]!r}; explicit or rect_grid is expected",
            generator.line,
        )
    columns, rows = int(generator.number("count_x")), int(generator.number("count_y"))
    if columns * rows > MOST_AGENTS or min(columns, rows) < 1:
        raise FormatError(f"has a grid of {columns} x {rows} agents", generator.line)
    x, y = generator.number("anchor_x"), generator.number("anchor_y")
    dx, dy = generator.number("offset_x"), generator.number("offset_y")
    angle = math.radians(generator.number("rotation", 0.0))
    for row in range(rows):
        for column in range(columns):
            right, up = column * dx, row * dy
            yield (
                x + right * math.cos(angle) - up * math.sin(angle),
                y + right * math.sin(angle) + up * math.cos(angle),
            )


def _goals(root: Element) -> Iterator[tuple[str, Any]]:
    """Goal sets of a behaviour file as regions."""
    for goals in root.all("GoalSet"):
        for goal in goals.all("Goal"):
            name = f"goal-{goals.attributes.get('id', '0')}-{goal.attributes.get('id', '0')}"
            kind = goal.attributes.get("type", "")
            if kind in ("point", "circle"):
                radius = goal.number("radius", 0.05) if kind == "circle" else 0.05
                yield name, disc((goal.number("x"), goal.number("y")), radius)
            elif kind == "AABB":
                yield (
                    name,
                    shapely.box(*(goal.number(key) for key in ("xmin", "ymin", "xmax", "ymax"))),
                )
            elif kind == "OBB":
                x, y, width, height = (goal.number(key) for key in ("x", "y", "width", "height"))
                box = shapely.box(x, y, x + width, y + height)
                yield name, rotate(box, goal.number("angle", 0.0), origin=(x, y))


MENGE = ForeignFormat(
    "Menge scene", (".xml",), read_scene,
    claims=lambda content: b"<Experiment" in content or b"<BFSM" in content,
)  # fmt: skip
