"""Maps: free space, boundary, seeding mesh, and whether a scene fits."""

from stplan.world.erosion import eroded, nearest_in
from stplan.world.free_space import FreeSpace, build_free_space, warnings_of
from stplan.world.placement import (
    check_scene_in_world,
    cut_off_agents,
    fitted_free_space,
    widest_crack,
    widest_passage,
)
from stplan.world.seeding_mesh import SeedingMesh, build_seeding_mesh

__all__ = [
    "FreeSpace",
    "SeedingMesh",
    "build_free_space",
    "build_seeding_mesh",
    "check_scene_in_world",
    "cut_off_agents",
    "eroded",
    "fitted_free_space",
    "nearest_in",
    "warnings_of",
    "widest_crack",
    "widest_passage",
]
