"""``map: {file: ...}``: a map in the format of another program, by the ending of its name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field

from stplan.maps.files import FileContent, read_beside
from stplan.maps.reader import Floor, MapBase, MapError, MapReader
from stplan.maps.rings import WeldKeys
from stplan.schema.hashing import meaning
from stplan.schema.mapping import GIVEN, Fault, key
from stplan.schema.quantities import Factor, NotNegative, Positive
from stplan.schema.quantities import Point as PointKey

if TYPE_CHECKING:
    from stplan.maps.formats.drawing import Drawing, FileOptions, FormatError

_Name = Annotated[str, Field(min_length=1, max_length=200)]
_Names = Annotated[list[_Name], Field(min_length=1, max_length=100)]
_Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]


class FileKeys(WeldKeys):
    """A file of another program as the map; docs/formats.md lists formats and their options."""

    file: Annotated[Annotated[str, Field(min_length=1, max_length=1000)] | None, GIVEN] = key(
        "base: a map of another program, its format by its ending, path relative to the scene file"
    )
    scale: Annotated[Factor | None, GIVEN] = key(
        "of `file`: m a unit of it; default: as the format has it"
    )
    origin: Annotated[PointKey | None, GIVEN] = key(
        "of `file`: [x, y] in m, where its (0, 0) comes to lie; default: [0, 0]"
    )
    flip: Annotated[Literal["x", "y", "both"] | None, GIVEN] = key(
        "of `file`: axes along which it is mirrored in place"
    )
    simplify: Annotated[NotNegative | None, GIVEN] = key(
        "of `file`: how far corners may be cut off the floor, m; default: one pixel of pictures, else 0"
    )
    thickness: Annotated[Positive | None, GIVEN] = key(
        "of `file`: of walls drawn as lines, or of lanes where there is nothing else, m; default: none"
    )
    layers: Annotated[_Names | None, GIVEN] = key(
        "of `file`: layers, groups or kinds whose shapes block the way; default: all that are no floor"
    )
    floor: Annotated[_Names | None, GIVEN] = key(
        "of `file`: layers, groups or kinds whose shapes can be walked on; default: as the format has it"
    )
    threshold: Annotated[_Share | None, GIVEN] = key(
        "of `file`, a picture: how light free pixels are at least, 0 to 1"
    )
    level: Annotated[_Name | None, GIVEN] = key(
        "of `file`, a building: the storey; default: the first"
    )
    doors: Annotated[Literal["open", "closed"] | None, GIVEN] = key(
        "of `file`, a building: whether its doors are open", "open"
    )


@dataclass(frozen=True)
class FileBase(MapBase):
    """A map of another program, with the files it consists of."""

    file: FileContent
    options: FileOptions
    companions: tuple[FileContent, ...] = ()

    def drawing(self) -> Drawing:
        """What the file holds, in m; raises MapError where it cannot be read."""
        from stplan.maps.formats.drawing import FormatError, moved

        try:
            return moved(self.raw_drawing(), self.options)
        except FormatError as error:
            raise MapError("map.file", located(self.file, error)) from error

    def raw_drawing(self) -> Drawing:
        """What the file holds, in its own units; raises FormatError where it cannot be read."""
        from stplan.maps.formats.registry import format_of

        return format_of(self.file).read(self.file, self.options, self._beside)

    def floor(self) -> Floor:
        """What is drawn as floor, or enclosed by walls, less what blocks the way."""
        from stplan.maps.formats.assembly import assembled
        from stplan.maps.formats.drawing import FormatError

        drawing = self.drawing()
        try:
            return assembled(drawing, self.options)
        except FormatError as error:
            raise MapError("map.file", located(self.file, error)) from error

    def contents(self) -> tuple[bytes, ...]:
        """The bytes of all files."""
        return (self.file.content, *(one.content for one in self.companions))

    def meaning(self) -> dict[str, Any]:
        """All that the scene says of it; what the files hold is hashed apart."""
        from stplan.maps.formats.registry import format_of

        return {"format": format_of(self.file).name, "options": meaning(self.options)}

    def _beside(self, name: str) -> FileContent:
        from stplan.maps.formats.drawing import FormatError

        for one in self.companions:
            if one.path == self.file.path.parent / name:
                return one
        raise FormatError(f"refers to {name[:100]!r}, which was not read")


def open_file(file: FileContent, options: FileOptions) -> FileBase:
    """The map in a file that was read, with the files that it mentions.

    Raises:
        MapError: it is of no known format, or mentions files that are not there.
    """
    from stplan.maps.formats.drawing import FormatError
    from stplan.maps.formats.registry import format_of

    try:
        mentions = format_of(file).mentions
        names = () if mentions is None else mentions(file)
        return FileBase(file, options, tuple(_companion(file, name) for name in names))
    except FormatError as error:
        raise MapError("map.file", located(file, error)) from error


def _companion(file: FileContent, name: str) -> FileContent:
    """The file of this name beside the one that mentions it; raises FormatError."""
    from stplan.maps.formats.drawing import FormatError

    parts = PurePosixPath(name.replace("\\", "/")).parts
    if not parts or ".." in parts or parts[0].startswith("/") or ":" in name:
        raise FormatError(f"refers to {name[:100]!r}; a file in its own folder is expected")
    faults: list[Fault] = []
    suffix = PurePosixPath(name).suffix.lower()
    found = read_beside(name, file.path.parent, (suffix,), "", "a file", faults)
    if faults:
        raise FormatError(f"refers to a file: {faults[0][1]}")
    return found


def located(file: FileContent, error: FormatError) -> str:
    """What is wrong with a file, after its name and, where it is known, the line."""
    at = f"{file.path.name}:{error.line}:" if error.line else file.path.name
    return f"{at} {error.text}"


def _compile(entry: FileKeys, folder: Path, faults: list[Fault]) -> FileBase:
    from stplan.maps.formats.drawing import FileOptions, FormatError
    from stplan.maps.formats.registry import SUFFIXES, format_of

    before = len(faults)
    file = read_beside(entry.file or "", folder, SUFFIXES, "map.file", "a map", faults)
    x, y = entry.origin or (0.0, 0.0)
    options = FileOptions(
        scale=entry.scale, origin=(x, y), flip=entry.flip or "", simplify=entry.simplify,
        weld=entry.weld, thickness=entry.thickness, layers=tuple(entry.layers or ()),
        floor=tuple(entry.floor or ()), threshold=entry.threshold, level=entry.level,
        doors=entry.doors != "closed",
    )  # fmt: skip
    if len(faults) > before:
        return FileBase(file, options)
    try:
        form = format_of(file)
        for name in sorted(SPECIAL - form.options):
            if getattr(entry, name) is not None:
                faults.append((f"map.{name}", f"is no option of a {form.name}"))
        return open_file(file, options)
    except FormatError as error:
        faults.append(("map.file", located(file, error)))
    except MapError as error:
        faults.append((error.path, error.text))
    return FileBase(file, options)


# Options that only some formats have.
SPECIAL = frozenset({"layers", "floor", "threshold", "level", "doors"})
FILE = MapReader("file", FileKeys, _compile, "a file")
