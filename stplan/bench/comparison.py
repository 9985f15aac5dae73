"""This planner and its rivals on the same scenes, in the same run.

Every agent has the same greatest speed and acceleration. Asked for is the least makespan: the time at
which the last agent arrives. What comes out, whoever found it, is measured by the code of the certificate.
"""

from __future__ import annotations

from stplan.arrays import FloatArray
from stplan.scene.model import Scene
from stplan.seeding.geodesic import geodesic_curves
from stplan.seeding.rods import RodProblem
from stplan.world import FreeSpace


def ways(scene: Scene, free_space: FreeSpace | None) -> list[FloatArray]:
    """(n, 2) the shortest way of every agent alone."""
    problem = RodProblem.from_scene(scene, free_space)
    curves = geodesic_curves(problem, free_space)
    return [curve[:, :2] for curve in curves if curve is not None]
