"""Small scenes that show that everything works, and that need every kernel, so that all are compiled."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numba.core import event

from stplan import planner
from stplan.callbacks import never
from stplan.errors import SeedingError
from stplan.installation.kernels import all_kernels
from stplan.problem.requirement import least_requirement
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene
from stplan.seeding.margins import margin_ladder
from stplan.seeding.search.joint import plan_jointly
from stplan.seeding.search.joint_search import JointSearch
from stplan.seeding.search.levels import Levels
from stplan.seeding.search.way_timing import timed_way
from stplan.seeding.seeder import Budget
from stplan.seeding.shortcutting.pacing import paced
from stplan.threads import threads

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stplan.problem.planning_problem import PlanningProblem
    from stplan.scene.model import Scene

Watch = Callable[[int, int], None]

_OPEN = """\
stplan: 1
name: self-test
horizon: 8
defaults: {radius: 0.3}
agents:
  - {id: a, start: [-3, 0], goal: [3, 0.1]}
  - {id: b, start: [0.2, -3], goal: [0, 3]}
"""
_LIMITS = """\
stplan: 1
name: limits
horizon: 10
defaults: {radius: 0.3}
agents:
  - {id: a, start: [-3, 0], goal: [3, 0.1], max_acceleration: 4, max_speed: 4}
  - {id: b, start: [3, 0.2], goal: [-3, 0], waypoints: [[0, 1]], weights: {acceleration: 0.1}}
  - {id: c, start: [0, -3], goal: [0.1, 3], preferred_time: 9, weights: {arrival: 1}, clearance: 0.3}
pairs: [{between: [a, b], grouping: 0.1}]
"""
_ROOM = """\
stplan: 1
name: room
horizon: 30
map:
  rectangle: [0, 0, 9, 5]
  obstacles:
    - {rectangle: [4, 0, 4.4, 2]}
    - {rectangle: [4, 3.1, 4.4, 5]}
    - {circle: {center: [6.5, 2.5], radius: 0.4}}
defaults: {radius: 0.35}
agents:
  - {id: a, start: [2, 0.6], goal: [7.5, 0.6]}
  - {id: b, start: [7.5, 4.4], goal: [1.2, 4.4], radius: 0.3}
  - {id: c, start: [1, 2.5], goal: [8, 2.5]}
"""
_LANE = """\
stplan: 1
name: lane
horizon: 20
map: {rectangle: [0, 0, 6, 0.8]}
defaults: {radius: 0.3}
agents:
  - {id: a, start: [1, 0.4], goal: [5, 0.4]}
  - {id: b, start: [5, 0.4], goal: [1, 0.4]}
"""
_THIN = _ROOM.replace("0.35", "0.04")
_SMOOTH = "solver: {clearance_model: smooth-minimum, effort: quick}\n"
_SCENES = (_OPEN, _LIMITS, _LIMITS + _SMOOTH, _ROOM, _ROOM + _SMOOTH, _THIN, _LANE)
# More pairs than are looked at one by one.
_CROWD = 220


@dataclass(frozen=True)
class SelfTest:
    """How planning a scene of two agents ended.

    Attributes:
        certified: whether a plan came about whose certificate holds.
        sentence: in words.
        seconds: it took.
    """

    certified: bool
    sentence: str
    seconds: float


def self_test() -> SelfTest:
    """Plan two agents that cross in the open."""
    plan = planner.plan(parse_scene(_OPEN))
    certified = plan.exit_status == 0 and plan.certificate.holds
    return SelfTest(certified, plan.certificate.summary, plan.run.seconds["total"])


def compile_kernels(progress: Watch | None = None) -> tuple[str, ...]:
    """Plan scenes that need the kernels between them, so that their machine code is on disk afterwards.

    Args:
        progress: given the number of kernels ready and of all, again and again.

    Returns:
        names of those that no scene has called.
    """
    kernels = all_kernels()

    def tell() -> None:
        if progress is not None:
            progress(sum(bool(kernel.overloads) for kernel in kernels.values()), len(kernels))

    tell()
    with _after_each_compilation(tell):
        for text in _SCENES:
            # Nobody gets past another in the lane: saying so takes searches of its own.
            with suppress(SeedingError):
                planner.plan(parse_scene(text))
            tell()
        _search_jointly(Levels(planner.prepare(parse_scene(_ROOM))))
        with threads(2, few=0):
            planner.seed(parse_scene(_OPEN))
        for text in (_OPEN, _ROOM):
            _keep_to_ways(planner.prepare(parse_scene(text)))
        scene = parse_scene(_crowd_text(_CROWD))
        planner.check(scene, _straight_lines(scene))
        tell()
    return tuple(name for name, kernel in kernels.items() if not kernel.overloads)


def _search_jointly(levels: Levels) -> None:
    """The last resorts of search, which scenes as simple as these do not need."""
    JointSearch(levels).attempt(Budget())
    level = levels.at(margin_ladder(levels.problem.scene.seeding.margin)[-1])
    planner = level.planner(1)
    plan_jointly(planner, (0, 1), np.random.default_rng(0), never)
    planner.soft_path(0, 1)


def _keep_to_ways(problem: PlanningProblem) -> None:
    """What only replanning asks for."""
    curves = [
        np.column_stack([problem.stops[a][[0, -1]], [problem.start_times[a], problem.max_times[a]]])
        for a in range(problem.num_agents)
    ]
    paced(problem, curves, 0, curves[0][:, :2], least_requirement(problem))
    points = np.linspace(problem.starts[0], problem.goals[0], 9)
    theirs = np.repeat(problem.starts[1:, None], 2, axis=1)
    timed_way(points, theirs, np.full(len(theirs), float(problem.radii[:2].sum())), 40)


def _crowd_text(count: int) -> str:
    agents = (f"  - {{id: a{k}, start: [0, {k}], goal: [9, {k}]}}" for k in range(count))
    return "\n".join(["stplan: 1", "name: crowd", "horizon: 9", "agents:", *agents, ""])


def _straight_lines(scene: Scene) -> WorldLines:
    """Everybody straight and at constant speed to its goal."""
    return WorldLines.from_curves(
        [agent.id for agent in scene.agents],
        [
            np.array([[*agent.start, agent.start_time], [*agent.goal, agent.max_time]])
            for agent in scene.agents
        ],
    )


class _AfterCompilation(event.Listener):
    """Calls a function whenever something has been compiled."""

    def __init__(self, tell: Callable[[], None]) -> None:
        self._tell = tell

    def on_start(self, event: Any) -> None:
        """Nothing yet."""

    def on_end(self, event: Any) -> None:
        """Something is compiled."""
        del event
        self._tell()


@contextmanager
def _after_each_compilation(tell: Callable[[], None]) -> Iterator[None]:
    with cast(Any, event).install_listener("numba:compile", _AfterCompilation(tell)):
        yield
