"""Optimisations of rivals of a plan, given up early where they do not look worth it.

A few iterations at the barrier's last weights tell nearly as much as a whole optimisation: curves that cost
more than 1.03 times the best plan after them never became cheaper than it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from stplan.analysis.own_costs import own_costs
from stplan.optimize.continuation import Optimisation, optimise
from stplan.optimize.scales import derive_scales
from stplan.problem.layout import KnotLayout
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import SolverSettings

# Curves dearer than so many times the best plan after a short run are not optimised to the end.
SHORT_SCREEN = 1.03
SHORT_ITERATIONS = 15


@dataclass
class Trials:
    """Optimisations of one problem, beside a plan of it.

    Attributes:
        reference: curves of the plan, or its seed: they give the barrier's first weight.
        stop: asked after every iteration.
        iterations: that were made.
    """

    problem: PlanningProblem
    reference: WorldLines
    stop: Callable[[], bool]
    iterations: int = 0
    _settings: tuple[SolverSettings, SolverSettings] = field(init=False)

    def __post_init__(self) -> None:
        self._settings = _settings(self.problem, self.reference)

    def shortly(self, lines: WorldLines, best: float) -> WorldLines | None:
        """`lines` after a short run, None where that was stopped or leaves them much dearer than `best`."""
        found = self._run(lines, self._settings[0]).world_lines
        return None if self.stop() or self.cost(found) > SHORT_SCREEN * best else found

    def fully(self, lines: WorldLines) -> Optimisation:
        """What `lines`, after a short run, come to in the end."""
        return self._run(lines, self._settings[1])

    def cost(self, lines: WorldLines) -> float:
        """What all agents pay by themselves, J s."""
        return float(own_costs(self.problem.scene, lines).sum())

    def _run(self, lines: WorldLines, settings: SolverSettings) -> Optimisation:
        problem = replace(self.problem, scene=replace(self.problem.scene, solver=settings))
        found = optimise(problem, lines, progress=_unheard, stop=self.stop)
        self.iterations += found.iterations
        return found


def _settings(problem: PlanningProblem, lines: WorldLines) -> tuple[SolverSettings, SolverSettings]:
    """Of a short run and of a full one: both end where the scene's own settings would, or before."""
    solver = problem.scene.solver
    first = derive_scales(problem, KnotLayout.from_offsets(lines.offsets), lines.knots).mu
    outer = solver.outer_iterations
    short = replace(
        solver,
        mu=first * solver.mu_decay ** max(outer - 3, 0),
        outer_iterations=1,
        max_iterations=min(SHORT_ITERATIONS, solver.max_iterations),
    )
    full = replace(
        solver, mu=first * solver.mu_decay ** max(outer - 2, 0), outer_iterations=min(outer, 2)
    )
    return short, full


def _unheard(line: str) -> None:
    del line
