"""The figures the planner is held to: generated scenes, what is asked of each, what is measured.

Every scene is planned in a process of its own, after untimed scenes that need every kernel, so that
no compilation is timed and peak memory is the scene's own.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from stplan.bench import families_open as wide
from stplan.bench import families_tight as tight
from stplan.bench.solves import SolveFigures, in_own_process, run, warm_up, with_solver
from stplan.callbacks import Progress, unheard
from stplan.errors import UsageError
from stplan.multistart import straight_conflicts
from stplan.optimize.continuation import optimise
from stplan.planner import Plan, prepare
from stplan.problem.kinetic_cost import total_kinetic_cost
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene

Quantity = Literal[
    "total seconds",
    "kinetic over straight",
    "evaluation share",
    "peak memory, MiB",
    "over converged cost",
]
# A tight scene is compared with its converged cost after this many seconds of optimisation.
TIGHT_SECONDS = 5.0
# The converged cost is what these tolerances and so many iterations reach, at most in so many seconds.
CONVERGED_TOLERANCE = 1e-4
CONVERGED_ITERATIONS = 1000
CONVERGED_SECONDS = 120.0


@dataclass(frozen=True)
class Case:
    """A generated scene and what is asked of it: the greatest value of every quantity.

    Attributes:
        small: whether it is measured when no full measurement is asked for.
        tight: whether its cost after `TIGHT_SECONDS` is compared with its converged cost.
    """

    name: str
    title: str
    scene: Callable[[], Scene]
    asked: tuple[tuple[Quantity, float], ...]
    small: bool = True
    tight: bool = False


@dataclass(frozen=True)
class Figure:
    """What was measured of a case.

    Attributes:
        conflicts: pairs that would collide on straight lines in the open plane, None with a map.
        over_converged: cost after `TIGHT_SECONDS` of optimisation over the converged cost, less 1.
        converged_seconds: what it took to converge (s).
    """

    name: str
    title: str
    run: SolveFigures
    conflicts: int | None
    over_converged: float = np.nan
    converged_seconds: float = np.nan

    def value(self, quantity: Quantity) -> float:
        """The measured value of something asked."""
        values: dict[Quantity, float] = {
            "total seconds": self.run.total_seconds,
            "kinetic over straight": self.run.kinetic_end,
            "evaluation share": self.run.evaluation_share,
            "peak memory, MiB": self.run.peak_mib,
            "over converged cost": self.over_converged,
        }
        return values[quantity]


def _tight(family: Callable[..., Scene], **size: int) -> Scene:
    return with_solver(family(np.random.default_rng(0), **size), knots=60)


def _whole(seconds: float, ratio: float) -> tuple[tuple[Quantity, float], ...]:
    return (("total seconds", seconds), ("kinetic over straight", ratio))


def cases() -> list[Case]:
    """All cases, in the order of the table."""
    found = [
        Case(
            f"circle-{count}",
            f"circle of {count}, radius 45 m, r 0.5 m, 90 s",
            partial(wide.circle, count, 45.0, 90.0),
            _whole(seconds, ratio),
        )
        for count, seconds, ratio in ((8, 1.5, 1.003), (20, 3.0, 1.008), (35, 8.0, 1.010))
    ]
    found += [
        Case(
            f"small-circle-{count}",
            f"circle of {count}, radius 8 m, r 0.25 m, 50 s",
            partial(wide.circle, count, 8.0, 50.0, 0.25),
            _whole(seconds, ratio),
        )
        for count, seconds, ratio in ((8, 0.8, 1.010), (20, 5.0, 1.040))
    ]
    found += [
        Case(
            "meadow",
            "meadow: 102 agents head-on, two heavy",
            lambda: wide.heavy_lanes(np.random.default_rng(0), 102),
            _whole(8.0, 1.004),
        ),
        Case(
            "flows-128",
            "crossing flows of 128 at 1 m/s, 36 knots",
            lambda: with_solver(wide.crossing_flows(128, 1.0), knots=36),
            (*_whole(10.0, 1.07), ("evaluation share", 0.2)),
        ),
        Case(
            "flows-512",
            "crossing flows of 512 at 0.5 m/s",
            lambda: wide.crossing_flows(512, 0.5),
            (*_whole(60.0, 1.07), ("peak memory, MiB", 2048.0)),
            small=False,
        ),
    ]
    # The same flows twice as dense.
    found += [
        Case(
            "dense-flows-128",
            "dense crossing flows of 128 at 1 m/s, 36 knots",
            lambda: with_solver(wide.crossing_flows(128, 1.0, density=0.24), knots=36),
            _whole(10.0, 1.07),
            small=False,
        ),
        Case(
            "dense-flows-512",
            "dense crossing flows of 512 at 0.5 m/s",
            lambda: wide.crossing_flows(512, 0.5, density=0.24),
            _whole(60.0, 1.07),
            small=False,
        ),
    ]
    converging: tuple[tuple[Quantity, float], ...] = (("over converged cost", 0.02),)
    found += [
        Case(name, title, scene, converging, small=False, tight=True)
        for name, title, scene in (
            ("door", "door, 10 a side, 60 knots", partial(_tight, tight.door, per_side=10)),
            ("warehouse", "warehouse of 20, 60 knots", partial(_tight, tight.warehouse, robots=20)),
            ("cabin", "cabin of 10, 60 knots", partial(_tight, tight.cabin, passengers=10)),
        )
    ]
    found.append(
        Case(
            "field-1000",
            "open field of 1,000, density 0.06",
            partial(wide.open_field, 1000, 0.06),
            (),
            small=False,
        )
    )
    return found


def chosen_cases(names: Iterable[str], *, full: bool) -> list[Case]:
    """Cases of the small or the full measurement; `names`, or what they begin with, choose instead.

    Raises:
        UsageError: a name fits no case.
    """
    everything = cases()
    wanted = [name.strip() for name in names if name.strip()]
    if not wanted:
        return [one for one in everything if full or one.small]
    for name in wanted:
        if not any(_fits(one, name) for one in everything):
            known = ", ".join(one.name for one in everything)
            raise UsageError(f"there is no figure {name!r}; expected some of {known}")
    return [one for one in everything if any(_fits(one, name) for name in wanted)]


def _fits(case: Case, name: str) -> bool:
    return case.name == name or case.name.startswith(f"{name}-")


def measure(chosen: Sequence[Case], *, progress: Progress) -> list[Figure]:
    """Measure cases one after the other."""
    progress("warm-up")
    in_own_process(warm_up)
    found = []
    for case in chosen:
        progress(f"{case.name}: {case.title}")
        figure = in_own_process(measure_one, case.name)
        found.append(figure)
        progress(f"{case.name}: {outcome(figure)}")
    return found


def measure_one(name: str) -> Figure:
    """Measure the case of this name in this process."""
    case = next(one for one in cases() if one.name == name)
    scene = case.scene()
    warm_up()
    measured, planned = run(scene)
    conflicts = None if scene.map else straight_conflicts(PlanningProblem.from_scene(scene, None))
    figure = Figure(case.name, case.title, measured, conflicts)
    return _compared(figure, planned) if case.tight and planned is not None else figure


def _compared(figure: Figure, planned: Plan) -> Figure:
    """`figure` with the cost after a few seconds over that of a run until nothing changes."""
    scene = planned.scene
    early, _ = _cost_after(scene, planned.seed, TIGHT_SECONDS)
    patient = with_solver(
        scene,
        max_iterations=CONVERGED_ITERATIONS,
        step_tolerance=CONVERGED_TOLERANCE,
        optimality_tolerance=CONVERGED_TOLERANCE,
    )
    best, seconds = _cost_after(patient, planned.seed, CONVERGED_SECONDS)
    over = early / min(best, early) - 1.0
    return replace(figure, over_converged=over, converged_seconds=seconds)


def _cost_after(scene: Scene, seed: WorldLines, seconds: float) -> tuple[float, float]:
    """Kinetic cost (J s) that at most `seconds` of optimisation reach, and the seconds it took."""
    problem = prepare(scene)
    started = time.perf_counter()
    outcome = optimise(
        problem,
        problem.written.inside(seed),
        progress=unheard,
        stop=lambda: time.perf_counter() - started > seconds,
    )
    took = time.perf_counter() - started
    kinetic = total_kinetic_cost(problem.masses, outcome.world_lines.curves())
    return problem.frame.cost * kinetic, took


def outcome(figure: Figure) -> str:
    """A figure in one line."""
    one = figure.run
    if one.status.startswith("failed:"):
        return one.status
    line = (
        f"seed {one.seed_seconds:.2f} s ({one.found_by}), optimise {one.optimise_seconds:.2f} s, "
        f"whole {one.total_seconds:.2f} s, {one.iterations} iterations of "
        f"{1e3 * one.iteration_seconds:.1f} ms, evaluation {100 * one.evaluation_share:.0f} %, "
        f"kinetic {one.kinetic_seed:.4f} -> {one.kinetic_end:.4f}, clearance {one.clearance:.2g} m, "
        f"{'certified' if one.certified else 'NOT CERTIFIED'}, {one.status}, {one.peak_mib:.0f} MiB"
    )
    if not np.isnan(figure.over_converged):
        line += (
            f"; after {TIGHT_SECONDS:g} s {100 * figure.over_converged:.1f} % above "
            f"its cost after {figure.converged_seconds:.0f} s"
        )
    return line
