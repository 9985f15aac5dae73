"""The assembled program: derivatives of the sum, bounds, and Ipopt's own derivative check."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.arrays import FloatArray, IntArray
from stplan.nlp.ipopt.adapter import solve
from stplan.nlp.problem import Problem, Stopwatch
from stplan.optimize.assembly import Assembly, Formulation, build_limits
from stplan.optimize.scales import derive_scales
from stplan.optimize.timed_constraints import find_timed_constraints, visit_knots
from stplan.problem.planning_problem import PlanningProblem
from stplan.scene.model import (
    Agent,
    Meet,
    PairRule,
    Scene,
    SeedingSettings,
    SolverSettings,
    Weights,
)
from tests.derivatives.checker import check_differences, check_not_vacuous, check_taylor_slopes
from tests.derivatives.samples import CORNERS, EDGES, LAYOUT, OFFSETS, RADII, sample_knots


class _Walls:
    boundary_vertices = CORNERS
    boundary_edges = EDGES


def sample_scene(**solver: object) -> Scene:
    """Three unequal agents whose seed is `sample_knots()`."""
    knots = sample_knots()
    agents = []
    for a in range(3):
        own = knots[OFFSETS[a] : OFFSETS[a + 1]]
        agents.append(
            Agent(
                id=f"agent{a}",
                start=tuple(own[0, :2]),
                goal=tuple(own[-1, :2]),
                start_time=float(own[0, 2]),
                max_time=float(own[-1, 2]) + 1,
                preferred_time=float(own[-1, 2]) - 0.5,
                radius=float(RADII[a]),
                mass=1.0 + a,
                after_arrival="stay" if a == 2 else "vanish",
                waypoints=(),
                # Without a regularity cost, the first agent's time is kept running by constraints.
                weights=Weights(
                    acceleration=0.3 * a,
                    arrival=0.2,
                    regularity=0.0 if a == 0 else None,
                    wall=float(a != 1),
                ),
            )
        )
    rules = (
        PairRule((0, 1, 2), (0, 1, 2), distance=0.5),
        PairRule((0,), (1,), grouping=0.1),
    )
    return Scene(
        "sample", "", None, "", None, 15.0, 1.3, tuple(agents), rules, SeedingSettings(),
        SolverSettings(barrier_range=1.5, **solver),  # type: ignore[arg-type]
    )  # fmt: skip


def limited_scene(**solver: object) -> Scene:
    """The same with limits of motion that the seed keeps, and a meeting."""
    scene = sample_scene(**solver)
    agents = tuple(
        replace(agent, max_speed=4.0, max_acceleration=9.0 if a else None)
        for a, agent in enumerate(scene.agents)
    )
    meet = PairRule((0,), (2,), meet=Meet(9.0))
    return replace(scene, agents=agents, pairs=(*scene.pairs, meet))


def sample_problem(limited: bool = False, **solver: object) -> Problem:
    scene = limited_scene(**solver) if limited else sample_scene(**solver)
    knots = sample_knots()
    planning = replace(PlanningProblem.from_scene(scene, None), free_space=_Walls())  # type: ignore[arg-type]
    timed = find_timed_constraints(PlanningProblem.from_scene(scene, None), LAYOUT, knots)
    formulation = Formulation(
        planning, LAYOUT, derive_scales(planning, LAYOUT, knots),
        build_limits(planning, LAYOUT, knots, timed), timed, 1e-4,
    )  # fmt: skip
    return Assembly(formulation).problem(knots, 0.3, Stopwatch())


class _AsFunction:
    """A problem as a function of knots."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem

    def value(self, knots: FloatArray) -> float:
        return self._problem.value(knots.ravel())

    def gradient(self, knots: FloatArray) -> FloatArray:
        return self._problem.gradient(knots.ravel()).reshape(-1, 3)

    def hessian_structure(self) -> tuple[IntArray, IntArray]:
        return self._problem.hessian_rows, self._problem.hessian_columns

    def hessian(self, knots: FloatArray) -> FloatArray:
        return self._problem.hessian(knots.ravel())


@pytest.mark.parametrize("model", ["contacts", "smooth-minimum"])
def test_derivatives_of_the_assembled_lagrangian(model: str) -> None:
    problem = sample_problem(clearance_model=model, hessian="exact")
    assert {term.name for term in problem.terms} == {
        "kinetic", "acceleration", "arrival", "regularity", "collision", "wall", "grouping",
    }  # fmt: skip
    function = _AsFunction(problem)
    check_differences(function, sample_knots())
    check_not_vacuous(function, sample_knots())
    rng = np.random.default_rng(7)
    check_taylor_slopes(function, sample_knots(), 0.02 * rng.normal(size=(19, 3)))
    rows, columns, values = problem.constraints_jacobian()
    # Constraints are linear: the Jacobian reproduces them and adds nothing to the Lagrangian's Hessian.
    x = sample_knots().ravel()
    assert len(problem.constraints(x)) == LAYOUT.num_segments[0]
    jacobian = np.zeros((LAYOUT.num_segments[0], problem.num_variables))
    jacobian[rows, columns] = values
    assert jacobian @ x == pytest.approx(problem.constraints(x))


def test_derivatives_with_limits_and_a_meeting() -> None:
    problem = sample_problem(limited=True, hessian="exact")
    names = {term.name for term in problem.terms}
    assert names >= {"speed limit", "acceleration limit", "rest limit", "meeting"}
    check_differences(_AsFunction(problem), sample_knots())
    rows, columns, values = problem.constraints_jacobian()
    # Agent 0 has guarded segments; the 5 and 6 of agents 1 and 2 are limited in their share.
    segments = LAYOUT.num_segments[0]
    jacobian = np.zeros((segments + 1 + 11, problem.num_variables))
    jacobian[rows, columns] = values
    assert len(set(zip(rows.tolist(), columns.tolist(), strict=True))) == len(rows)
    x = sample_knots().ravel()
    found = problem.constraints(x)
    assert jacobian @ x == pytest.approx(found)
    ((i, j),) = problem.limits.links
    assert found[segments] == pytest.approx(x[3 * j + 2] - x[3 * i + 2])
    own = sample_knots()[OFFSETS[1] : OFFSETS[2], 2]
    shares = problem.limits.greatest_share[5:10]
    assert found[segments + 1 : segments + 6] == pytest.approx(shares * np.ptp(own) - np.diff(own))
    least, greatest = problem.constraint_bounds()
    assert (least[segments], greatest[segments]) == (0.0, 0.0)
    assert (least[:segments] > 0).all()
    assert (found[segments + 1 :] > 0).all()


def test_no_step_goes_past_a_limit() -> None:
    problem = sample_problem(limited=True)
    knots = sample_knots()
    problem.accept(knots.ravel())
    assert np.isfinite(problem.value(knots.ravel()))
    hurried = knots.copy()
    hurried[2, 2] = hurried[3, 2] - 0.1
    assert problem.value(hurried.ravel()) == np.inf


@pytest.mark.parametrize("model", ["contacts", "smooth-minimum"])
def test_ipopt_derivative_test_passes(model: str, capfd: pytest.CaptureFixture[str]) -> None:
    problem = sample_problem(clearance_model=model, hessian="exact")
    options = {
        "derivative_test": "second-order",
        "derivative_test_perturbation": 1e-7,
        "derivative_test_tol": 1e-4,
        "point_perturbation_radius": 0.0,
        "print_level": 5,
    }
    solve(
        problem, sample_knots(), max_iterations=1, linear_solver="mumps", objective_scale=1.0,
        limited_memory=False, options=options, stop=lambda _: True,
    )  # fmt: skip
    assert "No errors detected by derivative checker." in capfd.readouterr().out


def test_touching_and_time_running_back_are_undefined() -> None:
    problem = sample_problem()
    knots = sample_knots()
    assert np.isfinite(problem.value(knots.ravel()))
    back = knots.copy()
    back[2, 2] = back[3, 2]
    assert problem.value(back.ravel()) == np.inf
    through = knots.copy()
    through[8] = knots[2]
    assert problem.value(through.ravel()) == np.inf
    outside = knots.copy()
    outside[2, 1] = -5.0
    assert problem.value(outside.ravel()) == np.inf
    broken = knots.copy()
    broken[2, 1] = np.nan
    assert problem.value(broken.ravel()) == np.inf


def test_bounds_fix_what_the_scene_gives() -> None:
    scene = sample_scene()
    knots = sample_knots()
    middle = replace(scene.agents[0], waypoints=(tuple(knots[2, :2]),))
    prescribed = replace(scene.agents[1], path=tuple(map(tuple, knots[6:12])))
    scene = replace(scene, agents=(middle, prescribed, scene.agents[2]))
    planning = PlanningProblem.from_scene(scene, None)
    timed = find_timed_constraints(planning, LAYOUT, knots)
    limits = build_limits(planning, LAYOUT, knots, timed)
    fixed = limits.lower == limits.upper
    assert fixed[0].all()
    assert fixed[5].tolist() == [True, True, False]
    assert fixed[2].tolist() == [True, True, False]
    assert fixed[6:12].all()
    assert not fixed[[1, 3, 4, 13]].any()
    assert limits.upper[18, 2] == scene.agents[2].max_time
    assert (limits.least_duration > 0).all()
    twice = replace(middle, waypoints=(tuple(knots[1, :2]), tuple(knots[4, :2])))
    assert visit_knots(twice, knots[:6]) == [(1, 1), (4, 4)]


def test_steps_that_contacts_cut_short_are_damped_and_long_ones_less_and_less() -> None:
    problem = sample_problem()
    x = sample_knots().ravel()
    problem.accept(x, 0.01)
    assert problem.damping == 0.0, "nothing has touched anything yet"
    plain = problem.hessian(x)
    # All agents in one place: the collision cost is undefined there.
    crowded = x.reshape(-1, 3).copy()
    crowded[:, :2] = crowded[0, :2]
    assert problem.value(crowded.ravel()) == np.inf
    problem.accept(x, 0.01)
    assert problem.damping > 0.0
    diagonal = problem.hessian_rows == problem.hessian_columns
    added = problem.hessian(x) - plain
    assert (added[diagonal] > 0).all()
    assert not added[~diagonal].any()
    before = problem.damping
    problem.accept(x, 1.0)
    assert problem.damping < before
    for _ in range(9):
        problem.accept(x, 1.0)
    assert problem.damping == 0.0
