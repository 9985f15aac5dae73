"""One planned scene, measured: how long, how dear, how close, how much memory."""

from __future__ import annotations

import multiprocessing
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from stplan.analysis.own_costs import own_costs
from stplan.bench import families_open as wide
from stplan.bench import families_tight as tight
from stplan.callbacks import Stop
from stplan.errors import SeedingError
from stplan.planner import Plan, plan, write_plan
from stplan.scene.model import Scene

Result = TypeVar("Result")


@dataclass(frozen=True)
class SolveFigures:
    """What `stplan solve` does with a scene, nan where it did not get that far.

    Attributes:
        seed_seconds, optimise_seconds: of these stages (s).
        total_seconds: all stages and the writing of the files (s).
        evaluation_share: of objective, gradient, Hessian and neighbour lists in `optimise_seconds`.
        kinetic_seed, kinetic_end: kinetic cost over that of straight lines, before and after.
        clearance: the smallest of the certificate (m).
        peak_mib: greatest resident memory of the process so far (MiB).
    """

    agents: int
    knots: int = 0
    found_by: str = ""
    status: str = ""
    certified: bool = False
    seed_seconds: float = np.nan
    optimise_seconds: float = np.nan
    total_seconds: float = np.nan
    iterations: int = 0
    evaluation_share: float = np.nan
    refused_steps: int = 0
    hessian_nonzeros: int = 0
    kinetic_seed: float = np.nan
    kinetic_end: float = np.nan
    clearance: float = np.nan
    peak_mib: float = np.nan

    @property
    def iteration_seconds(self) -> float:
        """Time of one iteration (s)."""
        return self.optimise_seconds / self.iterations if self.iterations else np.nan


@dataclass(frozen=True)
class PricedSolve:
    """A solve and what its plan costs.

    Attributes:
        cost: of all agents by themselves, as `own_costs`; nan without a certified plan.
        seconds: of processor time, seeding included.
    """

    figures: SolveFigures
    cost: float
    seconds: float


def priced(scene: Scene, seconds: float = np.inf, costs: Scene | None = None) -> PricedSolve:
    """Plan `scene` for at most so many `seconds` of processor time, and price its plan.

    Args:
        costs: the scene whose costs count, where it is another.
    """
    began = time.process_time()
    figures, planned = run(scene, stop=lambda: time.process_time() > began + seconds)
    taken = time.process_time() - began
    if planned is None or not figures.certified:
        return PricedSolve(figures, np.nan, taken)
    return PricedSolve(figures, plan_cost(costs or scene, planned), taken)


def plan_cost(scene: Scene, planned: Plan) -> float:
    """What the plan's curves, those of its seed where it has no others, cost all agents of `scene`."""
    return float(own_costs(scene, planned.trajectories or planned.seed).sum())


def run(scene: Scene, stop: Stop | None = None) -> tuple[SolveFigures, Plan | None]:
    """Plan `scene`, until `stop` at most, and write its files to a folder that is removed again."""
    started = time.perf_counter()
    try:
        planned = written_plan(scene, stop)
    except SeedingError as error:
        reason = str(error).splitlines()[0]
        seconds = time.perf_counter() - started
        failed = SolveFigures(len(scene.agents), status=f"failed: {reason}", total_seconds=seconds)
        return failed, None
    return measured(planned, time.perf_counter() - started), planned


def written_plan(scene: Scene, stop: Stop | None = None, num_workers: int = 1) -> Plan:
    """The plan of `scene`, its files written to a folder that is removed again.

    Raises:
        SeedingError: no initial curves were found.
    """
    planned = plan(scene, stop=stop, num_workers=num_workers)
    with tempfile.TemporaryDirectory() as folder:
        write_plan(planned, Path(folder))
    return planned


def measured(planned: Plan, total_seconds: float) -> SolveFigures:
    """The figures of a plan that took `total_seconds`."""
    report, seconds, times = planned.report, planned.run.seconds, planned.run.optimisation
    smallest = planned.certificate.smallest
    figures = SolveFigures(
        agents=len(planned.scene.agents),
        knots=len(planned.seed.knots),
        found_by=report.seed.found_by,
        status=planned.status,
        certified=planned.certificate.holds,
        seed_seconds=seconds["seed"],
        total_seconds=total_seconds,
        kinetic_seed=report.seed.metrics.kinetic_over_straight or np.nan,
        kinetic_end=report.metrics.kinetic_over_straight or np.nan,
        clearance=np.inf if smallest is None else smallest.clearance,
        peak_mib=planned.run.peak_memory_mib,
    )
    if times is None:
        return figures
    return replace(
        figures,
        optimise_seconds=times.whole,
        iterations=times.iterations,
        evaluation_share=times.evaluation / times.whole,
        refused_steps=times.refused_steps,
        hessian_nonzeros=times.hessian_nonzeros,
    )


def warm_up(**solver: object) -> None:
    """Plan small scenes that between them need every kernel, so that none is compiled while timed.

    `solver` are settings that differ from the defaults.
    """
    draw = np.random.default_rng(0)
    relaxed = tight.corridor_with_pocket(draw, half_width=3.0)
    searched = tight.plus_crossing(draw, turn=3)
    scenes = (
        # Patient: compilation counts as time of the seeder.
        replace(relaxed, seeding=replace(relaxed.seeding, method="relaxation", time_limit=600.0)),
        replace(searched, seeding=replace(searched.seeding, method="search", time_limit=600.0)),
        wide.circle(4, 4.0, 12.0),
    )
    for scene in scenes:
        plan(with_solver(scene, **solver))


def with_solver(scene: Scene, **solver: object) -> Scene:
    """`scene` with other settings of the solver."""
    return replace(scene, solver=replace(scene.solver, **solver))  # type: ignore[arg-type]


def in_own_process(work: Callable[..., Result], *arguments: object) -> Result:
    """The result of `work(*arguments)` in a fresh process, whose peak memory is its own."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        return pool.submit(work, *arguments).result()
