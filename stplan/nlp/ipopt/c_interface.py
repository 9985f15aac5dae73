"""Ipopt's C interface, in the library that cyipopt loaded: arrays change hands whole.

cyipopt 1.7 hands over the entries of Jacobians and Hessians as one Python number after another, which takes a
fifth of an iteration. `Problem` does what cyipopt's class of that name does, as far as it is used here, with
the same numbers in the same order. Where the library does not show its functions (Windows) or is older than
3.14, cyipopt's own is used.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import CFUNCTYPE, c_bool, c_char_p, c_double, c_int, c_void_p
from functools import partial
from itertools import count
from types import ModuleType
from typing import Any, Protocol

import numpy as np

from stplan.arrays import FloatArray, IntArray

# The first version that tells its current iterate.
_OLDEST = (3, 14)
# Ipopt's truth values are `bool` since 3.14; callbacks may answer with 0 and 1 all the same, and those that
# they are given are not looked at. The last argument of callbacks is the key of `_RUNS`.
_EVALUATE = CFUNCTYPE(c_int, c_int, c_void_p, c_int, c_void_p, c_void_p)
_CONSTRAIN = CFUNCTYPE(c_int, c_int, c_void_p, c_int, c_int, c_void_p, c_void_p)
_DERIVE = CFUNCTYPE(
    c_int, c_int, c_void_p, c_int, c_int, c_int, c_void_p, c_void_p, c_void_p, c_void_p
)
_CURVE = CFUNCTYPE(
    c_int, c_int, c_void_p, c_int, c_double, c_int, c_void_p, c_int, c_int, *[c_void_p] * 4
)
_WATCH = CFUNCTYPE(c_int, c_int, c_int, *[c_double] * 8, c_int, c_void_p)
# Results and arguments of the functions that are used.
_FUNCTIONS: dict[str, tuple[Any, list[Any]]] = {
    "CreateIpoptProblem": (c_void_p, [
        c_int, c_void_p, c_void_p, c_int, c_void_p, c_void_p, c_int, c_int, c_int,
        _EVALUATE, _CONSTRAIN, _EVALUATE, _DERIVE, _CURVE,
    ]),
    "FreeIpoptProblem": (None, [c_void_p]),
    "AddIpoptStrOption": (c_bool, [c_void_p, c_char_p, c_char_p]),
    "AddIpoptNumOption": (c_bool, [c_void_p, c_char_p, c_double]),
    "AddIpoptIntOption": (c_bool, [c_void_p, c_char_p, c_int]),
    "SetIntermediateCallback": (c_bool, [c_void_p, _WATCH]),
    "IpoptSolve": (c_int, [c_void_p] * 8),
    "GetIpoptCurrentIterate": (c_bool, [
        c_void_p, c_int, c_int, c_void_p, c_void_p, c_void_p, c_int, c_void_p, c_void_p,
    ]),
}  # fmt: skip


class Callbacks(Protocol):
    """What is minimised, by cyipopt's names; x is (n,)."""

    def objective(self, x: FloatArray) -> float:
        """At x; raises `CyIpoptEvaluationError` where it is undefined."""
        ...

    def gradient(self, x: FloatArray) -> FloatArray:
        """(n,)."""
        ...

    def constraints(self, x: FloatArray) -> FloatArray:
        """(m,)."""
        ...

    def jacobianstructure(self) -> tuple[IntArray, IntArray]:
        """Rows and columns of the constraints' derivatives."""
        ...

    def jacobian(self, x: FloatArray) -> FloatArray:
        """Their values."""
        ...

    def hessianstructure(self) -> tuple[IntArray, IntArray]:
        """Rows and columns of the Lagrangian's second derivatives, a lower triangle."""
        ...

    def hessian(self, x: FloatArray, lagrange: FloatArray, factor: float) -> FloatArray:
        """Their values, the objective's times `factor`."""
        ...

    def intermediate(self, *args: Any) -> bool:
        """Whether to go on after an iteration, whose eleven figures Ipopt hands over."""
        ...


def problem_maker(module: ModuleType) -> Callable[..., Any]:
    """What makes a `Problem` with the library of cyipopt's compiled `module`, or cyipopt's own class."""
    library = ctypes.PyDLL(module.__file__)
    if module.IPOPT_VERSION < _OLDEST or not all(hasattr(library, name) for name in _FUNCTIONS):
        return module.Problem
    for name, (result, arguments) in _FUNCTIONS.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return partial(Problem, library, module.CyIpoptEvaluationError)


class Problem:
    """A nonlinear program for Ipopt: n variables x, lb <= x <= ub, and m constraints, cl <= g(x) <= cu.

    Args:
        library: with Ipopt's functions.
        undefined: what the objective raises where it has no value.
        problem_obj: the callbacks.

    Raises:
        RuntimeError: Ipopt does not take these sizes and bounds.
    """

    def __init__(
        self,
        library: Any,
        undefined: type[Exception],
        *,
        n: int,
        m: int,
        problem_obj: Callbacks,
        lb: FloatArray,
        ub: FloatArray,
        cl: FloatArray,
        cu: FloatArray,
    ) -> None:
        self._ipopt, self.undefined = library, undefined
        self.size, self.num_constraints = n, m
        self._callbacks = problem_obj
        self.jacobian_structure = _indices(problem_obj.jacobianstructure())
        self.hessian_structure = _indices(problem_obj.hessianstructure())
        low, high, least, greatest = (_floats(one) for one in (lb, ub, cl, cu))
        self._handle = library.CreateIpoptProblem(
            n, _address(low), _address(high), m, _address(least), _address(greatest),
            len(self.jacobian_structure[0]), len(self.hessian_structure[0]), 0,
            _OBJECTIVE, _CONSTRAINTS, _GRADIENT, _JACOBIAN, _HESSIAN,
        )  # fmt: skip
        if not self._handle:
            raise RuntimeError(f"Ipopt takes no problem of {n} variables and {m} constraints")
        library.SetIntermediateCallback(self._handle, _INTERMEDIATE)

    def __del__(self) -> None:
        if getattr(self, "_handle", None):
            self._ipopt.FreeIpoptProblem(self._handle)

    def add_option(self, key: str, value: str | int | float) -> None:
        """Set one of Ipopt's options.

        Raises:
            TypeError: Ipopt does not take it.
        """
        add, given = {
            str: (self._ipopt.AddIpoptStrOption, str(value).encode()),
            float: (self._ipopt.AddIpoptNumOption, value),
            int: (self._ipopt.AddIpoptIntOption, value),
        }.get(type(value), (None, None))
        if add is None or not add(self._handle, key.encode(), given):
            raise TypeError(f"Ipopt does not take {value!r} for {key!r}")

    def solve(
        self,
        x: FloatArray,
        lagrange: FloatArray | None = None,
        zl: FloatArray | None = None,
        zu: FloatArray | None = None,
    ) -> tuple[FloatArray, dict[str, Any]]:
        """Minimise from x (n,), where a warm start asks for it from multipliers (m,), (n,) and (n,).

        Returns:
            x, and `status` with `mult_g`, `mult_x_L` and `mult_x_U` at the end.

        Raises:
            Exception: what a callback raised.
        """
        n, m = self.size, self.num_constraints
        end = _floats(x).copy()
        duals = [
            np.zeros(size) if one is None else _floats(one).copy()
            for one, size in ((lagrange, m), (zl, n), (zu, n))
        ]
        key, run = next(_KEYS), _Run(self, self._callbacks)
        _RUNS[key] = run
        try:
            status = self._ipopt.IpoptSolve(
                self._handle, _address(end), None, None, *map(_address, duals), key
            )
        finally:
            del _RUNS[key]
        if run.fault is not None:
            raise run.fault
        return end, dict(zip(("mult_g", "mult_x_L", "mult_x_U"), duals, strict=True), status=status)

    def get_current_iterate(self) -> dict[str, FloatArray] | None:
        """{"x": (n,)} during `intermediate`; None where Ipopt has none to tell."""
        x = np.empty(self.size)
        found = self._ipopt.GetIpoptCurrentIterate(
            self._handle, 0, self.size, _address(x), None, None, self.num_constraints, None, None
        )
        return {"x": x} if found else None


class _Run:
    """A call of `solve`: its callbacks answer Ipopt with 1, or with 0 where there is no value.

    Attributes:
        fault: what a callback raised; from then on there are no values, and no further iteration.
    """

    def __init__(self, problem: Problem, callbacks: Callbacks) -> None:
        self.problem = problem
        self.callbacks = callbacks
        self.fault: BaseException | None = None

    def __call__(self, name: str, *args: Any) -> int:
        if self.fault is not None:
            return 0
        try:
            return int(getattr(self, name)(*args))
        except self.problem.undefined:
            return 0
        except BaseException as fault:
            self.fault = fault
            return 0

    def objective(self, x: int, value: int) -> bool:
        c_double.from_address(value).value = self.callbacks.objective(self._point(x))
        return True

    def gradient(self, x: int, values: int) -> bool:
        return _hand_over(self.callbacks.gradient(self._point(x)), values, self.problem.size)

    def constraints(self, x: int, values: int) -> bool:
        size = self.problem.num_constraints
        return _hand_over(self.callbacks.constraints(self._point(x)), values, size)

    def jacobian(self, x: int, rows: int, columns: int, values: int) -> bool:
        structure = self.problem.jacobian_structure
        if not values:
            return _hand_over_structure(structure, rows, columns)
        return _hand_over(self.callbacks.jacobian(self._point(x)), values, len(structure[0]))

    def hessian(
        self, x: int, factor: float, duals: int, rows: int, columns: int, values: int
    ) -> bool:
        structure = self.problem.hessian_structure
        if not values:
            return _hand_over_structure(structure, rows, columns)
        lagrange = _copied(duals, self.problem.num_constraints)
        entries = self.callbacks.hessian(self._point(x), lagrange, factor)
        return _hand_over(entries, values, len(structure[0]))

    def intermediate(self, *args: Any) -> bool:
        return self.callbacks.intermediate(*args)

    def _point(self, address: int) -> FloatArray:
        return _copied(address, self.problem.size)


# The solves that go on in this process, by what Ipopt hands to the callbacks.
_RUNS: dict[int, _Run] = {}
_KEYS = count(1)


def _floats(values: Any) -> FloatArray:
    return np.ascontiguousarray(values, dtype=np.float64)


def _indices(structure: tuple[IntArray, IntArray]) -> tuple[Any, Any]:
    """Rows and columns as Ipopt's integers."""
    rows, columns = (np.ascontiguousarray(one, dtype=np.intc) for one in structure)
    return rows, columns


def _address(array: Any) -> int:
    return int(array.ctypes.data)


def _copied(address: int, size: int) -> FloatArray:
    values = np.empty(size)
    if size:
        ctypes.memmove(_address(values), address, values.nbytes)
    return values


def _hand_over(values: FloatArray, address: int, size: int) -> bool:
    """Copy (size,) values to Ipopt."""
    given = _floats(values)
    if given.shape != (size,):
        raise ValueError(f"Ipopt expects {size} values, not an array of shape {given.shape}")
    if size:
        ctypes.memmove(address, _address(given), given.nbytes)
    return True


def _hand_over_structure(structure: tuple[Any, Any], rows: int, columns: int) -> bool:
    for given, address in zip(structure, (rows, columns), strict=True):
        if len(given):
            ctypes.memmove(address, _address(given), given.nbytes)
    return True


_OBJECTIVE = _EVALUATE(lambda n, x, new, value, key: _RUNS[key]("objective", x, value))
_GRADIENT = _EVALUATE(lambda n, x, new, values, key: _RUNS[key]("gradient", x, values))
_CONSTRAINTS = _CONSTRAIN(lambda n, x, new, m, values, key: _RUNS[key]("constraints", x, values))
_JACOBIAN = _DERIVE(
    lambda n, x, new, m, entries, rows, columns, values, key: _RUNS[key](
        "jacobian", x, rows, columns, values
    )
)
_HESSIAN = _CURVE(
    lambda n, x, new, factor, m, duals, renewed, entries, rows, columns, values, key: _RUNS[key](
        "hessian", x, factor, duals, rows, columns, values
    )
)
_INTERMEDIATE = _WATCH(lambda *figures: _RUNS[figures[-1]]("intermediate", *figures[:-1]))
