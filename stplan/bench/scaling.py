"""How the time of an iteration grows with agents, with knots and with the edges of walls.

Each sweep plans scenes that differ in one size, several random draws of each, and fits the exponent p
of time ~ size^p to the medians of the draws.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stplan.bench import families_open as wide
from stplan.bench.families_maze import maze
from stplan.bench.solves import SolveFigures, run, warm_up, with_solver
from stplan.callbacks import Progress
from stplan.scene.model import Scene
from stplan.world import build_free_space

SMALL_DRAWS, FULL_DRAWS = 1, 3
# Parts of an iteration that are fitted, as they are called in the tables.
PARTS = ("iteration", "evaluation", "linear algebra and rest", "Hessian nonzeros")


@dataclass(frozen=True)
class Sweep:
    """Scenes that grow in one direction.

    Attributes:
        name: of the command.
        size: what grows.
        scene: builds the scene of a size and a draw.
        small, full: the sizes of the small and of the full measurement.
        asked: the greatest exponent that is asked for.
    """

    name: str
    title: str
    size: str
    scene: Callable[[int, int], Scene]
    small: tuple[int, ...]
    full: tuple[int, ...]
    asked: float


@dataclass(frozen=True)
class Point:
    """One planned scene of a sweep.

    Attributes:
        size: what was asked for, the same for all draws.
        measured: what the scene came out with: a maze has only about the edges asked for.
    """

    size: int
    draw: int
    measured: int
    run: SolveFigures

    def part(self, name: str) -> float:
        """Milliseconds of a part of an iteration, or nonzeros."""
        whole = 1e3 * self.run.iteration_seconds
        values = {
            "iteration": whole,
            "evaluation": whole * self.run.evaluation_share,
            "linear algebra and rest": whole * (1.0 - self.run.evaluation_share),
            "Hessian nonzeros": float(self.run.hessian_nonzeros),
        }
        return values[name]


def _flows(agents: int, draw: int, knots: int) -> Scene:
    # An iteration is one of all together, however many they are.
    return with_solver(wide.crossing_flows(agents, 1.0, draw), knots=knots, blocks="all")


SWEEPS = {
    sweep.name: sweep
    for sweep in (
        Sweep(
            "agents",
            "crossing flows at 1 m/s and constant density, 40 knots an agent",
            "agents",
            lambda size, draw: _flows(size, draw, 40),
            (8, 16, 32, 64),
            (8, 16, 32, 64, 128, 256),
            1.2,
        ),
        Sweep(
            "knots",
            "crossing flows of 16 agents at 1 m/s",
            "knots per agent",
            lambda size, draw: _flows(16, draw, size),
            (30, 60, 120),
            (30, 60, 120, 240),
            1.2,
        ),
        Sweep(
            "walls",
            "three agents of 200 knots in a maze between hedges",
            "wall edges",
            maze,
            (1000, 4000, 10000),
            (1000, 2500, 5000, 10000, 20000),
            0.3,
        ),
    )
}


def measure(sweep: Sweep, *, full: bool, progress: Progress) -> list[Point]:
    """Plan every draw of every size, after untimed scenes that need every kernel."""
    progress(f"{sweep.name}: warm-up")
    warm_up()
    found = []
    for size in sweep.full if full else sweep.small:
        for draw in range(FULL_DRAWS if full else SMALL_DRAWS):
            point = measure_one(sweep, size, draw)
            found.append(point)
            progress(f"{sweep.name}: {size} {sweep.size}, draw {draw + 1}: {outcome(point)}")
    return found


def measure_one(sweep: Sweep, size: int, draw: int) -> Point:
    """Plan one draw of a size."""
    scene = sweep.scene(size, draw)
    free_space = build_free_space(scene)
    measured = size if free_space is None else len(free_space.boundary_edges)
    return Point(size, draw, measured, run(scene)[0])


def outcome(point: Point) -> str:
    """A point in one line."""
    one = point.run
    if not one.iterations:
        return one.status
    return (
        f"{point.part('iteration'):.2f} ms an iteration, evaluation {100 * one.evaluation_share:.0f} %, "
        f"{one.iterations} iterations, {one.hessian_nonzeros} nonzeros, {one.status}"
    )


def medians(points: Sequence[Point], part: str) -> tuple[list[float], list[float]]:
    """Mean measured sizes, growing, and the medians over the draws of each; failures do not count."""
    planned = [point for point in points if point.run.iterations]
    asked = sorted({point.size for point in planned})
    groups = [[point for point in planned if point.size == size] for size in asked]
    sizes = [float(np.mean([point.measured for point in group])) for group in groups]
    values = [float(np.median([point.part(part) for point in group])) for group in groups]
    return sizes, values


def exponent(points: Sequence[Point], part: str) -> float:
    """p of part ~ size^p by least squares in logarithms; nan of fewer than two sizes."""
    return growth(*medians(points, part))


def growth(sizes: Sequence[float], values: Sequence[float]) -> float:
    """p of values ~ sizes^p by least squares in logarithms; nan of fewer than two sizes."""
    if len(sizes) < 2:
        return float("nan")
    return float(np.polyfit(np.log(sizes), np.log(values), 1)[0])
