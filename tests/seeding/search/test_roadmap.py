"""The roadmap: exact points, true clearances, and every passage wider than an agent."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from stplan.seeding.search.graph import UNREACHABLE, make_graph
from stplan.seeding.search.roadmap import Roadmap, build_roadmap
from stplan.world import FreeSpace


def free_space(outer: list[tuple[float, float]], *holes: list[tuple[float, float]]) -> FreeSpace:
    return FreeSpace.from_polygon(shapely.Polygon(outer, holes))


def connects(roadmap: Roadmap, radius: float, start: int = 0, goal: int = 1) -> bool:
    free = roadmap.graph.free_moves(radius)
    hops = roadmap.graph.hops_to(int(roadmap.place_of[goal]), free)
    return bool(hops[roadmap.place_of[start]] < UNREACHABLE)


ROOM_WITH_BLOCK = free_space([(0, 0), (10, 0), (10, 6), (0, 6)], [(4, 2), (6, 2), (6, 4), (4, 4)])
ENDS = np.array([[1.0, 3.0], [9.0, 3.0]])


def test_exact_points_are_vertices_to_the_last_bit() -> None:
    exact = np.array([[1.0 / 3.0, 1.0 + 1e-13], [9.0 - 1.0 / 7.0, 3.0], [1.0 / 3.0, 1.0 + 1e-13]])
    roadmap = build_roadmap(ROOM_WITH_BLOCK, exact, np.array([0.3]))
    assert np.array_equal(roadmap.graph.vertices[roadmap.place_of], exact)
    assert roadmap.place_of[0] == roadmap.place_of[2]


def test_free_edges_keep_their_radius_from_the_walls() -> None:
    radii = np.array([0.3, 0.7])
    graph = build_roadmap(ROOM_WITH_BLOCK, ENDS, radii).graph
    walls = ROOM_WITH_BLOCK.polygon.boundary
    share = np.linspace(0, 1, 33)[:, None, None]
    head, tail = graph.vertices[graph.edges[:, 0]], graph.vertices[graph.edges[:, 1]]
    samples = shapely.points(head + share * (tail - head))
    sampled = shapely.distance(samples, walls).min(axis=0)
    inside = shapely.contains(ROOM_WITH_BLOCK.polygon, samples).all(axis=0)
    for radius in radii:
        free = graph.free_moves(radius)[graph.num_vertices : graph.num_vertices + len(graph.edges)]
        assert free.any()
        assert not free.all() or radius == radii[0]
        assert inside[free].all()
        assert (sampled[free] > radius).all()


@pytest.mark.parametrize(
    ("half_width", "refine"), [(1.003, 1.0), (1.01, 1.0), (1.05, 1.0), (1.5, 1.0), (3.0, 1.0)]
)
def test_every_passage_wider_than_the_agent_is_connected(half_width: float, refine: float) -> None:
    radius = 0.4
    half = half_width * radius
    # A bent corridor of constant width between two rooms.
    middle = shapely.LineString([(0, 0), (4, 0.5), (6, 3), (11, 3.3)])
    corridor = middle.buffer(half, cap_style="flat", join_style="mitre")
    rooms = [shapely.Point(0, 0).buffer(1.2), shapely.Point(11, 3.3).buffer(1.2)]
    space = FreeSpace.from_polygon(shapely.union_all([corridor, *rooms]))
    ends = np.array([[0.0, 0.0], [11.0, 3.3]])
    roadmap = build_roadmap(space, ends, np.array([radius]), refine=refine)
    assert connects(roadmap, radius)


def test_a_passage_narrower_than_the_agent_is_not() -> None:
    walls = free_space([(0, 0), (10, 0), (10, 6), (0, 6)], [(4, 0.7), (6, 0.7), (6, 5.3), (4, 5.3)])
    roadmap = build_roadmap(walls, ENDS, np.array([0.3, 0.36]))
    assert connects(roadmap, 0.3)
    assert not connects(roadmap, 0.36)


def test_corners_of_obstacles_are_passed_on_mitred_rings() -> None:
    radius = 0.5
    graph = build_roadmap(ROOM_WITH_BLOCK, ENDS, np.array([radius])).graph
    # The offset corner is sqrt(2) offsets away from the block's corner, along the diagonal.
    away = graph.vertices - [4.0, 2.0]
    on_diagonal = np.isclose(away[:, 0], away[:, 1], atol=1e-9) & (away[:, 0] < 0)
    offsets = -away[on_diagonal, 0]
    assert np.any((offsets > radius) & (offsets < 1.05 * radius))


def test_the_open_plane_has_room_around_the_ends() -> None:
    roadmap = build_roadmap(None, ENDS, np.array([0.3]), around=2.0)
    assert np.isinf(roadmap.graph.clearance).all()
    assert roadmap.graph.vertices[:, 1].min() < 1.5
    assert roadmap.graph.vertices[:, 1].max() > 4.5
    assert connects(roadmap, 0.3)


def test_a_large_map_is_covered_coarsely_and_graded_near_the_ends() -> None:
    size = 2000.0
    space = free_space([(0, 0), (size, 0), (size, size), (0, size)])
    ends = np.array([[10.0, 10.0], [1990.0, 1990.0]])
    roadmap = build_roadmap(space, ends, np.array([0.5]))
    assert roadmap.graph.num_vertices < 20000
    length = roadmap.graph.length[roadmap.graph.num_vertices :]
    assert np.median(length) > 5.0
    near = np.hypot(*(roadmap.graph.vertices - ends[0]).T)
    assert ((near > 0) & (near < 2.0)).any()
    assert connects(roadmap, 0.5)


def test_agents_that_ignore_walls_get_edges_through_them() -> None:
    space = free_space([(0, 0), (10, 0), (10, 6), (0, 6)], [(4, -1), (6, -1), (6, 7), (4, 7)])
    roadmap = build_roadmap(space, ENDS, np.array([0.3]), ignores_walls=True)
    assert not connects(roadmap, 0.3)
    assert connects(roadmap, -np.inf)


def test_collinear_points_in_the_open_plane_are_linked() -> None:
    graph = make_graph(
        np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]),
        np.array([[0, 1], [1, 2]]),
        np.full(5, np.inf),
    )
    assert graph.hops_to(2, graph.free_moves(0.1)).tolist() == [2, 1, 0]


def test_the_same_input_gives_the_same_bytes() -> None:
    first, second = (build_roadmap(ROOM_WITH_BLOCK, ENDS, np.array([0.3])).graph for _ in range(2))
    assert first.vertices.tobytes() == second.vertices.tobytes()
    assert first.edges.tobytes() == second.edges.tobytes()
    assert first.clearance.tobytes() == second.clearance.tobytes()
