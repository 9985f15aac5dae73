"""Rods and map as binary glTF, for Blender and everything else that shows 3D models."""

from __future__ import annotations

import numpy as np
import trimesh

from stplan.arrays import FloatArray, IntArray
from stplan.viewing.palette import agent_colours
from stplan.viewing.rod_meshes import rod_curve, rod_mesh
from stplan.viewing.run_view import RunView
from stplan.world import FreeSpace
from stplan.world.triangulation import triangles_of

_SIDES = 32
_WALL_GREY = (0.55, 0.58, 0.62)
_FLOOR_GREY = (0.88, 0.89, 0.91)
# Height of the walls over the smallest radius.
_WALL_HEIGHT = 0.5


def glb_bytes(view: RunView, metres_per_second: float | None = None) -> bytes:
    """One mesh an agent, named by its id, ``map floor`` and ``map walls``; lengths in m.

    In glTF the second axis points upwards: x stays x, time (from the run's begin) is y, and the map's y is
    -z. Programs whose third axis is up, as Blender, turn that back on reading, and so does a scene
    with the file for its map: it gets this very floor. Vertices have single precision; far from the
    origin they are relative to a place of whole extents that every node is moved to.

    Args:
        metres_per_second: height of a second; None is the scene's time scale.
    """
    pace = view.time_scale if metres_per_second is None else metres_per_second
    scene = trimesh.Scene()
    origin = _origin(view)
    to_place = trimesh.transformations.translation_matrix([origin[0], 0.0, -origin[1]])

    def add(name: str, vertices: FloatArray, triangles: IntArray, colour: FloatArray) -> None:
        mesh = _mesh(vertices - [*origin, 0.0], triangles, colour)
        scene.add_geometry(mesh, node_name=name, geom_name=name, transform=to_place)

    colours = agent_colours(view.num_agents)
    for a, name in enumerate(view.lines.agent_ids):
        curve = rod_curve(view.lines.curve(a), float(view.leaves[a]))
        curve = (curve - [0.0, 0.0, view.begin]) * [1.0, 1.0, pace]
        vertices, triangles = rod_mesh(curve, float(view.radii[a]), _SIDES)
        add(name, vertices, triangles, colours[a])
    if view.free_space is not None:
        height = _WALL_HEIGHT * float(view.radii.min())
        vertices, triangles = wall_mesh(view.free_space, height)
        add("map walls", vertices, triangles, np.array(_WALL_GREY))
        add("map floor", *floor_mesh(view.free_space), np.array(_FLOOR_GREY))
    content: bytes = scene.export(file_type="glb")
    return content


def _origin(view: RunView) -> FloatArray:
    """A place (x, y) near the run, m; the origin itself unless it is further off than the run is wide."""
    places = view.lines.knots[:, :2]
    if view.free_space is not None:
        places = np.vstack([places, view.free_space.boundary_vertices])
    low, high = places.min(axis=0), places.max(axis=0)
    extent = max(float((high - low).max()), 1.0)
    near: FloatArray = extent * np.trunc((low + high) / (2.0 * extent))
    return near


def floor_mesh(free_space: FreeSpace) -> tuple[FloatArray, IntArray]:
    """The floor at height 0, facing upwards: vertices (V, 3) and triangles (F, 3)."""
    corners = triangles_of(free_space.area)
    a, b, c = np.moveaxis(corners, 1, 0)
    clockwise = (b - a)[:, 0] * (c - a)[:, 1] < (b - a)[:, 1] * (c - a)[:, 0]
    corners[clockwise] = corners[clockwise][:, ::-1]
    vertices, place = np.unique(corners.reshape(-1, 2), axis=0, return_inverse=True)
    return np.column_stack([vertices, np.zeros(len(vertices))]), place.reshape(-1, 3)


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
