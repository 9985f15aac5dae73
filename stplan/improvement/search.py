"""Large-neighbourhood search on a finished plan.

An optimisation keeps the homotopy class of its seed. Here other curves are proposed for a few agents of the
best plan, all agents are optimised for a few iterations, and what looks worth it is optimised to the end. A
plan is kept where it is cheaper and holds its certificate, so the best one only ever gets cheaper, and may be
taken at any moment. Kinds of moves that gained much for the iterations they took are tried more often.

Three screens save most of the work: a proposal that is much dearer before it is optimised, one that is dearer
after a few iterations, and one whose class was optimised before, are given up. docs/method.md tells where
their limits come from.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from stplan.analysis.own_costs import own_costs
from stplan.arrays import FloatArray
from stplan.callbacks import Progress, Stop, unheard
from stplan.certify.certificate import Certificate, certify
from stplan.compiled import working_time
from stplan.deadline import OutOfTimeError, until
from stplan.improvement.budget import ImprovementBudget
from stplan.improvement.proposals import MOVES, Proposals
from stplan.improvement.trials import Trials
from stplan.optimize.continuation import LiveLine, Optimisation
from stplan.optimize.restoration import asks_for_more, restore
from stplan.problem.kinetic_cost import kinetic_cost
from stplan.problem.launches import Launches
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.seeding.homotopy import signature

# Dearer proposals than so many times the present plan are not optimised at all: all that ever succeeded
# were below 1.13.
PREPARED_SCREEN = 1.2
# A plan has to be cheaper by this share to be kept.
WORTHWHILE = 1e-4
# What kinds of moves are worth at least of what they were at first, how slowly that changes, and at most.
LEAST_SHARE, MEMORY, MOST_WORTH = 0.15, 0.9, 10.0
# Percent gained per so many iterations is worth 1.
WORTH_UNIT = 50.0


@dataclass(frozen=True)
class ImprovementRecord:
    """What came of an improvement.

    Attributes:
        moves, accepted: tried, and how many of them led to a cheaper plan.
        cost_before, cost_after: of all agents, `own_costs`.
        history: of every accepted move its number, its kind and the cost after it.
        kinds: of every kind of move, how many were tried and accepted.
    """

    moves: int
    accepted: int
    cost_before: float
    cost_after: float
    history: tuple[dict[str, Any], ...]
    kinds: dict[str, dict[str, int]]

    @property
    def sentence(self) -> str:
        """What came of it, in words."""
        saved = 100.0 * (1.0 - self.cost_after / self.cost_before) if self.cost_before > 0 else 0.0
        return (
            f"improved in {self.accepted} of {self.moves} moves: cost {self.cost_before:.6g} -> "
            f"{self.cost_after:.6g}, {saved:.2f} % less"
        )

    def as_dict(self) -> dict[str, Any]:
        """For the report."""
        return asdict(self)


@dataclass(frozen=True)
class Improvement:
    """The best plan, and how it was come by.

    Attributes:
        world_lines: as the user's.
        certificate: of it; it holds.
        optimisation: that led to it, None where nothing was gained.
        record: for the report; repeatable where the budget is one of moves.
        interrupted: whether it was asked to stop.
    """

    world_lines: WorldLines
    certificate: Certificate
    optimisation: Optimisation | None
    record: ImprovementRecord
    interrupted: bool


def improve(
    problem: PlanningProblem,
    lines: WorldLines,
    budget: ImprovementBudget,
    *,
    rng_seed: int = 0,
    progress: Progress,
    stop: Stop,
    live: LiveLine | None = None,
) -> Improvement:
    """The cheapest plan that the moves of `budget` lead to, `lines` where they lead to none.

    Args:
        lines: a plan of `problem`, as the user's, that holds its certificate.
        rng_seed: of all random numbers.
        progress: is told a line for every plan that is kept.
        stop: asked again and again; True ends with the best plan so far.
        live: given a maker of a line after every move.
    """
    search = _Search(problem, lines, rng_seed, budget, stop)
    while search.goes_on():
        search.move()
        if search.kept_last:
            progress(search.line())
        elif live is not None:
            live(search.line)
    return search.result()


@dataclass
class _Tally:
    """What one kind of move has come to."""

    worth: float
    least: float
    tried: int = 0
    kept: int = 0

    def add(self, gain: float, iterations: float) -> None:
        """Count a move that gained this share of the cost for the effort of so many iterations."""
        self.tried += 1
        self.kept += gain > 0.0
        rate = 100.0 * gain * WORTH_UNIT / iterations
        self.worth = max(self.least, MEMORY * self.worth + (1.0 - MEMORY) * min(rate, MOST_WORTH))


@dataclass
class _Best:
    """The plan that is best so far."""

    lines: WorldLines
    cost: float
    optimisation: Optimisation | None = None
    history: list[dict[str, Any]] = field(default_factory=list)


class _Search:
    def __init__(
        self,
        problem: PlanningProblem,
        lines: WorldLines,
        rng_seed: int,
        budget: ImprovementBudget,
        stop: Stop,
    ) -> None:
        self._problem = problem
        self._given = lines
        lines = problem.written.inside(lines)
        self._rng = np.random.default_rng(rng_seed)
        self._budget = budget
        self._deadline = working_time() + budget.seconds
        self._stop = stop
        self._launches = Launches.of_curves(problem, list(lines.curves()))
        self._proposals = Proposals(
            problem if self._launches is None else self._launches.problem, self._rng
        )
        self._tallies = {move: _Tally(move.worth, LEAST_SHARE * move.worth) for move in MOVES}
        self._known: set[bytes] = set()
        self._least: FloatArray | None = None
        self._moves, self._effort = 0, 0.0
        self._trials = Trials(problem, self._stopped)
        self.kept_last = False
        self._start = float(own_costs(problem.scene, lines).sum())
        self._best = _Best(lines, self._start)

    def goes_on(self) -> bool:
        """Whether there is another move to be tried."""
        problem = self._problem
        if problem.prescribed.all() or not problem.collides.any() or self._start <= 0.0:
            return False  # Nobody can go another way round anybody, or gain by it.
        spent = self._moves >= self._budget.moves or self._effort >= self._budget.effort
        return not spent and not self._stopped()

    def _stopped(self) -> bool:
        return self._stop() or working_time() > self._deadline

    def move(self) -> None:
        """Try one move, and keep the plan it leads to where that is cheaper and certified, in time."""
        with until(self._deadline), suppress(OutOfTimeError):
            self._move()

    def _move(self) -> None:
        if not self._known:
            self._take_up()
        worth = np.array([tally.worth for tally in self._tallies.values()])
        move = MOVES[int(self._rng.choice(len(MOVES), p=worth / worth.sum()))]
        before, used = self._best.cost, self._trials.iterations
        self._moves += 1
        curves = self._proposals.propose(move, self._stopped)
        if curves is not None and self._launches is not None:
            curves = self._launches.joined(curves)
        found = None if curves is None else self._optimised(curves)
        self.kept_last = found is not None
        if found is not None:
            self._best = found
            found.history.append({"move": self._moves, "by": str(move), "cost": found.cost})
            self._take_up()
        effort = move.effort + self._trials.iterations - used
        self._effort += effort
        self._tallies[move].add(1.0 - self._best.cost / before, effort)

    def line(self) -> str:
        """How far things are."""
        return f"improving: {self.record().sentence}"

    def result(self) -> Improvement:
        """The best plan, with its certificate."""
        best, written = self._best, self._problem.written
        lines = self._given if best.optimisation is None else written.outside(best.lines)
        return Improvement(
            lines,
            certify(written.scene, written.free_space, lines),
            best.optimisation,
            self.record(),
            self._stop(),
        )

    def record(self) -> ImprovementRecord:
        """What has come of it so far."""
        best = self._best
        kinds = {
            str(move): {"tried": tally.tried, "accepted": tally.kept}
            for move, tally in self._tallies.items()
        }
        cost = self._problem.frame.cost
        history = tuple(one | {"cost": cost * one["cost"]} for one in best.history)
        return ImprovementRecord(
            self._moves, len(history), cost * self._start, cost * best.cost, history, kinds
        )

    def _take_up(self) -> None:
        """Propose changes to the best plan from now on."""
        lines, scene = self._best.lines, self._problem.scene
        curves = list(lines.curves())
        launches = Launches.of_curves(self._problem, curves)
        if launches is not None and self._best.optimisation is not None:
            self._launches = launches
            self._proposals = Proposals(launches.problem, self._rng)
        if self._least is None:
            ways = self._proposals.ways[: self._problem.num_agents]
            self._least = _least_costs(self._problem, ways)
        self._known.add(signature(self._problem, curves))
        excess = own_costs(scene, lines) - self._least
        if self._launches is not None:
            curves = self._launches.parted(curves)
            excess = np.pad(excess, (0, len(curves) - len(excess)))
        self._proposals.start_from(curves, excess)

    def _optimised(self, curves: list[FloatArray]) -> _Best | None:
        """The plan that `curves` lead to, None where it is no cheaper, or looks so."""
        problem = self._problem
        lines = WorldLines.from_curves(problem.agent_ids, curves)
        if self._trials.cost(lines) > PREPARED_SCREEN * self._best.cost:
            return None
        if asks_for_more(problem):
            lines = restore(problem, lines, progress=unheard, stop=self._stopped)
            if not self._holds(lines):
                return None
        short = self._trials.shortly(lines, self._best.cost)
        if short is None:
            return None
        label = signature(problem, list(short.curves()))
        if label in self._known:
            return None
        self._known.add(label)
        full = self._trials.fully(short)
        cost = self._trials.cost(full.world_lines)
        if cost >= (1.0 - WORTHWHILE) * self._best.cost:
            return None
        if not self._holds(full.world_lines):
            return None
        return _Best(full.world_lines, cost, full, [*self._best.history])

    def _holds(self, lines: WorldLines) -> bool:
        """Whether the user's lines hold their certificate."""
        written = self._problem.written
        return certify(written.scene, written.free_space, written.outside(lines)).holds


def _least_costs(problem: PlanningProblem, ways: list[FloatArray | None]) -> FloatArray:
    """(A,) kinetic cost of everybody alone on its shortest way, weighted; 0 where none is known."""
    return np.array(
        [
            0.0 if way is None else agent.weights.kinetic * kinetic_cost(agent.mass, way)
            for agent, way in zip(problem.scene.agents, ways, strict=True)
        ]
    )
