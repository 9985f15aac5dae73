"""Levels: the roadmap of a margin and every agent's journey on it, worked out once for all who search it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement, requirement
from stplan.reasons import Reason
from stplan.seeding.infeasibility import stranded, too_few_layers
from stplan.seeding.search.graph import Graph
from stplan.seeding.search.journeys import Journeys, automatic_layers, hasty_layers
from stplan.seeding.search.planner import LayeredPlanner
from stplan.seeding.search.way_edges import Track

if TYPE_CHECKING:
    from stplan.seeding.search.shortest_ways import Way


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
        if asked is None and self.problem.scene.minimise != "energy":
            return hasty_layers(self.problem, self.graph)
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

    @cached_property
    def ways(self) -> list[Way | None]:
        """Every agent's shortest way around the walls, None where it has none or heeds no walls."""
        from stplan.seeding.search.shortest_ways import shortest_ways

        return shortest_ways(self.problem)

    def at(self, margin: float) -> Level:
        """The level of a margin."""
        if margin not in self._known:
            self._known[margin] = self._level(margin)
        return self._known[margin]

    def _level(self, margin: float) -> Level:
        from stplan.seeding.search.roadmap import build_roadmap

        problem = self.problem
        required = with_ways(requirement(problem, margin), problem.radii, self.ways)
        movers = np.flatnonzero(~problem.prescribed)
        heeding = problem.heeds_walls[movers]
        radii = required.walls[movers]
        roadmap = build_roadmap(
            problem.free_space,
            np.vstack(problem.stops),
            radii[heeding] if heeding.any() else radii,
            tracks=tracks_of(self.ways, required),
            ignores_walls=not heeding.all(),
            around=4.0 * float(problem.distance.max()),
        )
        journeys = Journeys(problem, roadmap.graph, roadmap.place_of, required)
        return Level(problem, margin, required, roadmap.graph, journeys)


def with_ways(required: Requirement, radii: FloatArray, ways: Sequence[Way | None]) -> Requirement:
    """`required`, with no more distance to walls than shortest ways leave agents of these `radii` (A,)."""
    from stplan.seeding.search.shortest_ways import walls_kept

    return Requirement(required.rods, walls_kept(ways, radii, required.walls))


def tracks_of(ways: Sequence[Way | None], required: Requirement) -> list[Track]:
    """The ways, and how far off the walls agents that take them keep; of the largest first."""
    known = [
        Track(way.legs, float(kept))
        for way, kept in zip(ways, required.walls, strict=True)
        if way is not None
    ]
    return sorted(known, key=lambda track: -track.clearance)


def off_roadmap(level: Level) -> tuple[Reason, ...]:
    """Those whose stops the roadmap of a level does not connect."""
    return stranded(level.problem, level.journeys.stranded(), level.margin)


def out_of_layers(planner: LayeredPlanner) -> tuple[Reason, ...]:
    """Those who would be late even alone on the layers of a planner."""
    return too_few_layers(planner.problem, planner.too_late(), planner.grid.count)
