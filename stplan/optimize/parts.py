"""Parts of a problem, optimised one after another with all others' rods fixed meanwhile.

Every iterate of the whole stays feasible: of the others the stretches of curves in view are there, and what
came too near out of view is looked at afterwards; then the part is optimised anew with a wider view.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.costs.formulation import TermSetup
from stplan.costs.registry import build_terms
from stplan.geometry.rod_neighbours import near_segments
from stplan.nlp.step_control import Stopwatch
from stplan.nlp.term import Capability
from stplan.optimize.assembly import formulate
from stplan.optimize.continuation import LiveLine, Optimisation, OuterIteration, optimise
from stplan.optimize.cost_scales import CostScales, written_costs
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.restriction import Piece, restricted
from stplan.problem.world_lines import WorldLines
from stplan.scene.interactions import pair_clearances
from stplan.status import Status

# How far around its rods a part sees others, in ranges of the barriers; twice as far each time that this
# was too little.
VIEW = 3.0
MOST_VIEWS = 4
# Stretches of a rod out of view no longer than so many segments are not left out.
SHORT_GAP = 2


class DividedProblem:
    """The curves of all, while parts of them are optimised.

    Args:
        problem: the whole.
        seed: clear curves.
        stop: asked after every iteration.
    """

    def __init__(
        self, problem: PlanningProblem, seed: WorldLines, stop: Callable[[], bool]
    ) -> None:
        self.problem, self._seed, self._stop = problem, seed, stop
        self.formulation = formulate(problem, seed)
        self.knots = seed.knots.copy()
        self._range = self.formulation.scales.pair_reach
        wish = pair_clearances(problem.scene)
        self._wish = 0.0 if wish is None else wish
        self._watch = Stopwatch()
        self._iterations = self._nonzeros = 0

    def optimise(
        self,
        agents: IntArray,
        *,
        begin: int = 0,
        tolerance: float = 1.0,
        live: LiveLine | None = None,
    ) -> Optimisation | None:
        """Some agents in view of the others; None where they cannot be moved without touching somebody.

        Args:
            agents: who, increasing.
            begin: values of mu that are left out.
            tolerance: factor on the scene's.
        """
        solver = self.problem.scene.solver
        solver = replace(solver, optimality_tolerance=tolerance * solver.optimality_tolerance)
        whole = replace(self.problem, scene=replace(self.problem.scene, solver=solver))
        view = VIEW
        for _ in range(MOST_VIEWS):
            pieces = self._pieces(agents, view)
            part = restricted(whole, agents, pieces)
            curves = [self._curve(agent) for agent in agents] + [piece.curve for piece in pieces]
            lines = WorldLines.from_curves(part.agent_ids, curves)
            found = optimise(
                part, lines, progress=_unheard, stop=self._stop, begin=begin, live=live
            )
            self._iterations += found.iterations
            self._nonzeros = max(self._nonzeros, found.nonzeros)
            _add(self._watch, found.watch)
            before = self.knots.copy()
            for agent, curve in zip(agents, found.world_lines.curves(), strict=False):
                self._curve(agent)[:] = curve
            if not len(self._near(agents, 0.0)):
                return found
            self.knots = before
            view *= 2.0
        return None

    def in_view(self) -> BoolArray:
        """(A, A) whether a pair that collides is in view of each other."""
        rods, problem = self.formulation.rods, self.problem
        pairs = near_segments(
            rods.positions(self.knots), rods.segments, rods.agents, problem.collides,
            problem.distance + VIEW * self._range + self._wish,
        )  # fmt: skip
        seen = np.zeros_like(problem.collides)
        first, second = rods.agents[pairs].T
        seen[first, second] = seen[second, first] = True
        return seen

    def _curve(self, agent: int) -> FloatArray:
        offsets = self.formulation.layout.offsets
        return self.knots[offsets[agent] : offsets[agent + 1]]

    def _near(self, agents: IntArray, view: float) -> IntArray:
        """Segments of others that come nearer than they keep, and `view` ranges more."""
        rods, problem = self.formulation.rods, self.problem
        inside = np.zeros(problem.num_agents, dtype=bool)
        inside[agents] = True
        wish = self._wish if view else 0.0
        pairs = near_segments(
            rods.positions(self.knots), rods.segments, rods.agents,
            problem.collides & (inside[:, None] ^ inside[None, :]),
            problem.distance + view * self._range + wish, inside[rods.agents],
        )  # fmt: skip
        found = np.unique(pairs)
        return found[~inside[rods.agents[found]]]

    def _pieces(self, agents: IntArray, view: float) -> list[Piece]:
        """The stretches of others' curves in view of some agents."""
        near = self._near(agents, view)
        rods, layout = self.formulation.rods, self.formulation.layout
        own = len(layout.segment)
        tails = set(rods.agents[near[near >= own]].tolist())
        seen: dict[int, list[int]] = {agent: [] for agent in tails}
        for segment in near[near < own].tolist():
            agent = int(layout.agent_of_segment[segment])
            seen.setdefault(agent, []).append(int(layout.segment[segment] - layout.first[agent]))
        pieces = []
        for agent in sorted(seen):
            last = int(layout.num_segments[agent]) - 1
            segments = sorted({*seen[agent], *([last] if agent in tails else [])})
            for run in _runs(segments):
                curve = self._curve(agent)[run[0] : run[-1] + 2].copy()
                pieces.append(Piece(agent, curve, agent in tails and run[-1] == last))
        return pieces

    def price(self) -> float:
        """What the agents pay, without barriers, in the user's units."""
        terms = build_terms(TermSetup(self.formulation, self.knots, 0.0), Capability.PRICE)
        return sum(written_costs(terms, self.knots, self.problem.frame).values())

    def least_clearance(self) -> float:
        """The smallest that is felt, in the user's units; inf where none is."""
        setup = TermSetup(self.formulation, self.knots, self.formulation.scales.mu)
        terms = build_terms(setup, Capability.CLEARANCE)
        least = min((term.least_clearance(self.knots) for term in terms), default=np.inf)
        return self.problem.frame.length * least

    def costs(self, mu: float) -> dict[str, float]:
        """Every term that is defined, by its name, in the user's units."""
        terms = build_terms(TermSetup(self.formulation, self.knots, mu))
        costs = written_costs(terms, self.knots, self.problem.frame)
        return {name: cost for name, cost in costs.items() if np.isfinite(cost)}

    @property
    def last_mu(self) -> float:
        """The barrier's weight at the end."""
        solver = self.problem.scene.solver
        return self.formulation.scales.mu * solver.mu_decay ** (solver.outer_iterations - 1)

    def optimisation(
        self, status: Status, done: Sequence[OuterIteration], seed_costs: dict[str, float]
    ) -> Optimisation:
        """The whole as it is now.

        Parts were padded by what their own clearances allowed; what is left holds for all of them.
        """
        lines, first = self._seed.with_knots(self.knots), self.formulation
        last = replace(first, padding=formulate(self.problem, lines).padding)
        self.formulation = last
        return Optimisation(
            world_lines=lines,
            status=status,
            outer_iterations=tuple(done),
            costs=self.costs(self.last_mu),
            seed_costs=seed_costs,
            scales=CostScales(last, self.last_mu, {}),
            seed_scales=CostScales(first, first.scales.mu, {}),
            watch=self._watch,
            iterations=self._iterations,
            nonzeros=self._nonzeros,
        )


def _runs(segments: Sequence[int]) -> list[list[int]]:
    """Increasing indices cut where more than `SHORT_GAP` are left out."""
    runs: list[list[int]] = []
    for segment in segments:
        if runs and segment - runs[-1][-1] <= SHORT_GAP + 1:
            runs[-1].append(segment)
        else:
            runs.append([segment])
    return runs


def _add(watch: Stopwatch, other: Stopwatch) -> None:
    watch.objective += other.objective
    watch.hessian += other.hessian
    watch.evaluations += other.evaluations
    watch.refused += other.refused


def _unheard(line: str) -> None:
    del line
