"""Clear curves -> clear curves that also keep the limits of motion, the visits and the meetings.

Seeding looks for curves that are clear. What a scene asks of speeds, accelerations, times and meetings is
reached afterwards: missing it costs a penalty that grows from round to round, while the barriers keep
everybody apart as ever, until the penalties' own barriers could take over. Every iterate is clear.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from stplan.arrays import FloatArray, IntArray
from stplan.costs.limit import Barrier, Penalty
from stplan.costs.timing import NONE, Timing
from stplan.nlp.ipopt.adapter import Iteration, solve
from stplan.nlp.ipopt.linear_solvers import chosen_linear_solver
from stplan.nlp.problem import Problem
from stplan.optimize.assembly import Assembly, Formulation
from stplan.optimize.continuation import formulate
from stplan.optimize.timed_constraints import visit_knots
from stplan.problem.layout import KnotLayout
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Agent
from stplan.seeding.rendezvous import Rendezvous
from stplan.seeding.shortcutting.resampling import resample_curve

# Weights of the penalties, in mean kinetic costs; and iterations spent on each of them.
WEIGHTS = (1.0, 10.0, 100.0, 1e3, 1e4, 1e5)
ITERATIONS = 60
# Penalties aim at this share of a limit and are content with the other.
AIM = 0.93
CONTENT = 0.98
# Timing aims this far inside its intervals, in mean durations of a segment, and is content at half of it.
INSET = 0.02
# A dwelling agent's second knot starts out this part of the next segment after the first, the first
# part that leaves everybody clear.
SPLITS = (0.2, 0.02, 1e-3, 1e-5)
# Least number of knots of a prescribed path along which somebody has to be met.
PRESCRIBED_KNOTS = 60
# A round ends when the objective falls by less than this share over so many iterations.
STALL_WINDOW = 6
STALL = 1e-3
REBUILD_EVERY = 4


def asks_for_more(problem: PlanningProblem) -> bool:
    """Whether `problem` asks more of curves than that they are clear."""
    moving = any(
        agent.max_speed is not None or agent.max_acceleration is not None or agent.visits
        for agent in problem.scene.agents
    )
    return moving or bool(problem.meetings)


def restore(
    problem: PlanningProblem,
    seed: WorldLines,
    planned: Sequence[Rendezvous] = (),
    *,
    progress: Callable[[str], None],
    stop: Callable[[], bool],
) -> WorldLines:
    """`seed` with knots for its timed constraints, keeping the scene's limits where that was reached.

    Whether it was is for the certificate to say. `stop` is asked after every iteration. Pairs with a
    `planned` place meet there.
    """
    if not asks_for_more(problem):
        return seed
    lines = _with_dwells(problem, _with_prescribed_knots(problem, seed))
    layout = KnotLayout.from_offsets(lines.offsets)
    formulation = formulate(problem, layout, lines.knots, free_times=True, planned=planned)
    rounds = _Rounds(formulation, lines.knots, stop)
    for number, weight in enumerate(WEIGHTS, start=1):
        if rounds.content() or stop():
            break
        progress(f"restoring speeds and times, round {number}: {rounds.state()}")
        rounds.run(weight)
    if not rounds.content():
        return lines.with_knots(rounds.knots)
    links = formulation.timed.links
    return lines.with_knots(_on_time(problem, layout, rounds.knots, links))


class _Rounds:
    """Penalised problems around the current knots."""

    def __init__(
        self, formulation: Formulation, knots: FloatArray, stop: Callable[[], bool]
    ) -> None:
        self._formulation = formulation
        self._stop = stop
        self._assembly = Assembly(formulation)
        self.knots = knots
        self._inset = INSET * float(
            np.median(
                knots[formulation.layout.segment + 1, 2] - knots[formulation.layout.segment, 2]
            )
        )

    def content(self, knots: FloatArray | None = None) -> bool:
        """Whether every limit is kept with a little to spare."""
        at = self.knots if knots is None else knots
        shares = [term.shares(at) for term in self._assembly.limit_terms(Barrier(0.0))]
        late = self._timing(1.0, 0.5 * self._inset, 0.25 * self._inset).missing(at)
        return all((share <= CONTENT).all() for share in shares) and not late.any()

    def state(self) -> str:
        """How far the limits are kept, in words."""
        terms = self._assembly.limit_terms(Barrier(0.0))
        found = [
            f"{term.name} {100 * float(term.shares(self.knots).max(initial=0.0)):.0f} %"
            for term in terms
        ]
        late = np.abs(self._timing(1.0, 0.0, 0.0).missing(self.knots)).max(initial=0.0)
        return ", ".join([*found, f"times {late:.2g} s off"])

    def run(self, weight: float) -> None:
        """One round at a penalty weight."""
        formulation, scales = self._formulation, self._formulation.scales
        kept = ("kinetic", "regularity")
        terms = [term for term in self._assembly.own_terms() if term.name in kept]
        terms += self._assembly.interaction_terms(self.knots, scales.mu)
        terms += self._assembly.limit_terms(Penalty(weight * scales.energy, AIM))
        # A time that is off by a mean duration weighs like a limit exceeded by its whole.
        unit = (self._inset / INSET) ** 2
        terms.append(self._timing(weight * scales.energy / unit, self._inset, 0.0))
        problem = Problem(
            formulation.layout, terms, formulation.limits, stiffness=self._assembly.stiffness
        )
        outcome = solve(
            problem,
            self.knots,
            max_iterations=ITERATIONS,
            linear_solver=chosen_linear_solver(formulation.problem.scene),
            objective_scale=1.0 / (scales.energy * max(1.0, 0.01 * weight)),
            limited_memory=False,
            options={},
            stop=_Content(self, problem, self._stop),
        )
        self.knots = outcome.knots

    def _timing(self, weight: float, inset: float, apart: float) -> Timing:
        """Penalties of visits less than `inset` inside their times, of meetings more than `apart` (s)."""
        found = self._formulation.timed
        inside = np.minimum(inset, 0.25 * np.ptp(found.window, axis=1))
        alone = np.column_stack([np.full_like(found.windowed, NONE), found.windowed])
        links = np.full(len(found.links), apart)
        low = [found.window[:, 0] + inside, found.dwell + inset, -links]
        high = [found.window[:, 1] - inside, np.full(len(found.dwell), np.inf), links]
        return Timing(
            np.vstack([alone, found.stays, found.links]),
            np.concatenate(low),
            np.concatenate(high),
            weight,
            self._formulation.layout.num_knots,
        )


class _Content:
    """Ends a round as soon as all limits are kept, or where it gets no further."""

    def __init__(self, rounds: _Rounds, problem: Problem, stop: Callable[[], bool]) -> None:
        self._rounds, self._problem, self._stop = rounds, problem, stop
        self._values: list[float] = []

    def __call__(self, iteration: Iteration) -> bool:
        self._values.append(iteration.objective)
        stale = iteration.number >= REBUILD_EVERY and self._problem.is_stale()
        if stale or self._stop() or self._rounds.content(iteration.knots):
            return True
        if len(self._values) <= STALL_WINDOW:
            return False
        fall = self._values[-1 - STALL_WINDOW] - self._values[-1]
        return fall <= STALL * abs(self._values[-1])


def _with_prescribed_knots(problem: PlanningProblem, seed: WorldLines) -> WorldLines:
    """`seed` with knots along the prescribed paths of agents that somebody has to meet."""
    met = {agent for meeting in problem.meetings for agent in (meeting.first, meeting.second)}
    curves = [
        resample_curve(curve, PRESCRIBED_KNOTS) if agent.path is not None and a in met else curve
        for a, (agent, curve) in enumerate(zip(problem.scene.agents, seed.curves(), strict=True))
    ]
    return WorldLines.from_curves(seed.agent_ids, curves)


def _with_dwells(problem: PlanningProblem, seed: WorldLines) -> WorldLines:
    """`seed` with a second knot on every waypoint at which an agent dwells, soon after the first."""
    if not any(visit.dwell > 0 for agent in problem.scene.agents for visit in agent.visits):
        return seed
    lines = seed
    for part in SPLITS:
        curves = [
            _dwelling(agent, curve, part)
            for agent, curve in zip(problem.scene.agents, seed.curves(), strict=True)
        ]
        lines = WorldLines.from_curves(seed.agent_ids, curves)
        layout = KnotLayout.from_offsets(lines.offsets)
        formulation = formulate(problem, layout, lines.knots, free_times=True)
        terms = Assembly(formulation).interaction_terms(lines.knots, 1.0)
        if all(np.isfinite(term.value(lines.knots)) for term in terms):
            break
    return lines


def _dwelling(agent: Agent, curve: FloatArray, part: float) -> FloatArray:
    """`curve` with second knots `part` of the next segment's duration after the first ones."""
    if agent.path is not None:
        return curve
    for (arrive, leave), visit in reversed(
        list(zip(visit_knots(agent, curve), agent.visits, strict=False))
    ):
        if visit.dwell <= 0 or leave != arrive:
            continue
        # A waypoint on the goal itself is left before the goal is reached.
        at = min(arrive, len(curve) - 2)
        before, after = curve[at], curve[at + 1]
        when = before[2] + (part if at == arrive else 1.0 - part) * (after[2] - before[2])
        curve = np.insert(curve, at + 1, [*curve[arrive, :2], when], axis=0)
    return curve


def _on_time(
    problem: PlanningProblem, layout: KnotLayout, knots: FloatArray, links: IntArray
) -> FloatArray:
    """`knots` with exactly one time for all knots of a meeting: that of a prescribed path, or the mean."""
    result = knots.copy()
    if not len(links):
        return result
    given = problem.prescribed[layout.agent_of_knot]
    shape = (layout.num_knots, layout.num_knots)
    graph = csr_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=shape)
    _, part_of = connected_components(graph, directed=False)
    for part in np.unique(part_of[links[:, 0]]):
        own = np.flatnonzero(part_of == part)
        prescribed = own[given[own]]
        result[own, 2] = knots[prescribed[0] if len(prescribed) else own, 2].mean()
    return result
