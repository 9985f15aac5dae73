"""Asks the installed Ipopt which linear solver works, by solving a problem of three variables.

Run in a process of its own: where the library behind a solver is missing or unfit, Ipopt may crash.
`python -m stplan.nlp.ipopt.probe '{"hsllib": "libhsl.so"}' ma57 mumps` prints each name before it is
tried, and once more when it has worked.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from typing import Any

import cyipopt
import numpy as np

from stplan.arrays import FloatArray, IntArray


class _Paraboloid:
    """Least distance from (1, 0, 0) with x + y + z in [0, 1/2], by cyipopt's names."""

    def objective(self, x: FloatArray) -> float:
        return float((x**2).sum() - 2.0 * x[0])

    def gradient(self, x: FloatArray) -> FloatArray:
        return 2.0 * x - np.array([2.0, 0.0, 0.0])

    def constraints(self, x: FloatArray) -> FloatArray:
        return np.array([x.sum()])

    def jacobian(self, x: FloatArray) -> FloatArray:
        return np.ones(3)

    def jacobianstructure(self) -> tuple[IntArray, IntArray]:
        return np.zeros(3, np.int64), np.arange(3)

    def hessian(self, x: FloatArray, lagrange: FloatArray, factor: float) -> FloatArray:
        return np.full(3, 2.0 * factor)

    def hessianstructure(self) -> tuple[IntArray, IntArray]:
        return np.arange(3), np.arange(3)


def works(linear_solver: str, options: dict[str, Any]) -> bool:
    """Whether Ipopt solves a small problem with `linear_solver`."""
    handle = cyipopt.Problem(
        n=3, m=1, problem_obj=_Paraboloid(), lb=np.full(3, -1.0), ub=np.full(3, 1.0),
        cl=[0.0], cu=[0.5],
    )  # fmt: skip
    try:
        for key, value in {"print_level": 0, "sb": "yes", **options}.items():
            handle.add_option(key, value)
        handle.add_option("linear_solver", linear_solver)
    except TypeError:
        return False
    solution, _ = handle.solve(np.zeros(3))
    return bool(np.allclose(solution, [5 / 6, -1 / 6, -1 / 6], atol=1e-4))


def main(arguments: Sequence[str]) -> None:
    """Print the names tried, and stop after the first that works."""
    options, *names = arguments
    for name in names:
        print(name, flush=True)
        if works(name, json.loads(options)):
            print(name, flush=True)
            return


if __name__ == "__main__":
    main(sys.argv[1:])
