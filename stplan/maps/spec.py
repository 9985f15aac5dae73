"""The map of a scene, as validated."""

from __future__ import annotations

from dataclasses import dataclass

from stplan.maps.obstacles import Obstacle
from stplan.maps.reader import MapBase
from stplan.schema.hashing import added


@dataclass(frozen=True)
class MapSpec:
    """The map as written.

    Attributes:
        obstacles: cut out of the base.
        resolution: wanted edge length of the seeding mesh, m.
        repair: whether what is not simple is mended instead of refused.
    """

    base: MapBase
    obstacles: tuple[Obstacle, ...] = ()
    resolution: float | None = None
    repair: bool = added(True)
