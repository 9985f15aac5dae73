"""How fast the variants of the optimiser come near the best cost, over whole scenes.

Every scene is seeded once; every variant starts from that seed. The cost that is compared is what the
scene asks for (kinetic, acceleration, arrival, grouping), without barriers and regularity, whose
weights differ between variants. The best cost of a scene is the least that any variant reached with
a certificate.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from stplan.arrays import FloatArray
from stplan.bench.solves import warm_up, with_solver
from stplan.callbacks import Progress, unheard
from stplan.certify.certificate import certify
from stplan.errors import SeedingError, UsageError
from stplan.nlp.term import Capability, Term
from stplan.optimize.continuation import optimise
from stplan.planner import find_initial_curves, prepare
from stplan.problem.world_lines import WorldLines
from stplan.scene import load_scene
from stplan.scene.model import Scene

# Options of `solver` that differ from the defaults, by the name of the variant.
VARIANTS: Mapping[str, Mapping[str, Any]] = {
    "default": {},
    "exact": {"hessian": "exact"},
    "limited-memory": {"hessian": "limited-memory"},
    "smooth minimum": {"clearance_model": "smooth-minimum"},
    "smooth minimum exact": {"clearance_model": "smooth-minimum", "hessian": "exact"},
    "unbounded log": {"barrier_range": np.inf},
    "mu decay 0.75": {"mu_decay": 0.75},
    "mu of the paper": {"mu": 1.0, "mu_decay": 0.75},
}
# Costs that the scene asks for; the others serve the method.
# How near the best cost is near: a hundredth and a thousandth of it above.
NEAR = (1e-2, 1e-3)
SMALL_SECONDS, FULL_SECONDS = 3.0, 30.0
SMALL_SCENES = ("symmetric", "bottleneck", "circle-8", "pocket-swap")


@dataclass(frozen=True)
class Trace:
    """Costs (N,) of a variant's iterates and the seconds (N,) after which they were reached."""

    scene: str
    variant: str
    costs: FloatArray
    seconds: FloatArray
    clearance: float
    certified: bool
    status: str


@dataclass(frozen=True)
class Convergence:
    """A variant on a scene: iterations and seconds to stay near the best cost, nan if it never did.

    Attributes:
        over_best: last cost over the best of the scene, less 1.
        iterations_near, seconds_near: for each share of `NEAR`.
    """

    scene: str
    variant: str
    status: str
    certified: bool
    clearance: float
    iterations: int
    seconds: float
    over_best: float
    iterations_near: tuple[float, ...]
    seconds_near: tuple[float, ...]

    @property
    def failed(self) -> bool:
        """Whether its certificate is broken or its cost stayed above the first share of `NEAR`."""
        return not self.certified or bool(np.isnan(self.iterations_near[0]))


def shipped_scenes(paths: Sequence[Path], *, full: bool) -> list[Path]:
    """The scenes to measure: those named, or those under ./scenes (a few unless `full`).

    Raises:
        UsageError: none are named and there are none.
    """
    if paths:
        return list(paths)
    found = sorted(Path("scenes").glob("*/*.yaml"))
    if not found:
        raise UsageError(
            "there are no scenes/*/*.yaml here; name some: stplan bench convergence SCENE..."
        )
    return found if full else [path for path in found if path.stem in SMALL_SCENES]


def chosen_variants(names: Sequence[str]) -> list[str]:
    """The variants named, all where none is.

    Raises:
        UsageError: there is no such variant.
    """
    wanted = [name.strip() for name in names if name.strip()]
    for name in wanted:
        if name not in VARIANTS:
            known = ", ".join(VARIANTS)
            raise UsageError(f"there is no variant {name!r}; expected some of {known}")
    return wanted or list(VARIANTS)


def measure(
    paths: Sequence[Path], time_limit: float, variants: Sequence[str], *, progress: Progress
) -> list[Convergence]:
    """Every variant on every scene, after untimed scenes that need every kernel."""
    scenes = [replace(load_scene(path), changes=()) for path in paths]
    progress("convergence: warm-up")
    for variant in variants:
        warm_up(**VARIANTS[variant], outer_iterations=1, max_iterations=2)
    found: list[Convergence] = []
    for scene in scenes:
        problem = prepare(scene)
        try:
            (initial,) = find_initial_curves(problem)
        except SeedingError as error:
            progress(f"{scene.name}: {str(error).splitlines()[0]}")
            continue
        traces = []
        for variant in variants:
            one = trace(scene, initial.seed.world_lines, variant, time_limit)
            traces.append(one)
            progress(
                f"{scene.name}: {variant}: {len(one.costs) - 1} iterations, {one.seconds[-1]:.2f} s, "
                f"cost {one.costs[-1]:.6g}, {one.status}"
            )
        found += outcomes(traces)
    return found


def trace(scene: Scene, seed: WorldLines, variant: str, time_limit: float) -> Trace:
    """Optimise `seed` (in the frame of its problem) as a variant does, for at most `time_limit` s."""
    problem = prepare(with_solver(scene, **VARIANTS[variant]))
    unit = problem.frame.cost
    costs: list[float] = []
    seconds: list[float] = []
    started = time.perf_counter()

    def observe(knots: FloatArray, terms: Sequence[Term]) -> None:
        priced = (term for term in terms if Capability.PRICE in term.capabilities)
        costs.append(unit * sum(term.value(knots) for term in priced))
        seconds.append(time.perf_counter() - started)

    outcome = optimise(
        problem, seed,
        progress=unheard,
        stop=lambda: time.perf_counter() - started > time_limit,
        observe=observe,
    )  # fmt: skip
    lines = problem.written.outside(outcome.world_lines)
    certificate = certify(scene, problem.written.free_space, lines)
    smallest = certificate.smallest
    return Trace(
        scene.name,
        variant,
        np.array(costs),
        np.array(seconds),
        np.inf if smallest is None else smallest.clearance,
        certificate.holds,
        "time limit" if outcome.status == "interrupted" else outcome.status,
    )


def outcomes(traces: Sequence[Trace]) -> list[Convergence]:
    """The traces of one scene, each judged by the best cost of all."""
    best = min((one.costs[-1] for one in traces if one.certified), default=np.nan)
    found = []
    for one in traces:
        near = [_settled(one.costs, best * (1.0 + share)) for share in NEAR]
        found.append(
            Convergence(
                one.scene,
                one.variant,
                one.status,
                one.certified,
                one.clearance,
                len(one.costs) - 1,
                float(one.seconds[-1]),
                float(one.costs[-1] / best - 1.0),
                tuple(np.nan if at is None else float(at) for at in near),
                tuple(np.nan if at is None else float(one.seconds[at]) for at in near),
            )
        )
    return found


def _settled(costs: FloatArray, most: float) -> int | None:
    """The first iterate from which on no cost is above `most`."""
    above = np.flatnonzero(~(costs <= most))
    first = int(above[-1]) + 1 if len(above) else 0
    return first if first < len(costs) else None
