"""Ipopt through its C interface does what it does through cyipopt, number for number."""

from __future__ import annotations

import _ctypes
from types import SimpleNamespace

import numpy as np
import pytest

from stplan.nlp.ipopt import adapter
from stplan.nlp.ipopt.adapter import Ipopt
from stplan.nlp.ipopt.c_interface import Problem, problem_maker
from stplan.nlp.ipopt.library import load_ipopt
from stplan.nlp.solution import Solution
from tests.derivatives.samples import sample_knots
from tests.nlp.sample_programs import sample_control

CYIPOPT = load_ipopt()


class Parabola:
    """(x - 1)^2 over x >= 0 with 2 x <= 1; undefined beyond 5."""

    def __init__(self, **replaced):
        vars(self).update(replaced)

    def objective(self, x):
        if x[0] > 5.0:
            raise CYIPOPT.CyIpoptEvaluationError
        return float((x[0] - 1.0) ** 2)

    def gradient(self, x):
        return 2.0 * (x - 1.0)

    def constraints(self, x):
        return 2.0 * x

    def jacobianstructure(self):
        return np.zeros(1, np.int64), np.zeros(1, np.int64)

    def jacobian(self, x):
        return np.array([2.0])

    def hessianstructure(self):
        return np.zeros(1, np.int64), np.zeros(1, np.int64)

    def hessian(self, x, lagrange, factor):
        return np.array([2.0 * factor])

    def intermediate(self, *figures):
        return True


def problem(callbacks: Parabola, make=None):
    """The parabola for Ipopt, silent."""
    make = make or problem_maker(CYIPOPT)
    made = make(n=1, m=1, problem_obj=callbacks, lb=[0.0], ub=[1e20], cl=[-1e20], cu=[1.0])
    for key, value in {"print_level": 0, "sb": "yes"}.items():
        made.add_option(key, value)
    return made


def test_the_bundled_ipopt_shows_its_interface():
    assert isinstance(problem(Parabola()), Problem)


@pytest.mark.parametrize("limited_memory", [False, True])
def test_iterates_are_those_of_cyipopt(limited_memory: bool, monkeypatch: pytest.MonkeyPatch):
    def solved() -> Solution:
        solver = Ipopt("mumps", limited_memory)
        control = sample_control(limited=True)
        settings = {"max_iterations": 12, "objective_scale": 1.0, "stop": lambda iteration: False}
        first = solver.solve(control, sample_knots(), **settings)
        return solver.solve(control, first.knots, warm_start=first.warm_start, **settings)

    direct = solved()
    monkeypatch.setattr(adapter, "_problem", CYIPOPT.Problem)
    same = solved()
    assert direct.iterations == same.iterations > 0
    assert direct.status is same.status
    np.testing.assert_array_equal(direct.knots, same.knots)
    assert (direct.knots != sample_knots()).any()
    for one, other in zip(
        vars(direct.warm_start).values(), vars(same.warm_start).values(), strict=True
    ):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("make", [None, CYIPOPT.Problem])
def test_steps_to_where_nothing_is_defined_are_shortened(make):
    x, info = problem(Parabola(), make).solve(np.array([4.9]))
    assert x[0] == pytest.approx(0.5, abs=1e-6)
    assert info["status"] == 0
    assert info["mult_g"][0] == pytest.approx(0.5, abs=1e-4)


def raising(fault: type[BaseException]):
    """A callback that raises one."""

    def callback(*_):
        raise fault("here")

    return callback


@pytest.mark.parametrize(
    "where", ["objective", "gradient", "constraints", "jacobian", "hessian", "intermediate"]
)
@pytest.mark.parametrize("fault", [KeyboardInterrupt, MemoryError])
def test_what_a_callback_raises_ends_the_run_and_comes_through(
    where: str, fault: type[BaseException]
):
    with pytest.raises(fault, match="here"):
        problem(Parabola(**{where: raising(fault)})).solve(np.array([0.1]))


def test_a_run_that_is_stopped_says_so():
    x, info = problem(Parabola(intermediate=lambda *figures: figures[1] < 2)).solve(np.array([0.1]))
    assert info["status"] == 5
    assert 0.0 < x[0] < 0.5


@pytest.mark.parametrize("where", ["gradient", "constraints", "jacobian", "hessian"])
def test_arrays_of_another_size_are_refused(where: str):
    with pytest.raises(ValueError, match=r"expects 1 values, not an array of shape \(2,\)"):
        problem(Parabola(**{where: lambda *_: np.ones(2)})).solve(np.array([0.1]))


@pytest.mark.parametrize(
    ("key", "value"), [("no_such", 1), ("tol", "x"), ("tol", None), ("max_iter", 1.5), ("sb", "z")]
)
def test_options_that_ipopt_does_not_take_are_refused(key: str, value: object):
    with pytest.raises(TypeError):
        problem(Parabola()).add_option(key, value)


@pytest.mark.parametrize("changed", [{"IPOPT_VERSION": (3, 13, 4)}, {"__file__": _ctypes.__file__}])
def test_other_libraries_are_used_through_cyipopt(changed: dict[str, object]):
    module = SimpleNamespace(
        **{
            "__file__": CYIPOPT.__file__,
            "IPOPT_VERSION": CYIPOPT.IPOPT_VERSION,
            "Problem": Parabola,
        }
        | changed
    )
    assert problem_maker(module) is Parabola
