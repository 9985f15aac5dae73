"""The paper's own scenes and sizes, planned by the default and by the paper's recipe."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stplan.bench import families_open as wide
from stplan.bench.families_maze import maze
from stplan.bench.scaling import Sweep, growth
from stplan.bench.solves import PricedSolve, priced, run, warm_up, with_solver
from stplan.callbacks import Progress
from stplan.costs.contacts.contact_term import ContactTerm
from stplan.costs.formulation import TermSetup
from stplan.costs.registry import build_terms
from stplan.nlp.term import Capability
from stplan.optimize.assembly import formulate
from stplan.planner import find_initial_curves, prepare
from stplan.scene.model import Scene, SolverSettings
from stplan.scene.presets import PAPER
from stplan.scene.reading.load import load_scene

# Scenes below the folder of all scenes, and what the paper shows by them.
FIGURES: Mapping[str, str] = {
    "three-agents/none": "asymmetric interactions, none",
    "three-agents/symmetric": "asymmetric interactions, symmetric",
    "three-agents/mass": "asymmetric interactions, stubborn",
    "three-agents/size": "asymmetric interactions, large and shy",
    "three-agents/size-and-mass": "asymmetric interactions, large and stubborn",
    "three-agents/friends": "asymmetric interactions, friends",
    "circle/circle-2": "circles of agents",
    "circle/circle-5": "circles of agents",
    "circle/circle-8": "circles of agents",
    "circle/circle-8-small": "circles of agents",
    "circle/circle-10": "circles of agents",
    "circle/circle-15": "circles of agents",
    "circle/circle-20": "circles of agents",
    "circle/circle-25": "circles of agents",
    "circle/circle-30": "circles of agents",
    "circle/circle-35": "circles of agents",
    "roomba/roomba": "maze of vacuum cleaners",
    "subway/platform": "subway platform",
    "aircraft/first-class": "aircraft",
    "tunnel/tunnel": "tunnel",
    "tight/warehouse": "warehouse of robots",
    "bottleneck/bottleneck": "flexible arrivals at a bottleneck",
    "mazes/corn": "corn maze",
    "pond/strangers": "pond, strangers",
    "pond/messenger": "pond, a message and an early arrival",
    "pond/meeting": "pond, a message",
    "flash-mob/flash-mob": "flash mob",
    "meadow/meadow": "large meadow",
}
SMALL_FIGURES = ("three-agents/symmetric", "circle/circle-5", "tunnel/tunnel")
SMALL_SECONDS, FULL_SECONDS = 20.0, 120.0
# Of more contacts than this no iteration is timed: it would take gigabytes.
MOST_CONTACTS = 2_500_000


@dataclass(frozen=True)
class Compared:
    """One of the paper's scenes by the default and by the paper's recipe."""

    scene: str
    shows: str
    default: PricedSolve
    paper: PricedSolve


def compare(files: Mapping[str, Path], seconds: float, *, progress: Progress) -> list[Compared]:
    """Every scene by either recipe, each stopped once it has had so many seconds of processor time."""
    warm_up()
    found = []
    for name, file in files.items():
        default = priced(load_scene(file), seconds)
        paper = priced(load_scene(file, ["preset=paper"]), seconds)
        found.append(Compared(name, FIGURES[name], default, paper))
        progress(
            f"{name}: {default.cost:.6g} in {default.seconds:.1f} s by default, "
            f"{paper.cost:.6g} in {paper.seconds:.1f} s by the paper's recipe, "
            f"{paper.figures.status}"
        )
    return found


def _recipe(scene: Scene) -> Scene:
    """`scene` by the paper's recipe, but for its knots, from the seeds of the default.

    What is measured is an iteration, and one and the same curves make the two comparable.
    """
    settings = {key: value for key, value in PAPER.solver.items() if key != "knots"}
    return with_solver(scene, **settings)


def _every_pair(scene: Scene) -> Scene:
    """`scene` with barriers of every pair of segments, which no broad phase can spare."""
    return with_solver(scene, barrier_range=float("inf"), clearance_model="contacts")


# What an iteration is measured of: three ways to sum barriers.
WAYS: Mapping[str, Callable[[Scene], Scene]] = {
    "default": lambda scene: scene,
    "paper": _recipe,
    "all pairs": _every_pair,
}


def _quick(scene: Scene, **solver: object) -> Scene:
    quick: SolverSettings = replace(scene.solver, effort="quick", starts=1)
    return with_solver(replace(scene, solver=quick), **solver)


# The paper's three plots of time: over agents, over nodes, over the boundary.
PLOTS = (
    Sweep(
        "paper-agents",
        "agents of 100 knots in crossing flows",
        "agents",
        lambda size, draw: _quick(wide.crossing_flows(size, 1.0, draw), knots=100),
        (4, 8),
        (4, 8, 16, 32),
        1.2,
    ),
    Sweep(
        "paper-knots",
        "a circle of 8 agents",
        "knots per agent",
        lambda size, draw: _quick(wide.circle(8, 8.0, 20.0), knots=size),
        (30, 60),
        (30, 60, 120, 180),
        1.2,
    ),
    Sweep(
        "paper-walls",
        "three agents of 200 knots in a maze",
        "wall edges",
        lambda size, draw: _quick(maze(size, draw)),
        (840, 1680),
        (840, 1680, 3360, 6720),
        0.3,
    ),
)


@dataclass(frozen=True)
class IterationTimes:
    """An iteration at one size of a plot, by the name of the way.

    Attributes:
        seconds: nan where none was made.
        contacts: that are listed around the initial curves, of agents and of walls.
    """

    plot: str
    size: int
    seconds: Mapping[str, float]
    contacts: Mapping[str, int]


def time_iterations(*, full: bool, progress: Progress) -> list[IterationTimes]:
    """An iteration of every way at every size of the paper's plots."""
    found = []
    for plot in PLOTS:
        for size in plot.full if full else plot.small:
            scene = plot.scene(size, 0)
            contacts = count_contacts(scene)
            seconds = dict.fromkeys(WAYS, np.nan)
            for way, change in WAYS.items():
                if contacts[way] <= MOST_CONTACTS:
                    seconds[way] = _iteration(change(scene))
            found.append(IterationTimes(plot.name, size, seconds, contacts))
            listed = ", ".join(
                f"{way} {1e3 * seconds[way]:.1f} ({contacts[way]} contacts)" for way in WAYS
            )
            progress(f"{plot.title}, {size} {plot.size}: {listed} ms an iteration")
    return found


def count_contacts(scene: Scene) -> dict[str, int]:
    """How many contacts every way lists around one and the same initial curves."""
    seed = find_initial_curves(prepare(scene))[0].seed.world_lines
    found = {}
    for way, change in WAYS.items():
        formulation = formulate(prepare(change(scene)), seed)
        terms = build_terms(TermSetup(formulation, seed.knots, 1.0), Capability.CLEARANCE)
        listed = [len(term.contacts.points) for term in terms if isinstance(term, ContactTerm)]
        found[way] = sum(listed)
    return found


def _iteration(scene: Scene) -> float:
    """Seconds an iteration of one outer iteration's first few."""
    few = with_solver(scene, outer_iterations=1, max_iterations=6)
    return run(few)[0].iteration_seconds


def growths(timings: Sequence[IterationTimes], plot: str) -> dict[str, tuple[float, float]]:
    """Exponents of time and of contacts over the size by way, nan where too few sizes were measured."""
    own = [one for one in timings if one.plot == plot]
    found = {}
    for way in WAYS:
        timed = [one for one in own if np.isfinite(one.seconds[way])]
        found[way] = (
            growth([float(one.size) for one in timed], [one.seconds[way] for one in timed]),
            growth([float(one.size) for one in own], [float(one.contacts[way]) for one in own]),
        )
    return found
