"""Families of tight scenes with random parameters, and the search alone measured on them.

`python -m tests.seeding.tight_families 40` tabulates how often and how fast 40 members of every
family are solved.
"""

from __future__ import annotations

import sys
import time
from collections import Counter

import numpy as np

from stplan.bench.families_tight import (
    FAMILIES,
    RADIUS,
    cabin,
    corridor_with_pocket,
    door,
    make_scene,
    pillars,
    plus_crossing,
    rectangle,
    scattered,
    warehouse,
)
from stplan.compiled import working_time
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.verification import verify
from stplan.scene.model import Scene
from stplan.seeding.search.levels import Levels
from stplan.seeding.search.schedule import Search
from stplan.seeding.seeder import Budget
from stplan.world import build_free_space

__all__ = [
    "FAMILIES",
    "RADIUS",
    "budget_of",
    "cabin",
    "corridor_with_pocket",
    "door",
    "make_scene",
    "measure",
    "pillars",
    "plus_crossing",
    "rectangle",
    "scattered",
    "warehouse",
]


def budget_of(scene: Scene) -> Budget:
    """What the settings of a scene allow an attempt that begins now."""
    settings = scene.seeding
    return Budget(settings.rng_seed, working_time() + settings.time_limit)


def measure(family: str, count: int, first_seed: int = 1000) -> str:
    """One line: how many of `count` members are solved, processor seconds, by which part."""
    seconds: list[float] = []
    parts: Counter[str] = Counter()
    solved = 0
    for seed in range(first_seed - 1, first_seed + count):
        scene = FAMILIES[family](np.random.default_rng(seed))
        problem = PlanningProblem.from_scene(scene, build_free_space(scene))
        begin = time.process_time()
        result = Search(Levels(problem)).attempt(budget_of(scene))
        if seed < first_seed:
            # The first one only warms up.
            continue
        seconds.append(time.process_time() - begin)
        if result.curves is not None and not verify(problem, result.curves):
            solved += 1
            parts[result.found_by] += 1
    times = ", ".join(f"{np.quantile(seconds, share):.3f}" for share in (0.5, 0.9, 1.0))
    by = ", ".join(f"{part} {number}" for part, number in parts.most_common())
    return f"{family:15s} {solved:3d}/{count}  median, 90 %, most: {times} s  ({by})"


if __name__ == "__main__":
    for name in FAMILIES:
        sys.stdout.write(measure(name, int(sys.argv[1])) + "\n")
        sys.stdout.flush()
