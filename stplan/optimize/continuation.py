"""The outer loop of the paper's algorithm: minimise, shrink mu by its decay, minimise again.

Every iterate of every run is feasible, so stopping at any moment leaves a valid plan. A run is cut short
and rebuilt (warm) when an interaction is felt that its sparsity structure has no room for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.formulation import Formulation
from stplan.nlp.backend import Backend
from stplan.nlp.ipopt.adapter import Ipopt
from stplan.nlp.ipopt.linear_solvers import chosen_linear_solver
from stplan.nlp.solution import Iteration, Solution, WarmStart
from stplan.nlp.step_control import StepControl, Stopwatch
from stplan.nlp.term import Term
from stplan.optimize.assembly import assemble, formulate, sharpness_of
from stplan.optimize.constraints import build_constraints
from stplan.optimize.cost_scales import CostScales, written_costs
from stplan.optimize.free_ends import into_place
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene
from stplan.status import Status

LiveLine = Callable[[Callable[[], str]], None]
Observer = Callable[[FloatArray, Sequence[Term]], None]

# A stale structure is rebuilt after at least this many iterations.
REBUILD_EVERY = 8


@dataclass(frozen=True)
class _Patience:
    """A run ends when the objective's relative fall over `window` iterations is below `share` of
    the optimality tolerance."""

    window: int
    share: float


# The last mu decides the plan; on the way to it the central path is only followed roughly.
ON_THE_WAY = _Patience(window=2, share=1e-1)
AT_THE_END = _Patience(window=4, share=1e-2)


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


class _Stop:
    """Decides after every iteration whether an outer iteration is over, and remembers why.

    Runs that are only cut short for a new structure count as one: `control` is the present one's.
    """

    def __init__(
        self, scene: Scene, floor: float, patience: _Patience, interrupted: Callable[[], bool]
    ) -> None:
        self._solver = scene.solver
        self._floor = floor
        self._patience = patience
        self._interrupted = interrupted
        # The paper's centimetre suits people; a maze of vacuum cleaners needs a share of their size.
        self._step_unit = min(1.0, *(agent.radius for agent in scene.agents))
        self._values: list[float] = []
        self.control: StepControl | None = None
        self.status: Status | None = None
        self.stale = False

    def __call__(self, iteration: Iteration) -> bool:
        if iteration.number or not self._values:
            self._values.append(iteration.objective)
        self.stale = False
        if self._interrupted():
            self.status = Status.INTERRUPTED
        elif iteration.number >= REBUILD_EVERY and self.control and self.control.is_stale():
            self.stale = True
        elif self._has_converged(iteration):
            self.status = Status.CONVERGED
        return self.stale or self.status is not None

    def _has_converged(self, iteration: Iteration) -> bool:
        if iteration.number < 1:
            return False
        small = self._solver.step_tolerance * self._step_unit
        if iteration.step <= small and not iteration.damped:
            return True
        window = self._patience.window
        if len(self._values) <= window:
            return False
        fall = self._values[-1 - window] - self._values[-1]
        scale = max(abs(self._values[-1] - self._floor), 1e-12)
        return fall <= self._patience.share * self._solver.optimality_tolerance * scale


def optimise(
    problem: PlanningProblem,
    seed: WorldLines,
    *,
    progress: Callable[[str], None],
    stop: Callable[[], bool],
    observe: Observer | None = None,
    live: LiveLine | None = None,
    backend: Backend | None = None,
) -> Optimisation:
    """Make `seed` smooth and cheap by the paper's outer loop.

    Args:
        progress: called with one line an outer iteration.
        stop: asked after every iteration; True ends with the best feasible curves.
        observe: called with the knots (M, 3) and the terms of the objective after every iteration.
        live: given a maker of the same line after every iteration, to be called at once or not at all.
        backend: what solves the nonlinear programs, Ipopt as the scene has it by default.

    Raises:
        SolverError: Ipopt lacks the linear solver or an option asked for.
    """
    formulation = formulate(problem, seed)
    solver = ipopt(problem.scene) if backend is None else backend
    loop = _Loop(formulation, seed, solver, progress, stop, observe, live)
    return loop.run()


def ipopt(scene: Scene) -> Ipopt:
    """The backend that `scene` asks for.

    Raises:
        SolverError: the installed Ipopt lacks the linear solver asked for.
    """
    solver = scene.solver
    return Ipopt(
        chosen_linear_solver(scene), solver.hessian == "limited-memory", dict(solver.ipopt)
    )


class _Loop:
    def __init__(
        self,
        formulation: Formulation,
        seed: WorldLines,
        backend: Backend,
        progress: Callable[[str], None],
        stop: Callable[[], bool],
        observe: Observer | None,
        live: LiveLine | None,
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
        self._watch = Stopwatch()
        self._sharpness: dict[str, FloatArray] = {}
        self._done: list[OuterIteration] = []
        self._seed_costs: dict[str, float] = {}
        self._seed_scales = CostScales(formulation, formulation.scales.mu, {})
        self._iterations = self._nonzeros = 0
        self._mu = formulation.scales.mu
        self._terms: Sequence[Term] = ()
        # What the regularity term costs at its best: no part of the objective worth converging.
        self._floor = float((formulation.scales.regularity * formulation.layout.num_segments).sum())

    def run(self) -> Optimisation:
        """All outer iterations, or until one is interrupted or gets nowhere."""
        solver = self._formulation.problem.scene.solver
        mu = self._formulation.scales.mu
        for outer in range(solver.outer_iterations):
            moved = self._outer_iteration(outer, mu)
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
            mu *= solver.mu_decay
        return self._result()

    def _outer_iteration(self, outer: int, mu: float) -> bool:
        """Minimise at one mu; returns whether that changed the objective.

        From a seed that touches something nothing is done.
        """
        scene = self._formulation.problem.scene
        patience = AT_THE_END if outer == scene.solver.outer_iterations - 1 else ON_THE_WAY
        stop = _Stop(scene, self._floor, patience, self._stop)
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
                return False
            self._nonzeros = max(self._nonzeros, len(program.hessian_structure[0]))
            stop.control, stop.stale = control, False
            solution = self._backend.solve(
                control,
                self._knots,
                max_iterations=scene.solver.max_iterations - used,
                objective_scale=1.0 / self._formulation.scales.energy,
                stop=self._watched(stop, control, outer, mu, used),
                warm_start=warm_start,
            )
            self._knots = solution.knots
            self._sharpness = sharpness_of(control.terms)
            used += solution.iterations
            damping = control.damping
            if not stop.stale or used >= scene.solver.max_iterations:
                break
            warm_start = solution.warm_start
            rebuilds += 1
        self._iterations += used
        self._terms = control.terms
        self._mu = mu
        after, frame = control.value(self._knots.ravel()), self._formulation.problem.frame
        self._done.append(
            OuterIteration(
                outer + 1, frame.cost * mu, used, rebuilds, sum(self._costs(control.terms).values()),
                frame.length * control.least_clearance(self._knots),
                _judge(stop, solution, moved=before != after),
            )
        )  # fmt: skip
        return before != after

    def _line(self, outer: int, mu: float, objective: float, least: float, used: int) -> str:
        total = self._formulation.problem.scene.solver.outer_iterations
        return (
            f"outer {outer + 1}/{total}  mu {mu:.3g}  objective {objective:.6g}  "
            f"rod clearance {least:.3g} m  {used} iterations"
        )

    def _watched(
        self, stop: _Stop, control: StepControl, outer: int, mu: float, used: int
    ) -> Callable[[Iteration], bool]:
        """`stop`, telling the observer and the live line about every iteration."""
        frame = self._formulation.problem.frame

        def watched(iteration: Iteration) -> bool:
            if self._observe is not None:
                self._observe(iteration.knots, control.terms)
            over = stop(iteration)
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


def _judge(stop: _Stop, solution: Solution, moved: bool) -> Status:
    """How an outer iteration ended: as its last run did, unless it was stopped for a reason."""
    if stop.status is not None:
        return stop.status
    # Stopped only to be rebuilt, with no iterations left for that.
    if solution.status in (Status.INTERRUPTED, Status.LIMIT):
        return Status.LIMIT if moved else Status.FAILED
    return solution.status
