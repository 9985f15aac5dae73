"""What passes between the outer loop and a solver of nonlinear programs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray
from stplan.status import Status


@dataclass(frozen=True)
class Iteration:
    """What a solver says after an iteration.

    `step` is the largest entry of the full step, m or s; it says nothing about convergence where the
    Hessian was `damped` to make it convex. `share` of it was taken.
    `optimality` is the largest entry of the gradient of the Lagrangian, in units of the scaled objective.
    """

    number: int
    objective: float
    step: float
    damped: bool
    knots: FloatArray
    share: float = 1.0
    optimality: float = np.inf


@dataclass(frozen=True)
class WarmStart:
    """Multipliers of the linear constraints and of lower and upper bounds, and the weight of the solver's
    own barrier that they belong to."""

    constraints: FloatArray
    lower: FloatArray
    upper: FloatArray
    barrier: float


@dataclass(frozen=True)
class Solution:
    """How a run ended.

    Attributes:
        knots: (M, 3) the last accepted iterate, always feasible.
        status: converged; interrupted, where the caller stopped it; limit, where its iterations were used
            up; or failed, where no step led on.
        iterations: how many it took.
        warm_start: for going on from here.
    """

    knots: FloatArray
    status: Status
    iterations: int
    warm_start: WarmStart | None
