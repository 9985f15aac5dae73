"""Meshes are seen from where their `up` axis points, never in a mirror, whatever their format."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely
import trimesh

from stplan.errors import SceneError
from stplan.world import build_free_space, fitted_free_space, warnings_of
from tests.world.scenes import scene

# An L with arms of unequal length: no turn and no mirror maps it to itself.
CORNERS = np.array([(0, 0), (7, 0), (7, 2), (3, 2), (3, 5), (0, 5)], dtype=float)
L_SHAPE = shapely.Polygon(CORNERS)
FACES = [[0, 1, 3], [1, 2, 3], [0, 3, 5], [3, 4, 5]]
OUTSIDE = "  - {id: a, start: [1, 1], goal: [5, 4], radius: 0.3}"
KINDS = ["obj", "ply", "off", "stl", "glb"]
# Right, forward and up of the map in the mesh: a right-handed frame each.
FRAMES = {
    "x": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
    "y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
}


def write(folder: Path, kind: str, up: str, height: float = 0.25, thickness: float = 0.0) -> None:
    """The L as `m.kind`, lying at a height over the plane that `up` is normal to."""
    flat = trimesh.Trimesh(np.column_stack([CORNERS, np.full(6, height)]), FACES, process=False)
    solid = flat
    if thickness:
        solid = trimesh.creation.extrude_triangulation(CORNERS, np.array(FACES), thickness)
    right, forward, upwards = np.array(FRAMES[up], dtype=float)
    assert np.linalg.det([right, forward, upwards]) == pytest.approx(1.0)
    solid.vertices = solid.vertices @ np.array([right, forward, upwards])
    (folder / f"m.{kind}").write_bytes(_bytes(solid.export(file_type=kind)))


def _bytes(content: str | bytes) -> bytes:
    return content if isinstance(content, bytes) else content.encode()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("up", FRAMES)
def test_the_floor_lies_as_seen_from_above(tmp_path: Path, kind: str, up: str) -> None:
    write(tmp_path, kind, up)
    space = build_free_space(scene(f"{{mesh: m.{kind}, up: {up}}}", folder=tmp_path))
    assert shapely.symmetric_difference(space.polygon, L_SHAPE).area < 1e-4


@pytest.mark.parametrize("kind", KINDS)
def test_the_axis_that_a_format_has_by_itself(tmp_path: Path, kind: str) -> None:
    write(tmp_path, kind, "y" if kind == "glb" else "z")
    built = scene(f"{{mesh: m.{kind}}}", folder=tmp_path)
    space = build_free_space(built)
    assert shapely.symmetric_difference(space.polygon, L_SHAPE).area < 1e-4
    assert warnings_of(built, space) == []


def test_whoever_relied_on_the_mirror_image_is_warned(tmp_path: Path) -> None:
    write(tmp_path, "obj", "y")
    built = scene("{mesh: m.obj, up: y}", folder=tmp_path)
    (warning,) = warnings_of(built, build_free_space(built))
    assert warning.startswith("warning: scene:3:20: map.up: m.obj: the map's y is the mesh's -z")
    assert "mirror" in warning
    with pytest.raises(SceneError) as caught:
        fitted_free_space(scene("{mesh: m.obj, up: y}", agents=OUTSIDE, folder=tmp_path))
    outside, why = caught.value.messages
    assert "(5, 4) lies outside the free space" in outside
    assert why.endswith(warning.partition("map.up: ")[2])


def test_where_the_mirror_image_is_the_same_nobody_is_warned(tmp_path: Path) -> None:
    text = "v -2 0 -1\nv 2 0 -1\nv 2 0 1\nv -2 0 1\nf 1 2 3 4\n"
    (tmp_path / "m.obj").write_text(text)
    built = scene("{mesh: m.obj, up: y}", folder=tmp_path)
    assert warnings_of(built, build_free_space(built)) == []


def test_a_flat_glb_with_z_up_is_refused_with_the_remedy(tmp_path: Path) -> None:
    write(tmp_path, "glb", "z")
    with pytest.raises(SceneError, match=r"no area seen along its y axis; .* `up: z`"):
        build_free_space(scene("{mesh: m.glb}", folder=tmp_path))


def test_a_glb_that_could_be_meant_either_way_is_read_by_the_standard(tmp_path: Path) -> None:
    write(tmp_path, "glb", "y", thickness=0.5)
    built = scene("{mesh: m.glb}", folder=tmp_path)
    space = build_free_space(built)
    assert shapely.symmetric_difference(space.polygon, L_SHAPE).area < 1e-4
    (warning,) = warnings_of(built, space)
    assert "y points up by the standard of glTF" in warning
    said = scene("{mesh: m.glb, up: y}", folder=tmp_path)
    assert said.content_hash == built.content_hash
