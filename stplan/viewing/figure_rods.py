"""The run in space and time: every agent a rod, time upwards."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import LightSource, to_rgb
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D

from stplan.arrays import FloatArray
from stplan.viewing.drawing import FAINT, WALL, view_box
from stplan.viewing.palette import hex_colours
from stplan.viewing.rod_meshes import rod_curve, rod_mesh
from stplan.viewing.run_view import RunView

# Up to so many agents: sides of a rod, and the most rings it is drawn with.
_DETAIL = ((10, 32, 80), (40, 16, 60), (1000, 7, 24), (np.inf, 3, 8))
# Height of the picture over the map's longer side.
_HEIGHT = 0.85


def draw_rods(axes: Axes3D, view: RunView) -> None:
    """Fill `axes` with the rods of `view` over its map."""
    xmin, ymin, xmax, ymax = view_box(view)
    axes.set_xlim(xmin, xmax)
    axes.set_ylim(ymin, ymax)
    axes.set_zlim(view.begin, max(view.end, view.begin + 1e-9))
    wide = max(xmax - xmin, ymax - ymin)
    axes.set_box_aspect((xmax - xmin, ymax - ymin, _HEIGHT * wide), zoom=1.1)
    axes.view_init(elev=24, azim=-58)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.pane.set_visible(False)
        axis.line.set_color(FAINT)
    axes.grid(False)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.set_title("Rods, time upwards in s")
    _, sides, rings = next(detail for detail in _DETAIL if view.num_agents <= detail[0])
    faces, colours = [], []
    light = LightSource(azdeg=300, altdeg=40)
    # In the picture the time axis is as long as `_HEIGHT` says; light falls on the picture.
    stretch = _HEIGHT * wide / max(view.end - view.begin, 1e-9)
    for a, colour in enumerate(hex_colours(view.num_agents)):
        curve = _with_few_knots(rod_curve(view.lines.curve(a), float(view.leaves[a])), rings)
        vertices, triangles = rod_mesh(curve, float(view.radii[a]), sides)
        corners = vertices[triangles]
        faces.append(corners)
        shown = corners * [1.0, 1.0, stretch]
        normals = np.cross(shown[:, 1] - shown[:, 0], shown[:, 2] - shown[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        shade = 0.72 + 0.4 * np.clip(normals @ light.direction, 0.0, 1.0)
        colours.append(np.clip(np.outer(shade, to_rgb(colour)), 0.0, 1.0))
    _draw_map(axes, view)
    axes.add_collection3d(
        Poly3DCollection(
            np.concatenate(faces), facecolors=np.concatenate(colours),
            edgecolors=np.concatenate(colours), linewidths=0.3, rasterized=True,
        )
    )  # fmt: skip


def _with_few_knots(curve: FloatArray, most: int) -> FloatArray:
    if len(curve) <= most:
        return curve
    return curve[np.unique(np.linspace(0, len(curve) - 1, most).astype(int))]


def _draw_map(axes: Axes3D, view: RunView) -> None:
    if view.free_space is None:
        return
    walls = view.free_space.boundary_segments.reshape(-1, 2, 2)
    floor = np.full((*walls.shape[:2], 1), view.begin)
    axes.add_collection3d(
        Line3DCollection(np.concatenate([walls, floor], axis=2), colors=WALL, linewidths=0.7)
    )
