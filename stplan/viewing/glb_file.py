"""Rods and map as binary glTF, for Blender and everything else that shows 3D models."""

from __future__ import annotations

import numpy as np
import trimesh

from stplan.arrays import FloatArray, IntArray
from stplan.viewing.palette import agent_colours
from stplan.viewing.rod_meshes import rod_curve, rod_mesh
from stplan.viewing.run_view import RunView
from stplan.world import FreeSpace

_SIDES = 32
_WALL_GREY = (0.55, 0.58, 0.62)
# Height of the walls over the smallest radius.
_WALL_HEIGHT = 0.5


def glb_bytes(view: RunView, metres_per_second: float | None = None) -> bytes:
    """One mesh an agent, named by its id, and one of the walls, named ``map walls``; lengths in m.

    In glTF the second axis points upwards: x stays x, time (from the run's begin) is y, and the map's y is
    -z. Programs whose third axis is up, as Blender, turn that back on reading.

    Args:
        metres_per_second: height of a second; None is the scene's time scale.
    """
    pace = view.time_scale if metres_per_second is None else metres_per_second
    scene = trimesh.Scene()
    colours = agent_colours(view.num_agents)
    for a, name in enumerate(view.lines.agent_ids):
        curve = rod_curve(view.lines.curve(a), float(view.leaves[a]))
        curve = (curve - [0.0, 0.0, view.begin]) * [1.0, 1.0, pace]
        vertices, triangles = rod_mesh(curve, float(view.radii[a]), _SIDES)
        scene.add_geometry(_mesh(vertices, triangles, colours[a]), node_name=name, geom_name=name)
    if view.free_space is not None:
        height = _WALL_HEIGHT * float(view.radii.min())
        vertices, triangles = wall_mesh(view.free_space, height)
        walls = _mesh(vertices, triangles, np.array(_WALL_GREY))
        scene.add_geometry(walls, node_name="map walls", geom_name="map walls")
    content: bytes = scene.export(file_type="glb")
    return content


def wall_mesh(free_space: FreeSpace, height: float) -> tuple[FloatArray, IntArray]:
    """A frame of upright walls along the boundary, `height` m high: vertices and triangles."""
    ends = free_space.boundary_segments.reshape(-1, 2, 2)
    low = np.concatenate([ends, np.zeros((len(ends), 2, 1))], axis=2)
    high = low + np.array([0.0, 0.0, height])
    vertices = np.concatenate([low, high], axis=1).reshape(-1, 3)
    base = 4 * np.arange(len(ends))[:, None, None]
    triangles = (base + np.array([[0, 1, 3], [0, 3, 2]])).reshape(-1, 3)
    return vertices, triangles


def _mesh(vertices: FloatArray, triangles: IntArray, colour: FloatArray) -> trimesh.Trimesh:
    turned = np.column_stack([vertices[:, 0], vertices[:, 2], -vertices[:, 1]])
    material = trimesh.visual.material.PBRMaterial(
        baseColorFactor=[*np.rint(255 * colour).astype(int).tolist(), 255],
        metallicFactor=0.0, roughnessFactor=0.7, doubleSided=True,
    )  # fmt: skip
    mesh = trimesh.Trimesh(turned, triangles, process=False)
    mesh.visual = trimesh.visual.TextureVisuals(material=material)
    return mesh
