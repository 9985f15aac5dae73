"""Who has done which task, on hand-made curves whose outcome is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.certify.tasks import Done, done_tasks
from stplan.scene import parse_scene
from stplan.scene.tasks import RobotTask

SCENE = parse_scene(
    "stplan: 1\nhorizon: none\nmap: {rectangle: [-2, -2, 12, 8]}\n"
    "defaults: {radius: 0.3, max_speed: 2}\nagents:\n"
    "  - {id: ann, start: [0, 0]}\n  - {id: bob, start: [0, 4]}\n"
    "tasks: {points: [[4, 0], [8, 0]], each: 1, service: 2}\n"
)
DOOR, SHELF = (4.0, 0.0), (8.0, 0.0)
# At the door from 2 to 5 s, at the shelf from 7 to 8.5 s.
ANN = [[0, 0, 0], [4, 0, 2], [4, 0, 4.5], [4, 0, 5], [8, 0, 7], [8, 0, 8.5], [0, 0, 13]]
BOB = [[0, 4, 0], [4, 0, 8], [4, 0, 11], [0, 4, 15]]


def judged(*tasks: RobotTask, **curves: list) -> tuple[tuple[Done, ...], tuple[str, ...]]:
    """What was done, and what is missing."""
    arrays = {name: np.array(one, dtype=float) for name, one in curves.items()}
    return done_tasks(replace(SCENE, tasks=tasks), arrays)


def test_own_tasks_are_done_in_order_and_as_early_as_can_be() -> None:
    done, missing = judged(
        RobotTask("ann", DOOR, 1.0), RobotTask("ann", DOOR, 1.5), RobotTask("ann", SHELF, 1.5),
        ann=ANN, bob=BOB,
    )  # fmt: skip
    assert missing == ()
    assert done == (
        Done(0, "ann", 2.0, 3.0), Done(1, "ann", 3.0, 4.5), Done(2, "ann", 7.0, 8.5),
    )  # fmt: skip


def test_who_stands_too_short_or_in_another_order_is_named() -> None:
    short = judged(RobotTask("ann", SHELF, 1.6), RobotTask("ann", DOOR, 1.0), ann=ANN, bob=BOB)
    sentence = "ann: never stands at (8, 0) for 1.6 s when it is to; 2 tasks left"
    assert short == ((), (sentence,))
    done, missing = judged(
        RobotTask("ann", SHELF, 1.0), RobotTask("ann", DOOR, 1.0), RobotTask("bob", DOOR, 3.0),
        ann=ANN, bob=BOB,
    )  # fmt: skip
    assert missing == ("ann: never stands at (4, 0) for 1 s when it is to; 1 task left",)
    # In the order in which they end.
    assert done == (Done(0, "ann", 7.0, 8.0), Done(2, "bob", 8.0, 11.0))
    # Two of 1.6 s do not fit into three seconds.
    twice = [RobotTask("ann", DOOR, 1.6)] * 2
    assert judged(*twice, ann=ANN, bob=BOB)[1] == (
        "ann: never stands at (4, 0) for 1.6 s when it is to; 1 task left",
    )


def test_nobody_does_the_task_of_another() -> None:
    _, missing = judged(RobotTask("bob", SHELF, 1.0), ann=ANN, bob=BOB)
    assert missing == ("bob: never stands at (8, 0) for 1 s when it is to; 1 task left",)


def test_shared_tasks_are_for_whoever_stands_there_long_enough() -> None:
    # The longest first: it takes all of somebody's stand, the short ones what is left.
    tasks = [RobotTask(None, DOOR, 1.0), RobotTask(None, DOOR, 3.0), RobotTask(None, DOOR, 2.0)]
    done, missing = judged(*tasks, ann=ANN, bob=BOB)
    assert missing == ()
    assert done == (
        Done(1, "ann", 2.0, 5.0), Done(2, "bob", 8.0, 10.0), Done(0, "bob", 10.0, 11.0),
    )  # fmt: skip


@pytest.mark.parametrize("more", [0, 1, 2])
def test_shared_tasks_that_nobody_does_are_named_or_counted(more: int) -> None:
    tasks = [RobotTask(None, SHELF, 1.5), *[RobotTask(None, SHELF, 9.0)] * (3 + more)]
    done, missing = judged(*tasks, ann=ANN, bob=BOB)
    assert done == (Done(0, "ann", 7.0, 8.5),)
    said = ["", "nobody does 1 more task", "nobody does 2 more tasks"][more]
    assert missing == ("nobody does the task at (8, 0)",) * 3 + ((said,) if said else ())


def test_passing_by_is_no_standing_but_does_for_a_task_without_service() -> None:
    passing = [[0, 0, 0], [4, 0, 2], [8, 0, 4], [0, 0, 9]]
    assert judged(RobotTask("ann", DOOR, 0.0), ann=passing, bob=BOB) == (
        (Done(0, "ann", 2.0, 2.0),), (),
    )  # fmt: skip
    assert judged(RobotTask("ann", DOOR, 0.1), ann=passing, bob=BOB)[0] == ()
    # Nor is a knot nearby, further away than rounding.
    beside = [[0, 0, 0], [4, 1e-5, 2], [4, 1e-5, 5], [0, 0, 9]]
    assert judged(RobotTask("ann", DOOR, 1.0), ann=beside, bob=BOB)[0] == ()
    almost = [[0, 0, 0], [4, 1e-8, 2], [4, 1e-8, 5], [0, 0, 9]]
    assert len(judged(RobotTask("ann", DOOR, 1.0), ann=almost, bob=BOB)[0]) == 1


def test_of_two_who_stand_there_the_earlier_one_takes_a_shared_task() -> None:
    late = [[0, 0, 0], [4, 0, 9], [4, 0, 20]]
    early = [[0, 4, 0], [4, 0, 3], [4, 0, 8], [0, 4, 20]]
    done, _ = judged(RobotTask(None, DOOR, 1.0), ann=late, bob=early)
    assert done == (Done(0, "bob", 3.0, 4.0),)
