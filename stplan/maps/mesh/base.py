"""Maps from flat meshes: a file beside the scene, one axis of which is dropped."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field

from stplan.errors import SceneError
from stplan.maps.files import FileContent, read_beside
from stplan.maps.reader import Floor, MapBase, MapError, MapReader, Note
from stplan.maps.rings import WeldKeys
from stplan.schema.mapping import GIVEN, Fault, key

if TYPE_CHECKING:
    import shapely

Axis = Literal["x", "y", "z"]
# Which axis points up where the scene does not say: the standard of glTF fixes it, others leave it open.
STANDARD_UP: dict[str, Axis] = {"glb": "y"}
SUFFIXES = (".obj", ".ply", ".off", ".stl", ".glb")


class MeshKeys(WeldKeys):
    """A mesh as the map."""

    mesh: Annotated[Annotated[str, Field(min_length=1, max_length=1000)] | None, GIVEN] = key(
        "base: a flat mesh (OBJ, PLY, OFF, STL, GLB), in m, path relative to the scene file"
    )
    up: Annotated[Axis | None, GIVEN] = key(
        "axis of the mesh that points up and is dropped; default: y for GLB, z for all others"
    )


@dataclass(frozen=True)
class MeshBase(MapBase):
    """A flat mesh, seen from above.

    Attributes:
        up: the axis that points there, None is the format's own.
        weld: how wide cracks may be that are closed, m; None follows the radii.
    """

    file: FileContent
    up: Axis | None
    weld: float | None = None

    @property
    def axis(self) -> Axis:
        """The axis that points up."""
        return self.up or STANDARD_UP.get(self.file.kind, "z")

    def floor(self) -> Floor:
        """The union of the mesh's triangles in the plane."""
        return self.floor_for(None)

    def floor_for(self, radius: float | None) -> Floor:
        """The same, for agents none of which has a smaller `radius` (m)."""
        from stplan.maps.mesh.reader import has_area, mesh_floor

        name = self.file.path.name
        try:
            floor = mesh_floor(self.file, self.axis, radius, self.weld)
        except SceneError as error:
            text = f"{name} {error}"
            if self.up is None and self.axis == "y" and has_area(self.file, "z"):
                text += "; by the standard of glTF y points up, and `up: z` says that z does here"
            raise MapError("map.mesh", text) from error
        if self.axis != "y":
            return floor
        text = ""
        if self.up is None:
            if has_area(self.file, "z"):
                text = "y points up by the standard of glTF; before, z did: `up: z` reads it so"
        elif not _symmetric(floor.area):
            text = (
                "the map's y is the mesh's -z, as seen from above; before, it was z: a mirror image"
            )
        notes = (Note("map.up" if self.up else "map.mesh", f"{name}: {text}"),) if text else ()
        return replace(floor, notes=(*floor.notes, *notes))

    def contents(self) -> tuple[bytes, ...]:
        """The bytes of the mesh file."""
        return (self.file.content,)

    def meaning(self) -> dict[str, Any]:
        """All that the scene says of it; what the file holds is hashed apart, its name never."""
        weld = {} if self.weld is None else {"weld": self.weld}
        return {"path": "mesh", "up": self.axis, **weld}


def _symmetric(area: shapely.Geometry) -> bool:
    """Whether `area` is its own image under (x, y) -> (x, -y), but for rounding."""
    import shapely

    mirrored = shapely.transform(area, lambda corners: corners * [1.0, -1.0])
    return bool(shapely.area(shapely.symmetric_difference(area, mirrored)) <= 1e-6 * area.area)


def _compile(entry: MeshKeys, folder: Path, faults: list[Fault]) -> MeshBase:
    file = read_beside(entry.mesh or "", folder, SUFFIXES, "map.mesh", "a mesh file", faults)
    return MeshBase(file, entry.up, entry.weld)


MESH = MapReader("mesh", MeshKeys, _compile, "a mesh")
