"""Maps from flat meshes: a file beside the scene, one axis of which is dropped."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from stplan.errors import SceneError
from stplan.maps.files import FileContent, read_beside
from stplan.maps.reader import Floor, MapBase, MapError, MapReader
from stplan.schema.mapping import GIVEN, Fault, FileModel, key

SUFFIXES = (".obj", ".ply", ".off", ".stl", ".glb")
Axis = Literal["x", "y", "z"]


class MeshKeys(FileModel):
    """A mesh as the map."""

    mesh: Annotated[Annotated[str, Field(min_length=1, max_length=1000)] | None, GIVEN] = key(
        "base: a flat mesh (OBJ, PLY, OFF, STL, GLB), in m, path relative to the scene file"
    )
    up: Annotated[Axis | None, GIVEN] = key("axis of the mesh that is dropped", "z")


@dataclass(frozen=True)
class MeshBase(MapBase):
    """A flat mesh; `up` names the axis that is dropped."""

    file: FileContent
    up: Axis

    def floor(self) -> Floor:
        """The union of the mesh's triangles in the plane."""
        from stplan.maps.mesh.reader import mesh_floor

        try:
            return mesh_floor(self.file, self.up)
        except SceneError as error:
            raise MapError("map.mesh", f"{self.file.path.name} {error}") from error

    def contents(self) -> tuple[bytes, ...]:
        """The bytes of the mesh file."""
        return (self.file.content,)

    def meaning(self) -> dict[str, Any]:
        """All that the scene says of it; what the file holds is hashed apart, its name never."""
        return {"path": "mesh", "up": self.up}


def _compile(entry: MeshKeys, folder: Path, faults: list[Fault]) -> MeshBase:
    file = read_beside(entry.mesh or "", folder, SUFFIXES, "map.mesh", "a mesh file", faults)
    return MeshBase(file, entry.up or "z")


MESH = MapReader("mesh", MeshKeys, _compile, "a mesh")
