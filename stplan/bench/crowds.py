"""Crowds planned whole: how often, how fast, and how near to what is least."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from stplan.bench.families_crowds import FAMILIES
from stplan.bench.solves import warm_up
from stplan.callbacks import Progress
from stplan.errors import SeedingError, UsageError
from stplan.planner import Plan, plan
from stplan.scene.model import Scene
from stplan.seeding.assignment import least_assignment

# A family, its size, and the seconds that a whole plan of it may take.
Case = tuple[str, int, float]
SMALL_CASES: tuple[Case, ...] = (("grid room", 40, 10.0), ("random room", 40, 10.0))
FULL_CASES: tuple[Case, ...] = (
    ("grid room", 40, 10.0),
    ("grid room", 60, 20.0),
    ("grid room", 100, 40.0),
    ("grid room", 200, 120.0),
    ("random room", 40, 10.0),
    ("random room", 60, 20.0),
    ("random room", 100, 40.0),
    ("counterflow", 100, 60.0),
    ("exchange", 120, 60.0),
    ("stream", 600, 180.0),
    ("assigned", 100, 60.0),
)
SMALL_DRAWS, FULL_DRAWS = 2, 20


@dataclass(frozen=True)
class CrowdSolve:
    """One draw of a case.

    Attributes:
        seconds: processor time of the whole plan.
        asked: how many seconds it may take.
        found_by: of the seed, empty where none was found.
        certified: whether there is a plan that holds its certificate.
        length_over_least: length of all ways over that of the least assignment, nan where none is asked for.
    """

    family: str
    agents: int
    draw: int
    seconds: float
    asked: float
    found_by: str
    certified: bool
    length_over_least: float


def chosen_cases(names: Sequence[str], *, full: bool) -> tuple[Case, ...]:
    """The cases of the families that `names` begin with; all where none is named.

    Raises:
        UsageError: there is no such family.
    """
    for name in names:
        if not any(family.startswith(name) for family in FAMILIES):
            raise UsageError(f"no family {name!r}; there are {', '.join(FAMILIES)}")
    cases = FULL_CASES if full or names else SMALL_CASES
    return tuple(
        case for case in cases if not names or any(case[0].startswith(name) for name in names)
    )


def measure(
    cases: Sequence[Case], draws: int, *, largest: int, progress: Progress
) -> list[CrowdSolve]:
    """All draws of all cases with no more than `largest` agents."""
    warm_up()
    found = []
    for family, size, asked in cases:
        if size > largest:
            continue
        for draw in range(draws):
            found.append(_solved(family, size, asked, draw))
            one = found[-1]
            outcome = f"by {one.found_by}" if one.certified else "not found"
            progress(f"{family} {size}, draw {draw}: {outcome} in {one.seconds:.1f} s")
    return found


def _solved(family: str, size: int, asked: float, draw: int) -> CrowdSolve:
    scene = FAMILIES[family](size, draw)
    began = time.process_time()
    found: Plan | None = None
    with suppress(SeedingError):
        found = plan(scene)
    return CrowdSolve(
        family=family,
        agents=len(scene.agents),
        draw=draw,
        seconds=time.process_time() - began,
        asked=asked,
        found_by="" if found is None else found.report.seed.found_by,
        certified=found is not None and found.certificate.holds,
        length_over_least=np.nan if found is None else _length_over_least(scene, found),
    )


def _length_over_least(scene: Scene, found: Plan) -> float:
    if not scene.assignments or found.trajectories is None:
        return np.nan
    curves = found.trajectories.curves()
    length = sum(float(np.hypot(*np.diff(curve[:, :2], axis=0).T).sum()) for curve in curves)
    return length / least_assignment(scene)
