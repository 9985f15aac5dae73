"""The proof that curves are clear names whoever breaks it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.verification import verify
from stplan.scene.model import PairRule
from tests.seeding.families import agent, scene


def test_a_tail_stands_where_a_vanishing_agent_does_not() -> None:
    here = agent("here", (0, 0), (5, 0), max_time=5.0)
    late = agent("late", (5, 9), (5, -9), max_time=20.0)
    curves = [
        np.array([[0, 0, 0], [5, 0, 5.0]]),
        np.array([[5, 9, 0], [5, 5, 15.0], [5, -9, 20.0]]),
    ]
    staying = PlanningProblem.from_scene(scene([here, late]), None)
    assert len(verify(staying, curves)) == 1
    vanishing = scene([replace(here, after_arrival="vanish"), late])
    assert verify(PlanningProblem.from_scene(vanishing, None), curves) == []


def test_pairs_that_ignore_each_other_may_meet() -> None:
    agents = [agent("a", (0, 0), (9, 0)), agent("b", (9, 0), (0, 0))]
    curves = [np.array([[0, 0, 0], [9, 0, 20.0]]), np.array([[9, 0, 0], [0, 0, 20.0]])]
    assert verify(PlanningProblem.from_scene(scene(agents), None), curves)
    rule = PairRule((0,), (1,), collide=False)
    assert verify(PlanningProblem.from_scene(scene(agents, pairs=(rule,)), None), curves) == []


def test_verify_names_what_is_wrong() -> None:
    walker = agent("w", (0, 0), (9, 0), waypoints=((3.0, 1.0), (6.0, 1.0)))
    tram = agent("p", (0, 5), (9, 5), path=((0.0, 5.0, 0.0), (9.0, 5.0, 20.0)))
    problem = PlanningProblem.from_scene(scene([walker, tram]), None)
    good = np.array([[0, 0, 0], [3, 1, 5], [6, 1, 10], [9, 0, 20.0]])
    path = np.array([[0, 5, 0], [4.5, 5, 10], [9, 5, 20.0]])
    assert verify(problem, [good, path]) == []

    def faults(change: FloatArray | None = None, **edits: object) -> str:
        curve = good.copy() if change is None else change
        for place, value in edits.items():
            row, column = place[1:].split("_")
            curve[int(row), int(column)] = value
        return "; ".join(map(str, verify(problem, [curve, path])))

    assert "start" in faults(k0_0=1e-12)
    assert "start" in faults(k0_2=0.5)
    assert "goal" in faults(k3_1=1e-12)
    assert "after 20" in faults(k3_2=20.5)
    assert "time" in faults(k2_2=5.0)
    assert "waypoint 1" in faults(k1_0=3.1)
    assert "waypoint 2" in faults(good[[0, 2, 1, 3]] * [1, 1, 0] + good * [0, 0, 1])
    assert "finite" in faults(k1_1=np.nan)
    assert "finite" in faults(good[:1])
    astray = path + np.array([[0, 0, 0], [0, 1, 0], [0, 0, 0]])
    (fault,) = verify(problem, [good, astray])
    assert fault.agents == ("p",)
    assert "path" in str(fault)
    assert "1 curves for 2" in str(verify(problem, [good])[0])
