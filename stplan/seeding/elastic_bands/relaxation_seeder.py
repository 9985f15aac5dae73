"""Seeding by relaxation: from straight ways where walls leave them clear, else from the shortest ones."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.clearance import wall_clearance
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement, requirement
from stplan.reasons import Reason
from stplan.seeding.elastic_bands.relaxation import MOST_SWEEPS, NAME, RELAXATION_KNOTS, relax
from stplan.seeding.infeasibility import touching
from stplan.seeding.seeder import Budget, SeedAttempt

if TYPE_CHECKING:
    from stplan.seeding.search.levels import Levels


@dataclass(frozen=True)
class Relaxation:
    """Clear curves by pushing elastic bands apart.

    Attributes:
        max_sweeps: sweeps at most.
        levels: of the problem; they know shortest ways.
    """

    name: ClassVar = NAME
    problem: PlanningProblem
    max_sweeps: int = MOST_SWEEPS
    levels: Levels | None = None

    @cached_property
    def required(self) -> Requirement:
        """What the margin of the scene asks for."""
        return requirement(self.problem, self.problem.scene.seeding.margin)

    @cached_property
    def ways(self) -> list[FloatArray | None] | None:
        """Ways around the walls to start from, one an agent where it has any; None starts straight."""
        if straight_ways_are_clear(self.problem):
            return None
        from stplan.seeding.elastic_bands.geodesics import geodesic_curves

        return geodesic_curves(self.problem, None if self.levels is None else self.levels.ways)

    def attempt(self, budget: Budget) -> SeedAttempt:
        """Sweep until everybody is clear."""
        problem = self.problem
        ways = None if self.ways is None else [way for way in self.ways if way is not None]
        if ways is not None and len(ways) < problem.num_agents:
            return SeedAttempt(self.name, reasons=self._without_way())
        budget.progress("seeding by relaxation")
        found = relax(
            problem,
            self.required,
            ways,
            num_knots=problem.scene.solver.knots or RELAXATION_KNOTS,
            rng_seed=budget.rng_seed,
            max_sweeps=self.max_sweeps,
            stopped=budget.spent,
        )
        return found if found.clear else replace(found, reasons=_why(problem, found))

    def _without_way(self) -> tuple[Reason, ...]:
        named = zip(self.problem.agent_ids, self.ways or (), strict=True)
        return tuple(Reason("no way", (name,)) for name, way in named if way is None)


def _why(problem: PlanningProblem, found: SeedAttempt) -> tuple[Reason, ...]:
    """What relaxation could not part."""
    if found.touching:
        return touching(problem, found.curves, found.touching)
    near = tuple(
        name
        for agent, (name, curve) in enumerate(zip(problem.agent_ids, found.curves, strict=True))
        if wall_clearance(problem, agent, curve) <= problem.radii[agent]
    )
    return (Reason("walls", near),) if near else ()


def straight_ways_are_clear(problem: PlanningProblem) -> bool:
    """Whether walls leave every agent its straight way through its waypoints."""
    if problem.boundary is None:
        return True
    for agent in range(problem.num_agents):
        stops = np.vstack([problem.starts[agent], problem.waypoints[agent], problem.goals[agent]])
        way = np.column_stack([stops, np.arange(len(stops))])
        if wall_clearance(problem, agent, way) <= problem.radii[agent]:
            return False
    return True
