"""Runs as JSON: GeoJSON with times, orders in the style of VDA 5050, paths in that of Open-RMF; and knots."""

from __future__ import annotations

import math
from typing import Any

import shapely

from stplan.exports.settings import ExportSettings
from stplan.files.json_file import json_bytes
from stplan.viewing.run_view import RunView


def geojson_bytes(view: RunView, settings: ExportSettings) -> bytes:
    """The floor as a polygon and every agent as a line with its `times` (s); places in m, not degrees."""
    del settings
    features: list[dict[str, Any]] = []
    if view.free_space is not None:
        floor = shapely.geometry.mapping(view.free_space.area)
        features.append({"type": "Feature", "properties": {"kind": "floor"}, "geometry": floor})
    for a, name in enumerate(view.lines.agent_ids):
        curve = view.lines.curve(a)
        properties = {
            "kind": "trajectory", "agent": name, "radius": float(view.radii[a]),
            "times": curve[:, 2].tolist(),
        }  # fmt: skip
        line = {"type": "LineString", "coordinates": curve[:, :2].tolist()}
        features.append({"type": "Feature", "properties": properties, "geometry": line})
    return json_bytes({"type": "FeatureCollection", "features": features})


def vda5050_bytes(view: RunView, settings: ExportSettings) -> bytes:
    """An order an agent: nodes with positions and headings at fixed steps, and edges between them.

    VDA 5050 has no times of its own: `plannedTime` (s from the run's begin) is an addition to its nodes.
    """
    frames = settings.frames(view)
    orders = []
    for a, name in enumerate(view.lines.agent_ids):
        nodes, edges = [], []
        rows = frames.rows(a)
        for number, k in enumerate(rows):
            x, y = frames.places[a, k].tolist()
            theta = math.remainder(float(frames.headings[a, k]), math.tau)
            nodes.append(
                {
                    "nodeId": f"{name}-{number}", "sequenceId": 2 * number, "released": True,
                    "nodePosition": {"x": x, "y": y, "theta": theta, "mapId": view.name},
                    "plannedTime": float(frames.times[k] - view.begin), "actions": [],
                }
            )  # fmt: skip
            if number:
                edges.append(
                    {
                        "edgeId": f"{name}-{number - 1}-{number}", "sequenceId": 2 * number - 1,
                        "released": True, "startNodeId": f"{name}-{number - 1}",
                        "endNodeId": f"{name}-{number}", "actions": [],
                    }
                )  # fmt: skip
        order = {"orderId": f"{view.name}-{name}", "orderUpdateId": 0, "serialNumber": name}
        orders.append({**order, "nodes": nodes, "edges": edges})
    return json_bytes({"version": "2.0.0", "manufacturer": "stplan", "orders": orders})


def openrmf_bytes(view: RunView, settings: ExportSettings) -> bytes:
    """A fleet's paths as in the path requests of Open-RMF: places with yaw at times since the run's begin."""
    frames = settings.frames(view)
    robots = []
    for a, name in enumerate(view.lines.agent_ids):
        path: list[dict[str, Any]] = []
        for k in frames.rows(a):
            nanoseconds = round(float(frames.times[k] - view.begin) * 1e9)
            x, y = frames.places[a, k].tolist()
            path.append(
                {
                    "t": {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9},
                    "x": x, "y": y, "yaw": math.remainder(float(frames.headings[a, k]), math.tau),
                    "level_name": view.name, "index": len(path),
                }
            )  # fmt: skip
        robots.append({"robot_name": name, "path": path})
    return json_bytes({"fleet_name": view.name, "robots": robots})


def paths_bytes(view: RunView, settings: ExportSettings) -> bytes:
    """``agent: (x,y,t)->(x,y,t)->...`` a line, in m and s, as solvers on grids write; knots as planned."""
    del settings
    lines = []
    for a, name in enumerate(view.lines.agent_ids):
        knots = "->".join(f"({x:.9g},{y:.9g},{t:.9g})" for x, y, t in view.lines.curve(a).tolist())
        lines.append(f"{name}: {knots}")
    return ("\n".join(lines) + "\n").encode()
