"""Levels: the roadmap of a margin and every agent's journey on it, worked out once for all who search it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement, requirement
from stplan.reasons import Reason
from stplan.seeding.infeasibility import not_connected, stranded, too_few_layers
from stplan.seeding.search.graph import Graph
from stplan.seeding.search.journeys import Journeys, automatic_layers
from stplan.seeding.search.planner import LayeredPlanner

# Roadmaps are so many times finer where the first one misses ways that the free space has.
REFINEMENTS = (2.0, 4.0)


@dataclass(frozen=True)
class Level:
    """Everything that depends on the margin alone.

    Attributes:
        margin: times the distances and radii that are kept.
        required: the distances that come of it.
        graph: places and moves between them.
        journeys: where every agent has to go on it.
    """

    problem: PlanningProblem
    margin: float
    required: Requirement
    graph: Graph
    journeys: Journeys

    @cached_property
    def layers(self) -> int:
        """Time layers to begin with."""
        asked = self.problem.scene.seeding.layers
        return asked or automatic_layers(self.problem, self.graph, self.journeys)

    def planner(self, layers: int, required: Requirement | None = None) -> LayeredPlanner:
        """A planner with `layers` times the layers, for other distances where `required` is given."""
        kept = self.required if required is None else required
        return LayeredPlanner(self.problem, self.graph, self.journeys, kept, layers * self.layers)


class Levels:
    """The levels of one problem, each made when it is first asked for.

    Attributes:
        ruled_out: margins whose roadmap is known to have no solution, and why.
    """

    def __init__(self, problem: PlanningProblem) -> None:
        self.problem = problem
        self.ruled_out: dict[float, tuple[Reason, ...]] = {}
        self._known: dict[float, Level] = {}

    def at(self, margin: float) -> Level:
        """The level of a margin, finer where the first roadmap misses ways that the free space has."""
        if margin not in self._known:
            self._known[margin] = self._connected(margin)
        return self._known[margin]

    def _connected(self, margin: float) -> Level:
        required = requirement(self.problem, margin)
        level = self._roadmap(margin, required, 1.0)
        if level.journeys.stranded() and not_connected(self.problem, required.walls):
            return level
        for refine in REFINEMENTS:
            if not level.journeys.stranded():
                break
            level = self._roadmap(margin, required, refine)
        return level

    def _roadmap(self, margin: float, required: Requirement, refine: float) -> Level:
        from stplan.seeding.search.roadmap import build_roadmap

        problem = self.problem
        movers = np.flatnonzero(~problem.prescribed)
        heeding = problem.heeds_walls[movers]
        radii = required.walls[movers]
        roadmap = build_roadmap(
            problem.free_space,
            np.vstack(problem.stops),
            radii[heeding] if heeding.any() else radii,
            ignores_walls=not heeding.all(),
            refine=refine,
            around=4.0 * float(problem.distance.max()),
        )
        journeys = Journeys(problem, roadmap.graph, roadmap.place_of, required)
        return Level(problem, margin, required, roadmap.graph, journeys)


def off_roadmap(level: Level) -> tuple[Reason, ...]:
    """Those whose stops the roadmap of a level does not connect."""
    return stranded(level.problem, level.journeys.stranded(), level.margin)


def out_of_layers(planner: LayeredPlanner) -> tuple[Reason, ...]:
    """Those who would be late even alone on the layers of a planner."""
    return too_few_layers(planner.problem, planner.too_late(), planner.grid.count)
