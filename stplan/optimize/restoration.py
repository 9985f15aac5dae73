"""Clear curves -> clear curves that also keep the limits of motion, the visits and the meetings.

Seeding looks for curves that are clear. What a scene asks of speeds, accelerations, times and meetings is
reached afterwards: missing it costs a penalty that grows from round to round, while the barriers keep
everybody apart as ever, until the penalties' own barriers could take over. Every iterate is clear.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.callbacks import Progress, Stop
from stplan.costs.formulation import Formulation, Penalties, TermSetup
from stplan.costs.limit import limits_among
from stplan.costs.registry import build_terms
from stplan.nlp.ipopt.adapter import Ipopt
from stplan.nlp.ipopt.linear_solvers import chosen_linear_solver
from stplan.nlp.solution import Iteration
from stplan.nlp.step_control import StepControl
from stplan.nlp.term import Capability
from stplan.optimize.assembly import assemble, formulate, sharpness_of
from stplan.optimize.constraints import build_constraints
from stplan.optimize.slowing import slowed
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
# Penalties of times aim this far inside their intervals, in mean durations of a segment.
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
    progress: Progress,
    stop: Stop,
) -> WorldLines:
    """`seed` with knots for its timed constraints, keeping the scene's limits where that was reached.

    Whether it was is for the certificate to say. `stop` is asked after every iteration. Pairs with a
    `planned` place meet there.
    """
    if not asks_for_more(problem):
        return seed
    lines = _with_dwells(problem, _with_prescribed_knots(problem, seed))
    rounds = _Rounds(formulate(problem, lines, planned), lines.knots, stop)
    rounds.slow_down()
    for number, weight in enumerate(WEIGHTS, start=1):
        if rounds.is_content(rounds.knots) or stop():
            break
        progress(f"restoring speeds and times, round {number}: {rounds.state()}")
        rounds.run(weight)
    for alike in (False, True):
        if not rounds.is_content(rounds.knots):
            rounds.slow_down(alike)
    lines = lines.with_knots(rounds.knots)
    if not rounds.is_content(rounds.knots):
        return lines
    return _on_time(problem, lines, rounds.formulation.timed.links)


class _Rounds:
    """Penalised programs around the current knots."""

    def __init__(self, formulation: Formulation, knots: FloatArray, stop: Stop) -> None:
        self.formulation = formulation
        self.knots = knots
        self._stop = stop
        self._sharpness: dict[str, FloatArray] = {}
        layout = formulation.layout
        self._constraints = build_constraints(
            formulation.problem, layout, knots, formulation.timed, free_times=True
        )
        self._backend = Ipopt(chosen_linear_solver(formulation.problem.scene))
        self._duration = float(np.median(knots[layout.segment + 1, 2] - knots[layout.segment, 2]))
        setup = TermSetup(formulation, knots, 0.0, self._penalties(1.0))
        self._limits = limits_among(build_terms(setup, Capability.LIMIT))

    def is_content(self, knots: FloatArray) -> bool:
        """Whether every limit is kept with a little to spare."""
        return all(term.is_kept(knots) for term in self._limits)

    def state(self) -> str:
        """How far the limits are kept, in words."""
        return ", ".join(term.state(self.knots) for term in self._limits)

    def run(self, weight: float) -> None:
        """One round at a penalty weight."""
        scales = self.formulation.scales
        program = assemble(
            self.formulation, self._constraints, self.knots, scales.mu,
            sharpness=self._sharpness, penalties=self._penalties(weight),
        )  # fmt: skip
        control = StepControl(program, self.knots)
        solution = self._backend.solve(
            control,
            self.knots,
            max_iterations=ITERATIONS,
            objective_scale=1.0 / (scales.energy * max(1.0, 0.01 * weight)),
            stop=_Content(self, control, self._stop),
        )
        self.knots = solution.knots
        self._sharpness = sharpness_of(control.terms)

    def slow_down(self, alike: bool = False) -> None:
        """Take more time where limits of motion are exceeded, if everybody stays clear then."""
        formulation = self.formulation
        setup = TermSetup(formulation, self.knots, 1.0)
        clearances = build_terms(setup, Capability.CLEARANCE)

        def clear(knots: FloatArray) -> bool:
            return all(np.isfinite(term.renewed(knots).value(knots)) for term in clearances)

        found = slowed(
            formulation.problem, formulation.layout, self.knots, self._limits, clear, alike=alike
        )
        self.knots = self.knots if found is None else found

    def _penalties(self, weight: float) -> Penalties:
        """A time that is off by a mean duration weighs like a limit exceeded by its whole."""
        whole = weight * self.formulation.scales.energy
        inset = INSET * self._duration
        unit = (inset / INSET) ** 2
        return Penalties(limit=whole, timing=whole / unit, inset=inset)


class _Content:
    """Ends a round as soon as all limits are kept, or where it gets no further."""

    def __init__(self, rounds: _Rounds, control: StepControl, stop: Stop) -> None:
        self._rounds, self._control, self._stop = rounds, control, stop
        self._values: list[float] = []

    def __call__(self, iteration: Iteration) -> bool:
        self._values.append(iteration.objective)
        stale = iteration.number >= REBUILD_EVERY and self._control.is_stale()
        if stale or self._stop() or self._rounds.is_content(iteration.knots):
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
        setup = TermSetup(formulate(problem, lines), lines.knots, 1.0)
        terms = build_terms(setup, Capability.CLEARANCE)
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


def _on_time(problem: PlanningProblem, lines: WorldLines, links: IntArray) -> WorldLines:
    """`lines` with exactly one time for all knots of a meeting: that of a prescribed path, or the mean."""
    if not len(links):
        return lines
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    layout, knots = KnotLayout.from_offsets(lines.offsets), lines.knots
    result = knots.copy()
    given = problem.prescribed[layout.agent_of_knot]
    shape = (layout.num_knots, layout.num_knots)
    graph = csr_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=shape)
    _, part_of = connected_components(graph, directed=False)
    for part in np.unique(part_of[links[:, 0]]):
        own = np.flatnonzero(part_of == part)
        prescribed = own[given[own]]
        result[own, 2] = knots[prescribed[0] if len(prescribed) else own, 2].mean()
    return lines.with_knots(result)
