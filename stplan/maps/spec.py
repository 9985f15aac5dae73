"""The map of a scene, as validated."""

from __future__ import annotations

from dataclasses import dataclass

from stplan.maps.obstacles import Obstacle
from stplan.maps.reader import MapBase


@dataclass(frozen=True)
class MapSpec:
    """The map as written: a base, obstacles cut out of it, wanted edge length of the mesh (m)."""

    base: MapBase
    obstacles: tuple[Obstacle, ...] = ()
    resolution: float | None = None
