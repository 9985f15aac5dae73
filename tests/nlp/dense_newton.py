"""A second solver of nonlinear programs: a projected, damped Newton method on dense matrices.

It shows what `Backend` asks for, and that nothing beside `stplan.nlp.ipopt` knows Ipopt. Bounds are kept by
projection: variables that their gradient presses against a bound stay there, the others take Newton's step,
cut back to the bounds (Bertsekas, "Projected Newton methods for optimization problems with simple
constraints", 1982). Small programs without linear constraints only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stplan.arrays import BoolArray, FloatArray
from stplan.errors import SolverError
from stplan.nlp.solution import Iteration, Solution, WarmStart
from stplan.nlp.step_control import StepControl
from stplan.status import Status
from tests.derivatives.checker import dense

# Armijo's share of the decrease that the gradient promises, and how often a step is halved for it.
ARMIJO = 1e-4
MOST_HALVINGS = 50


@dataclass(frozen=True)
class DenseNewton:
    """Newton's method as a backend.

    Attributes:
        tolerance: on the largest entry of the projected gradient of the scaled objective.
    """

    tolerance: float = 1e-9

    def solve(
        self,
        control: StepControl,
        knots: FloatArray,
        *,
        max_iterations: int,
        objective_scale: float,
        stop: Callable[[Iteration], bool],
        warm_start: WarmStart | None = None,
    ) -> Solution:
        """Minimise from feasible `knots` (M, 3); there is nothing to start warm.

        Raises:
            SolverError: the program has linear constraints.
        """
        del warm_start
        program = control.program
        if len(program.linear.least):
            raise SolverError("the dense Newton method takes no linear constraints")
        lower, upper = program.constraints.lower.ravel(), program.constraints.upper.ravel()
        x = np.clip(knots.ravel(), lower, upper)
        value, step, damped, status = control.value(x), 0.0, False, Status.LIMIT
        number = 0
        for number in range(max_iterations + 1):
            if stop(Iteration(number, value, step, damped, control.iterate)):
                status = Status.INTERRUPTED
                break
            gradient = control.gradient(x)
            # On its bound and pressed against it.
            free: BoolArray = ~(((x <= lower) & (gradient > 0)) | ((x >= upper) & (gradient < 0)))
            if objective_scale * np.abs(gradient[free]).max(initial=0.0) <= self.tolerance:
                status = Status.CONVERGED
                break
            if number == max_iterations:
                break
            hessian = dense(program.hessian_structure, control.hessian(x), len(x))
            direction = np.zeros_like(x)
            direction[free], shifted = _newton_step(hessian[np.ix_(free, free)], gradient[free])
            found = _search(control, x, direction, value, gradient, (lower, upper))
            if found is None:
                status = Status.FAILED
                break
            share, x, value = found
            step, damped = float(np.abs(direction).max()), shifted or control.damping > 0
            control.accept(x, share)
        return Solution(control.iterate, status, number, warm_start=None)


def _newton_step(hessian: FloatArray, gradient: FloatArray) -> tuple[FloatArray, bool]:
    """Downhill step, and whether the Hessian was shifted to be positive definite for it."""
    shift, unit = 0.0, 1e-6 * float(np.abs(np.diag(hessian)).max())
    while True:
        try:
            factor = np.linalg.cholesky(hessian + shift * np.eye(len(hessian)))
        except np.linalg.LinAlgError:
            shift = max(10.0 * shift, unit)
            continue
        return -np.linalg.solve(factor.T, np.linalg.solve(factor, gradient)), shift > 0.0


def _search(
    control: StepControl,
    x: FloatArray,
    direction: FloatArray,
    value: float,
    gradient: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
) -> tuple[float, FloatArray, float] | None:
    """Share of the step, the point and its value that lie low enough; None where there are none."""
    share = 1.0
    for _ in range(MOST_HALVINGS):
        nearer = np.clip(x + share * direction, *bounds)
        found = control.value(nearer)
        # What rounding adds to a value does not count against a step.
        promised = ARMIJO * float(gradient @ (nearer - x)) + 1e-15 * abs(value)
        if np.isfinite(found) and found <= value + promised and not np.array_equal(nearer, x):
            return share, nearer, found
        share *= 0.5
    return None
