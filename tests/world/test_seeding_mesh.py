"""What every seeding mesh promises."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from stplan.scene.model import Agent, Scene
from stplan.world import SeedingMesh, build_free_space, build_seeding_mesh
from stplan.world.seeding_mesh import MOST_VERTICES
from tests.world.scenes import scene

AGENTS = """\
  - {id: a, start: [1.1, 1.3], goal: [8.7, 3.1], waypoints: [[5, 3.3], [1.1, 1.3]], radius: 0.3}
  - {id: b, start: [8.7, 3.1], goal: [1.1000001, 1.3], radius: 0.4, start_time: 1}
"""
WORLDS = {
    "open": "",
    "rectangle": "{rectangle: [0, 0, 10, 4]}",
    "obstacle": "{rectangle: [0, 0, 10, 4], "
    "obstacles: [{circle: {center: [5, 1.5], radius: 0.6}}, {rectangle: [6.5, 2, 6.6, 5]}]}",
    "coarse": "{rectangle: [0, 0, 10, 4], resolution: 8, "
    "obstacles: [{circle: {center: [3, 2], radius: 0.05}}]}",
    "fine": "{rectangle: [0, 0, 10, 4], resolution: 0.001}",
    "mesh": "{mesh: m.obj, resolution: 0.5}",
}


@pytest.fixture(params=WORLDS)
def built(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Scene, SeedingMesh]:
    """A scene and its mesh."""
    (tmp_path / "m.obj").write_text(
        "v 0 0 0\nv 10 0 0\nv 10 4 0\nv 0 4 0\nv 4.25 1.75 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"
    )
    made = scene(WORLDS[request.param], AGENTS, tmp_path)
    return made, build_seeding_mesh(made, build_free_space(made))


def vertices_of(mesh: SeedingMesh, agent: Agent) -> list[int]:
    """The vertices of an agent's stops, which are there to the last bit."""
    stops = np.array([agent.start, *agent.waypoints, agent.goal])
    hits = (mesh.vertices[None] == stops[:, None]).all(axis=2)
    assert (hits.sum(axis=1) == 1).all()
    return hits.argmax(axis=1).tolist()


def test_stops_are_exact(built: tuple[Scene, SeedingMesh]) -> None:
    made, mesh = built
    for agent in made.agents:
        assert len(vertices_of(mesh, agent)) == len(agent.waypoints) + 2
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices)


def test_edges_are_canonical_and_inside(built: tuple[Scene, SeedingMesh]) -> None:
    made, mesh = built
    edges = mesh.edges
    assert edges.dtype == np.int64
    assert (edges[:, 0] < edges[:, 1]).all()
    assert np.array_equal(np.unique(edges, axis=0), edges)
    step = np.diff(mesh.vertices[edges], axis=1)[:, 0]
    assert mesh.lengths == pytest.approx(np.hypot(*step.T))
    assert (mesh.edge_clearance > 0).all()
    space = build_free_space(made)
    if space is not None:
        assert shapely.covers(space.polygon, shapely.linestrings(mesh.vertices[edges])).all()


def test_clearance_is_the_distance_to_the_walls(built: tuple[Scene, SeedingMesh]) -> None:
    made, mesh = built
    space = build_free_space(made)
    if space is None:
        assert np.isinf(mesh.vertex_clearance).all()
        assert np.isinf(mesh.edge_clearance).all()
        return
    picked = np.random.default_rng(1).integers(len(mesh.edges), size=40)
    walls = space.polygon.boundary
    for edge in picked.tolist():
        line = shapely.LineString(mesh.vertices[mesh.edges[edge]])
        assert mesh.edge_clearance[edge] == pytest.approx(line.distance(walls), abs=1e-12)
        vertex = mesh.edges[edge, 0]
        point = shapely.Point(mesh.vertices[vertex])
        assert mesh.vertex_clearance[vertex] == pytest.approx(point.distance(walls), abs=1e-12)


def test_every_agent_finds_a_way_at_its_radius(built: tuple[Scene, SeedingMesh]) -> None:
    made, mesh = built
    assert len(mesh.vertices) <= MOST_VERTICES
    for agent in made.agents:
        free = mesh.edges[mesh.edge_clearance > agent.radius]
        shape = (len(mesh.vertices),) * 2
        graph = coo_array((np.ones(len(free)), (free[:, 0], free[:, 1])), shape=shape)
        parts = connected_components(graph, directed=False)[1]
        assert len(set(parts[vertices_of(mesh, agent)].tolist())) == 1


def test_the_same_scene_gives_the_same_mesh(built: tuple[Scene, SeedingMesh]) -> None:
    made, mesh = built
    again = build_seeding_mesh(made, build_free_space(made))
    for name in SeedingMesh.__dataclass_fields__:
        assert np.array_equal(getattr(mesh, name), getattr(again, name)), name


def test_vertices_of_the_map_are_kept_and_refined(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text(
        "v 0 0 0\nv 10 0 0\nv 10 4 0\nv 0 4 0\nv 4.25 1.75 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"
    )
    made = scene(WORLDS["mesh"], AGENTS, tmp_path)
    mesh = build_seeding_mesh(made, build_free_space(made))
    assert [4.25, 1.75] in mesh.vertices.tolist()
    assert np.median(mesh.lengths) < 0.5
    assert mesh.lengths.max() < 4 * 0.6 + 1e-9


def test_a_single_resting_agent_in_the_open_plane() -> None:
    made = scene("", "  - {id: a, start: [1, 1], goal: [1, 1], radius: 0.3}")
    mesh = build_seeding_mesh(made, None)
    assert len(set(vertices_of(mesh, made.agents[0]))) == 1
    assert len(mesh.edges) > 10
