"""The ways to write a map. A new one is a file, a base of `MapFile` and an entry of `READERS`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field

from stplan.maps.formats.base import FILE, FileKeys
from stplan.maps.mesh.base import MESH, MeshKeys
from stplan.maps.obstacles import ObstacleFile, compile_obstacle, exactly_one
from stplan.maps.polygon import POLYGON, RECTANGLE, PolygonKeys, RectangleKeys
from stplan.maps.reader import MapReader
from stplan.maps.rings import RepairKeys
from stplan.maps.spec import MapSpec
from stplan.schema.mapping import GIVEN, Fault, key
from stplan.schema.quantities import Positive

MOST_OBSTACLES = 100_000


class CommonKeys(RepairKeys):
    """What every map may have."""

    obstacles: Annotated[
        Annotated[list[ObstacleFile], Field(max_length=MOST_OBSTACLES)] | None, GIVEN
    ] = key("shapes cut out of the base")
    resolution: Annotated[Positive | None, GIVEN] = key(
        "wanted edge length of the seeding mesh, m; default: from the smallest radius"
    )


# The first base comes last in the schema.
class MapFile(CommonKeys, RectangleKeys, PolygonKeys, FileKeys, MeshKeys):
    """Where agents may be: exactly one base (mesh, file, polygon or rectangle), less the obstacles."""


READERS: tuple[MapReader, ...] = (MESH, FILE, POLYGON, RECTANGLE)


def compile_map(entry: MapFile, folder: Path, faults: list[Fault]) -> MapSpec:
    """The map; with new `faults` it must not be used. Files are looked for in `folder`, and read."""
    names = tuple(reader.key for reader in READERS)
    chosen = exactly_one(entry, names, "map", faults)
    reader = next((one for one in READERS if one.key == chosen), RECTANGLE)
    _check_options(entry, faults)
    base = reader.compile(entry, folder, faults)
    repair = entry.repair is not False
    obstacles = tuple(
        compile_obstacle(obstacle, f"map.obstacles[{k}]", faults, repair=repair)
        for k, obstacle in enumerate(entry.obstacles or [])
    )
    return MapSpec(base, obstacles, entry.resolution, repair)


def _check_options(entry: MapFile, faults: list[Fault]) -> None:
    """A fault for every key that belongs to a base that is not given."""
    for name in type(entry).model_fields:
        owners = [one for one in READERS if name in one.keys.model_fields and name != one.key]
        if name in CommonKeys.model_fields or not owners or getattr(entry, name) is None:
            continue
        if all(getattr(entry, one.key) is None for one in owners):
            nouns = " or ".join(one.noun for one in owners)
            hints = [one.elsewhere[name] for one in owners if name in one.elsewhere]
            hint = f"; {hints[0]}" if hints else ", and there is none"
            faults.append((f"map.{name}", f"belongs to {nouns}{hint}"))
