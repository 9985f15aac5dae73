"""Goals that move and tasks in words: what everybody wants, and what became of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stplan.amounts import amount
from stplan.analysis.chases import chases
from stplan.analysis.throughput import throughput
from stplan.explain.explanation import Fact, Section
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene
from stplan.scene.moving_goals import REPLAN_EVERY, MovingGoal
from stplan.scene.tasks import WINDOW, RobotTask
from stplan.wording import count, names

if TYPE_CHECKING:
    from stplan.world import FreeSpace


def tasks_section(scene: Scene) -> Section:
    """What the robots of a scene have to do."""
    lists: dict[str | None, list[RobotTask]] = {}
    for task in scene.tasks:
        lists.setdefault(task.agent, []).append(task)
    facts = []
    for name, tasks in lists.items():
        whose = "shared by all" if name is None else f"of {name}"
        points = count(len({task.at for task in tasks}), "point")
        service = sum(task.service for task in tasks)
        facts.append(
            Fact(
                f"{count(len(tasks), 'task')} {whose}, at {points}, {amount(service)} s of service"
            )
        )
    every = amount(scene.replan_every or REPLAN_EVERY)
    lead = (
        f"Every {every} s whoever's plan ends within {amount(WINDOW)} s is planned on, among the plans "
        "of all others, until all is done:"
    )
    return Section("tasks", "What is to be done", lead, facts)


def done_section(scene: Scene, space: FreeSpace | None, lines: WorldLines) -> Section:
    """What of the tasks of `scene` was done on `lines`, and how fast."""
    found = throughput(scene, space, lines)
    facts = [Fact("No task was done.")] if found is None else [*map(Fact, found.sentences)]
    return Section("tasks", "What was done", "", facts)


def wishes_section(scene: Scene) -> Section:
    """What everybody whose goal moves wants of whom."""
    facts = [
        Fact(f"{agent.id} {_wish(agent.moving_goal)}")
        for agent in scene.agents
        if agent.moving_goal is not None
    ]
    sights: dict[tuple[float, bool], list[str]] = {}
    for agent in scene.agents:
        if agent.sight is not None:
            sights.setdefault((agent.sight, agent.line_of_sight), []).append(agent.id)
    facts += [
        Fact(
            f"{names(who)} {'sees' if len(who) == 1 else 'see'} others within {amount(sight)} m alone"
            + (", and not through walls" if blocked else "")
        )
        for (sight, blocked), who in sights.items()
    ]
    every = amount(scene.replan_every or REPLAN_EVERY)
    lead = f"The scene is played: every {every} s all decide anew, by where the others are then:"
    return Section("chases", "What nobody knows beforehand", lead, facts)


def _wish(goal: MovingGoal) -> str:
    whom = names(goal.others)
    if goal.kind == "follow":
        return f"follows {whom}, to within {amount(goal.within)} m"
    if goal.kind == "pursue":
        return f"pursues {whom}, and catches within {amount(goal.capture)} m"
    where = [str(place) for place in goal.places]
    return f"evades {whom}" + (f", to {names(where)}" if where else "")


def outcome_section(scene: Scene, lines: WorldLines) -> Section:
    """What became of the goals that move of `scene` as `lines` were executed."""
    facts = [*map(Fact, chases(scene, lines).sentences)]
    return Section("chases", "What became of it", "When it was played:", facts)
