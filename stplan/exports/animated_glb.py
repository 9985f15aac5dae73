"""Moving discs as binary glTF: a node an agent with its own animation, and the floor."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.exports.settings import ExportSettings
from stplan.viewing.glb_file import floor_mesh
from stplan.viewing.palette import agent_colours
from stplan.viewing.run_view import RunView

_SIDES = 32
_FLOAT, _UINT = 5126, 5125
_VERTICES, _INDICES = 34962, 34963
_FLOOR = (0.88, 0.89, 0.91)


class _Buffer:
    """Arrays packed one behind another, each with its accessor."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, array: Any, kind: str, *, target: int | None = None, index: bool = False) -> int:
        """The accessor of an array (n,) or (n, d) of the `kind` SCALAR, VEC3 or VEC4."""
        packed = np.ascontiguousarray(array, dtype="<u4" if index else "<f4")
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": packed.nbytes}
        self.views.append(view | ({} if target is None else {"target": target}))
        self.data += packed.tobytes()
        rows = packed.reshape(len(packed), -1)
        self.accessors.append(
            {
                "bufferView": len(self.views) - 1, "componentType": _UINT if index else _FLOAT,
                "count": len(packed), "type": kind,
                "min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist(),
            }
        )  # fmt: skip
        return len(self.accessors) - 1


def animated_glb_bytes(view: RunView, settings: ExportSettings) -> bytes:
    """Discs as high as wide that move at fixed steps and look where they go; absent ones have no size.

    In glTF the second axis points upwards: the map's y is -z. Lengths in m, times in s from the run's begin.
    """
    frames = settings.frames(view)
    buffer = _Buffer()
    vertices, triangles = _disc()
    shape = {
        "attributes": {"POSITION": buffer.add(vertices, "VEC3", target=_VERTICES)},
        "indices": buffer.add(triangles.ravel(), "SCALAR", target=_INDICES, index=True),
    }
    colours = [*agent_colours(view.num_agents).tolist(), _FLOOR]
    meshes = [{"primitives": [{**shape, "material": a}]} for a in range(view.num_agents)]
    times = buffer.add(frames.times - view.begin, "SCALAR")
    nodes: list[dict[str, Any]] = []
    samplers: list[dict[str, Any]] = []
    channels: list[dict[str, Any]] = []
    for a, name in enumerate(view.lines.agent_ids):
        there = ~np.isnan(frames.places[a, :, 0])
        places = np.where(there[:, None], frames.places[a], view.lines.curve(a)[-1, :2])
        moves = np.column_stack([places[:, 0], np.zeros(len(places)), -places[:, 1]])
        half = frames.headings[a] / 2
        turns = np.column_stack(
            [np.zeros_like(half), np.sin(half), np.zeros_like(half), np.cos(half)]
        )
        sizes = np.where(there[:, None], view.radii[a], 0.0) * np.ones(3)
        size = [float(view.radii[a])] * 3
        nodes.append({"name": name, "mesh": a, "scale": size, "translation": moves[0].tolist()})
        for path, values, kind, how in (
            ("translation", moves, "VEC3", "LINEAR"), ("rotation", turns, "VEC4", "LINEAR"),
            ("scale", sizes, "VEC3", "STEP"),
        ):  # fmt: skip
            samplers.append(
                {"input": times, "output": buffer.add(values, kind), "interpolation": how}
            )
            channels.append({"sampler": len(samplers) - 1, "target": {"node": a, "path": path}})
    if view.free_space is not None:
        vertices, triangles = floor_mesh(view.free_space)
        turned = np.column_stack([vertices[:, 0], vertices[:, 2], -vertices[:, 1]])
        floor = {
            "attributes": {"POSITION": buffer.add(turned, "VEC3", target=_VERTICES)},
            "indices": buffer.add(triangles.ravel(), "SCALAR", target=_INDICES, index=True),
            "material": view.num_agents,
        }
        meshes.append({"primitives": [floor]})
        nodes.append({"name": "map floor", "mesh": view.num_agents})
    tree = {
        "asset": {"version": "2.0", "generator": "stplan"},
        "scene": 0, "scenes": [{"nodes": [*range(len(nodes))]}], "nodes": nodes, "meshes": meshes,
        "materials": [_material(colour) for colour in colours[: len(meshes)]],
        "animations": [{"name": view.name, "samplers": samplers, "channels": channels}],
        "accessors": buffer.accessors, "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.data)}],
    }  # fmt: skip
    return _packed(tree, bytes(buffer.data))


def _material(colour: Sequence[float]) -> dict[str, Any]:
    paint = {"baseColorFactor": [*colour, 1.0], "metallicFactor": 0.0}
    return {"pbrMetallicRoughness": paint, "doubleSided": True}


def _disc() -> tuple[FloatArray, IntArray]:
    """A disc of radius 1 and height 1 with a nose along x: vertices (V, 3) and triangles (F, 3)."""
    angles = 2 * np.pi * np.arange(_SIDES) / _SIDES
    low = np.column_stack([np.cos(angles), np.zeros(_SIDES), -np.sin(angles)])
    high = low + np.array([0.0, 1.0, 0.0])
    nose = np.array([[0.9, 1.01, 0.0], [0.3, 1.01, 0.3], [0.3, 1.01, -0.3]])
    middles = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    k = np.arange(_SIDES)
    after = (k + 1) % _SIDES
    bottom, top = np.full(_SIDES, 2 * _SIDES), np.full(_SIDES, 2 * _SIDES + 1)
    faces = [
        np.column_stack([k, after, after + _SIDES]),
        np.column_stack([k, after + _SIDES, k + _SIDES]),
        np.column_stack([bottom, after, k]),
        np.column_stack([top, k + _SIDES, after + _SIDES]),
        np.array([[2, 4, 3]]) + 2 * _SIDES,
    ]
    return np.vstack([low, high, middles, nose]), np.vstack(faces)


def _packed(tree: dict[str, Any], data: bytes) -> bytes:
    """Header, JSON and buffer, each padded to four bytes."""
    text = json.dumps(tree, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    length = 12 + 8 + len(text) + 8 + len(data)
    return b"".join([
        struct.pack("<4sII", b"glTF", 2, length), struct.pack("<I4s", len(text), b"JSON"), text,
        struct.pack("<I4s", len(data), b"BIN\0"), data,
    ])  # fmt: skip
