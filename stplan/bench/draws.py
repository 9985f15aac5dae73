"""How near default plans are to the best that any method finds, on random draws of tight families.

Every draw is planned by default, with other random numbers, with more effort, by single seeders, and the
default plan is improved by a number of moves. The cheapest of all these is the best known; what the default
costs over it is the price of asking for nothing.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from stplan.bench.families_tight import FAMILIES
from stplan.bench.named_scenes import named
from stplan.bench.solves import plan_cost, priced, warm_up
from stplan.callbacks import Progress
from stplan.errors import SeedingError
from stplan.improvement.budget import ImprovementBudget
from stplan.planner import improve, plan
from stplan.scene.model import Scene

# Corridors are left out: two agents have a class or two, and nothing to choose.
DRAWN = tuple(name for name in FAMILIES if not name.startswith("corridor"))
# Of the generator of draws, with the family's place and the number of the draw.
RNG_SEED = 13
DEFAULT, IMPROVED = "default", "improved"
# Single methods may look so long for a seed, s of processor time.
TIME_LIMIT = 20.0


def _seeded(number: int) -> Callable[[Scene], Scene]:
    return lambda scene: replace(scene, seeding=replace(scene.seeding, rng_seed=number))


def _by(method: Literal["relaxation", "search", "dijkstra"]) -> Callable[[Scene], Scene]:
    return lambda scene: replace(
        scene, seeding=replace(scene.seeding, method=method, time_limit=TIME_LIMIT)
    )


def _best(scene: Scene) -> Scene:
    return replace(scene, solver=replace(scene.solver, effort="best"))


# What competes with the default, by name.
METHODS: Mapping[str, Callable[[Scene], Scene]] = {
    "rng_seed 1": _seeded(1),
    "rng_seed 2": _seeded(2),
    "effort best": _best,
    "relaxation": _by("relaxation"),
    "search": _by("search"),
    "dijkstra": _by("dijkstra"),
}


@dataclass(frozen=True)
class DrawTrial:
    """One draw of a family, planned in every way.

    Attributes:
        draw: its number in the family, from 0.
        costs: of all agents by themselves, `own_costs`, by method; nan where it found no certified plan.
        seconds: of processor time, of the default alone.
    """

    family: str
    draw: int
    agents: int
    costs: Mapping[str, float]
    seconds: float

    @property
    def best(self) -> str:
        """The method that is cheapest, the default where nothing else is cheaper; empty where none is."""
        known = {name: cost for name, cost in self.costs.items() if not np.isnan(cost)}
        return min(known, key=known.__getitem__) if known else ""

    @property
    def excess(self) -> float:
        """What the default costs over the best, as a share; inf where only others have a plan."""
        if not self.best:
            return np.nan
        cost = self.costs[DEFAULT]
        return np.inf if np.isnan(cost) else cost / self.costs[self.best] - 1.0


def chosen(names: list[str]) -> list[str]:
    """The families with one of `names` in their own, all where there is none; UsageError for others."""
    return named(DRAWN, names)


def drawn(family: str, draw: int) -> Scene:
    """A draw of a family, which leaves the metric to the program as scenes do by default."""
    rng = np.random.default_rng([RNG_SEED, DRAWN.index(family), draw])
    return replace(FAMILIES[family](rng), metric="auto")


def measure(
    families: list[str],
    draws: int,
    moves: int,
    *,
    methods: Mapping[str, Callable[[Scene], Scene]] = METHODS,
    progress: Progress,
) -> list[DrawTrial]:
    """So many draws of every family, the default plans improved by so many moves."""
    warm_up()
    found = []
    for family in families:
        for draw in range(draws):
            found.append(_tried(family, draw, moves, methods))
            one = found[-1]
            progress(
                f"{family} {draw}: {one.costs[DEFAULT]:.6g} in {one.seconds:.1f} s, "
                f"{100.0 * one.excess:.1f} % over {one.best or 'nothing'}"
            )
    return found


def _tried(
    family: str, draw: int, moves: int, methods: Mapping[str, Callable[[Scene], Scene]]
) -> DrawTrial:
    scene = drawn(family, draw)
    costs = {DEFAULT: np.nan, IMPROVED: np.nan}
    began = time.process_time()
    try:
        planned = plan(scene)
        seconds = time.process_time() - began
        costs[DEFAULT] = plan_cost(scene, planned)
        costs[IMPROVED] = plan_cost(scene, improve(planned, ImprovementBudget(moves=moves)))
    except SeedingError:
        seconds = time.process_time() - began
    costs |= {name: priced(changed(scene)).cost for name, changed in methods.items()}
    return DrawTrial(family, draw, len(scene.agents), costs, seconds)
