"""What report.json and run.json of a plan hold: the first is repeatable, the second is not."""

from __future__ import annotations

import platform
from functools import cache
from importlib import metadata
from typing import Any

from stplan.analysis.metrics import metrics
from stplan.certify.certificate import Certificate
from stplan.clock import Clock
from stplan.memory import MIB, peak
from stplan.nlp.ipopt.adapter import versions as ipopt_versions
from stplan.optimize.continuation import Optimisation
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene
from stplan.seeding.portfolio import Seed
from stplan.status import Status


def report(
    scene: Scene,
    seed: Seed,
    seed_certificate: Certificate,
    certificate: Certificate,
    lines: WorldLines,
    status: Status,
) -> dict[str, Any]:
    """What report.json holds of curves `lines` and their `certificate`."""
    tightest = seed_certificate.smallest
    return {
        "format": 1,
        "status": status,
        "advice": status.advice,
        "scene": {
            "name": scene.name,
            "source": None if scene.source is None else str(scene.source),
            "hash": scene.content_hash,
            # A run is checked later against the scene as it was planned.
            "overrides": list(scene.overrides),
        },
        "versions": versions(),
        "certificate": certificate.as_dict(),
        "metrics": metrics(scene, lines).as_dict(),
        "seed": {
            "found_by": seed.found_by,
            "record": seed.record.as_dict(),
            "smallest_clearance": None if tightest is None else tightest.clearance,
            "metrics": metrics(scene, seed.world_lines).as_dict(),
        },
    }


@cache
def versions() -> dict[str, str]:
    """Versions of this program and of what its results depend on."""
    names = ("stplan", "numpy", "scipy", "numba", "shapely", "trimesh")
    return {name: metadata.version(name) for name in names} | ipopt_versions()


def run_record(clock: Clock) -> dict[str, Any]:
    """What run.json holds of any planning."""
    return {
        "started": clock.started.isoformat(),
        "seconds": {**clock.seconds, "total": clock.total},
        "host": platform.node(),
        "platform": platform.platform(),
        "python": platform.python_version(),
        "peak_memory_mib": round(peak() / MIB, 1),
    }


def optimisation_times(optimised: Optimisation, clock: Clock) -> dict[str, Any]:
    """How the optimiser's time splits into evaluation and the rest, nearly all linear algebra."""
    whole = clock.seconds["optimise"]
    evaluation = optimised.watch.objective + optimised.watch.hessian
    return {
        "iterations": optimised.iterations,
        "seconds_per_iteration": whole / max(optimised.iterations, 1),
        "seconds": {
            "objective_and_gradient": optimised.watch.objective,
            "hessian": optimised.watch.hessian,
            "evaluation": evaluation,
            "linear_solve_and_rest": whole - evaluation,
        },
        "evaluations": optimised.watch.evaluations,
        "refused_steps": optimised.watch.refused,
        "hessian_nonzeros": optimised.nonzeros,
    }
