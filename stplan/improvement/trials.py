"""Optimisations of rivals of a plan, given up early where they do not look worth it.

A few iterations at the barrier's last weights tell nearly as much as a whole optimisation: curves that cost
more than 1.03 times the best plan after them never became cheaper than it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from stplan.analysis.own_costs import own_costs
from stplan.callbacks import Stop, unheard
from stplan.optimize.continuation import Optimisation, optimise
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import SolverSettings

# Curves dearer than so many times the best plan after a short run are not optimised to the end.
SHORT_SCREEN = 1.03
SHORT_ITERATIONS = 15
# Short and full runs begin so many outer iterations before the end.
SHORT_FROM_END, FULL_FROM_END = 3, 2


@dataclass
class Trials:
    """Optimisations of one problem, beside a plan of it.

    Attributes:
        stop: asked after every iteration.
        iterations: that were made.
    """

    problem: PlanningProblem
    stop: Stop
    iterations: int = 0

    def shortly(self, lines: WorldLines, best: float) -> WorldLines | None:
        """`lines` after a short run, None where that was stopped or leaves them much dearer than `best`."""
        solver = self.problem.scene.solver
        begin = max(solver.outer_iterations - SHORT_FROM_END, 0)
        short = replace(
            solver,
            outer_iterations=min(begin + 1, solver.outer_iterations),
            max_iterations=min(SHORT_ITERATIONS, solver.max_iterations),
        )
        found = self._run(lines, short, begin).world_lines
        return None if self.stop() or self.cost(found) > SHORT_SCREEN * best else found

    def fully(self, lines: WorldLines) -> Optimisation:
        """What `lines`, after a short run, come to in the end."""
        solver = self.problem.scene.solver
        return self._run(lines, solver, max(solver.outer_iterations - FULL_FROM_END, 0))

    def cost(self, lines: WorldLines) -> float:
        """What all agents pay by themselves, J s."""
        return float(own_costs(self.problem.scene, lines).sum())

    def _run(self, lines: WorldLines, settings: SolverSettings, begin: int) -> Optimisation:
        problem = replace(self.problem, scene=replace(self.problem.scene, solver=settings))
        found = optimise(problem, lines, progress=unheard, stop=self.stop, begin=begin)
        self.iterations += found.iterations
        return found
