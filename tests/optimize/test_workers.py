"""Parts are optimised alike by any number of processes, whatever becomes of them."""

from __future__ import annotations

import multiprocessing
import os
import signal
from dataclasses import replace

import numpy as np
import pytest

from stplan.bench import families_open as wide
from stplan.errors import SolverError
from stplan.optimize.parts import DividedProblem, Part
from stplan.optimize.workers import on_this_machine
from stplan.planner import find_initial_curves, prepare
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines

PARTS = [Part(np.arange(3 * k, 3 * k + 3), begin=2) for k in range(4)]


@pytest.fixture(scope="module")
def seeded() -> tuple[PlanningProblem, WorldLines]:
    scene = wide.crossing_flows(12, 1.0, 3)
    quick = replace(scene.solver, effort="quick", starts=1)
    problem = prepare(replace(scene, solver=quick))
    (initial,) = find_initial_curves(problem)
    return problem, initial.seed.world_lines


def curves(divided: DividedProblem, number: int) -> list[np.ndarray]:
    told: list[int] = []
    with on_this_machine(number)(divided) as crew:
        results = crew.optimise(PARTS, told.append)
    assert told == [1, 2, 3, 4]
    assert not multiprocessing.active_children()
    return [np.vstack(result.curves) for result in results if result is not None]


def test_two_processes_give_what_this_one_gives(seeded: tuple[PlanningProblem, WorldLines]) -> None:
    alone, forked = (curves(DividedProblem(*seeded, lambda: False), number) for number in (1, 2))
    assert len(alone) == len(forked) == len(PARTS)
    assert all(map(np.array_equal, alone, forked))
    assert not np.array_equal(alone[0], np.vstack(list(seeded[1].curves())[:3]))


def test_the_part_of_a_process_that_dies_is_done_here(
    seeded: tuple[PlanningProblem, WorldLines], monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = curves(DividedProblem(*seeded, lambda: False), 1)
    here, optimised = os.getpid(), DividedProblem.optimised

    def dying(self: DividedProblem, part: Part) -> object:
        if os.getpid() != here and part.agents[0] == 3:
            os.kill(os.getpid(), signal.SIGKILL)
        return optimised(self, part)

    monkeypatch.setattr(DividedProblem, "optimised", dying)
    assert all(map(np.array_equal, expected, curves(DividedProblem(*seeded, lambda: False), 2)))


def test_what_a_process_raises_is_raised_here(
    seeded: tuple[PlanningProblem, WorldLines], monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(self: DividedProblem, part: Part) -> object:
        raise SolverError("no such solver")

    monkeypatch.setattr(DividedProblem, "optimised", failing)
    with pytest.raises(SolverError, match="no such solver"):
        curves(DividedProblem(*seeded, lambda: False), 2)
    assert not multiprocessing.active_children()


def test_a_stop_reaches_all_processes(seeded: tuple[PlanningProblem, WorldLines]) -> None:
    divided = DividedProblem(*seeded, lambda: True)
    with on_this_machine(2)(divided) as crew:
        assert crew.optimise(PARTS, lambda done: None) == [None] * len(PARTS)
