"""What is fixed and bounded."""

from __future__ import annotations

from dataclasses import replace

from stplan.optimize.constraints import build_constraints
from stplan.optimize.timed_constraints import find_timed_constraints, visit_knots
from stplan.problem.planning_problem import PlanningProblem
from tests.derivatives.samples import LAYOUT, sample_knots
from tests.nlp.sample_programs import sample_scene


def test_bounds_fix_what_the_scene_gives() -> None:
    scene = sample_scene()
    knots = sample_knots()
    middle = replace(scene.agents[0], waypoints=(tuple(knots[2, :2]),))
    prescribed = replace(scene.agents[1], path=tuple(map(tuple, knots[6:12])))
    scene = replace(scene, agents=(middle, prescribed, scene.agents[2]))
    planning = PlanningProblem.from_scene(scene, None)
    timed = find_timed_constraints(planning, LAYOUT, knots)
    limits = build_constraints(planning, LAYOUT, knots, timed)
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
