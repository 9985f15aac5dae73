"""The free space against areas and distances known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from stplan.errors import SceneError
from stplan.maps.obstacles import CIRCLE_SIDES
from stplan.world import build_free_space, eroded
from tests.world.scenes import scene

BOX = "rectangle: [0, 0, 10, 4]"


def free(world: str):
    """The free space of a map."""
    return build_free_space(scene(f"{{{world}}}"))


def test_the_open_plane_has_none() -> None:
    assert build_free_space(scene()) is None


def test_area_with_holes_and_obstacles() -> None:
    ring = "polygon: [[0, 0], [10, 0], [10, 4], [0, 4]]"
    space = free(f"{ring}, holes: [[[1, 2], [2, 2], [2, 3]]]")
    assert space.polygon.area == pytest.approx(39.5)
    assert len(space.boundary_edges) == 7
    cut = free(f"{BOX}, obstacles: [{{rectangle: [4, -1, 6, 3]}}, {{rectangle: [5, 0, 7, 1]}}]")
    assert cut.polygon.area == pytest.approx(40 - 6 - 1)
    assert shapely.length(cut.boundary) == pytest.approx(cut.polygon.length)


def test_an_obstacle_across_leaves_two_parts() -> None:
    space = free(f"{BOX}, obstacles: [{{rectangle: [4, -1, 6, 5]}}]")
    assert len(shapely.get_parts(space.polygon)) == 2
    assert space.clearance(np.array([[5.0, 2.0], [1.0, 2.0]])).tolist() == [-1.0, 1.0]


def test_a_circle_is_contained_in_its_polygon() -> None:
    space = free(f"{BOX}, obstacles: [{{circle: {{center: [5, 2], radius: 1}}}}]")
    angle = np.linspace(0, 2 * np.pi, 5000)
    disc = np.array([5.0, 2.0]) + (1 - 1e-12) * np.column_stack([np.cos(angle), np.sin(angle)])
    assert not space.contains(disc).any()
    assert space.polygon.area == pytest.approx(40 - CIRCLE_SIDES * np.tan(np.pi / CIRCLE_SIDES))


def test_clearance_is_signed() -> None:
    space = free(BOX)
    points = np.array([[5, 1], [9.5, 2], [-3, -4], [12, 2], [0, 2], [5, 2]], dtype=float)
    assert space.clearance(points) == pytest.approx([1, 0.5, -5, -2, 0, 2])
    assert space.contains(points).tolist() == [True, True, False, False, False, True]
    assert space.clearance(np.empty((0, 2))).shape == (0,)


def test_segment_clearance() -> None:
    space = free(f"{BOX}, obstacles: [{{rectangle: [4, 1, 6, 2]}}]")
    starts = np.array([[1, 1], [1, 1.5], [4.5, 1.5], [11, 1], [1, 1], [2, 2]], dtype=float)
    ends = np.array([[3, 1], [9, 1.5], [5.5, 1.5], [12, 1], [1, 1], [4, 3]], dtype=float)
    room = space.segment_clearance(starts, ends)
    assert room[[0, 4]] == pytest.approx([1, 1])
    assert room[5] == pytest.approx(2 / np.sqrt(5))  # The corner (4, 2) to the line of slope 1/2.
    assert (room[1:4] < 0).all()


def test_clearance_against_brute_force() -> None:
    space = free(f"{BOX}, obstacles: [{{circle: {{center: [5, 2], radius: 1.2}}}}]")
    points = np.random.default_rng(5).uniform([-1, -1], [11, 5], (300, 2))
    head, tail = space.boundary_segments[:, :2], space.boundary_segments[:, 2:]
    step = tail - head
    along = ((points[:, None] - head) * step).sum(axis=2) / (step**2).sum(axis=1)
    near = head + np.clip(along, 0, 1)[..., None] * step
    distance = np.linalg.norm(points[:, None] - near, axis=2).min(axis=1)
    assert np.abs(space.clearance(points)) == pytest.approx(distance, abs=1e-12)


@pytest.mark.parametrize(
    "obstacle", ["rectangle: [-1, -1, 11, 5]", "circle: {center: [5, 2], radius: 6}"]
)
def test_nothing_left(obstacle: str) -> None:
    with pytest.raises(SceneError, match=r"^scene:\d+:\d+: map: has no area left to move in"):
        free(f"{BOX}, obstacles: [{{{obstacle}}}]")


def test_erosion_is_quiet_and_exact() -> None:
    space = free(BOX)
    assert eroded(space.polygon, 1.0).area == pytest.approx(8 * 2)
    assert eroded(space.polygon, 3.0).is_empty
    shapes = [
        shapely.box(x, y, x + 1, y + 1) for x in range(5) for y in range(5) if (x * y) % 3 < 2
    ]
    joined = shapely.union_all(shapes)
    for radius in np.linspace(0.01, 2.0, 60):
        inner = eroded(joined, float(radius), quad_segs=32)
        assert inner.is_empty or joined.contains(inner)
