"""Faces of any shape cover their own area, and nothing hangs between them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from stplan.errors import SceneError
from stplan.maps.mesh.cracks import joined
from stplan.maps.mesh.obj import read_obj, split_face
from stplan.world import FreeSpace, build_free_space
from tests.world.scenes import scene

Points = list[tuple[float, float]]


def obj(points: Points, *faces: list[int], height: str = "0") -> str:
    """OBJ text of points and of faces that count them from 1."""
    lines = [f"v {x!r} {y!r} {height}" for x, y in points]
    return "\n".join(lines + ["f " + " ".join(map(str, face)) for face in faces]) + "\n"


def free(folder: Path, content: str | bytes, name: str = "m.obj") -> FreeSpace:
    """The free space of a mesh file with this content, seen along its z axis."""
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    space = build_free_space(scene(f"{{mesh: {name}, up: z}}", folder=folder))
    assert space is not None
    return space


CONCAVE: dict[str, Points] = {
    "house": [(0, 0), (2, 0), (2, 2), (1, 0.5), (0, 2)],
    "chevron": [(0, 0), (2, 2), (0, 0.5), (-2, 2)],
    "comb": [(0, 0), (7, 0), (7, 3), (6, 3), (6, 1), (4, 1), (4, 3), (3, 3), (3, 1), (1, 1), (1, 3), (0, 3)],
    "straight corners": [(0, 0), (1, 0), (2, 0), (3, 0), (3, 1), (3, 2), (1.5, 2), (0, 2), (0, 1)],
    "half straight": [(0, 0), (1, 0), (2, 0), (1, 1)],
}  # fmt: skip


@pytest.mark.parametrize("name", CONCAVE)
@pytest.mark.parametrize("turned", [False, True])
def test_a_face_covers_its_own_area(tmp_path: Path, name: str, turned: bool) -> None:
    ring = CONCAVE[name]
    for first in range(len(ring)):
        face = [(first + k) % len(ring) + 1 for k in range(len(ring))]
        space = free(tmp_path, obj(ring, face[::-1] if turned else face))
        assert space.polygon.equals(shapely.Polygon(ring))


@settings(max_examples=60, deadline=None)
@given(
    radii=st.lists(st.integers(1, 40), min_size=4, max_size=24),
    shift=st.sampled_from([0.0, 1.0e3, 5.0e5]),
)
def test_star_shaped_faces(radii: list[int], shift: float) -> None:
    angle = 2 * np.pi * np.arange(len(radii)) / len(radii)
    ring = shift + np.array(radii)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    triangles = split_face(ring)
    assert triangles is not None
    pieces = shapely.polygons(ring[np.array(triangles)])
    true = shapely.Polygon(ring)
    assert shapely.area(pieces).sum() == pytest.approx(true.area, rel=1e-7)
    assert shapely.symmetric_difference(shapely.union_all(pieces), true).area < 1e-7 * true.area
    assert set(np.unique(triangles).tolist()) == set(range(len(radii)))


def test_a_face_around_a_hole_is_bridged(tmp_path: Path) -> None:
    ring = [(0, 0), (4, 0), (4, 4), (0, 4), (1, 1), (1, 3), (3, 3), (3, 1)]
    space = free(tmp_path, obj(ring, [1, 2, 3, 4, 1, 5, 6, 7, 8, 5]))
    assert space.polygon.area == 12
    assert len(space.polygon.interiors) == 1


def test_a_face_may_repeat_a_corner(tmp_path: Path) -> None:
    assert (
        free(tmp_path, obj([(0, 0), (4, 0), (4, 2), (0, 2)], [1, 2, 2, 3, 4, 4])).polygon.area == 8
    )


def test_a_large_face_is_split_fast_enough() -> None:
    angle = 2 * np.pi * np.arange(1500) / 1500
    ring = (10 + np.cos(40 * angle))[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    triangles = split_face(ring)
    assert triangles is not None
    assert len(triangles) == 1498


def test_faces_on_edge_have_no_area(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 4 0 0\nv 4 2 0\nv 0 2 0\nv 0 0 1\nv 4 0 1\nf 1 2 3 4\nf 1 2 6 5\n"
    assert free(tmp_path, text).polygon.area == 8


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (
            "v 0 0 0\nv 2 3 0\nv 2 0 0\nv 0 2 0\nf 1 2 3 4\n",
            "has a face that cuts itself in line 5",
        ),
        ("v 0 0 0\nv 2 2 0\nf 1 2\n", "has a face of fewer than three corners in line 3"),
        ("v 0 0\nv 2 2\nv 2 0\nf 1 2 3\n", "cannot be read"),
        ("v 0 0 0\nv 2 2 0\nv 2 0 0\nv 1 0 0\nf 1 2 3 8\n", "faces that refer to vertices"),
        ("v 0 0 0\nv 2 2 0\nv 2 0 0\nv 1 0 0\nf 0 1 2 3\n", "faces that refer to vertices"),
    ],
)
def test_faces_in_doubt_are_refused(tmp_path: Path, text: str, fault: str) -> None:
    with pytest.raises(SceneError, match=rf"^scene:3:\d+: map\.mesh: m\.obj .*{fault}"):
        free(tmp_path, text)


def test_lines_may_continue_and_end_in_any_way() -> None:
    text = b"# caf\xe9\r\nv 0 0 0\r\nv 1 0 0 # here\r\nv 0 \\\r\n1 0\r\nl 1 2\r\nf -3//1 2/7 3\r\n"
    vertices, triangles = read_obj(text, (0, 1))
    assert vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert triangles.tolist() == [[0, 1, 2]]


# A side of one triangle is two sides of its neighbours: their common corner hangs on it.
HANGING = np.array([(0, 0), (3, 1), (1, 3), (1.5, 0.5), (2.5, -2), (0.4, -1.9)])
HANGING_FACES = [[0, 1, 2], [0, 5, 3], [5, 4, 3], [3, 4, 1]]


@pytest.mark.parametrize("turn", np.linspace(0.1, 6.0, 7))
@pytest.mark.parametrize("kind", ["obj", "ply", "off", "stl", "glb"])
def test_a_hanging_corner_leaves_no_wall(tmp_path: Path, turn: float, kind: str) -> None:
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    flat = HANGING @ rotation.T
    mesh = trimesh.Trimesh(np.column_stack([flat, np.zeros(6)]), HANGING_FACES, process=False)
    space = free(tmp_path, mesh.export(file_type=kind), f"m.{kind}")
    assert isinstance(space.polygon, shapely.Polygon)
    assert not space.polygon.interiors
    assert space.clearance(flat[3:4])[0] > 0.3


@pytest.mark.parametrize("decimals", [6, 9, 16])
def test_hanging_corners_leave_no_wall_however_rounded(decimals: int) -> None:
    for turn in np.linspace(0.0, 6.28, 150):
        rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        corners = 4 * np.round(HANGING @ rotation.T, decimals)
        shape = joined(corners, np.array(HANGING_FACES)).area
        assert isinstance(shape, shapely.Polygon)
        assert not shape.interiors
        assert set(map(tuple, shape.exterior.coords)) <= set(map(tuple, corners.tolist()))


@pytest.mark.parametrize("crack", [1e-15, 1e-12, 1e-9, 1e-7])
def test_nearly_equal_corners_leave_no_wall(tmp_path: Path, crack: float) -> None:
    points = [(0, 0), (10, 0), (10, 10), (10 - crack, 10 + crack), (0, 10), (-crack, crack)]
    space = free(tmp_path, obj(points, [1, 2, 3], [6, 4, 5]))
    assert space.polygon.area == pytest.approx(100)
    assert space.clearance(np.array([[5.0, 5.0]]))[0] == pytest.approx(5)


def test_a_true_slit_stays(tmp_path: Path) -> None:
    points = [(0, 0), (10, 0), (10, 10), (0, 0.001), (10, 10.001), (0, 10)]
    assert len(shapely.get_parts(free(tmp_path, obj(points, [1, 2, 3], [4, 5, 6])).polygon)) == 2


def test_closing_cracks_keeps_written_coordinates(tmp_path: Path) -> None:
    text = obj([(0.1, 0.2), (7.654321, 0.2), (7.654321, 7.123457), (0.1, 7.123457), (0.1, 3.3)],
               [1, 2, 3], [1, 3, 5], [5, 3, 4], [1, 2, 4])  # fmt: skip
    corners = {tuple(corner) for corner in free(tmp_path, text).boundary_vertices.tolist()}
    assert corners == {(0.1, 0.2), (7.654321, 0.2), (7.654321, 7.123457), (0.1, 7.123457)}


PLY = """ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y
property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n{}\n{}\n"""


@pytest.mark.parametrize("name", CONCAVE)
@pytest.mark.parametrize("kind", ["ply", "off"])
def test_concave_faces_of_other_files_are_exact_or_refused(
    tmp_path: Path, name: str, kind: str
) -> None:
    ring = CONCAVE[name]
    for first in range(len(ring)):
        face = [len(ring), *((first + k) % len(ring) for k in range(len(ring)))]
        points = "\n".join(f"{x} {y} 0" for x, y in ring)
        row = " ".join(map(str, face))
        text = PLY.format(len(ring), points, row)
        if kind == "off":
            text = f"OFF\n{len(ring)} 1 0\n{points}\n{row}\n"
        try:
            area = free(tmp_path, text, f"m.{kind}").polygon.area
        except SceneError as error:
            fault = str(error)
            area = None
        if area is None:
            refused = "has concave faces; triangles are expected" in fault
            assert refused, fault
            assert "straight" not in name
        else:
            assert area == pytest.approx(shapely.Polygon(ring).area, rel=1e-6)


@pytest.mark.parametrize("kind", ["ply", "off"])
def test_solids_are_not_taken_for_concave_faces(tmp_path: Path, kind: str) -> None:
    for solid in (
        trimesh.creation.box((4, 2, 1)),
        trimesh.creation.cone(2, 3),
        trimesh.creation.icosphere(),
    ):
        assert free(tmp_path, solid.export(file_type=kind), f"m.{kind}").polygon.area > 1
