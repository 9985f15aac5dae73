"""JuPedSim: geometries in its trajectory files (``.sqlite``), and scenarios as JSON with a walkable area."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import shapely

from stplan.maps.files import FileContent
from stplan.maps.formats.drawing import (
    Beside,
    Drawing,
    FileOptions,
    Flow,
    ForeignFormat,
    FormatError,
    finite,
    repaired,
)
from stplan.maps.formats.json_tree import read_json_tree, ring
from stplan.maps.formats.sqlite_file import query
from stplan.maps.formats.wkt import drawing_of, wkt_shapes

# Where a scenario keeps its geometry, by any of these names.
_AREAS = (
    "walkable_area_wkt",
    "walkable_area",
    "walkable_polygon",
    "geometry_wkt",
    "geometry",
    "wkt",
)
_GROUPS = ("distributions", "exits")


def read_database(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """The first geometry of a trajectory file."""
    del options, beside
    (rows,) = query(file.content, ["SELECT wkt FROM geometry LIMIT 2"])
    if not rows or not isinstance(rows[0][0], str):
        raise FormatError("holds no geometry")
    drawing = drawing_of(wkt_shapes(rows[0][0]))
    if len(rows) > 1:
        return replace(drawing, notes=(*drawing.notes, "has several geometries; the first is read"))
    return drawing


def read_scenario(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """The walkable area less obstacles, distributions as sources and exits as goals.

    An area that is kept in a file of its own is imported beside it.
    """
    del options, beside
    tree = read_json_tree(file.content)
    floors, mended = repaired(_area(tree), "polygons")
    regions: dict[str, Any] = {}
    flows = []
    for group in _GROUPS:
        entries = tree.get(group)
        if isinstance(entries, list):
            entries = {f"{group}-{k}": entry for k, entry in enumerate(entries)}
        for name, entry in (entries or {}).items() if isinstance(entries, dict) else ():
            regions[name] = _polygon(entry, f"{group}.{name}")
    exits = tree.get("exits")
    goals = (
        tuple(exits)
        if isinstance(exits, dict)
        else tuple(name for name in regions if name.startswith("exits"))
    )
    for name in regions:
        if name in goals:
            continue
        entry = (
            (tree["distributions"] or {}).get(name)
            if isinstance(tree.get("distributions"), dict)
            else None
        )
        settings = entry.get("parameters", entry) if isinstance(entry, dict) else {}
        count = (
            settings.get("number", settings.get("number_of_agents"))
            if isinstance(settings, dict)
            else None
        )
        flows.append(
            Flow(
                (name,), goals, None if count is None else int(finite(count, f"{name}: number")),
                _length(settings, ("radius",), name), _length(settings, ("v0", "desired_speed"), name),
            )
        )  # fmt: skip
    obstacles = tree.get("obstacles")
    blocked = [
        _polygon(entry, f"obstacles.{k}")
        for k, entry in (
            obstacles.items() if isinstance(obstacles, dict) else enumerate(obstacles or ())
        )
    ]
    cut, more = repaired(blocked, "obstacles", blocked=True)
    return Drawing(
        floors=floors, blocked=cut, regions=regions, flows=tuple(flows), mended=mended + more
    )


def _area(tree: dict[str, Any]) -> list[Any]:
    for key in _AREAS:
        found = tree.get(key)
        if isinstance(found, str):
            return wkt_shapes(found)
        if isinstance(found, list | dict):
            return [_polygon(found, key)]
    return []


def _polygon(entry: Any, path: str) -> Any:
    """A polygon as a ring, under `coordinates`, or as well-known text."""
    if isinstance(entry, dict):
        entry = entry.get("coordinates", entry.get("polygon", entry.get("vertices")))
    if isinstance(entry, str):
        return shapely.union_all(wkt_shapes(entry))
    if isinstance(entry, list) and len(entry) == 1 and isinstance(entry[0], list):
        entry = entry[0]
    return shapely.make_valid(shapely.Polygon(ring(entry, path)))


def _length(settings: Any, keys: tuple[str, ...], path: str) -> float | None:
    for key in keys:
        if isinstance(settings, dict) and settings.get(key) is not None:
            return finite(settings[key], f"{path}.{key}")
    return None


DATABASE = ForeignFormat("JuPedSim trajectory file", (".sqlite", ".sqlite3", ".db"), read_database)
SCENARIO = ForeignFormat(
    "JuPedSim scenario", (".json",), read_scenario,
    claims=lambda content: b'"exits"' in content or b'"walkable_' in content or b'"distributions"' in content,
)  # fmt: skip
