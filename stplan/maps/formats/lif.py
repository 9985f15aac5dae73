"""Track layouts of fleets in the Layout Interchange Format of the VDMA: nodes, edges, stations, in m."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from stplan.arrays import Point
from stplan.maps.files import FileContent
from stplan.maps.formats.drawing import Beside, Drawing, FileOptions, ForeignFormat, FormatError
from stplan.maps.formats.json_tree import mapping, members, place, read_json_tree

# Width of a lane, m, where `thickness` does not say: room for two vehicles to pass.
LANE = 2.0


def read_layout(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """A layout: a lane along every edge is floor; stations and nodes are spots."""
    del beside
    layouts = members(read_json_tree(file.content), "layouts")
    names = [
        str(one.get("layoutId", k)) if isinstance(one, dict) else str(k)
        for k, one in enumerate(layouts)
    ]
    if not layouts or (options.level or names[0]) not in names:
        raise FormatError(
            f"has no layout {options.level or ''}; it has: {', '.join(names[:20]) or 'none'}"
        )
    layout = layouts[names.index(options.level or names[0])]
    nodes: dict[str, Point] = {}
    for k, node in enumerate(members(layout, "nodes")):
        path = f"nodes[{k}]"
        nodes[str(node.get("nodeId", k)) if isinstance(node, dict) else str(k)] = place(
            mapping(node, "nodePosition", f"{path}."), f"{path}.nodePosition"
        )
    lanes: list[Any] = []
    limited = curved = 0
    for k, edge in enumerate(members(layout, "edges")):
        ends = [
            edge.get(key) if isinstance(edge, dict) else None
            for key in ("startNodeId", "endNodeId")
        ]
        missing = [end for end in ends if str(end) not in nodes]
        if missing:
            raise FormatError(
                f"edges[{k}] names the node {str(missing[0])[:40]!r}, which is not there"
            )
        for_types = [
            one for one in members(edge, "vehicleTypeEdgeProperties") if isinstance(one, dict)
        ]
        limited += any("maxSpeed" in one for one in for_types)
        curved += any(one.get("trajectory") for one in for_types)
        lanes.append(shapely.LineString([nodes[str(end)] for end in ends]))
    if not lanes:
        raise FormatError("has no edges")
    width = options.thickness or LANE
    unit = 1.0 if options.scale is None else options.scale
    floors = shapely.buffer(np.array(lanes, dtype=object), width / 2 / unit, quad_segs=8)
    notes = [f"lanes are {width:g} m wide (map.thickness)"]
    if limited:
        notes.append(f"speed limits of {limited} edges were left out")
    if curved:
        notes.append(f"trajectories of {curved} edges were left out: these lanes are straight")
    if len(layouts) > 1 and options.level is None:
        notes.append(
            f"is read in the layout {names[0]}; map.level chooses among the others: {', '.join(names[1:20])}"
        )
    return Drawing(
        floors=tuple(floors),
        spots=_stations(layout, nodes) or nodes,
        names=tuple(names),
        notes=tuple(notes),
    )


def _stations(layout: Any, nodes: dict[str, Point]) -> dict[str, Point]:
    """Where vehicles stand to work at a station."""
    found = {}
    for k, station in enumerate(members(layout, "stations")):
        name = str(station.get("stationId", k)) if isinstance(station, dict) else str(k)
        for node in members(station, "interactionNodeIds", f"stations[{k}]."):
            if str(node) in nodes:
                found[name] = nodes[str(node)]
    return found


LIF = ForeignFormat(
    "LIF layout", (".lif", ".json"), read_layout, frozenset({"level"}),
    lambda content: b'"layouts"' in content,
)  # fmt: skip
