"""The outer loop of the paper's algorithm: minimise, shrink mu by its decay, minimise again.

Every iterate of every run is feasible, so stopping at any moment leaves a valid plan. A run is cut short
and rebuilt (warm) when an interaction is felt that its sparsity structure has no room for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from stplan.arrays import FloatArray
from stplan.costs.contacts.contact_term import ContactTerm
from stplan.costs.term import Term
from stplan.nlp.ipopt.adapter import FAILURES, IpoptResult, Iteration, Multipliers, solve
from stplan.nlp.ipopt.linear_solvers import chosen_linear_solver
from stplan.nlp.problem import Problem, Stopwatch
from stplan.optimize.assembly import Assembly, Formulation, build_limits
from stplan.optimize.scales import derive_scales
from stplan.optimize.timed_constraints import find_timed_constraints
from stplan.problem.layout import KnotLayout
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene
from stplan.seeding.rendezvous import Rendezvous
from stplan.status import Status

LiveLine = Callable[[Callable[[], str]], None]

# A stale structure is rebuilt after at least this many iterations.
REBUILD_EVERY = 8
# Relative padding of all distances; halved clearance of the seed where that is less.
PADDING = 1e-4


@dataclass(frozen=True)
class _Patience:
    """A run ends when the objective's relative fall over `window` iterations is below `share` of
    the optimality tolerance."""

    window: int
    share: float


# The last mu decides the plan; on the way to it the central path is only followed roughly.
ON_THE_WAY = _Patience(window=2, share=1e-1)
AT_THE_END = _Patience(window=4, share=1e-2)

Observer = Callable[[FloatArray, Sequence[Term]], None]


@dataclass
class Optimisation:
    """The optimised curves and how they were reached.

    Attributes:
        status: how the last outer iteration ended.
        record: one entry an outer iteration, repeatable (no times).
        watch: seconds, for the run record only.
    """

    world_lines: WorldLines
    status: Status
    record: list[dict[str, Any]]
    costs: dict[str, float]
    watch: Stopwatch = field(default_factory=Stopwatch)
    iterations: int = 0
    nonzeros: int = 0


class _Stop:
    """Decides after every iteration whether an outer iteration is over, and remembers why.

    Runs of Ipopt that are only cut short for a new structure count as one: `problem` is the present one's.
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
        self.problem: Problem | None = None
        self.why = ""

    def __call__(self, iteration: Iteration) -> bool:
        if iteration.number or not self._values:
            self._values.append(iteration.objective)
        self.why = self._reason(iteration)
        return bool(self.why)

    def _reason(self, iteration: Iteration) -> str:
        if self._interrupted():
            return "interrupted"
        if iteration.number >= REBUILD_EVERY and self.problem and self.problem.is_stale():
            return "stale"
        if iteration.number < 1:
            return ""
        small = self._solver.step_tolerance * self._step_unit
        if iteration.step <= small and not iteration.damped:
            return "converged"
        window = self._patience.window
        if len(self._values) > window:
            fall = self._values[-1 - window] - self._values[-1]
            scale = max(abs(self._values[-1] - self._floor), 1e-12)
            if fall <= self._patience.share * self._solver.optimality_tolerance * scale:
                return "converged"
        return ""


def optimise(
    problem: PlanningProblem,
    seed: WorldLines,
    *,
    progress: Callable[[str], None],
    stop: Callable[[], bool],
    observe: Observer | None = None,
    live: LiveLine | None = None,
) -> Optimisation:
    """Make `seed` smooth and cheap by the paper's outer loop.

    Args:
        progress: called with one line an outer iteration.
        stop: asked after every iteration; True ends with the best feasible curves.
        observe: called with the knots (M, 3) and the terms of the objective after every iteration.
        live: given a maker of the same line after every iteration, to be called at once or not at all.

    Raises:
        SolverError: Ipopt lacks the linear solver or an option asked for.
    """
    layout = KnotLayout.from_offsets(seed.offsets)
    formulation = formulate(problem, layout, seed.knots)
    loop = _Loop(formulation, seed.knots, progress, stop, observe, live)
    loop.run()
    return loop.result(seed)


def formulate(
    problem: PlanningProblem,
    layout: KnotLayout,
    knots: FloatArray,
    *,
    free_times: bool = False,
    planned: Sequence[Rendezvous] = (),
) -> Formulation:
    """What stays the same while `problem` is optimised from seed `knots` (M, 3).

    With `free_times`, visits and meetings are bound in place only. Pairs with a `planned` place meet there.
    """
    timed = find_timed_constraints(problem, layout, knots, planned)
    formulation = Formulation(
        problem=problem,
        layout=layout,
        scales=derive_scales(problem, layout, knots),
        limits=build_limits(problem, layout, knots, timed, free_times=free_times),
        timed=timed,
        padding=0.0,
    )
    return _padded(formulation, knots)


def _padded(formulation: Formulation, knots: FloatArray) -> Formulation:
    """The formulation with as much padding as the seed's clearance allows."""
    terms = Assembly(formulation).interaction_terms(knots, 0.0)
    least = _least_clearance(terms, knots)
    widest = float(formulation.problem.distance.max())
    return replace(formulation, padding=float(min(PADDING, 0.5 * max(least, 0.0) / widest)))


def _least_clearance(terms: Sequence[Term], knots: FloatArray) -> float:
    """Smallest clearance that a barrier sees, m; inf where there are no barriers."""
    contacts = [term for term in terms if isinstance(term, ContactTerm)]
    return min((term.least_clearance(knots) for term in contacts), default=float("inf"))


class _Loop:
    def __init__(
        self,
        formulation: Formulation,
        knots: FloatArray,
        progress: Callable[[str], None],
        interrupted: Callable[[], bool],
        observe: Observer | None,
        live: LiveLine | None,
    ) -> None:
        self._formulation = formulation
        self._assembly = Assembly(formulation)
        self._knots = knots
        self._progress = progress
        self._interrupted = interrupted
        self._observe = observe
        self._live = live
        self._linear_solver = chosen_linear_solver(formulation.problem.scene)
        self._watch = Stopwatch()
        self._record: list[dict[str, Any]] = []
        self._status = Status.CONVERGED
        self._iterations = 0
        self._nonzeros = 0
        self._terms: Sequence[Term] = ()
        # What the regularity term costs at its best: no part of the objective worth converging.
        self._floor = float((formulation.scales.regularity * formulation.layout.num_segments).sum())

    def run(self) -> None:
        """All outer iterations, or until one is interrupted or fails."""
        solver = self._formulation.problem.scene.solver
        mu = self._formulation.scales.mu
        for outer in range(solver.outer_iterations):
            before = self._status
            self._outer_iteration(outer, mu)
            if self._status is Status.FAILED and outer > 0:
                # Too near its limits to move at all: what the last mu left is the result.
                self._status = before
                return
            if self._status in (Status.INTERRUPTED, Status.FAILED):
                return
            mu *= solver.mu_decay

    def _outer_iteration(self, outer: int, mu: float) -> None:
        solver = self._formulation.problem.scene.solver
        left = solver.max_iterations
        multipliers: Multipliers | None = None
        ipopt_mu: float | None = None
        used = rebuilds = 0
        damping = 0.0
        before: float | None = None
        patience = AT_THE_END if outer == solver.outer_iterations - 1 else ON_THE_WAY
        stop = _Stop(self._formulation.problem.scene, self._floor, patience, self._interrupted)
        while True:
            problem = self._assembly.problem(self._knots, mu, self._watch, damping)
            self._nonzeros = max(self._nonzeros, len(problem.hessian_rows))
            if before is None:
                before = problem.value(self._knots.ravel())
            stop.problem = problem
            watched = self._watched(stop, problem, outer, mu, used)
            outcome = self._solve(problem, left, watched, multipliers, ipopt_mu)
            self._knots = outcome.knots
            used += outcome.iterations
            left = solver.max_iterations - used
            damping = problem.damping
            if stop.why != "stale" or left <= 0:
                break
            multipliers = outcome.multipliers
            ipopt_mu = outcome.ipopt_mu
            rebuilds += 1
        self._iterations += used
        after = problem.value(self._knots.ravel())
        self._terms = problem.terms
        self._status = self._judge(outcome, stop.why, before, after)
        least = _least_clearance(problem.terms, self._knots)
        self._record.append(
            {
                "outer_iteration": outer + 1,
                "mu": mu,
                "iterations": used,
                "rebuilds": rebuilds,
                "objective": after,
                "clearance": least,
                "status": self._status,
            }
        )
        self._progress(f"{self._line(outer, mu, after, least, used)}  {self._status}")

    def _line(self, outer: int, mu: float, objective: float, least: float, used: int) -> str:
        return (
            f"outer {outer + 1}/{self._formulation.problem.scene.solver.outer_iterations}  mu {mu:.3g}  "
            f"objective {objective:.6g}  rod clearance {least:.3g} m  {used} iterations"
        )

    def _watched(
        self, stop: _Stop, problem: Problem, outer: int, mu: float, used: int
    ) -> Callable[[Iteration], bool]:
        """`stop`, telling the observer and the live line about every iteration."""

        def watched(iteration: Iteration) -> bool:
            if self._observe is not None:
                self._observe(iteration.knots, problem.terms)
            over = stop(iteration)
            if self._live is not None:
                self._live(
                    lambda: self._line(
                        outer, mu, iteration.objective,
                        _least_clearance(problem.terms, iteration.knots), used + iteration.number,
                    )
                )  # fmt: skip
            return over

        return watched

    def _solve(
        self,
        problem: Problem,
        left: int,
        stop: Callable[[Iteration], bool],
        multipliers: Multipliers | None,
        ipopt_mu: float | None,
    ) -> IpoptResult:
        solver = self._formulation.problem.scene.solver
        return solve(
            problem,
            self._knots,
            max_iterations=left,
            linear_solver=self._linear_solver,
            objective_scale=1.0 / self._formulation.scales.energy,
            limited_memory=solver.hessian == "limited-memory",
            options=solver.ipopt,
            stop=stop,
            multipliers=multipliers,
            ipopt_mu=ipopt_mu,
        )

    def _judge(self, outcome: IpoptResult, why: str, before: float, after: float) -> Status:
        if why == "interrupted":
            return Status.INTERRUPTED
        if why == "converged" or outcome.status in (0, 1):
            return Status.CONVERGED
        if outcome.status in FAILURES and before == after:
            return Status.FAILED
        return Status.LIMIT

    def result(self, seed: WorldLines) -> Optimisation:
        """What was reached, with the cost of every term at the last mu."""
        costs = {term.name: term.value(self._knots) for term in self._terms}
        return Optimisation(
            world_lines=seed.with_knots(self._knots),
            status=self._status,
            record=self._record,
            costs=costs,
            watch=self._watch,
            iterations=self._iterations,
            nonzeros=self._nonzeros,
        )
