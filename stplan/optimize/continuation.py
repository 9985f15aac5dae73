"""The outer loop of the paper's algorithm: minimise, shrink mu by its decay, minimise again.

Every iterate of every run is feasible, so stopping at any moment leaves a valid plan. A run is cut short
and rebuilt (warm) when an interaction is felt that its sparsity structure has no room for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from stplan.arrays import FloatArray
from stplan.callbacks import Progress, Stop
from stplan.costs.formulation import Formulation
from stplan.nlp.backend import Backend
from stplan.nlp.ipopt.adapter import Ipopt
from stplan.nlp.ipopt.linear_solvers import chosen_linear_solver
from stplan.nlp.solution import Iteration, Solution, WarmStart
from stplan.nlp.step_control import StepControl, Stopwatch
from stplan.nlp.term import Term
from stplan.optimize.assembly import assemble, formulate, sharpness_of
from stplan.optimize.constraints import build_constraints
from stplan.optimize.convergence import AT_THE_END, ON_THE_WAY, Judge
from stplan.optimize.cost_scales import CostScales, written_costs
from stplan.optimize.free_ends import into_place
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene
from stplan.status import Status

LiveLine = Callable[[Callable[[], str]], None]
Observer = Callable[[FloatArray, Sequence[Term]], None]
# Asked after an outer iteration with its objective, in the user's units, and how many are still to come.
Proceed = Callable[[float, int], bool]
# From what judges, the run's control and the iterations before it to what is asked after every iteration.
Watched = Callable[[Judge, StepControl, int], Callable[[Iteration], bool]]

# Barriers of the lead-in become so much weaker every outer iteration, until they have their own size.
LEAD_IN_DECAY = 0.3


@dataclass(frozen=True)
class OuterIteration:
    """What one mu led to; repeatable (no times).

    Attributes:
        number: from 1.
        mu: barrier weight, in the user's units as the objective.
        iterations: of the solver, over all its runs.
        rebuilds: how often it was rebuilt for a new sparsity structure.
        objective: at the end, at this mu.
        clearance: the smallest that is felt, m; inf where none is.
        status: how it ended.
    """

    number: int
    mu: float
    iterations: int
    rebuilds: int
    objective: float
    clearance: float
    status: Status

    def as_dict(self) -> dict[str, Any]:
        """The entry of a report."""
        return {
            "outer_iteration": self.number,
            "mu": self.mu,
            "iterations": self.iterations,
            "rebuilds": self.rebuilds,
            "objective": self.objective,
            "clearance": self.clearance,
            "status": self.status,
        }


@dataclass(frozen=True)
class Optimisation:
    """The optimised curves and how they were reached.

    Attributes:
        status: how the last outer iteration ended that did not fail; failed where all did.
        outer_iterations: one an outer iteration; none where the seed touches something.
        costs: every term at the optimised curves and the last mu, by its name, in the user's units; those
            that are defined there.
        seed_costs: every term at the seed and the first mu, alike.
        scales, seed_scales: what these costs were weighed with.
        watch: seconds, for the run record only.
        iterations: of the solver in all.
        nonzeros: most entries of a Hessian.
    """

    world_lines: WorldLines
    status: Status
    outer_iterations: tuple[OuterIteration, ...]
    costs: Mapping[str, float]
    seed_costs: Mapping[str, float]
    scales: CostScales
    seed_scales: CostScales
    watch: Stopwatch = field(default_factory=Stopwatch)
    iterations: int = 0
    nonzeros: int = 0


def optimise(
    problem: PlanningProblem,
    seed: WorldLines,
    *,
    progress: Progress,
    stop: Stop,
    observe: Observer | None = None,
    live: LiveLine | None = None,
    backend: Backend | None = None,
    formulation: Formulation | None = None,
    begin: int = 0,
    proceed: Proceed | None = None,
) -> Optimisation:
    """Make `seed` smooth and cheap by the paper's outer loop.

    Args:
        progress: called with one line an outer iteration.
        stop: asked after every iteration; True ends with the best feasible curves.
        observe: called with the knots (M, 3) and the terms of the objective after every iteration.
        live: given a maker of the same line after every iteration, to be called at once or not at all.
        backend: what solves the nonlinear programs, Ipopt as the scene has it by default.
        formulation: of `problem` and `seed`, where it is known already.
        begin: outer iterations of the scene's settings that `seed` has behind it, from an earlier run.
        proceed: False ends with what there is then.

    Raises:
        SolverError: Ipopt lacks the linear solver or an option asked for.
    """
    formulation = formulation or formulate(problem, seed)
    solver = ipopt(problem.scene) if backend is None else backend
    loop = _Loop(formulation, seed, solver, progress, stop, observe, live, proceed)
    return loop.run(begin)


def ipopt(scene: Scene) -> Ipopt:
    """The backend that `scene` asks for.

    Raises:
        SolverError: the installed Ipopt lacks the linear solver asked for.
    """
    solver = scene.solver
    return Ipopt(
        chosen_linear_solver(scene), solver.hessian == "limited-memory", dict(solver.ipopt)
    )


@dataclass(frozen=True)
class _Minimised:
    """What came of minimising at one mu; `before` is the objective there was."""

    control: StepControl
    solution: Solution
    iterations: int
    rebuilds: int
    before: float


class _Loop:
    def __init__(
        self,
        formulation: Formulation,
        seed: WorldLines,
        backend: Backend,
        progress: Progress,
        stop: Stop,
        observe: Observer | None,
        live: LiveLine | None,
        proceed: Proceed | None,
    ) -> None:
        self._formulation = formulation
        self._constraints = build_constraints(
            formulation.problem, formulation.layout, seed.knots, formulation.timed
        )
        self._seed = seed
        self._knots = seed.knots
        self._backend = backend
        self._progress = progress
        self._stop = stop
        self._observe = observe
        self._live = live
        self._proceed = proceed
        self._watch = Stopwatch()
        self._sharpness: dict[str, FloatArray] = {}
        self._done: list[OuterIteration] = []
        self._seed_costs: dict[str, float] = {}
        self._seed_scales = CostScales(formulation, formulation.scales.mu, {})
        self._mu = formulation.scales.mu
        self._iterations = self._nonzeros = self._total = 0
        self._terms: Sequence[Term] = ()

    def run(self, begin: int) -> Optimisation:
        """All outer iterations, or until one is interrupted or gets nowhere."""
        given = self._formulation.scales
        schedule = _schedule(self._formulation, begin)
        self._total = len(schedule)
        for outer, (mu, factor) in enumerate(schedule):
            scales = given.lead_in(factor) if factor > 1.0 else given
            self._formulation = replace(self._formulation, scales=scales)
            self._mu = mu
            moved = self._outer_iteration(outer, mu, mu * factor)
            if not self._done:
                break
            done = self._done[-1]
            self._progress(
                f"{self._line(outer, done.mu, done.objective, done.clearance, done.iterations)}"
                f"  {done.status}"
            )
            # Where nothing moves any more, curves are too near their limits: the last mu's are the result.
            if done.status is Status.INTERRUPTED or (done.status is Status.FAILED and not moved):
                break
            left = self._total - outer - 1
            if left and self._proceed is not None and not self._proceed(done.objective, left):
                break
        return self._result()

    def _outer_iteration(self, outer: int, mu: float, greatest: float) -> bool:
        """Minimise at one mu; returns whether that changed the objective.

        `greatest` is what mu is said to be: in the lead-in, that of the agents who feel most of it.
        """
        patience = AT_THE_END if outer == self._total - 1 else ON_THE_WAY
        judge = Judge(self._formulation, patience, self._stop)
        done = self._minimise(
            mu, judge,
            lambda judge, control, used: self._watched(judge, control, outer, greatest, used),
        )  # fmt: skip
        if done is None:
            return False
        control, frame = done.control, self._formulation.problem.frame
        moved = done.before != control.value(self._knots.ravel())
        self._done.append(
            OuterIteration(
                outer + 1, frame.cost * greatest, done.iterations, done.rebuilds,
                sum(self._costs(control.terms).values()),
                frame.length * control.least_clearance(self._knots),
                _judged(judge, done.solution, moved),
            )
        )  # fmt: skip
        return moved

    def _minimise(self, mu: float, judge: Judge, watched: Watched) -> _Minimised | None:
        """Move the knots to where the objective at `mu` is least, as `judge` sees it.

        From a seed that touches something nothing is done: None.
        """
        scene = self._formulation.problem.scene
        warm_start: WarmStart | None = None
        used = rebuilds = 0
        damping = 0.0
        before: float | None = None
        while True:
            program = assemble(
                self._formulation, self._constraints, self._knots, mu, sharpness=self._sharpness
            )
            control = StepControl(program, self._knots, damping=damping, watch=self._watch)
            if before is None:
                before = control.value(self._knots.ravel())
            if not self._seed_costs:
                self._seed_costs = self._costs(control.terms)
                self._seed_scales = CostScales(self._formulation, mu, sharpness_of(control.terms))
                self._terms = control.terms
            if not np.isfinite(before):
                return None
            self._nonzeros = max(self._nonzeros, len(program.hessian_structure[0]))
            judge.control, judge.stale = control, False
            solution = self._backend.solve(
                control,
                self._knots,
                max_iterations=scene.solver.max_iterations - used,
                objective_scale=1.0 / self._formulation.scales.energy,
                stop=watched(judge, control, used),
                warm_start=warm_start,
            )
            self._knots = solution.knots
            self._sharpness = sharpness_of(control.terms)
            used += solution.iterations
            damping = control.damping
            if not judge.stale or used >= scene.solver.max_iterations:
                break
            warm_start = solution.warm_start
            rebuilds += 1
        self._iterations += used
        self._terms = control.terms
        return _Minimised(control, solution, used, rebuilds, before)

    def _line(self, outer: int, mu: float, objective: float, least: float, used: int) -> str:
        return (
            f"outer {outer + 1}/{self._total}  mu {mu:.3g}  objective {objective:.6g}  "
            f"rod clearance {least:.3g} m  {used} iterations"
        )

    def _watched(
        self, judge: Judge, control: StepControl, outer: int, mu: float, used: int
    ) -> Callable[[Iteration], bool]:
        """`judge`, telling the observer and the live line about every iteration."""
        frame = self._formulation.problem.frame

        def watched(iteration: Iteration) -> bool:
            if self._observe is not None:
                self._observe(iteration.knots, control.terms)
            over = judge(iteration)
            if self._live is not None:
                self._live(
                    lambda: self._line(
                        outer, frame.cost * mu, frame.cost * iteration.objective,
                        frame.length * control.least_clearance(iteration.knots),
                        used + iteration.number,
                    )
                )  # fmt: skip
            return over

        return watched

    def _costs(self, terms: Sequence[Term]) -> dict[str, float]:
        """What every term costs, without those that are undefined."""
        costs = written_costs(terms, self._knots, self._formulation.problem.frame)
        return {name: cost for name, cost in costs.items() if np.isfinite(cost)}

    def _result(self) -> Optimisation:
        """What was reached, with the cost of every term at the last mu."""
        sound = [done.status for done in self._done if done.status is not Status.FAILED]
        return Optimisation(
            world_lines=self._seed.with_knots(into_place(self._constraints, self._knots)),
            status=sound[-1] if sound else Status.FAILED,
            outer_iterations=tuple(self._done),
            costs=self._costs(self._terms),
            seed_costs=self._seed_costs,
            scales=CostScales(self._formulation, self._mu, self._sharpness)
            if self._done
            else self._seed_scales,
            seed_scales=self._seed_scales,
            watch=self._watch,
            iterations=self._iterations,
            nonzeros=self._nonzeros,
        )


def _schedule(formulation: Formulation, begin: int) -> list[tuple[float, float]]:
    """mu of every outer iteration from `begin` on, and how much stronger barriers may still be meanwhile.

    Where agents pay much more than what their motion costs, a lead-in goes before: see `Scales.lead_in`.
    """
    solver, scales = formulation.problem.scene.solver, formulation.scales
    mu = scales.mu * solver.mu_decay**begin
    lead = int(np.ceil(np.log(scales.excess.max()) / np.log(1.0 / LEAD_IN_DECAY) - 1.0))
    leading = [(mu, LEAD_IN_DECAY**-ahead) for ahead in range(max(lead, 0), 0, -1)]
    outers = range(begin, solver.outer_iterations)
    return leading + [(scales.mu * solver.mu_decay**outer, 1.0) for outer in outers]


def _judged(judge: Judge, solution: Solution, moved: bool) -> Status:
    """How an outer iteration ended: as its last run did, unless it was stopped for a reason."""
    if judge.status is not None:
        return judge.status
    # Stopped only to be rebuilt, with no iterations left for that.
    if solution.status in (Status.INTERRUPTED, Status.LIMIT):
        return Status.LIMIT if moved else Status.FAILED
    return solution.status
