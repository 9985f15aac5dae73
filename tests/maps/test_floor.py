"""The area of a map: obstacles are cut out of it all at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from stplan.errors import SceneError
from stplan.maps.floor import polygons, read_floor
from stplan.maps.obstacles import CircleObstacle, PolygonObstacle
from stplan.maps.polygon import PolygonBase
from stplan.maps.spec import MapSpec
from stplan.world import build_free_space
from tests.world.scenes import scene

SQUARE = PolygonBase(((0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)))


def box(x: float, y: float, width: float, height: float) -> PolygonObstacle:
    """A rectangle by its corner and sizes."""
    return PolygonObstacle(((x, y), (x + width, y), (x + width, y + height), (x, y + height)))


def test_obstacles_one_by_one_leave_the_same() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        corners, sizes = rng.uniform(-1, 10, (30, 2)), rng.uniform(0.1, 2, (30, 2))
        obstacles = [box(*corners[k], *sizes[k]) for k in range(25)]
        obstacles += [CircleObstacle(tuple(corners[k]), sizes[k, 0]) for k in range(25, 30)]
        area = shapely.box(0, 0, 10, 10)
        for shape in polygons([obstacle.outline() for obstacle in obstacles]):
            area = shapely.difference(area, shape)
        whole = read_floor(MapSpec(SQUARE, tuple(obstacles))).area
        assert shapely.symmetric_difference(area, whole).area < 1e-12
        assert len(shapely.get_parts(area)) == len(shapely.get_parts(whole))


def test_many_obstacles_take_one_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    cuts = []
    cut = shapely.difference
    monkeypatch.setattr(shapely, "difference", lambda *args: cuts.append(1) or cut(*args))
    cells = [box(x, y, 1, 1) for x in range(60) for y in range(60) if (x * y) % 7 < 3]
    outer = PolygonBase(((0.0, 0.0), (60.0, 0.0), (60.0, 60.0), (0.0, 60.0)))
    floor = read_floor(MapSpec(outer, tuple(cells)))
    assert floor.area.area == 3600 - len(cells)
    assert len(cuts) == 1


def test_the_obstacle_at_fault_is_named() -> None:
    crossed = PolygonObstacle(((0, 0), (5, 5), (5, 0), (0, 5)))
    spec = MapSpec(SQUARE, (box(1, 1, 1, 1), crossed))
    (note,) = read_floor(spec).notes
    assert note.path == "map.obstacles[1]"
    with pytest.raises(SceneError, match=r"crosses itself at \(2\.5, 2\.5\)") as caught:
        read_floor(replace(spec, repair=False))
    assert caught.value.path == "map.obstacles[1]"
    flat = PolygonObstacle(((0, 0), (5, 5), (2, 2)))
    with pytest.raises(SceneError, match="has no area") as caught:
        read_floor(MapSpec(SQUARE, (flat, box(1, 1, 1, 1))))
    assert caught.value.path == "map.obstacles[0]"


def test_a_ring_of_many_corners_is_read_and_keeps_its_corners() -> None:
    angle = 2 * np.pi * np.arange(20_000) / 20_000
    reach = 100 + np.sin(40 * angle)
    ring = np.round(reach[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]), 4)
    text = ", ".join(f"[{x}, {y}]" for x, y in ring.tolist())
    space = build_free_space(scene(f"{{polygon: [{text}]}}"))
    found = set(map(tuple, space.boundary_vertices.tolist()))
    assert found <= set(map(tuple, ring.tolist()))
    assert space.polygon.equals(shapely.Polygon(ring))
