"""Flat meshes from files: OBJ is read here, whose faces have any shape, the rest through trimesh."""

from __future__ import annotations

import io
import logging
import warnings
from typing import Any

import numpy as np
import shapely

from stplan.amounts import amount
from stplan.arrays import FloatArray, IntArray
from stplan.errors import SceneError
from stplan.maps.files import FileContent
from stplan.maps.mesh.counts import announced_faces, check_counts
from stplan.maps.mesh.cracks import joined
from stplan.maps.mesh.obj import read_obj
from stplan.maps.reader import Floor, Note

# Triangles may cover the floor so often on average: storeys above one another, a closed surface.
MOST_LAYERS = 64
# Cracks are closed up to these shares of the smallest radius and of the floor's extent.
WELD_RADIUS, WELD_EXTENT = 2e-3, 5e-4
# Cosine between the normals of two pieces of one face that lie on top of each other.
FOLDED = -0.99
# Seen from where an axis points, x and y of the map are these axes of the mesh, times these signs.
_KEPT_AXES = {"x": (1, 2), "y": (0, 2), "z": (0, 1)}
_SIGNS = {"x": (1.0, 1.0), "y": (1.0, -1.0), "z": (1.0, 1.0)}


def read_flat_mesh(file: FileContent, up: str) -> tuple[FloatArray, IntArray]:
    """Vertices (V, 2) in m and triangles (F, 3) of a mesh file, as seen from where the axis `up` points.

    Equal vertices are merged, faces split, triangles without area after projection left out.

    Raises:
        SceneError: the file is no mesh, has no area, or has faces whose area is in doubt; the
            message goes after the file's name.
    """
    content, kind = file.content, file.kind
    try:
        announced = announced_faces(content, kind)
        load = read_obj(content, _KEPT_AXES[up]) if kind == "obj" else _load(content, kind)
        vertices, triangles = load
        check_counts(len(vertices), len(triangles))
        if len(triangles) < announced:
            # Some readers take what they find, however much the head of the file announces.
            raise ValueError("faces are missing")
    except (SceneError, MemoryError):
        raise
    except Exception as error:  # a hostile file may raise anything at all inside the reader
        raise SceneError(
            f"cannot be read: it is damaged, cut short or no {file.path.suffix} mesh"
        ) from error
    if not len(triangles):
        raise SceneError("has no faces")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise SceneError("has faces that refer to vertices it does not have")
    # Adding 0 leaves no -0.
    flat = vertices[:, _KEPT_AXES[up]] * _SIGNS[up] + 0.0
    # Of the axis that is dropped too: normals are computed with it.
    corners = vertices[triangles]
    if not np.isfinite(corners).all() or np.abs(corners).max() > 1e9:
        raise SceneError("has vertices that are not finite or absurdly far away")
    if kind in {"ply", "off"} and _has_folds(vertices, triangles, "xyz".index(up)):
        raise SceneError("has concave faces; triangles are expected, or an OBJ file")
    flat, place = np.unique(flat, axis=0, return_inverse=True)
    triangles = place.reshape(-1)[triangles]
    a, b, c = (flat[triangles[:, k]] for k in range(3))
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    extent = np.ptp(flat[triangles.ravel()], axis=0).max()
    keep = np.abs(area) > 1e-14 * extent**2
    if not keep.any():
        raise SceneError(f"has no area seen along its {up} axis")
    if np.abs(area).sum() / 2 > MOST_LAYERS * float(np.ptp(flat[triangles.ravel()], axis=0).prod()):
        raise SceneError(
            f"has faces on top of one another, more than {MOST_LAYERS} layers "
            "on average; a floor is expected"
        )
    return flat, triangles[keep]


def has_area(file: FileContent, up: str) -> bool:
    """Whether there is a floor to see from where the axis `up` points."""
    try:
        read_flat_mesh(file, up)
    except SceneError:
        return False
    return True


def _load(content: bytes, kind: str) -> tuple[FloatArray, IntArray]:
    """Vertices (V, 3) and triangles (F, 3) as the file has them, no faces if it has only lines."""
    import trimesh

    if kind == "off":
        # Comments may be in any encoding.
        content = content.decode("utf-8", errors="replace").encode()
    logger = logging.getLogger("trimesh")
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            loaded = trimesh.load(
                io.BytesIO(content), file_type=kind, process=False, skip_materials=True
            )
            mesh: Any = loaded.to_geometry() if isinstance(loaded, trimesh.Scene) else loaded
    finally:
        logger.setLevel(level)
    triangles = np.asarray(getattr(mesh, "faces", ()), dtype=np.int64).reshape(-1, 3)
    return np.asarray(mesh.vertices, dtype=np.float64).reshape(-1, 3), triangles


def _has_folds(vertices: FloatArray, triangles: IntArray, up: int) -> bool:
    """Whether triangles come from a concave face that the reader split as a fan.

    Neighbours (a, b, c) and (a, c, d) or (c, d, a) of a fan then lie on top of each other: they
    turn opposite ways in the same plane. Twins that cover the same triangle are no fan.
    """
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1)
    flat = np.abs(normals[:, up]) > 1e-6 * np.maximum(length, np.finfo(float).tiny)
    triangles, normals, length = triangles[flat], normals[flat], length[flat]
    a, b, c = triangles.T
    keys = np.concatenate([a * len(vertices) + b, c * len(vertices) + a])
    beyond = np.concatenate([c, b])
    owner = np.tile(np.arange(len(triangles)), 2)
    order = np.argsort(keys, kind="stable")
    wanted = a * len(vertices) + c
    first = np.searchsorted(keys[order], wanted, side="left")
    last = np.searchsorted(keys[order], wanted, side="right")
    # At a non-manifold side only the first neighbour is looked at.
    here = np.flatnonzero(first < last)
    there = order[first[here]]
    cosine = (normals[here] * normals[owner[there]]).sum(axis=1)
    cosine /= length[here] * length[owner[there]]
    return bool(((cosine < FOLDED) & (beyond[there] != b[here])).any())


def mesh_floor(
    file: FileContent, up: str, radius: float | None = None, weld: float | None = None
) -> Floor:
    """The union of a mesh's triangles in the plane. Raises like `read_flat_mesh`.

    Args:
        radius: of the smallest agent, m, where it is known.
        weld: how wide cracks may be that are closed, m; None: far below the radius and the extent, or what
            rounding leaves where no radius is known.
    """
    vertices, triangles = read_flat_mesh(file, up)
    extent = float(np.ptp(vertices[triangles.ravel()], axis=0).max())
    within = weld or 0.0
    if weld is None and radius is not None:
        within = min(WELD_RADIUS * radius, WELD_EXTENT * extent)
    try:
        found = joined(vertices, triangles, within)
    except shapely.errors.GEOSException as error:
        raise SceneError("has faces too tangled to be joined") from error
    notes: tuple[Note, ...] = ()
    if found.num_welded:
        corners = "1 corner" if found.num_welded == 1 else f"{found.num_welded} corners"
        text = (
            f"{file.path.name}: cracks up to {amount(found.widest)} m wide were closed at {corners}; "
            f"map.weld sets how wide they may be, here {amount(within)} m"
        )
        notes = (Note("map.mesh", text),)
    return Floor(found.area, vertices[triangles], notes=notes)
