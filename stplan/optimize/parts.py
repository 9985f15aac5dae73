"""Parts of a problem, optimised one after another with all others' rods fixed meanwhile.

Every iterate of the whole stays feasible: of the others the stretches of curves in view are there, and what
came too near out of view is looked at afterwards; then the part is optimised anew with a wider view.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.callbacks import Stop, never, unheard
from stplan.compiled import working_time
from stplan.costs.formulation import TermSetup
from stplan.costs.registry import build_terms
from stplan.nlp.step_control import Stopwatch
from stplan.nlp.term import Capability
from stplan.optimize.assembly import formulate, padding
from stplan.optimize.continuation import LiveLine, Optimisation, OuterIteration, optimise
from stplan.optimize.cost_scales import CostScales, written_costs
from stplan.optimize.scales import pair_reaches
from stplan.optimize.surveyor import Surveyor
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.restriction import restricted
from stplan.problem.world_lines import WorldLines
from stplan.status import Status

# How far around its rods a part sees others, in ranges of the barriers; twice as far each time that this
# was too little.
VIEW = 3.0
MOST_VIEWS = 4


@dataclass(frozen=True)
class Part:
    """A part that is to be optimised.

    Attributes:
        agents: who, increasing.
        begin: values of mu that are left out.
        tolerance: factor on the scene's.
        beside: who is being moved at the same time: half of the room towards them is left to them.
        strength: factor on barriers around others who plan, too.
    """

    agents: IntArray
    begin: int = 0
    tolerance: float = 1.0
    beside: IntArray | None = None
    strength: float = 1.0


@dataclass(frozen=True)
class PartResult:
    """What became of a part.

    Attributes:
        agents: who, increasing.
        curves: theirs.
        iterations, nonzeros, watch: as for an `Optimisation`.
    """

    agents: IntArray
    curves: tuple[FloatArray, ...]
    iterations: int
    nonzeros: int
    watch: Stopwatch


class DividedProblem:
    """The curves of all, while parts of them are optimised.

    Args:
        problem: the whole.
        seed: clear curves.
        stop: asked after every iteration.
    """

    def __init__(self, problem: PlanningProblem, seed: WorldLines, stop: Stop) -> None:
        self.problem, self._seed, self.stop = problem, seed, stop
        self.formulation = formulate(problem, seed)
        self.surveyor = Surveyor(problem, self.formulation)
        self.knots = seed.knots.copy()
        self._watch = Stopwatch()
        self._iterations = self._nonzeros = 0

    def __getstate__(self) -> dict[str, Any]:
        """What travels to another machine, where nobody can be asked whether to stop.

        What takes a square of all pairs is made there.
        """
        scales = replace(self.formulation.scales, pair_reach=np.empty((0, 0)))
        formulation = replace(self.formulation, scales=scales)
        gone = {"surveyor": None, "_boxes": None, "_knots": None}
        return vars(self) | gone | {"stop": never, "formulation": formulation}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        reach = pair_reaches(self.problem, self.problem.distance)
        scales = replace(self.formulation.scales, pair_reach=reach)
        self.formulation = replace(self.formulation, scales=scales)
        self.surveyor = Surveyor(self.problem, self.formulation)
        self.knots = self._seed.knots

    @property
    def knots(self) -> FloatArray:
        """(M, 3) everybody's as they are now."""
        return self._knots

    @knots.setter
    def knots(self, knots: FloatArray) -> None:
        self._knots = knots
        # Of thousands of agents every look at all knots counts: there is one for every part.
        self._boxes = self.surveyor.boxes(knots, np.arange(self.problem.num_agents))

    def optimise(self, part: Part, live: LiveLine | None = None) -> Optimisation | None:
        """Some agents in view of the others; None where they cannot be moved without touching somebody."""
        found = self._optimised(part, live)
        if found is None:
            return None
        self.take(_result(*found))
        return found[1]

    def optimised(self, part: Part) -> PartResult | None:
        """Like `optimise`, with everybody left where they are."""
        begun = working_time()
        found = self._optimised(part, None)
        if found is None:
            return None
        result = _result(*found)
        result.watch.parts = working_time() - begun
        return result

    def _optimised(self, part: Part, live: LiveLine | None) -> tuple[IntArray, Optimisation] | None:
        solver = self.problem.scene.solver
        tolerance = part.tolerance * solver.optimality_tolerance
        scene = replace(self.problem.scene, solver=replace(solver, optimality_tolerance=tolerance))
        members = self.surveyor.with_partners(part.agents)
        problem = restricted(replace(self.problem, scene=scene), members)
        lines = WorldLines.from_curves(problem.agent_ids, [self.curve(agent) for agent in members])
        view = VIEW
        for _ in range(MOST_VIEWS):
            around = self.surveyor.around(
                self.knots, members, view, part.beside, part.strength, self._boxes
            )
            found = optimise(
                problem, lines, progress=unheard, stop=self.stop, begin=part.begin, live=live,
                formulation=formulate(problem, lines, surroundings=around),
            )  # fmt: skip
            moved = self.knots.copy()
            self._put(moved, members, found.world_lines.curves())
            boxes = self._boxes.renewed(members, self.surveyor.boxes(moved, members))
            if not len(self.surveyor.near(moved, members, 0.0, boxes).own):
                return members, found
            view *= 2.0
        return None

    def take(self, result: PartResult) -> None:
        """Move a part to where its optimisation led."""
        self._move(result.agents, result.curves)
        self._count(result)

    def take_clear(self, result: PartResult, groups: IntArray) -> IntArray:
        """Move those of a part who are clear of what others have become meanwhile; who was not moved.

        Who stays clears nobody's way, so it is asked again until all are clear. Of `groups` (A,) either all
        members of one are moved or none.
        """
        self._count(result)
        before = {agent: self.curve(agent).copy() for agent in result.agents.tolist()}
        self._move(result.agents, result.curves)
        left = result.agents
        while len(left):
            near = self.surveyor.near(self.knots, left, 0.0, self._boxes)
            touching = self.formulation.rods.agents[near.own]
            if not len(touching):
                break
            stay = np.isin(groups[left], groups[touching])
            back, left = left[stay], left[~stay]
            self._move(back, [before[agent] for agent in back.tolist()])
        return np.setdiff1d(result.agents, left)

    def _count(self, result: PartResult) -> None:
        self._iterations += result.iterations
        self._nonzeros = max(self._nonzeros, result.nonzeros)
        _add(self._watch, result.watch)

    def curve(self, agent: int) -> FloatArray:
        """(n + 1, 3) knots of an agent as it is now."""
        offsets = self.formulation.layout.offsets
        return self.knots[offsets[agent] : offsets[agent + 1]]

    def _move(self, agents: IntArray, curves: Iterable[FloatArray]) -> None:
        """Put `agents` on `curves`."""
        self._put(self._knots, agents, curves)
        self._boxes = self._boxes.renewed(agents, self.surveyor.boxes(self._knots, agents))

    def _put(self, knots: FloatArray, agents: IntArray, curves: Iterable[FloatArray]) -> None:
        """Put the knots of `agents` among all (M, 3) on `curves`."""
        offsets = self.formulation.layout.offsets
        for agent, curve in zip(agents.tolist(), curves, strict=True):
            knots[offsets[agent] : offsets[agent + 1]] = curve

    def in_view(self) -> IntArray:
        """(N, 2) pairs that collide and are in view of each other."""
        return self.surveyor.pairs_in_view(self.knots, VIEW)

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
        last = replace(first, padding=padding(first, self.knots))
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


def _result(agents: IntArray, found: Optimisation) -> PartResult:
    curves = tuple(found.world_lines.curves())
    return PartResult(agents, curves, found.iterations, found.nonzeros, found.watch)


def _add(watch: Stopwatch, other: Stopwatch) -> None:
    watch.objective += other.objective
    watch.hessian += other.hessian
    watch.evaluations += other.evaluations
    watch.refused += other.refused
    watch.parts += other.parts
