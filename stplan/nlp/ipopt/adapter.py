"""Translation to Ipopt through cyipopt, and nothing else: all else that concerns it is elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.errors import SolverError
from stplan.nlp.ipopt.c_interface import problem_maker
from stplan.nlp.ipopt.library import load_ipopt, package_version
from stplan.nlp.solution import Iteration, Solution, WarmStart
from stplan.nlp.step_control import StepControl
from stplan.status import Status

_IPOPT = load_ipopt()
_problem = problem_maker(_IPOPT)

# Ipopt's statuses that mean "done", and that its iterations are used up or that it was stopped.
_SOLVED, _ACCEPTABLE = 0, 1
_STOPPED, _ITERATIONS_USED = 5, -1
# Those that mean a wrong option or a missing linear solver.
_INVALID_OPTION, _INTERNAL_ERROR = -12, -199

_DEFAULTS: dict[str, Any] = {
    "print_level": 0,
    "sb": "yes",
    "jac_c_constant": "yes",
    "jac_d_constant": "yes",
    "nlp_scaling_method": "none",
    # Starts are feasible and runs are stopped early: a greater barrier of Ipopt's own would still be felt at
    # their ends, and keep the latest arrivals from their bounds. Multipliers start out fitting to it.
    "mu_strategy": "monotone",
    "mu_init": 1e-9,
    "bound_mult_init_method": "mu-based",
    # Bounds are promises: never relaxed, and the start is hardly pushed away from them.
    "bound_relax_factor": 0.0,
    "slack_move": 0.0,
    "bound_push": 1e-8,
    "bound_frac": 1e-8,
    "slack_bound_push": 1e-8,
    "slack_bound_frac": 1e-8,
    "tol": 1e-9,
    "acceptable_iter": 0,
    # Refine a solution of the linear system only where it is found to be inaccurate.
    "min_refinement_steps": 0,
}
# Measured (docs/performance.md): the systems are well scaled, and orderings by least fill are quickest.
_MUMPS: dict[str, Any] = {
    "mumps_permuting_scaling": 0,
    "mumps_scaling": 0,
    "mumps_pivot_order": 2,
}
_WARM: dict[str, Any] = {
    "warm_start_init_point": "yes",
    "warm_start_bound_push": 1e-10,
    "warm_start_bound_frac": 1e-10,
    "warm_start_slack_bound_push": 1e-10,
    "warm_start_slack_bound_frac": 1e-10,
    "warm_start_mult_bound_push": 1e-10,
}


class _Callbacks:
    """The methods cyipopt calls, by cyipopt's names."""

    def __init__(self, control: StepControl, stop: Callable[[Iteration], bool]) -> None:
        self._control = control
        self._stop = stop
        self._program = control.program
        self.iterations = 0
        self.ipopt_mu = float(_DEFAULTS["mu_init"])
        self.handle: Any = None

    def within_bounds(self, x: FloatArray) -> FloatArray:
        """`x` with what rounding has moved past its bounds put back on them."""
        bounds = self._program.constraints
        clipped: FloatArray = np.clip(x, bounds.lower.ravel(), bounds.upper.ravel())
        return clipped

    def objective(self, x: FloatArray) -> float:
        value = self._control.value(x)
        if not np.isfinite(value):
            # Undefined here: Ipopt shortens the step. Raised from nowhere else, it would abort there.
            raise _IPOPT.CyIpoptEvaluationError
        return value

    def gradient(self, x: FloatArray) -> FloatArray:
        return self._control.gradient(x)

    def constraints(self, x: FloatArray) -> FloatArray:
        return self._program.linear.at(x)

    def jacobian(self, x: FloatArray) -> FloatArray:
        return self._program.linear.values

    def jacobianstructure(self) -> tuple[IntArray, IntArray]:
        return self._program.linear.rows, self._program.linear.columns

    def hessian(self, x: FloatArray, lagrange: FloatArray, factor: float) -> FloatArray:
        return factor * self._control.hessian(x)

    def hessianstructure(self) -> tuple[IntArray, IntArray]:
        return self._program.hessian_structure

    def intermediate(
        self,
        alg_mod: int,
        iter_count: int,
        obj_value: float,
        inf_pr: float,
        inf_du: float,
        mu: float,
        d_norm: float,
        regularization_size: float,
        alpha_du: float,
        alpha_pr: float,
        ls_trials: int,
    ) -> bool:
        current = self.handle.get_current_iterate() if alg_mod == 0 else None
        if current is not None:
            x = self.within_bounds(np.array(current["x"]))
            if np.isfinite(self._control.value(x)):
                self._control.accept(x, alpha_pr if iter_count else 1.0)
        self.iterations = iter_count
        self.ipopt_mu = mu
        damped = regularization_size > 0 or self._control.damping > 0
        knots = self._control.iterate
        return not self._stop(
            Iteration(iter_count, obj_value, d_norm, damped, knots, alpha_pr, inf_du)
        )


@dataclass(frozen=True)
class Ipopt:
    """Ipopt as a backend.

    Attributes:
        linear_solver: one that the installed Ipopt can use.
        limited_memory: approximate the Hessian from gradients.
        options: further Ipopt options, which win over ours.
    """

    linear_solver: str
    limited_memory: bool = False
    options: Mapping[str, Any] = field(default_factory=dict)

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
        """Run Ipopt from feasible `knots` (M, 3) until it converges or `stop` returns True.

        Raises:
            SolverError: Ipopt does not know an option or lacks the linear solver.
        """
        program = control.program
        callbacks = _Callbacks(control, stop)
        handle = _problem(
            n=program.num_variables,
            m=len(program.linear.least),
            problem_obj=callbacks,
            lb=program.constraints.lower.ravel(),
            ub=program.constraints.upper.ravel(),
            cl=program.linear.least,
            cu=program.linear.greatest,
        )
        callbacks.handle = handle
        for key, value in self._chosen(max_iterations, objective_scale, warm_start).items():
            _set_option(handle, key, value)
        duals = {}
        if warm_start is not None:
            duals = {
                "lagrange": warm_start.constraints,
                "zl": warm_start.lower,
                "zu": warm_start.upper,
            }
        solution, info = handle.solve(knots.ravel().copy(), **duals)
        # Without this cycle the memory of Ipopt is given back at once.
        callbacks.handle = None
        status = int(info["status"])
        if status == _INVALID_OPTION or (status == _INTERNAL_ERROR and callbacks.iterations == 0):
            raise SolverError(
                f"Ipopt does not start with linear solver {self.linear_solver} and the options "
                f"{dict(self.options)} of solver.ipopt"
            )
        solution = callbacks.within_bounds(np.asarray(solution))
        feasible = np.isfinite(solution).all() and np.isfinite(control.value(solution))
        return Solution(
            knots=solution.reshape(-1, 3).copy() if feasible else control.iterate,
            status=_status(status),
            iterations=callbacks.iterations,
            warm_start=WarmStart(
                np.array(info["mult_g"]), np.array(info["mult_x_L"]), np.array(info["mult_x_U"]),
                callbacks.ipopt_mu,
            ),
        )  # fmt: skip

    def _chosen(
        self, max_iterations: int, objective_scale: float, warm_start: WarmStart | None
    ) -> dict[str, Any]:
        """All options of a run."""
        chosen = dict(_DEFAULTS, linear_solver=self.linear_solver, max_iter=max_iterations)
        chosen["obj_scaling_factor"] = objective_scale
        if self.linear_solver == "mumps":
            chosen |= _MUMPS
        if self.limited_memory:
            chosen["hessian_approximation"] = "limited-memory"
        if warm_start is not None:
            chosen |= {"mu_init": warm_start.barrier, **_WARM}
        return chosen | dict(self.options)


def _status(status: int) -> Status:
    if status in (_SOLVED, _ACCEPTABLE):
        return Status.CONVERGED
    if status == _STOPPED:
        return Status.INTERRUPTED
    return Status.LIMIT if status == _ITERATIONS_USED else Status.FAILED


def require_options(options: Mapping[str, Any]) -> None:
    """Refuse `options` that Ipopt does not know, before anything is made of them.

    Raises:
        SolverError: naming the first.
    """
    if not options:
        return
    handle = _problem(n=1, m=0, problem_obj=_Nothing(), lb=np.zeros(1), ub=np.ones(1), cl=[], cu=[])
    for key, value in options.items():
        _set_option(handle, key, value)


class _Nothing:
    """A problem that is never solved."""

    def objective(self, x: FloatArray) -> float:
        return 0.0

    def gradient(self, x: FloatArray) -> FloatArray:
        return np.zeros(1)

    def hessian(self, x: FloatArray, lagrange: FloatArray, factor: float) -> FloatArray:
        return np.zeros(0)

    def hessianstructure(self) -> tuple[IntArray, IntArray]:
        return np.empty(0, np.int64), np.empty(0, np.int64)

    jacobianstructure = hessianstructure


def _set_option(handle: Any, key: str, value: Any) -> None:
    try:
        handle.add_option(key, value)
    except TypeError as error:
        raise SolverError(
            f"solver.ipopt.{key}: Ipopt does not take {value!r} for this option, "
            "or does not know it; see Ipopt's list of options"
        ) from error


def versions() -> dict[str, str]:
    """Versions of cyipopt and of the Ipopt it carries."""
    return {
        "cyipopt": package_version(),
        "ipopt": ".".join(str(part) for part in _IPOPT.IPOPT_VERSION),
    }
