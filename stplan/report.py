"""What report.json and run.json of a plan hold: the first is repeatable, the second is not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from importlib import metadata
from platform import node, python_version
from platform import platform as platform_name
from typing import TYPE_CHECKING, Any

from stplan.analysis.arrival_gap import ArrivalGap
from stplan.analysis.chases import Chases
from stplan.analysis.cost_bound import CostBound
from stplan.analysis.metrics import Metrics, metrics
from stplan.analysis.robustness import Robustness
from stplan.analysis.throughput import Throughput
from stplan.certify.certificate import Certificate
from stplan.clock import Clock
from stplan.memory import MIB, peak
from stplan.nlp.ipopt.adapter import versions as ipopt_versions
from stplan.nlp.ipopt.linear_solvers import chosen_linear_solver
from stplan.optimize.continuation import Optimisation, OuterIteration
from stplan.optimize.cost_scales import CostScales
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene
from stplan.seeding.portfolio import Seed
from stplan.status import Status

if TYPE_CHECKING:
    from stplan.improvement.search import ImprovementRecord

FORMAT = 1


@dataclass(frozen=True)
class SeedReport:
    """Of the initial curves: what found them, at what effort, and how good they are."""

    found_by: str
    record: Mapping[str, float]
    smallest_clearance: float | None
    metrics: Metrics

    @staticmethod
    def of(seed: Seed, lines: WorldLines, certificate: Certificate, scene: Scene) -> SeedReport:
        """The report on a certified `seed` of `scene`; `lines` are its curves as the user's."""
        tightest = certificate.smallest
        return SeedReport(
            seed.found_by,
            seed.record.as_dict(),
            None if tightest is None else tightest.clearance,
            metrics(scene, lines),
        )

    def as_dict(self) -> dict[str, Any]:
        """For report.json."""
        return {
            "found_by": self.found_by,
            "record": dict(self.record),
            "smallest_clearance": self.smallest_clearance,
            "metrics": self.metrics.as_dict(),
        }


@dataclass(frozen=True)
class OptimisationReport:
    """Of the optimisation: the linear solver, the cost of every term at the end, the outer iterations.

    Attributes:
        scales: what the costs were weighed with.
    """

    linear_solver: str
    costs: Mapping[str, float]
    scales: CostScales
    outer_iterations: Sequence[OuterIteration]

    @staticmethod
    def of(scene: Scene, optimised: Optimisation) -> OptimisationReport:
        """The report on an optimisation of `scene`."""
        return OptimisationReport(
            chosen_linear_solver(scene),
            optimised.costs,
            optimised.scales,
            optimised.outer_iterations,
        )

    def as_dict(self) -> dict[str, Any]:
        """For report.json."""
        return {
            "linear_solver": self.linear_solver,
            "costs": dict(self.costs),
            "scales": self.scales.as_dict(),
            "outer_iterations": [done.as_dict() for done in self.outer_iterations],
        }


@dataclass(frozen=True)
class RivalReport:
    """Of one of several plans that were made: where it came from, what its seed and it cost, J s."""

    found_by: str
    start: float
    seed_cost: float
    plan_cost: float
    status: Status


@dataclass(frozen=True)
class Report:
    """What report.json holds.

    Attributes:
        certificate, metrics: of the trajectories, or of the seed where there is no more.
        optimisation: None where only a seed was asked for.
        rivals: all plans that were made, of which this is the cheapest; none where it is the only one.
        improvement: None where there was none, neither asked for nor as part of planning.
        bound: what the trajectories cost, and any others at least; None where only a seed was asked for.
        notes: what the user has to know about the map.
        arrivals: how fast the plan is; None where its cost was to be least.
        chases: what became of goals that move; None where there are none.
        robustness: what the trajectories forgive; None where nothing was asked.
        throughput: how many tasks were done in which time; None where there are none.
    """

    scene: Scene
    status: Status
    certificate: Certificate
    metrics: Metrics
    seed: SeedReport
    optimisation: OptimisationReport | None = None
    rivals: tuple[RivalReport, ...] = ()
    improvement: ImprovementRecord | None = None
    bound: CostBound | None = None
    notes: tuple[str, ...] = ()
    arrivals: ArrivalGap | None = None
    chases: Chases | None = None
    robustness: Robustness | None = None
    throughput: Throughput | None = None

    def as_dict(self) -> dict[str, Any]:
        """For report.json."""
        scene = self.scene
        content = {
            "format": FORMAT,
            "status": self.status,
            "advice": self.status.advice,
            "scene": {
                "name": scene.name,
                "source": None if scene.source is None else str(scene.source),
                "hash": scene.content_hash,
                # A run is checked later against the scene as it was planned.
                "overrides": list(scene.overrides),
                **({"time_scale": scene.time_scale} if scene.metric == "chosen" else {}),
                **({"horizon": scene.horizon} if scene.horizon_rule == "chosen" else {}),
            },
            "versions": versions(),
            "certificate": self.certificate.as_dict(),
            "metrics": self.metrics.as_dict(),
            "seed": self.seed.as_dict(),
        }
        if self.notes:
            content["notes"] = list(self.notes)
        if self.optimisation is not None:
            content |= self.optimisation.as_dict()
        if self.rivals:
            content["rivals"] = [asdict(one) for one in self.rivals]
        if self.bound is not None:
            content["bound"] = self.bound.as_dict()
        if self.arrivals is not None:
            content["arrivals"] = self.arrivals.as_dict()
        if self.chases is not None:
            content["chases"] = self.chases.as_dict()
        if self.robustness is not None:
            content["robustness"] = self.robustness.as_dict()
        if self.throughput is not None:
            content["throughput"] = self.throughput.as_dict()
        if self.improvement is not None:
            content["improvement"] = self.improvement.as_dict()
        return content


@dataclass(frozen=True)
class OptimisationTimes:
    """How the optimiser's time splits into evaluation and the rest, nearly all linear algebra; s.

    Attributes:
        whole: of the stage.
        objective, hessian: of evaluating the objective with its gradient, and the Hessian.
        parts: of processor time for parts that were optimised on their own, by whomever.
    """

    iterations: int
    whole: float
    objective: float
    hessian: float
    evaluations: int
    refused_steps: int
    hessian_nonzeros: int
    parts: float = 0.0

    @staticmethod
    def of(optimised: Optimisation, seconds: float) -> OptimisationTimes:
        """Those of an optimisation that took `seconds`."""
        watch = optimised.watch
        return OptimisationTimes(
            optimised.iterations, seconds, watch.objective, watch.hessian, watch.evaluations,
            watch.refused, optimised.nonzeros, watch.parts,
        )  # fmt: skip

    @property
    def evaluation(self) -> float:
        """Of all evaluations, s."""
        return self.objective + self.hessian

    def as_dict(self) -> dict[str, Any]:
        """For run.json."""
        return {
            "iterations": self.iterations,
            "seconds_per_iteration": self.whole / max(self.iterations, 1),
            "seconds": {
                "objective_and_gradient": self.objective,
                "hessian": self.hessian,
                "evaluation": self.evaluation,
                "linear_solve_and_rest": self.whole - self.evaluation,
                "parts": self.parts,
            },
            "evaluations": self.evaluations,
            "refused_steps": self.refused_steps,
            "hessian_nonzeros": self.hessian_nonzeros,
        }


@dataclass(frozen=True)
class RunRecord:
    """What run.json holds: whatever may differ between two runs of the same scene.

    Attributes:
        started: date and time, ISO 8601.
        seconds: of every stage, and in total.
        optimisation: None where only a seed was asked for.
    """

    started: str
    seconds: Mapping[str, float]
    optimisation: OptimisationTimes | None = None
    host: str = field(default_factory=node)
    platform: str = field(default_factory=platform_name)
    python: str = field(default_factory=python_version)
    peak_memory_mib: float = field(default_factory=lambda: round(peak() / MIB, 1))

    @staticmethod
    def of(clock: Clock, optimisation: OptimisationTimes | None = None) -> RunRecord:
        """The record of what `clock` timed in this process."""
        seconds = {**clock.seconds, "total": clock.total}
        return RunRecord(clock.started.isoformat(), seconds, optimisation)

    def and_then(self, clock: Clock) -> RunRecord:
        """The record of this and of what `clock` timed after it."""
        later = {**clock.seconds, "total": clock.total}
        names = [*(name for name in {**self.seconds, **later} if name != "total"), "total"]
        seconds = {name: self.seconds.get(name, 0.0) + later.get(name, 0.0) for name in names}
        return replace(self, seconds=seconds, peak_memory_mib=round(peak() / MIB, 1))

    def as_dict(self) -> dict[str, Any]:
        """For run.json."""
        content = {
            "started": self.started,
            "seconds": dict(self.seconds),
            "host": self.host,
            "platform": self.platform,
            "python": self.python,
            "peak_memory_mib": self.peak_memory_mib,
        }
        return content | (
            {} if self.optimisation is None else {"optimisation": self.optimisation.as_dict()}
        )


@cache
def versions() -> dict[str, str]:
    """Versions of this program and of what its results depend on."""
    names = ("stplan", "numpy", "scipy", "numba", "shapely", "trimesh")
    return {name: metadata.version(name) for name in names} | ipopt_versions()
