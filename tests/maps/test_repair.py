"""Rings that are not simple are mended by a rule, and it is said what was wrong with them and where."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from stplan.errors import SceneError
from stplan.maps.repair import enclosed, even_odd, nonzero
from stplan.world import FreeSpace, build_free_space, warnings_of
from tests.world.scenes import scene

Ring = list[list[float]]

SQUARE = "polygon: [[0, 0], [8, 0], [8, 8], [0, 8]]"
# Name -> ring, area inside by the even-odd rule, area cut out by the nonzero rule, what is said.
RINGS: dict[str, tuple[Ring, float, float, str]] = {
    "bow-tie": (
        [[0, 0], [4, 2], [4, 0], [0, 2]], 4, 4, "touches or crosses itself at (2, 1)",
    ),
    "two rooms that touch": (
        [[0, 0], [6, 0], [6, 2], [3, 2], [5, 5], [1, 5], [3, 2], [0, 2]], 18, 18,
        "touches or crosses itself at (3, 2)",
    ),
    "spike inwards": (
        [[0, 0], [4, 0], [4, 1.5], [4, 0], [7, 0], [7, 3], [0, 3]], 21, 21,
        "runs there and back from (4, 0) to (4, 1.5)",
    ),
    "spike outwards": (
        [[0, 0], [7, 0], [7, 1], [9, 1], [7, 1], [7, 3], [0, 3]], 21, 21,
        "runs there and back from (7, 1) to (9, 1)",
    ),
    "keyhole": (
        [[0, 0], [6, 0], [6, 6], [0, 6], [0, 3], [2, 3], [2, 4], [4, 4], [4, 2], [2, 2], [2, 3], [0, 3]],
        32, 32, "runs there and back from (0, 3) to (2, 3)",
    ),
    "court in a corner": (
        [[0, 0], [6, 0], [6, 6], [0, 6], [0, 0], [1, 4], [4, 1]], 28.5, 28.5,
        "touches or crosses itself at (0, 0)",
    ),
    "loop of the same turn": (
        [[0, 0], [6, 0], [6, 4], [3, 4], [3, 1], [5, 1], [5, 5], [0, 5]], 23, 29,
        "touches or crosses itself at (5, 4)",
    ),
}  # fmt: skip


def free(world: str) -> tuple[FreeSpace, list[str]]:
    """The free space of a map, and the warnings about it."""
    built = scene(f"{{{world}}}")
    space = build_free_space(built)
    assert space.polygon.is_valid
    return space, warnings_of(built, space)


@pytest.mark.parametrize("name", RINGS)
@pytest.mark.parametrize("backwards", [False, True])
def test_an_outer_ring(name: str, backwards: bool) -> None:
    ring, inside, _, said = RINGS[name]
    drawn = ring[::-1] if backwards else ring
    space, (warning,) = free(f"polygon: {[*drawn, drawn[0]]}")
    assert space.area.area == pytest.approx(inside)
    assert warning.startswith("warning: scene:3:7: map.polygon: ")
    assert said.split(" from ")[0] in warning
    for corner in said.partition("(")[2].rstrip(")").split(") to ("):
        assert f"({corner})" in warning
    with pytest.raises(
        SceneError, match=r"map\.polygon: .* a simple ring is expected, or map\.repair"
    ):
        scene(f"{{polygon: {drawn}, repair: false}}")


@pytest.mark.parametrize("name", RINGS)
@pytest.mark.parametrize("as_hole", [False, True])
def test_a_hole_and_an_obstacle(name: str, as_hole: bool) -> None:
    ring, _, cut, _ = RINGS[name]
    key = f"holes: [{ring}]" if as_hole else f"obstacles: [{{polygon: {ring}}}]"
    space, (warning,) = free(f"polygon: [[-5, -5], [15, -5], [15, 15], [-5, 15]], {key}")
    assert space.area.area == pytest.approx(400 - cut)
    assert "map.holes[0]: " in warning if as_hole else "map.obstacles[0]: " in warning
    with pytest.raises(SceneError, match="a simple ring is expected"):
        scene(f"{{polygon: [[-5, -5], [15, -5], [15, 15], [-5, 15]], {key}, repair: false}}")


def test_rings_may_turn_either_way_and_be_closed() -> None:
    ring = [[0, 0], [8, 0], [8, 8], [0, 8]]
    hole = [[2, 2], [3, 2], [3, 3]]
    for outer in (ring, ring[::-1], [*ring, ring[0]]):
        for inner in (hole, hole[::-1], [*hole, hole[0]]):
            space, warnings = free(f"polygon: {outer}, holes: [{inner}]")
            assert space.area.area == 63.5
            assert warnings == []


def test_holes_that_meet_each_other_or_the_edge() -> None:
    near = "[[1, 1], [3, 1], [3, 3], [1, 3]], [[2, 2], [4, 2], [4, 4], [2, 4]]"
    side = "[[1, 5], [2, 5], [2, 6], [1, 6]], [[2, 5], [3, 5], [3, 6], [2, 6]]"
    edge = "[[7, 3], [9, 3], [9, 4], [7, 4]]"
    out = "[[20, 20], [21, 20], [21, 21]]"
    space, warnings = free(f"{SQUARE}, holes: [{near}, {side}, {edge}, {out}]")
    assert space.area.area == pytest.approx(64 - 7 - 2 - 1)
    said = "\n".join(warnings)
    assert "map.holes[1]: meets map.holes[0] at (2.5, 2.5); the two are cut out as one" in said
    assert "map.holes[3]: meets map.holes[2] at (2, 5)" in said
    assert "map.holes[4]: reaches the edge of the polygon at (8, 3); cut out as `obst" in said
    assert "map.holes[5]: lies outside the polygon" in said
    assert len(warnings) == 4
    with pytest.raises(SceneError) as caught:
        scene(f"{{{SQUARE}, holes: [{near}, {side}, {edge}, {out}], repair: false}}")
    assert len(caught.value.messages) == 4
    assert all("`obstacles` may reach its edge" in text for text in caught.value.messages)


def test_holes_that_touch_in_a_corner_are_none_of_our_business() -> None:
    corner = "[[1, 1], [2, 1], [2, 2], [1, 2]], [[2, 2], [3, 2], [3, 3], [2, 3]]"
    space, warnings = free(f"{SQUARE}, holes: [{corner}]")
    assert space.area.area == 62
    assert warnings == []


def test_what_encloses_nothing_is_refused() -> None:
    twice = [[0, 0], [4, 0], [4, 4], [0, 4]] * 2
    with pytest.raises(SceneError, match=r"map\.polygon: has no area"):
        free(f"polygon: {twice}")
    with pytest.raises(SceneError, match=r"map\.holes\[0\]: has no area"):
        free(f"{SQUARE}, holes: [[[1, 1], [2, 2], [4, 4]]]")


@settings(max_examples=80, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), min_size=3, max_size=12))
def test_nothing_becomes_free_that_the_drawing_does_not_enclose(
    ring: list[tuple[int, int]],
) -> None:
    corners = np.array(ring, dtype=float)
    area = {rule: enclosed(corners, rule).area for rule in (even_odd, nonzero)}
    assert all(shapely.is_valid(one) for one in area.values())
    rng = np.random.default_rng(len(ring))
    # Off the lattice and off every line through two of its points.
    points = rng.uniform(0, 9, (300, 2))
    turns = np.arctan2(*(corners[None] - points[:, None]).T[::-1]).T
    steps = np.diff(turns, append=turns[:, :1], axis=1)
    winding = np.rint(((steps + np.pi) % (2 * np.pi) - np.pi).sum(axis=1) / (2 * np.pi)).astype(int)
    for rule, one in area.items():
        inside = shapely.contains_xy(one, points[:, 0], points[:, 1])
        assert (inside == rule(winding)).all()
    assert shapely.difference(area[even_odd], area[nonzero]).area < 1e-9
