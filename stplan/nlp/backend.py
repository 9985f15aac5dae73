"""Solvers of nonlinear programs behind one call."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from stplan.arrays import FloatArray
from stplan.nlp.solution import Iteration, Solution, WarmStart
from stplan.nlp.step_control import StepControl


class Backend(Protocol):
    """A solver whose every accepted iterate is feasible: it goes nowhere `control` gives no value."""

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
        """Minimise the program of `control` from feasible `knots` (M, 3).

        Every iterate is handed to `control.accept` before `stop` is asked, which ends the run.

        Args:
            objective_scale: the solver works on scale * objective, which makes its tolerances relative.

        Raises:
            SolverError: the solver lacks something it was asked for.
        """
        ...
