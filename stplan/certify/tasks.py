"""Whether robots have done their tasks: who stood where for how long, by their curves alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stplan.amounts import amount, place
from stplan.arrays import FloatArray, Point
from stplan.certify.motion import place_tolerance, time_tolerance
from stplan.scene.model import Scene
from stplan.scene.tasks import RobotTask
from stplan.wording import count

# Tasks that nobody did that are named.
MOST_NAMED = 3


@dataclass(frozen=True)
class Done:
    """A task (its number in the scene) as it was done: by whom, and from when until when, s."""

    task: int
    agent: str
    begin: float
    end: float


@dataclass
class _Stand:
    """A robot that stands somewhere, and from when on nothing is done there yet."""

    agent: str
    begin: float
    end: float
    tolerance: float


def done_tasks(
    scene: Scene, curves: Mapping[str, FloatArray]
) -> tuple[tuple[Done, ...], tuple[str, ...]]:
    """The tasks of `scene` that `curves` did, and a sentence for everybody who did not do all of its own.

    Tasks of one robot are done in their order, each as early as can be. Of the shared ones each is done by
    whoever stands there long enough and does nothing else meanwhile.
    """
    stands = _stands(scene, curves)
    done: list[Done] = []
    sentences: list[str] = []
    own: dict[str, list[int]] = {}
    shared: dict[Point, list[int]] = {}
    for number, task in enumerate(scene.tasks):
        if task.agent is None:
            shared.setdefault(task.at, []).append(number)
        else:
            own.setdefault(task.agent, []).append(number)
    for name, numbers in own.items():
        now = -np.inf
        for position, number in enumerate(numbers):
            task = scene.tasks[number]
            there = [one for one in stands.get(task.at, []) if one.agent == name]
            found = _first(there, task, now)
            if found is None:
                sentences.append(_left(name, task, len(numbers) - position))
                break
            begin, now = found
            done.append(Done(number, name, begin, now))
    left = 0
    for at, numbers in shared.items():
        open_stands = stands.get(at, [])
        for number in sorted(numbers, key=lambda one: -scene.tasks[one].service):
            taken = _taken(open_stands, scene.tasks[number])
            if taken is None:
                left += 1
                if left <= MOST_NAMED:
                    sentences.append(f"nobody does the task at {place(*at)}")
            else:
                done.append(Done(number, *taken))
    if left > MOST_NAMED:
        sentences.append(f"nobody does {count(left - MOST_NAMED, 'more task')}")
    return tuple(sorted(done, key=lambda one: (one.end, one.task))), tuple(sentences)


def _left(name: str, task: RobotTask, number: int) -> str:
    return (
        f"{name}: never stands at {place(*task.at)} for {amount(task.service)} s "
        f"when it is to; {count(number, 'task')} left"
    )


def _first(stands: Sequence[_Stand], task: RobotTask, now: float) -> tuple[float, float] | None:
    """From when until when a task is done first after a moment, None if never."""
    for one in stands:
        begin = max(one.begin, now)
        if begin + task.service <= one.end + one.tolerance:
            return begin, begin + task.service
    return None


def _taken(stands: Sequence[_Stand], task: RobotTask) -> tuple[str, float, float] | None:
    """Who does a task, from when until when; that time is taken then."""
    for one in stands:
        if one.begin + task.service <= one.end + one.tolerance:
            begin, one.begin = one.begin, one.begin + task.service
            return one.agent, begin, one.begin
    return None


def _stands(scene: Scene, curves: Mapping[str, FloatArray]) -> dict[Point, list[_Stand]]:
    """Who stands at the point of a task, by that, in the order of time."""
    found: dict[Point, list[_Stand]] = {task.at: [] for task in scene.tasks}
    agents = {agent.id: agent for agent in scene.agents}
    for name, curve in curves.items():
        tolerance = place_tolerance(agents[name], curve)
        for point, list_ in found.items():
            on = np.hypot(*(curve[:, :2] - point).T) <= tolerance
            edges = np.flatnonzero(np.diff(np.concatenate([[0], on.astype(np.int8), [0]])))
            for first, after in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
                begin, end = float(curve[first, 2]), float(curve[after - 1, 2])
                list_.append(_Stand(name, begin, end, time_tolerance(curve)))
    for list_ in found.values():
        list_.sort(key=lambda one: (one.begin, one.agent))
    return found
