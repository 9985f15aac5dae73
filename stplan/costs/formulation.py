"""What terms are built from: the problem, and what its seed decides once and for all."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.costs.contacts.smooth_minimum import SmoothMinimum
from stplan.problem.layout import KnotLayout
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.rods import Rods
from stplan.problem.surroundings import Surroundings
from stplan.scene.interactions import Interactions


@dataclass(frozen=True)
class Scales:
    """Weights derived from a seed.

    Attributes:
        energy: E, the mean of the agents' E_a, the unit of the objective.
        own: (A,) E_a, J s: the kinetic cost of an agent's seed, or what stands for it.
        mu: barrier weight of the first outer iteration.
        barrier: (A,) what an agent feels of it, E_a / E (1 where the scene gives mu); 0 where motion is
            prescribed.
        excess: (A,) all that an agent pays on its seed, over E_a; at least 1.
        regularity: (A,) K^R.
        kinetic: (A,) K^K, or more where an agent hardly minds its motion: what E_a is worth.
        stiffness: (A,) mass over the mean duration of a segment, kg/s: the scale of kinetic second
            derivatives.
        pair_reach: (A + B, A + B) m, clearance at which repulsion starts, of the agents and those around.
        wall_reach: (A,) m.
        span: from the earliest start to the latest arrival, s.
    """

    energy: float
    own: FloatArray
    mu: float
    barrier: FloatArray
    excess: FloatArray
    regularity: FloatArray
    kinetic: FloatArray
    stiffness: FloatArray
    pair_reach: FloatArray
    wall_reach: FloatArray
    span: float

    def pair_barrier(self, first: IntArray, second: IntArray) -> FloatArray:
        """What pairs feel of mu: the geometric mean, or of one alone where the other is fixed.

        Of the agents and, behind them, of those around them, who are fixed.
        """
        barrier = np.zeros(len(self.pair_reach))
        barrier[: len(self.barrier)] = self.barrier
        own = np.where(barrier > 0.0, barrier, 1.0)
        mean = np.sqrt(own[first] * own[second])
        fixed = barrier == 0.0
        mean = np.where(fixed[first], barrier[second], mean)
        return np.where(fixed[second], barrier[first], mean)

    def lead_in(self, factor: float) -> Scales:
        """With barriers `factor` times as strong, but no more than what an agent pays asks for."""
        return replace(self, barrier=self.barrier * np.minimum(self.excess, factor))


@dataclass(frozen=True)
class TimedConstraints:
    """Knots with a place or a time of their own.

    Attributes:
        places: (P,) knots on waypoints.
        stays: (D, 2) knots between which an agent dwells, `dwell` (D,) for how long at least, s.
        windowed: (W,) knots whose time lies in `window` (W, 2), s.
        links: (L, 2) knots i < j at which a pair meets, `within` (L,) m of each other.
    """

    places: IntArray
    stays: IntArray
    dwell: FloatArray
    windowed: IntArray
    window: FloatArray
    links: IntArray
    within: FloatArray


@dataclass(frozen=True)
class Formulation:
    """Everything about a problem that stays the same while mu shrinks.

    Attributes:
        rods: segments and tails.
        padding: relative enlargement of all distances, so that what is left at the end is positive
            for any reader's rounding; small enough for the seed to stay feasible.
        surroundings: B agents that are no part of the problem and do not move, None without any.
    """

    problem: PlanningProblem
    layout: KnotLayout
    rods: Rods
    scales: Scales
    timed: TimedConstraints
    padding: float = 0.0
    surroundings: Surroundings | None = None

    @property
    def interactions(self) -> Interactions:
        """Of the agents, then of those around them."""
        around = self.surroundings
        return self.problem.interactions if around is None else around.interactions

    def weights(self, name: str) -> FloatArray:
        """(A,) the weights of the scene's agents by their key."""
        agents = self.problem.scene.agents
        return np.array([getattr(agent.weights, name) for agent in agents], dtype=np.float64)

    def limits(self, name: str) -> FloatArray:
        """(A,) a limit of the scene's agents by its key, inf where an agent has none."""
        found = [getattr(agent, name) for agent in self.problem.scene.agents]
        return np.array([np.inf if value is None else value for value in found])

    @property
    def smooth_minimum(self) -> SmoothMinimum | None:
        """The model of clearances, None where they are those of contacts."""
        solver = self.problem.scene.solver
        if solver.clearance_model != "smooth-minimum":
            return None
        return SmoothMinimum(solver.alpha, solver.alpha_rule, solver.hessian_cutoff)


@dataclass(frozen=True)
class Penalties:
    """How limits and times are led to where they hold, while feasibility is restored.

    Attributes:
        limit: weight of a limit that is exceeded by its whole.
        timing: weight per s^2.
        inset: how far inside their intervals times are led, s.
    """

    limit: float
    timing: float
    inset: float


@dataclass(frozen=True)
class TermSetup:
    """One program's part in a formulation.

    Attributes:
        knots: (M, 3) feasible, around which structures are made.
        mu: barrier weight.
        penalties: None where limits are barriers and times are kept by the constraints.
        sharpness: of earlier terms' smooth minima, by their name.
    """

    formulation: Formulation
    knots: FloatArray
    mu: float
    penalties: Penalties | None = None
    sharpness: Mapping[str, FloatArray] = field(default_factory=dict)
