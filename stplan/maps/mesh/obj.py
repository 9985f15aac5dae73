"""Faces of Wavefront OBJ text, split so that the floor they cover stays exactly theirs.

A fan, the usual way to split a face, covers too much of a concave face, and leaves a corner that lies
on a straight side hanging: the neighbour ends there, and the crack between them would be a wall.
"""

from __future__ import annotations

from array import array
from io import StringIO
from itertools import pairwise

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.errors import SceneError
from stplan.maps.mesh.counts import check_counts

# A face has no area, and a corner no angle, below this share of the square of the face's extent.
NO_AREA = 1e-13
# Corners of one face: splitting it takes time with the square of them.
MOST_CORNERS = 2000
# Characters of a line, enough for as many.
LONGEST_LINE = 100_000


def read_obj(content: bytes, kept_axes: tuple[int, int]) -> tuple[FloatArray, IntArray]:
    """Vertices (V, 3) and triangles (F, 3) of OBJ text; everything but `v` and `f` is passed over.

    Faces are split as they are seen in the plane of `kept_axes`. References that point nowhere stay
    so: they are below 0 or at least V.

    Raises:
        SceneError: a face has too few corners or cuts itself; the message goes after the file's name.
        ValueError: a line cannot be read.
    """
    # Names and comments may be in any encoding.
    text = content.decode("utf-8", errors="replace").replace("\r\n", "\n").replace("\\\n", " ")
    vertices = array("d")
    faces: list[list[int]] = []
    lines: list[int] = []
    for number, line in enumerate(StringIO(text), start=1):
        if len(line) > LONGEST_LINE:
            raise SceneError(f"has more than {LONGEST_LINE} characters in line {number}")
        words = line.partition("#")[0].split()
        if not words:
            continue
        if words[0] == "v":
            x, y, z = words[1:4]
            vertices.extend((float(x), float(y), float(z)))
        elif words[0] == "f":
            face = [int(word.partition("/")[0]) for word in words[1:]]
            if len(face) < 3:
                raise SceneError(f"has a face of fewer than three corners in line {number}")
            if len(face) > MOST_CORNERS:
                raise SceneError(f"has a face of more than {MOST_CORNERS} corners in line {number}")
            # Negative references count back from the vertex before this line.
            num_vertices = len(vertices) // 3
            faces.append([k - 1 if k >= 0 else num_vertices + k for k in face])
            lines.append(number)
            check_counts(num_vertices, len(faces))
    points = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    check_counts(len(points), 0)
    flat = points[:, kept_axes]
    triangles: list[list[int]] = []
    for face, number in zip(faces, lines, strict=True):
        if len(face) == 3 or min(face) < 0 or max(face) >= len(points):
            triangles.extend([face[0], b, c] for b, c in pairwise(face[1:]))
            continue
        corners = split_face(flat[face])
        if corners is None:
            raise SceneError(f"has a face that cuts itself in line {number}")
        triangles.extend([face[i], face[j], face[k]] for i, j, k in corners)
    return points, np.array(triangles, dtype=np.int64).reshape(-1, 3)


def split_face(corners: FloatArray) -> list[tuple[int, int, int]] | None:
    """Triangles (indices) of a simple polygon (n, 2) that may be concave, by cutting off ears.

    Every corner is a corner of some triangle with area, those on straight sides too. A polygon with
    no area has no triangles, one that cuts itself gives None, and one that is not finite is given
    as a fan, for the caller to refuse.
    """
    if not np.isfinite(corners).all():
        return [(0, k, k + 1) for k in range(1, len(corners) - 1)]
    # Relative to a corner, so that the smallness of areas is that of the face, wherever it lies.
    corners = corners - corners[0]
    least = NO_AREA * float(np.ptp(corners, axis=0).max()) ** 2
    ring = [k for k in range(len(corners)) if (corners[k] != corners[k - 1]).any()]
    area = _doubled_area(corners[ring])
    if abs(area) <= least:
        return []
    if area < 0:
        ring.reverse()
    triangles: list[tuple[int, int, int]] = []
    at = 0
    while len(ring) > 2:
        for offset in range(len(ring)):
            place = (at + offset) % len(ring)
            ear = (ring[place - 1], ring[place], ring[(place + 1) % len(ring)])
            if _is_ear(corners, ring, ear, least):
                break
        else:
            return triangles if abs(_doubled_area(corners[ring])) <= len(ring) * least else None
        triangles.append(ear)
        del ring[place]
        at = place
    return triangles


def _doubled_area(corners: FloatArray) -> float:
    """Twice the area of a polygon (n, 2), negative where it turns right."""
    x, y = corners.T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())


def _is_ear(corners: FloatArray, ring: list[int], ear: tuple[int, int, int], least: float) -> bool:
    """Whether the corner turns left, with area, and no other corner touches its triangle."""
    triangle = corners[list(ear)]
    steps = np.roll(triangle, -1, axis=0) - triangle
    if steps[0, 0] * steps[1, 1] - steps[0, 1] * steps[1, 0] <= least:
        return False
    others = corners[ring]
    # Corners in the same place belong to a bridge to a hole, and touch nothing but each other.
    others = others[(others[:, None] != triangle).any(axis=2).all(axis=1)]
    rise = others[:, None] - triangle
    left = steps[:, 0] * rise[..., 1] - steps[:, 1] * rise[..., 0] >= -least
    return not left.all(axis=1).any()
