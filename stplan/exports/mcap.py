"""MCAP with messages of ROS 2: a path an agent, and its disc as a marker at fixed steps."""

from __future__ import annotations

import io
import math
import re
from typing import Any

from stplan.exports.settings import ExportSettings
from stplan.optional import require
from stplan.viewing.palette import agent_colours
from stplan.viewing.run_view import RunView

_LINE = "=" * 80
_TIME = "int32 sec\nuint32 nanosec"
_HEADER = "builtin_interfaces/Time stamp\nstring frame_id"
_POSE = "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation"
_PARTS = {
    "std_msgs/Header": _HEADER,
    "builtin_interfaces/Time": _TIME,
    "builtin_interfaces/Duration": _TIME,
    "geometry_msgs/PoseStamped": "std_msgs/Header header\ngeometry_msgs/Pose pose",
    "geometry_msgs/Pose": _POSE,
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "std_msgs/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a",
    "sensor_msgs/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data",
    "visualization_msgs/UVCoordinate": "float32 u\nfloat32 v",
    "visualization_msgs/MeshFile": "string filename\nuint8[] data",
    "visualization_msgs/Marker": (
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n"
        "geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\n"
        "bool frame_locked\ngeometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\n"
        "string texture_resource\nsensor_msgs/CompressedImage texture\n"
        "visualization_msgs/UVCoordinate[] uv_coordinates\nstring text\n"
        "string mesh_resource\nvisualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials"
    ),
}
_CYLINDER, _ADD, _DELETE = 3, 0, 2


def mcap_bytes(view: RunView, settings: ExportSettings) -> bytes:
    """``/agents/NAME/path`` (nav_msgs/Path, once), ``/agents`` (visualization_msgs/MarkerArray, each step).

    Times are from the run's begin; the frame is ``map``, in m.
    """
    ros = require("mcap_ros2.writer", "an MCAP file", "export")
    frames = settings.frames(view)
    buffer = io.BytesIO()
    writer = ros.Writer(buffer)
    path_type = writer.register_msgdef("nav_msgs/msg/Path", _definition(
        "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses"))  # fmt: skip
    markers_type = writer.register_msgdef("visualization_msgs/msg/MarkerArray", _definition(
        "visualization_msgs/Marker[] markers"))  # fmt: skip
    for a, name in enumerate(view.lines.agent_ids):
        poses = []
        for k in frames.rows(a):
            x, y = frames.places[a, k].tolist()
            header = _header(_since(view, float(frames.times[k])))
            poses.append({"header": header, "pose": _pose(x, y, float(frames.headings[a, k]))})
        topic = f"/agents/{re.sub(r'[^A-Za-z0-9_]', '_', name)}_{a + 1}/path"
        path = {"header": _header(0), "poses": poses}
        writer.write_message(topic, path_type, path, log_time=0, publish_time=0)
    colours = agent_colours(view.num_agents).tolist()
    for k, time in enumerate(frames.times.tolist()):
        at = _since(view, time)
        markers = [
            _marker(
                at, a, view, colours[a], frames.places[a, k].tolist(), float(frames.headings[a, k])
            )
            for a in range(view.num_agents)
        ]
        writer.write_message(
            "/agents", markers_type, {"markers": markers}, log_time=at, publish_time=at
        )
    writer.finish()
    return buffer.getvalue()


def _definition(fields: str) -> str:
    """A message with the definitions of all that it is made of, as bags keep them."""
    found: dict[str, str] = {}

    def add(text: str) -> None:
        for line in text.splitlines():
            kind = line.split()[0].removesuffix("[]")
            if kind in _PARTS and kind not in found:
                found[kind] = _PARTS[kind]
                add(_PARTS[kind])

    add(fields)
    return "\n".join([fields, *(f"{_LINE}\nMSG: {name}\n{text}" for name, text in found.items())])


def _since(view: RunView, time: float) -> int:
    return round((time - view.begin) * 1e9)


def _header(nanoseconds: int) -> dict[str, Any]:
    return {
        "stamp": {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9},
        "frame_id": "map",
    }


def _pose(x: float, y: float, heading: float) -> dict[str, Any]:
    return {
        "position": {"x": x, "y": y, "z": 0.0},
        "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(heading / 2), "w": math.cos(heading / 2)},
    }


def _marker(
    at: int, number: int, view: RunView, colour: list[float], place: list[float], heading: float
) -> dict[str, Any]:
    """A disc, or that there is none."""
    there = not math.isnan(place[0])
    x, y = place if there else (0.0, 0.0)
    width = 2 * float(view.radii[number])
    red, green, blue = colour
    return {
        "header": _header(at), "ns": "agents", "id": number + 1, "type": _CYLINDER,
        "action": _ADD if there else _DELETE, "pose": _pose(x, y, heading),
        "scale": {"x": width, "y": width, "z": 0.1}, "color": {"r": red, "g": green, "b": blue, "a": 1.0},
        "lifetime": {"sec": 0, "nanosec": 0}, "frame_locked": False, "points": [], "colors": [],
        "texture_resource": "", "texture": {"header": _header(at), "format": "", "data": b""},
        "uv_coordinates": [], "text": view.lines.agent_ids[number], "mesh_resource": "",
        "mesh_file": {"filename": "", "data": b""},
        "mesh_use_embedded_materials": False,
    }  # fmt: skip
