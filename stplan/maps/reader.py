"""What a way to write a map has to offer: keys of the scene's `map`, and an area made of them.

A reader is one file: a `FileModel` with its keys, a `MapBase` with what they hold once validated, and a
`MapReader` that leads from one to the other; `stplan.maps.registry` lists them. Files are read when the
scene is, once, and their bytes kept in the base, so that the scene's hash is of the bytes planned.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stplan.errors import SceneError
from stplan.schema.mapping import Fault, FileModel

if TYPE_CHECKING:
    import shapely

    from stplan.arrays import FloatArray


class MapError(SceneError):
    """A map that cannot be used; `path` says which key of the scene is to blame."""

    def __init__(self, path: str, text: str) -> None:
        super().__init__(text)
        self.path, self.text = path, text


@dataclass(frozen=True)
class Note:
    """Something about a map that its user has to know.

    Attributes:
        path: the key of the scene it is about.
        text: what is the matter, and where.
        mending: what was done to mend it, which `map.repair: false` refuses; empty where nothing had to be.
    """

    path: str
    text: str
    mending: str = ""

    @property
    def sentence(self) -> str:
        """All of it."""
        return f"{self.text}; {self.mending}" if self.mending else self.text


@dataclass(frozen=True)
class Floor:
    """What becomes of a map.

    Attributes:
        area: where centres of agents may be, a valid Polygon or MultiPolygon, m.
        triangles: (F, 3, 2) the map's own, m, None where it has none.
        slits: walls without thickness inside the area, polylines (n, 2), m.
        notes: for the user.
    """

    area: shapely.Geometry
    triangles: FloatArray | None = None
    slits: tuple[FloatArray, ...] = ()
    notes: tuple[Note, ...] = ()


class MapBase(ABC):
    """A map as validated, before obstacles are cut out of it. Subclasses are frozen dataclasses."""

    @abstractmethod
    def floor(self) -> Floor:
        """The area of the map; raises MapError where there is none."""

    def floor_for(self, radius: float | None) -> Floor:
        """The same for agents none of which has a smaller `radius` (m): what they cannot feel may differ."""
        del radius
        return self.floor()

    def contents(self) -> tuple[bytes, ...]:
        """What the files held that the map was read from."""
        return ()


@dataclass(frozen=True)
class MapReader:
    """One way to write a map.

    Attributes:
        key: the key of the scene's `map` that chooses it.
        keys: the model of all its keys.
        compile: (keys, folder of the scene, faults) -> the map. It adds what is wrong to the faults;
            with new ones the map must not be used.
        noun: what it makes, for messages.
        elsewhere: what to do instead of its other keys where another base is chosen, by key.
    """

    key: str
    keys: type[FileModel]
    compile: Callable[[Any, Path, list[Fault]], MapBase]
    noun: str
    elsewhere: Mapping[str, str] = field(default_factory=dict)
