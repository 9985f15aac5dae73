"""From a scene and its seed to the terms and limits of a nonlinear program."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.acceleration import Acceleration
from stplan.costs.acceleration_limit import AccelerationLimit, RestLimit
from stplan.costs.arrival import Arrival
from stplan.costs.collision import Collision
from stplan.costs.grouping import Grouping
from stplan.costs.kinetic import Kinetic
from stplan.costs.limit import Barrier, Limit, Profile
from stplan.costs.meeting import MeetingLimit
from stplan.costs.regularity import Regularity
from stplan.costs.speed_limit import SpeedLimit
from stplan.costs.term import Term
from stplan.costs.wall import Wall
from stplan.nlp.problem import Limits, Problem, Stopwatch
from stplan.optimize.scales import Scales
from stplan.optimize.timed_constraints import TimedConstraints
from stplan.problem.layout import KnotLayout
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.rods import Rods

# Smallest duration of a segment over the mean one; and over the seed's own, where that is shorter.
LEAST_DURATION_SHARE = 1e-3
SEED_DURATION_SHARE = 0.1
# Largest duration of a segment over the mean one where acceleration is limited; and by how much longer
# segments of the seed may grow.
LONGEST_SHARE = 2.0
SPARE_SHARE = 0.01


@dataclass(frozen=True)
class Formulation:
    """Everything about a problem that stays the same while mu shrinks.

    Attributes:
        padding: relative enlargement of all distances, so that what is left at the end is positive
            for any reader's rounding; small enough for the seed to stay feasible.
    """

    problem: PlanningProblem
    layout: KnotLayout
    scales: Scales
    limits: Limits
    timed: TimedConstraints
    padding: float


def build_limits(
    problem: PlanningProblem,
    layout: KnotLayout,
    seed: FloatArray,
    timed: TimedConstraints,
    *,
    free_times: bool = False,
) -> Limits:
    """Bounds around `seed` (M, 3): fixed starts, goals, waypoints and paths; latest arrivals.

    With `free_times`, visits and meetings are bound in place only.
    """
    lower = np.full(seed.shape, -2e19)
    upper = np.full(seed.shape, 2e19)
    for a, agent in enumerate(problem.scene.agents):
        first, last = layout.first[a], layout.last[a]
        own = slice(first, last + 1)
        if agent.path is not None:
            lower[own] = upper[own] = seed[own]
            continue
        lower[first] = upper[first] = seed[first]
        lower[last, :2] = upper[last, :2] = seed[last, :2]
        upper[last, 2] = agent.max_time
    lower[timed.places, :2] = upper[timed.places, :2] = seed[timed.places, :2]
    step = seed[layout.segment + 1, 2] - seed[layout.segment, 2]
    mean = ((seed[layout.last, 2] - seed[layout.first, 2]) / layout.num_segments)[
        layout.agent_of_segment
    ]
    least = np.minimum(LEAST_DURATION_SHARE * mean, SEED_DURATION_SHARE * step)
    irregular = np.array([agent.weights.regularity == 0.0 for agent in problem.scene.agents])
    guarded = irregular[layout.agent_of_segment]
    dwelling = np.searchsorted(layout.segment, timed.stays[:, 0])
    share = _greatest_shares(problem, layout, step)
    share[dwelling] = np.inf
    if free_times:
        no_links = np.empty((0, 2), dtype=np.int64)
        return Limits(lower, upper, least, np.flatnonzero(guarded), no_links, share)
    windowed, window = timed.windowed, timed.window
    lower[windowed, 2] = np.maximum(lower[windowed, 2], window[:, 0])
    upper[windowed, 2] = np.minimum(upper[windowed, 2], window[:, 1])
    least[dwelling] = timed.dwell
    guarded[dwelling] = True
    return Limits(lower, upper, least, np.flatnonzero(guarded), timed.links, share)


def _greatest_shares(problem: PlanningProblem, layout: KnotLayout, step: FloatArray) -> FloatArray:
    """(S,) parts of an agent's duration that its segments may last, given the seed's `step` (S,) in s.

    A long segment would hide how fast an agent has to speed up: where acceleration is limited, none lasts
    longer than twice the mean, or hardly longer than in the seed.
    """
    limited = np.array([agent.max_acceleration is not None for agent in problem.scene.agents])
    whole = np.bincount(layout.agent_of_segment, step, layout.num_agents)
    own = np.maximum(
        LONGEST_SHARE / layout.num_segments[layout.agent_of_segment],
        (1.0 + SPARE_SHARE) * step / whole[layout.agent_of_segment],
    )
    return np.where(limited[layout.agent_of_segment], own, np.inf)


class Assembly:
    """Builds programs for a formulation, keeping alphas from one to the next."""

    def __init__(self, formulation: Formulation) -> None:
        self._formulation = formulation
        self._pair_alphas: FloatArray | None = None
        self._wall_alphas: FloatArray | None = None

    def problem(
        self, knots: FloatArray, mu: float, watch: Stopwatch, damping: float = 0.0
    ) -> Problem:
        """The program at barrier weight `mu`, its structure made around feasible `knots` (M, 3)."""
        formulation = self._formulation
        exact = formulation.problem.scene.solver.hessian == "exact"
        terms = [
            *self.own_terms(),
            *self.interaction_terms(knots, mu),
            *self.limit_terms(Barrier(mu)),
        ]
        return Problem(
            formulation.layout, terms, formulation.limits, exact, watch, self.stiffness, damping
        )

    @property
    def stiffness(self) -> FloatArray:
        """(3 M,) kinetic second derivatives of every variable in order of size, for damping."""
        formulation = self._formulation
        axes = np.array([1.0, 1.0, formulation.problem.scene.time_scale**2])
        own = formulation.scales.stiffness[formulation.layout.agent_of_knot]
        return (own[:, None] * axes).ravel()

    def own_terms(self) -> list[Term]:
        """The costs of single agents."""
        formulation = self._formulation
        agents = formulation.problem.scene.agents
        layout = formulation.layout

        def weights(name: str) -> FloatArray:
            return np.array([getattr(agent.weights, name) for agent in agents], dtype=np.float64)

        terms: list[Term] = [
            Kinetic(layout, weights("kinetic"), formulation.problem.masses),
            Regularity(
                layout,
                formulation.scales.regularity,
                formulation.problem.start_times,
                exact=formulation.problem.scene.solver.hessian == "exact",
            ),
        ]
        if weights("acceleration").any():
            terms.append(
                Acceleration(layout, weights("acceleration"), formulation.problem.scene.time_scale)
            )
        if weights("arrival").any():
            preferred = [agent.preferred_time or 0.0 for agent in agents]
            terms.append(Arrival(layout, weights("arrival"), np.array(preferred)))
        return terms

    def limit_terms(self, profile: Profile) -> list[Limit]:
        """Limits of speed, acceleration and of the distance at meetings, as the scene has them."""
        formulation = self._formulation
        layout, timed = formulation.layout, formulation.timed

        def limits(name: str) -> FloatArray:
            found = [getattr(agent, name) for agent in formulation.problem.scene.agents]
            return np.array([np.inf if value is None else value for value in found])

        speeds, accelerations = limits("max_speed"), limits("max_acceleration")
        terms: list[Limit] = []
        if np.isfinite(speeds).any():
            terms.append(SpeedLimit(layout, speeds, profile))
        if np.isfinite(accelerations).any():
            terms.append(AccelerationLimit(layout, accelerations, profile))
            terms.append(RestLimit(layout, accelerations, profile))
        if len(timed.links):
            links, within = timed.links, timed.within
            terms.append(MeetingLimit(links, within, profile, layout.num_knots))
        return terms

    def rods(self, knots: FloatArray) -> Rods:
        """Segments and tails of the scene's rods."""
        problem = self._formulation.problem
        return Rods.build(
            self._formulation.layout,
            knots,
            np.flatnonzero(problem.stays),
            problem.final_time,
            problem.time_scale,
        )

    def interaction_terms(self, knots: FloatArray, mu: float) -> list[Term]:
        """The costs of pairs and walls."""
        formulation = self._formulation
        solver = formulation.problem.scene.solver
        alpha_0 = solver.alpha if solver.clearance_model == "smooth-minimum" else None
        exact = solver.hessian == "exact"
        rods = self.rods(knots)
        terms: list[Term] = []
        if formulation.problem.interactions.collides.any():
            padded = replace(
                formulation.problem.interactions,
                distance=formulation.problem.interactions.distance * (1 + formulation.padding),
            )
            collision = Collision(
                knots, rods, padded, mu, formulation.scales.pair_reach,
                alpha_0=alpha_0, exact=exact, alphas=self._pair_alphas,
            )  # fmt: skip
            self._pair_alphas = collision.alphas
            terms.append(collision)
        walls = np.array([agent.weights.wall for agent in formulation.problem.scene.agents])
        # Where motion is prescribed, its walls are no concern of the planner.
        walls[formulation.problem.prescribed] = 0.0
        if formulation.problem.free_space is not None and walls.any():
            radii = formulation.problem.radii
            wall = Wall(
                knots, formulation.layout, formulation.problem.free_space.boundary_vertices,
                formulation.problem.free_space.boundary_edges, radii * (1 + formulation.padding), walls, mu,
                formulation.scales.wall_reach, alpha_0=alpha_0, exact=exact, alphas=self._wall_alphas,
            )  # fmt: skip
            self._wall_alphas = wall.alphas
            terms.append(wall)
        if formulation.problem.interactions.grouping.any():
            terms.append(
                Grouping(knots, rods, formulation.problem.interactions, solver.alpha, exact=exact)
            )
        return terms
