"""Scenes of the paper's authors (``setup.json``): a mesh of the floor, agents with weights, in m and s."""

from __future__ import annotations

from typing import Any

import shapely

from stplan.errors import SceneError
from stplan.maps.files import FileContent
from stplan.maps.formats.drawing import (
    Beside,
    Drawing,
    DrawnAgent,
    FileOptions,
    ForeignFormat,
    FormatError,
    finite,
)
from stplan.maps.formats.json_tree import mapping, members, read_json_tree

MESHES = (".obj", ".ply", ".off", ".stl", ".glb")
# Our weights by their names.
_WEIGHTS = {
    "kinetic": "K_ke", "acceleration": "K_accel", "arrival": "K_pv", "regularity": "K_rg",
    "collision": "K_agent", "wall": "K_map",
}  # fmt: skip


def read_setup(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """The floor as the mesh seen from above, and everybody with the mass and weights given."""
    del options
    from stplan.maps.mesh.base import STANDARD_UP
    from stplan.maps.mesh.reader import mesh_floor

    tree = read_json_tree(file.content)
    floors: tuple[Any, ...] = ()
    for name in _mentioned(file):
        mesh = beside(name)
        try:
            area = mesh_floor(mesh, STANDARD_UP.get(mesh.kind, "z")).area
        except SceneError as error:
            raise FormatError(f"refers to {name}, which {error}") from error
        floors = tuple(shapely.get_parts(area))
    agents = _agents(mapping(tree, "agents"))
    obstacles = tree.get("obstacles")
    notes = [f"{len(obstacles)} obstacles were left out"] if obstacles else []
    between = sum(
        len(members(one, "xse")) > 2 for one in members(tree, "agents") if isinstance(one, dict)
    )
    if between:
        notes.append(f"places between start and goal of {between} agents were left out")
    return Drawing(floors=floors, agents=agents, notes=tuple(notes))


def _agents(entries: dict[str, Any]) -> tuple[DrawnAgent, ...]:
    numbers = {
        str(entry.get("id")): name for name, entry in entries.items() if isinstance(entry, dict)
    }
    agents = []
    for name, entry in entries.items():
        path = f"agents.{name[:40]}"
        ends = members(entry, "xse", f"{path}.")
        if len(ends) < 2 or not all(isinstance(end, list) and len(end) == 3 for end in ends):
            raise FormatError(f"{path}.xse is no list of places [x, y, t]")
        (x, y, t), (goal_x, goal_y, end) = (
            [finite(v, f"{path}.xse") for v in one] for one in (ends[0], ends[-1])
        )
        given = entry.get("energy_coefficients")
        given = given if isinstance(given, dict) else {}
        weights = {
            ours: finite(given[theirs], f"{path}.energy_coefficients.{theirs}")
            for ours, theirs in _WEIGHTS.items()
            if theirs in given
        }
        friends = tuple(
            numbers[str(one)]
            for one in members(entry, "friends", f"{path}.")
            if str(one) in numbers
        )
        agents.append(
            DrawnAgent(
                name, (x, y), (goal_x, goal_y), finite(entry.get("radius", 0.3), f"{path}.radius"),
                start_time=t, max_time=end, mass=finite(entry.get("mass", 1.0), f"{path}.mass"),
                vanishes=True, weights=weights, friends=friends,
            )
        )  # fmt: skip
    return tuple(agents)


def _mentioned(file: FileContent) -> tuple[str, ...]:
    terrain = read_json_tree(file.content).get("terrain")
    name = terrain.get("mesh") if isinstance(terrain, dict) else None
    if not name:
        return ()
    if not isinstance(name, str) or not name.lower().endswith(MESHES):
        raise FormatError(
            f"terrain.mesh is {str(name)[:100]!r}; a file that ends in {', '.join(MESHES)} is expected"
        )
    return (name,)


MAPPIT = ForeignFormat(
    "MAPPIT setup", (".json",), read_setup,
    claims=lambda content: b'"xse"' in content, mentions=_mentioned,
)  # fmt: skip
