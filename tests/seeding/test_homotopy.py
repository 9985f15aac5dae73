"""Labels of homotopy classes: what changes them, and what does not."""

from __future__ import annotations

import numpy as np

from stplan.bench import families_open as wide
from stplan.problem.planning_problem import PlanningProblem
from stplan.seeding.homotopy import signature


def passing(side: float, late: float = 0.0) -> list[np.ndarray]:
    """Two agents on one line, the first of which steps aside by `side` m, `late` s after half-time."""
    way = np.array(
        [[-5.0, 0.0, 0.0], [-1.0, side, 9.0 + late], [1.0, side, 11.0 + late], [5.0, 0.0, 20.0]]
    )
    other = np.array([[5.0, 0.0, 0.0], [-5.0, 0.0, 20.0]])
    return [way, other]


def problem() -> PlanningProblem:
    starts = np.array([[-5.0, 0.0], [5.0, 0.0]])
    return PlanningProblem.from_scene(wide.crowd(starts, -starts, 20.0), None)


def test_left_and_right_are_different_classes() -> None:
    left, right = (signature(problem(), passing(side)) for side in (2.0, -2.0))
    assert left != right


def test_how_far_one_steps_aside_is_no_other_class() -> None:
    near, far = (signature(problem(), passing(2.0, late)) for late in (0.0, 0.5))
    assert near == far


def test_who_goes_first_through_a_crossing_is_a_class_of_its_own() -> None:
    starts = np.array([[-5.0, 0.0], [0.0, -5.0]])
    crossing = PlanningProblem.from_scene(wide.crowd(starts, -starts, 20.0), None)

    def curves(first: float, second: float) -> list[np.ndarray]:
        middle = np.zeros(2)
        return [
            np.vstack([[*start, 0.0], [*middle, when], [*-start, 20.0]])
            for start, when in zip(starts, (first, second), strict=True)
        ]

    assert signature(crossing, curves(8.0, 12.0)) != signature(crossing, curves(12.0, 8.0))


def test_who_minds_nobody_has_one_class() -> None:
    scene = wide.crowd(np.array([[0.0, 0.0]]), np.array([[4.0, 0.0]]), 10.0)
    alone = PlanningProblem.from_scene(scene, None)
    assert signature(alone, [np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 10.0]])]) == b""
