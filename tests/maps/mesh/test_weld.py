"""Dirty meshes: corners that were meant to be one, hanging corners and flipped faces leave no walls."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely
import trimesh

from stplan.arrays import FloatArray, IntArray
from stplan.maps.mesh.cracks import joined
from stplan.problem.planning_problem import PlanningProblem
from stplan.scene.model import Scene
from stplan.seeding.infeasibility import hopeless
from stplan.wording import sentence
from stplan.world import FreeSpace, build_free_space, cut_off_agents, warnings_of
from tests.world.scenes import scene

# A room of 9 x 6 with a wall to walk around; the corner (4, 4) hangs on the side from (0, 4) to (9, 4).
CORNERS = np.array(
    [(0, 0), (4, 0), (4, 4), (0, 4), (5, 0), (9, 0), (9, 4), (5, 4), (0, 6), (9, 6)], dtype=float
)
FACES = np.array([(0, 1, 2), (0, 2, 3), (4, 5, 6), (4, 6, 7), (3, 6, 9), (3, 9, 8)])
ROOM = shapely.difference(shapely.box(0, 0, 9, 6), shapely.box(4, 0, 5, 4))
AGENT = "  - {{id: a, start: [2, 1], goal: [7, 1], radius: {}}}"


def soup(jitter: float, seed: int = 1) -> tuple[FloatArray, IntArray]:
    """The room as triangles that share nothing, every corner `jitter` (m) off at most, some flipped."""
    rng = np.random.default_rng(seed)
    corners = CORNERS[FACES].reshape(-1, 2)
    corners = corners + rng.uniform(-jitter, jitter, corners.shape)
    faces = np.arange(len(corners)).reshape(-1, 3)
    faces[::2] = faces[::2, ::-1]
    return corners, faces


def write(folder: Path, kind: str, jitter: float) -> str:
    """The file `m.kind` of the soup, and the scene's map."""
    corners, faces = soup(jitter)
    mesh = trimesh.Trimesh(np.column_stack([corners, np.zeros(18)]), faces, process=False)
    content = mesh.export(file_type=kind)
    (folder / f"m.{kind}").write_bytes(content if isinstance(content, bytes) else content.encode())
    return f"{{mesh: m.{kind}, up: z}}"


def free(folder: Path, world: str, radius: float = 0.3) -> tuple[FreeSpace, list[str]]:
    """The free space of a map for an agent of this radius, and the warnings about it."""
    built = scene(world, AGENT.format(radius), folder=folder)
    space = build_free_space(built)
    return space, warnings_of(built, space)


def problem_of(built: Scene) -> PlanningProblem:
    """The problem of a scene, in its own units."""
    return PlanningProblem.from_scene(built, build_free_space(built))


def connected(space: FreeSpace, radius: float = 0.3) -> bool:
    """Whether there is a way around the wall."""
    stops = [np.array([[2.0, 1.0], [7.0, 1.0]])]
    return cut_off_agents(space, stops, np.array([radius])) == []


@pytest.mark.parametrize("kind", ["obj", "ply", "off", "stl", "glb"])
def test_corners_a_tenth_of_a_millimetre_apart_are_one(tmp_path: Path, kind: str) -> None:
    space, (warning,) = free(tmp_path, write(tmp_path, kind, 1e-4))
    assert isinstance(space.polygon, shapely.Polygon)
    assert not space.polygon.interiors
    assert shapely.hausdorff_distance(space.polygon, ROOM) < 3e-4
    assert "map.mesh: m." in warning
    assert "cracks up to 0.000" in warning
    assert "map.weld sets how wide they may be, here 0.0006 m" in warning


@pytest.mark.parametrize("kind", ["obj", "stl"])
def test_whole_meshes_are_left_as_they_are(tmp_path: Path, kind: str) -> None:
    space, warnings = free(tmp_path, write(tmp_path, kind, 0.0))
    assert warnings == []
    assert space.polygon.equals(ROOM)


def test_the_tolerance_follows_the_smallest_radius(tmp_path: Path) -> None:
    world = write(tmp_path, "obj", 1e-4)
    assert isinstance(free(tmp_path, world, 0.3)[0].polygon, shapely.Polygon)
    # For someone that small a tenth of a millimetre may be a wall.
    space, warnings = free(tmp_path, world, 0.01)
    assert not connected(space, 0.01)
    assert warnings == []


def test_it_can_be_set_and_switched_off(tmp_path: Path) -> None:
    world = write(tmp_path, "obj", 2e-3)
    assert not connected(free(tmp_path, world)[0])
    space, (warning,) = free(tmp_path, world.replace("}", ", weld: 0.008}"))
    assert connected(space)
    assert isinstance(space.polygon, shapely.Polygon)
    assert "here 0.008 m" in warning
    write(tmp_path, "obj", 1e-4)
    assert not connected(free(tmp_path, world.replace("}", ", weld: 0}"))[0])
    plain, off, set_ = (scene(w, folder=tmp_path).content_hash for w in (
        world, world.replace("}", ", weld: 0}"), world.replace("}", ", weld: 0.001}")
    ))  # fmt: skip
    assert len({plain, off, set_}) == 3


def test_a_refusal_says_how_wide_the_cracks_are_and_what_closes_them(tmp_path: Path) -> None:
    world = write(tmp_path, "obj", 2e-3)
    (reason,) = hopeless(problem_of(scene(world, AGENT.format(0.3), folder=tmp_path)))
    text = sentence(reason)
    assert text.startswith("a: cracks in the mesh up to 0.00")
    assert reason.figures["distance"] < 6e-3
    advice = float(text.partition("map.weld: ")[2].partition(" ")[0])
    assert advice >= reason.figures["distance"]
    healed = scene(world.replace("}", f", weld: {advice}}}"), AGENT.format(0.3), folder=tmp_path)
    assert hopeless(problem_of(healed)) == ()


def test_rooms_that_are_apart_are_no_cracks(tmp_path: Path) -> None:
    apart = CORNERS[FACES[:4]].reshape(-1, 2)
    text = "".join(f"v {x} {y} 0\n" for x, y in apart) + "f 1 2 3\nf 4 5 6\nf 7 8 9\nf 10 11 12\n"
    (tmp_path / "m.obj").write_text(text)
    (reason,) = hopeless(problem_of(scene("{mesh: m.obj}", AGENT.format(0.3), folder=tmp_path)))
    assert sentence(reason) == "a: its start and goal lie in separate parts of the map"


@pytest.mark.parametrize("seed", range(5))
def test_nothing_is_moved_further_than_allowed(seed: int) -> None:
    # Chains of corners closer than the tolerance, far longer than it.
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, 400))
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    fan = np.array([(0, k + 1, (k + 1) % 400 + 1) for k in range(400)])
    corners = np.vstack([[0.0, 0.0], rim])[fan].reshape(-1, 2)
    corners += rng.uniform(-1e-4, 1e-4, corners.shape)
    shape = joined(corners, np.arange(1200).reshape(-1, 3), 0.02)
    assert isinstance(shape.area, shapely.Polygon)
    assert shape.widest <= 0.02
    assert shapely.hausdorff_distance(shape.area, shapely.Polygon(rim)) < 0.02


def test_faces_drawn_twice_and_turned_hide_no_cracks() -> None:
    corners, faces = soup(1e-4)
    twice = np.vstack([faces, faces[:, [2, 1, 0]], faces[:, [1, 2, 0]]])
    once, more = joined(corners, faces, 1e-3), joined(corners, twice, 1e-3)
    assert isinstance(more.area, shapely.Polygon)
    assert more.area.equals(once.area)
    assert more.num_welded == once.num_welded
