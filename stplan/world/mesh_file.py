"""Flat meshes from files, through trimesh."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from stplan.arrays import FloatArray, IntArray
from stplan.errors import SceneError
from stplan.scene.model import MeshBase, Scene

MOST_VERTICES = 5_000_000
_KEPT_AXES = {"x": (1, 2), "y": (0, 2), "z": (0, 1)}


def read_flat_mesh(path: Path, up: str) -> tuple[FloatArray, IntArray]:
    """Vertices (V, 2) in m and triangles (F, 3) of a mesh file, the axis `up` dropped.

    Equal vertices are merged, quads split, triangles without area after projection left out.

    Raises:
        SceneError: the file is no mesh, or has no area.
    """
    import trimesh

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            loaded = trimesh.load(path, process=False, skip_materials=True)
            mesh: Any = loaded.to_geometry() if isinstance(loaded, trimesh.Scene) else loaded
        vertices = np.asarray(mesh.vertices, dtype=np.float64)
        triangles = np.asarray(mesh.faces, dtype=np.int64).reshape(-1, 3)
    except KeyboardInterrupt:
        raise
    except Exception as error:  # a hostile file may raise anything at all inside the reader
        raise SceneError(
            f"{path.name} cannot be read as a mesh ({type(error).__name__})"
        ) from error
    if not len(triangles):
        raise SceneError(f"{path.name} has no faces")
    if len(vertices) > MOST_VERTICES:
        raise SceneError(
            f"{path.name} has {len(vertices)} vertices, at most {MOST_VERTICES} are read"
        )
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise SceneError(f"{path.name} has faces that refer to vertices it does not have")
    flat = vertices[:, _KEPT_AXES[up]]
    if not np.isfinite(flat[triangles]).all() or np.abs(flat[triangles]).max() > 1e9:
        raise SceneError(f"{path.name} has vertices that are not finite or absurdly far away")
    flat, place = np.unique(flat, axis=0, return_inverse=True)
    triangles = place.reshape(-1)[triangles]
    a, b, c = (flat[triangles[:, k]] for k in range(3))
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    extent = np.ptp(flat[triangles.ravel()], axis=0).max()
    keep = np.abs(area) > 1e-14 * extent**2
    if not keep.any():
        raise SceneError(f"{path.name} has no area seen along its {up} axis")
    return flat, triangles[keep]


def mesh_polygon(scene: Scene, base: MeshBase) -> shapely.Geometry:
    """The union of a mesh's triangles in the plane."""
    try:
        vertices, triangles = read_flat_mesh(base.path, base.up)
    except SceneError as error:
        raise SceneError(scene.located("map.mesh", str(error))) from error
    corners = vertices[triangles]
    shapes = shapely.polygons(corners)
    if shapely.coverage_is_valid(shapes):
        return shapely.coverage_union_all(shapes)
    return shapely.union_all(shapes)
