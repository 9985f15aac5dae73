"""How many tasks robots do in an hour, against what they could if nobody were in anybody's way."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stplan.amounts import amount
from stplan.certify.tasks import done_tasks
from stplan.problem.continuation import curves_of
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.shortest_ways import lengths_between
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene
from stplan.wording import count

if TYPE_CHECKING:
    from stplan.world import FreeSpace

HOUR = 3600.0


@dataclass(frozen=True)
class Worked:
    """What one robot did.

    Attributes:
        tasks: how many.
        time: until its last one was done, s.
        bound: the same, had it gone on its shortest ways at its greatest speed; s.
    """

    agent: str
    tasks: int
    time: float
    bound: float


@dataclass(frozen=True)
class Throughput:
    """What all did; rates are in tasks an hour, until the last one is done.

    Attributes:
        bound: no more than this, whatever is planned for the tasks that everybody did.
        share: the rate over its bound.
        busy: the time that everybody's tasks take at least over what they took, all together.
    """

    tasks: int
    seconds: float
    per_hour: float
    bound: float
    share: float
    busy: float
    robots: tuple[Worked, ...]

    @property
    def sentences(self) -> list[str]:
        """In words."""
        return [
            f"{count(self.tasks, 'task')} done in {amount(self.seconds)} s: {amount(self.per_hour)} an hour, "
            f"{amount(100.0 * self.share)} % of the {amount(self.bound)} that robots could do at most "
            "if nobody were in anybody's way",
            f"robots take {amount(100.0 / self.busy - 100.0)} % longer for their tasks than each would alone",
        ]

    def as_dict(self) -> dict[str, Any]:
        """For report.json."""
        return asdict(self)


def throughput(scene: Scene, space: FreeSpace | None, lines: WorldLines) -> Throughput | None:
    """What the robots of `scene` did on `lines` (in any order); None if nothing.

    Nobody gets from task to task on less than the shortest way, or faster than its greatest speed.
    """
    done, _ = done_tasks(scene, curves_of(lines))
    if not done:
        return None
    stops = []
    for agent in scene.agents:
        own = sorted((one for one in done if one.agent == agent.id), key=lambda one: one.end)
        stops.append(np.array([agent.start, *(scene.tasks[one.task].at for one in own)]))
    problem = PlanningProblem.from_scene(scene, space)
    robots = []
    for agent, own_stops, legs in zip(
        scene.agents, stops, lengths_between(problem, stops), strict=True
    ):
        own = [one for one in done if one.agent == agent.id]
        if not own:
            continue
        service = sum(scene.tasks[one.task].service for one in own)
        bound = float(legs.sum()) / (agent.max_speed or np.inf) + service
        time = max(one.end for one in own) - agent.start_time
        robots.append(Worked(agent.id, len(own_stops) - 1, time, bound))
    seconds, least = max(one.time for one in robots), max(one.bound for one in robots)
    rates = [HOUR * len(done) / time if time > 0.0 else 0.0 for time in (seconds, least)]
    total = sum(one.time for one in robots)
    return Throughput(
        tasks=len(done),
        seconds=seconds,
        per_hour=rates[0],
        bound=rates[1],
        share=least / seconds if seconds > 0.0 else 1.0,
        busy=sum(one.bound for one in robots) / total if total > 0.0 else 1.0,
        robots=tuple(robots),
    )
