"""Ends that move in their places."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from stplan.certify.places import distance_outside
from stplan.nlp.constraints import Constraints, HalfPlanes
from stplan.optimize.free_ends import as_bounds, convex_part, into_place
from stplan.planner import check, plan, seed
from stplan.scene import parse_scene
from stplan.scene.places import Place

STAR = Place(
    "star",
    tuple(
        (r * np.cos(a), r * np.sin(a))
        for a, r in zip(np.arange(10) * np.pi / 5, [3.0, 1.2] * 5, strict=True)
    ),
    area=True,
)
SQUARE = Place("square", ((0.0, 0.0), (0.0, 2.0), (2.0, 2.0), (2.0, 0.0)), area=True)
BENT = Place("bent", ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0)), area=False)


def polygon_of(place: Place, point: tuple[float, float]) -> shapely.Geometry:
    """The convex part of a place around a point, cut out of a large box."""
    normals, least, greatest = convex_part(place, np.array(point))
    shape = shapely.box(-50, -50, 50, 50)
    for normal, low, high in zip(normals, least, greatest, strict=True):
        side = np.array([-normal[1], normal[0]])
        for direction, bound in ((normal, high), (-normal, -low)):
            if bound < 1e9:
                foot = direction * bound
                shape &= shapely.Polygon(
                    [foot + 99 * side, foot - 99 * side, foot - 99 * side - 99 * direction,
                     foot + 99 * side - 99 * direction]
                )  # fmt: skip
    return shape


@pytest.mark.parametrize("point", [(0.1, 0.2), (2.0, 0.1), (-0.9, 0.4), (0.6, -1.5)])
def test_the_part_of_an_area_is_convex_inside_it_and_around_the_point(
    point: tuple[float, float],
) -> None:
    part = polygon_of(STAR, point)
    assert STAR.shape().buffer(1e-6).covers(part)
    assert part.buffer(1e-9).covers(shapely.Point(point))
    assert part.area > 0.15


@pytest.mark.parametrize("point", [(0.5, 1.5), (1.0, 2.0), (2.0, 0.0)])
def test_a_convex_place_is_its_own_part(point: tuple[float, float]) -> None:
    assert polygon_of(SQUARE, point).area == pytest.approx(4.0)


def test_a_line_gives_its_straight_piece() -> None:
    normals, least, greatest = convex_part(BENT, np.array([4.0, 1.0]))
    ends = [normals @ [4.0, 0.0], normals @ [4.0, 3.0]]
    for end in ends:
        assert (end >= least - 1e-12).all()
        assert (end <= greatest + 1e-12).all()
    assert not (normals @ [3.9, 1.0] >= least).all() or not (normals @ [3.9, 1.0] <= greatest).all()


def test_planes_along_axes_become_bounds() -> None:
    normals, least, greatest = convex_part(SQUARE, np.array([1.0, 0.5]))
    planes = HalfPlanes(np.zeros(4, dtype=np.int64), normals, least, greatest)
    lower, upper = np.full((1, 3), -2e19), np.full((1, 3), 2e19)
    assert not len(as_bounds(planes, lower, upper).knots)
    assert lower[0, :2].tolist() == [0, 0]
    assert upper[0, :2].tolist() == [2, 2]
    slanted = HalfPlanes(
        np.zeros(1, dtype=np.int64), np.array([[0.6, 0.8]]), np.array([-2e19]), np.array([1.0])
    )
    assert len(as_bounds(slanted, lower, upper).knots) == 1
    nothing = np.empty(0, dtype=np.int64)
    held = Constraints(
        lower, upper, np.empty(0), nothing, nothing.reshape(0, 2), np.empty(0), slanted
    )
    moved = into_place(held, np.array([[1.0, 1.0, 5.0]]))
    assert slanted.normals[0] @ moved[0, :2] == pytest.approx(1.0)
    # Straight back would lead below the square.
    low = into_place(held, np.array([[2.0, 0.0, 5.0]]))[0]
    assert low[1] >= 0.0
    assert slanted.normals[0] @ low[:2] == pytest.approx(1.0, abs=0.03)
    inside = np.array([[0.0, 0.0, 5.0]])
    assert into_place(held, inside) is inside


SLANTED = """\
stplan: 1
horizon: 20
map: {rectangle: [0, 0, 12, 12]}
places: {exit: {line: [[4, 11], [11, 4]]}, lawn: {polygon: [[9, 1], [11, 1], [11, 3]]}}
defaults: {after_arrival: vanish}
agents:
  - {id: a, start: [1, 2], goal: {place: exit}}
  - {id: b, start: [2, 1], goal: {place: exit}}
  - {id: c, start: [1, 1], goal: {place: lawn}}
"""


def test_ends_move_to_where_they_are_cheapest() -> None:
    scene = parse_scene(SLANTED)
    first = seed(scene)
    found = plan(scene)
    assert found.certificate.holds
    assert found.trajectories is not None
    assert check(scene, found.trajectories).holds
    # Alone, everybody would go straight across: two thirds of a metre apart both almost can.
    ends = found.trajectories.knots[found.trajectories.offsets[1:] - 1, :2]
    straight = np.array([[7.0, 8.0], [8.0, 7.0]])
    assert np.abs(ends[:2] - straight).max() < 0.3
    places = {place.name: place for place in scene.places}
    for end, name in zip(ends, ("exit", "exit", "lawn"), strict=True):
        assert distance_outside(places[name], end) < 1e-7
    lengths = [
        np.hypot(*np.diff(lines.curve(2)[:, :2], axis=0).T).sum()
        for lines in (first.seed, found.trajectories)
    ]
    assert lengths[1] < lengths[0]


def test_the_certificate_knows_the_place() -> None:
    scene = parse_scene(SLANTED)
    found = plan(scene)
    assert found.trajectories is not None
    knots = found.trajectories.knots.copy()
    knots[found.trajectories.offsets[3] - 1, :2] = [8.0, 1.5]
    broken = check(scene, found.trajectories.with_knots(knots))
    assert not broken.holds
    assert "c: ends at (8, 1.5), 1.12 m outside place lawn" in broken.violations[0]


def test_what_a_plan_costs_at_least_holds_for_any_end() -> None:
    found = plan(parse_scene(SLANTED))
    bound = found.report.bound
    assert bound is not None
    # Straight to the line, in 20 s: what the two pay at least, wherever they end.
    assert bound.least[:2] == pytest.approx([0.5 * (12 / np.sqrt(2)) ** 2 / 20.0] * 2, rel=1e-6)
    assert (bound.least <= bound.costs).all()
