"""Maps: free space, boundary, and whether a scene fits."""

from stplan.world.free_space import FreeSpace, build_free_space
from stplan.world.placement import check_scene_in_world, disconnected_agents

__all__ = ["FreeSpace", "build_free_space", "check_scene_in_world", "disconnected_agents"]
