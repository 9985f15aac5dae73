"""Translation to Ipopt through cyipopt, and nothing else: the only file that imports cyipopt."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import cyipopt
import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.errors import SolverError
from stplan.nlp.problem import Problem


@dataclass(frozen=True)
class Iteration:
    """What Ipopt says after an iteration.

    `step` is the largest entry of the full step, m or s; it says nothing about convergence where the
    Hessian was `damped` to make it convex.
    """

    number: int
    objective: float
    optimality: float
    step: float
    ipopt_mu: float
    damped: bool
    knots: FloatArray


@dataclass(frozen=True)
class Multipliers:
    """Warm start of the duals: constraints, lower and upper bounds."""

    constraints: FloatArray
    lower: FloatArray
    upper: FloatArray


@dataclass(frozen=True)
class IpoptResult:
    """The last accepted iterate (always feasible), Ipopt's status and duals."""

    knots: FloatArray
    status: int
    message: str
    multipliers: Multipliers
    iterations: int
    ipopt_mu: float


# Ipopt's statuses that mean "no progress possible", against those that mean "done" or "stopped".
FAILURES = frozenset({-1, -2, -3, -4, -5, -10, -11, -12, -13, -100, -101, -102, -199, 2, 3, 4})

_DEFAULTS: dict[str, Any] = {
    "print_level": 0,
    "sb": "yes",
    "jac_c_constant": "yes",
    "jac_d_constant": "yes",
    "nlp_scaling_method": "none",
    "mu_strategy": "monotone",
    "mu_init": 1e-3,
    # Bounds are promises: never relaxed, and the start is hardly pushed away from them.
    "bound_relax_factor": 0.0,
    "bound_push": 1e-8,
    "bound_frac": 1e-8,
    "slack_bound_push": 1e-8,
    "slack_bound_frac": 1e-8,
    "tol": 1e-6,
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

    def __init__(
        self, problem: Problem, stop: Callable[[Iteration], bool], start: FloatArray
    ) -> None:
        self._problem = problem
        self._stop = stop
        self._rows, self._columns, self._slopes = problem.constraints_jacobian()
        self.accepted = start.copy()
        self.iterations = 0
        self.ipopt_mu = float(_DEFAULTS["mu_init"])
        self.handle: Any = None

    def objective(self, x: FloatArray) -> float:
        value = self._problem.value(x)
        if not np.isfinite(value):
            # Undefined here: Ipopt shortens the step. Raised from nowhere else, it would abort there.
            raise cyipopt.CyIpoptEvaluationError
        return value

    def gradient(self, x: FloatArray) -> FloatArray:
        return self._problem.gradient(x)

    def constraints(self, x: FloatArray) -> FloatArray:
        return self._problem.constraints(x)

    def jacobian(self, x: FloatArray) -> FloatArray:
        return self._slopes

    def jacobianstructure(self) -> tuple[IntArray, IntArray]:
        return self._rows, self._columns

    def hessian(self, x: FloatArray, lagrange: FloatArray, factor: float) -> FloatArray:
        return factor * self._problem.hessian(x)

    def hessianstructure(self) -> tuple[IntArray, IntArray]:
        return self._problem.hessian_rows, self._problem.hessian_columns

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
            x = np.array(current["x"])
            if np.isfinite(self._problem.value(x)):
                self.accepted = x
                self._problem.accept(x, alpha_pr if iter_count else 1.0)
        self.iterations = iter_count
        self.ipopt_mu = mu
        knots = self.accepted.reshape(-1, 3)
        damped = regularization_size > 0 or self._problem.damping > 0
        return not self._stop(Iteration(iter_count, obj_value, inf_du, d_norm, mu, damped, knots))


def solve(
    problem: Problem,
    knots: FloatArray,
    *,
    max_iterations: int,
    linear_solver: str,
    objective_scale: float,
    limited_memory: bool,
    options: Mapping[str, Any],
    stop: Callable[[Iteration], bool],
    multipliers: Multipliers | None = None,
    ipopt_mu: float | None = None,
) -> IpoptResult:
    """Run Ipopt from feasible `knots` (M, 3) until it converges or `stop` returns True.

    Args:
        objective_scale: Ipopt works on scale * objective, which makes its tolerances relative.
        options: further Ipopt options, which win over ours.

    Raises:
        SolverError: Ipopt does not know an option or lacks the linear solver.
    """
    start = knots.ravel().copy()
    problem.accept(start)
    callbacks = _Callbacks(problem, stop, start)
    limits = problem.limits
    least, greatest = problem.constraint_bounds()
    handle = cyipopt.Problem(
        n=problem.num_variables,
        m=len(least),
        problem_obj=callbacks,
        lb=limits.lower.ravel(),
        ub=limits.upper.ravel(),
        cl=least,
        cu=greatest,
    )
    callbacks.handle = handle
    chosen = dict(_DEFAULTS, linear_solver=linear_solver, max_iter=max_iterations)
    chosen["obj_scaling_factor"] = objective_scale
    if linear_solver == "mumps":
        chosen |= _MUMPS
    if limited_memory:
        chosen["hessian_approximation"] = "limited-memory"
    if ipopt_mu is not None:
        chosen["mu_init"] = ipopt_mu
    if multipliers is not None:
        chosen |= _WARM
    chosen |= dict(options)
    for key, value in chosen.items():
        _set_option(handle, key, value)
    warm = (
        {}
        if multipliers is None
        else {
            "lagrange": multipliers.constraints,
            "zl": multipliers.lower,
            "zu": multipliers.upper,
        }
    )
    solution, info = handle.solve(start, **warm)
    # Without this cycle the memory of Ipopt is given back at once.
    callbacks.handle = None
    status = int(info["status"])
    if status == -12 or (status == -199 and callbacks.iterations == 0):
        raise SolverError(
            f"Ipopt does not start with linear solver {linear_solver} and the options "
            f"{dict(options)} of solver.ipopt"
        )
    solution = np.asarray(solution)
    if not np.isfinite(solution).all() or not np.isfinite(problem.value(solution)):
        solution = callbacks.accepted
    message = info["status_msg"]
    return IpoptResult(
        knots=solution.reshape(-1, 3).copy(),
        status=status,
        message=message.decode() if isinstance(message, bytes) else str(message),
        multipliers=Multipliers(
            np.array(info["mult_g"]), np.array(info["mult_x_L"]), np.array(info["mult_x_U"])
        ),
        iterations=callbacks.iterations,
        ipopt_mu=callbacks.ipopt_mu,
    )


def require_options(options: Mapping[str, Any]) -> None:
    """Refuse `options` that Ipopt does not know, before anything is made of them.

    Raises:
        SolverError: naming the first.
    """
    if not options:
        return
    handle = cyipopt.Problem(
        n=1, m=0, problem_obj=_Nothing(), lb=np.zeros(1), ub=np.ones(1), cl=[], cu=[]
    )
    for key, value in options.items():
        _set_option(handle, key, value)


class _Nothing:
    """A problem that is never solved."""

    def objective(self, x: FloatArray) -> float:
        return 0.0

    def gradient(self, x: FloatArray) -> FloatArray:
        return np.zeros(1)


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
        "cyipopt": str(cyipopt.__version__),
        "ipopt": ".".join(str(part) for part in cyipopt.IPOPT_VERSION),
    }
