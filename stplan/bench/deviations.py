"""What each deviation of the default from the paper's recipe gains: all but one of them kept at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stplan.bench.markdown import number, table
from stplan.bench.solves import priced, warm_up
from stplan.callbacks import Progress
from stplan.scene.reading.load import load_scene
from stplan.world import build_free_space

DEFAULT = "the default"
# What is as in the paper, as `--set` has it. Alpha and the cutoff of the Hessian belong to smooth minima.
VARIANTS: Mapping[str, tuple[str, ...]] = {
    DEFAULT: (),
    "initial curves": ("seeding.method=dijkstra", "seeding.shortcuts=false"),
    "distance": ("solver.clearance_model=smooth-minimum",),
    "distance and alpha": ("solver.clearance_model=smooth-minimum", "solver.alpha_rule=stepped"),
    "distance and Hessian": (
        "solver.clearance_model=smooth-minimum",
        "solver.hessian_cutoff=4.5e-5",
    ),
    "barrier": ("solver.barrier_range=.inf",),
    "mu": ("solver.mu_decay=0.75",),
    "nodes": ("solver.knots=100",),
    "end of a solve": ("solver.convergence=first-order",),
    "metric": ("time_scale=1",),
    "one start": ("solver.effort=quick", "solver.starts=1"),
    "all of them": ("preset=paper",),
}
SMALL_SCENES = ("three-agents/symmetric", "tunnel/tunnel")
FULL_SCENES = (
    "three-agents/symmetric",
    "three-agents/size-and-mass",
    "circle/circle-8",
    "circle/circle-15",
    "roomba/roomba",
    "subway/platform",
    "tunnel/tunnel",
    "bottleneck/bottleneck",
    "pond/strangers",
    "pond/messenger",
)


@dataclass(frozen=True)
class Trial:
    """A variant's plan of a scene.

    Attributes:
        cost: of all agents by themselves, nan without a certified plan.
        seconds: of processor time, seeding included.
    """

    variant: str
    scene: str
    cost: float
    iterations: int
    seconds: float


@dataclass(frozen=True)
class Gain:
    """What a variant is over the default, on the scenes that both plan.

    Attributes:
        planned: scenes with a certified plan.
        cost, iterations, seconds: geometric means of the ratios, nan where there is none.
        worst: greatest ratio of costs.
    """

    variant: str
    planned: int
    cost: float
    worst: float
    iterations: float
    seconds: float


def measure(files: Mapping[str, Path], seconds: float, *, progress: Progress) -> list[Trial]:
    """Every variant on every scene, each stopped after so many seconds of processor time."""
    warm_up()
    found = []
    for name, file in files.items():
        for variant, settings in VARIANTS.items():
            one = priced(load_scene(file, list(settings)), seconds)
            found.append(Trial(variant, name, one.cost, one.figures.iterations, one.seconds))
            progress(f"{name}: {variant} as in the paper: {one.cost:.6g} in {one.seconds:.1f} s")
    return found


def gains(outcomes: Sequence[Trial]) -> list[Gain]:
    """Every variant beside the default."""
    known = {(one.variant, one.scene): one for one in outcomes}
    scenes = list(dict.fromkeys(one.scene for one in outcomes))
    found = []
    for variant in VARIANTS:
        own = [known[variant, scene] for scene in scenes]
        both = [
            (one, known[DEFAULT, one.scene])
            for one in own
            if np.isfinite([one.cost, known[DEFAULT, one.scene].cost]).all()
        ]
        costs = [one.cost / default.cost for one, default in both]
        found.append(
            Gain(
                variant,
                sum(bool(np.isfinite(one.cost)) for one in own),
                _mean(costs),
                max(costs, default=np.nan),
                _mean([max(a.iterations, 1) / max(b.iterations, 1) for a, b in both]),
                _mean([a.seconds / b.seconds for a, b in both]),
            )
        )
    return found


def _mean(ratios: Sequence[float]) -> float:
    return float(np.exp(np.mean(np.log(ratios)))) if ratios else np.nan


@dataclass(frozen=True)
class Snapping:
    """What the nearest vertices of meshes do to starts and goals.

    Attributes:
        places: starts and goals on maps that are meshes.
        away: of the furthest one from its nearest vertex, m.
        in_walls: places whose nearest vertex is nearer to a wall than the agent's radius.
    """

    places: int
    away: float
    in_walls: int


def snap_places(files: Mapping[str, Path]) -> Snapping:
    """Starts and goals put on the nearest vertices of their meshes, as the paper does."""
    places, away, in_walls = 0, 0.0, 0
    for file in files.values():
        scene = load_scene(file)
        free_space = build_free_space(scene)
        if free_space is None or free_space.triangles is None:
            continue
        vertices = np.unique(free_space.triangles.reshape(-1, 2), axis=0)
        asked = np.array([place for agent in scene.agents for place in (agent.start, agent.goal)])
        radii = np.repeat([agent.radius for agent in scene.agents], 2)
        distance = np.linalg.norm(asked[:, None] - vertices, axis=2)
        nearest = vertices[distance.argmin(axis=1)]
        places += len(asked)
        away = max(away, float(distance.min(axis=1).max()))
        in_walls += int((free_space.clearance(nearest) <= radii).sum())
    return Snapping(places, away, in_walls)


def deviations_text(outcomes: Sequence[Trial], snapping: Snapping) -> str:
    """The gains as a table, and what snapping would do."""
    scenes = len({one.scene for one in outcomes})
    head = (
        "as in the paper", f"planned, of {scenes}", "cost", "dearest", "iterations", "processor time",
        "--set",
    )  # fmt: skip
    rows = [
        (
            one.variant,
            str(one.planned),
            number(one.cost, ".4f"),
            number(one.worst, ".3f"),
            number(one.iterations, ".2f"),
            number(one.seconds, ".2f"),
            " ".join(f"`{setting}`" for setting in VARIANTS[one.variant]),
        )
        for one in gains(outcomes)
    ]
    goals = (
        f"Goals: of {snapping.places} starts and goals on maps that are meshes the nearest vertex is up to "
        f"{snapping.away:.2f} m away, and at {snapping.in_walls} of them nearer to a wall than the agent's "
        "radius."
    )
    return f"{table(head, rows, words=(0, 6))}\n{goals}\n"
