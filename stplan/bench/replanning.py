"""How quickly plans are mended when something happens, and what mended ones cost.

Events are drawn: somebody is delayed, is sent elsewhere, or finds a disc on its way. The mended plan is set
beside one that is planned afresh from that moment with all that is known, with the effort of the scene.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stplan import planner
from stplan.arrays import FloatArray
from stplan.bench.csv_table import csv_table
from stplan.bench.families_open import open_field
from stplan.bench.markdown import number, table
from stplan.bench.result_files import result_files
from stplan.callbacks import Progress
from stplan.compiled import working_time
from stplan.errors import SceneError, SeedingError
from stplan.maps.obstacles import CircleObstacle
from stplan.planned import Plan
from stplan.problem.continuation import continued_scene, curves_of, piece_of, place_at
from stplan.problem.kinetic_cost import total_kinetic_cost
from stplan.replanning.execution import go_on
from stplan.scene.model import Scene, WorldChange

KINDS = ("delay", "goal", "door")
# Agents are delayed so long, s; discs lie so far ahead of an agent, as shares of what is left of its way.
DELAY = 4.0
AHEAD = (0.4, 0.8)
# Events happen within these shares of the horizon.
WITHIN = (0.05, 0.7)
CROWD, DENSITY = 100, 0.08


@dataclass(frozen=True)
class MendedDraw:
    """What came of an event.

    Attributes:
        seconds: of processor time.
        certified: None where there is no plan.
        cost, afresh: kinetic cost from the event on, J s; of a plan afresh, nan where none was made.
    """

    scene: str
    kind: str
    agents: int
    seconds: float
    certified: bool | None
    cost: float = float("nan")
    afresh: float = float("nan")


def crowd_scene() -> Scene:
    """A hundred agents in the open."""
    return replace(open_field(CROWD, DENSITY), name="open-field")


def measure(
    scenes: Sequence[Scene], draws: int, afresh: int, *, progress: Progress, rng_seed: int = 0
) -> list[MendedDraw]:
    """`draws` events of every kind in every scene, the first `afresh` of them beside a fresh plan.

    The first mending of a scene is done twice, so that nothing is loaded or compiled within what is measured.
    """
    found: list[MendedDraw] = []
    for scene in scenes:
        before = planner.plan(scene)
        warm = False
        for kind in KINDS if scene.map is not None else KINDS[:2]:
            rng = np.random.default_rng([rng_seed, KINDS.index(kind)])
            for number_of in range(draws):
                change = drawn(kind, scene, before, rng)
                if not warm:
                    mended(scene, before, kind, change, afresh=False)
                    warm = True
                one = mended(scene, before, kind, change, afresh=number_of < afresh)
                found.append(one)
                verdict = {None: "refused", False: "not certified", True: "certified"}
                progress(
                    f"{scene.name}: {kind} at {change.at:.4g} s  {one.seconds:.2f} s  "
                    f"{verdict[one.certified]}"
                )
    return found


def drawn(kind: str, scene: Scene, before: Plan, rng: np.random.Generator) -> WorldChange:
    """An event of a kind, of somebody who is on its way."""
    curves = curves_of(before.trajectories or before.seed)
    at = float(rng.uniform(*WITHIN)) * scene.horizon
    moving = [k for k, one in enumerate(scene.agents) if curves[one.id][-1, 2] > at]
    chosen = int(rng.choice(moving))
    agent = scene.agents[chosen]
    if kind == "delay":
        return WorldChange(at, scene, delays=((agent.id, DELAY),), causes=("a delay",))
    if kind == "goal":
        goals = np.array([one.goal for one in scene.agents])
        free = [
            one.start
            for one in scene.agents
            if np.hypot(*(np.delete(goals, chosen, axis=0) - one.start).T).min() > 2.0 * one.radius
        ]
        goal = free[int(rng.integers(len(free)))] if free else agent.start
        agents = list(scene.agents)
        agents[chosen] = replace(agent, goal=goal)
        return WorldChange(at, replace(scene, agents=tuple(agents)), causes=("a new goal",))
    curve = curves[agent.id]
    when = at + float(rng.uniform(*AHEAD)) * float(curve[-1, 2] - at)
    x, y, _ = place_at(curve, when).tolist()
    floor = scene.map
    if floor is None:
        raise ValueError("doors close in maps alone")
    obstacle = CircleObstacle((x, y), agent.radius)
    closed = replace(floor, obstacles=(*floor.obstacles, obstacle))
    return WorldChange(at, replace(scene, map=closed), causes=("a closed door",))


def mended(
    scene: Scene, before: Plan, kind: str, change: WorldChange, *, afresh: bool
) -> MendedDraw:
    """Mend a plan, and measure."""
    world = replace(scene, changes=(change,))
    began = working_time()
    try:
        plan = go_on(world, before, [change])
    except SeedingError:
        return MendedDraw(scene.name, kind, len(scene.agents), working_time() - began, None)
    one = MendedDraw(
        scene.name, kind, len(scene.agents), working_time() - began, plan.certificate.holds
    )
    curves = curves_of(plan.trajectories or plan.seed)
    rest = {
        name: piece_of(curve, max(change.at, float(curve[0, 2])), float(curve[-1, 2]))
        for name, curve in curves.items()
        if curve[-1, 2] > change.at
    }
    one = replace(one, cost=_cost(change.scene, rest))
    if not afresh:
        return one
    history = curves_of(before.trajectories or before.seed)
    try:
        fresh = planner.plan(continued_scene(scene, history, change))
    except (SeedingError, SceneError):
        return one
    return replace(one, afresh=_cost(change.scene, curves_of(fresh.trajectories or fresh.seed)))


def _cost(scene: Scene, curves: dict[str, FloatArray]) -> float:
    masses = {agent.id: agent.mass for agent in scene.agents}
    return total_kinetic_cost([masses[name] for name in curves], list(curves.values()))


def files(measured: Sequence[MendedDraw]) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    rows = [{name: getattr(one, name) for name in MendedDraw.__annotations__} for one in measured]
    return result_files("replanning", csv_table(rows), markdown_text(measured))


def markdown_text(measured: Sequence[MendedDraw]) -> str:
    """One row a scene and kind of event."""
    head = (
        "scene", "agents", "event", "draws", "certified", "refused", "median s", "worst s",
        "cost over afresh, median %", "compared",
    )  # fmt: skip
    rows = []
    for scene, kind in dict.fromkeys((one.scene, one.kind) for one in measured):
        own = [one for one in measured if (one.scene, one.kind) == (scene, kind)]
        seconds = [one.seconds for one in own]
        over = [100.0 * (one.cost / one.afresh - 1.0) for one in own if np.isfinite(one.afresh)]
        figures = (
            number(float(np.median(seconds)), ".2f"),
            number(max(seconds), ".2f"),
            number(float(np.median(over)) if over else np.nan, "+.1f"),
        )
        certified = _count(own, lambda one: one.certified is True)
        refused = _count(own, lambda one: one.certified is None)
        counts = str(len(own)), certified, refused
        rows.append((scene, str(own[0].agents), kind, *counts, *figures, str(len(over))))
    return table(head, rows, (0, 2))


def _count(measured: Sequence[MendedDraw], counts: Callable[[MendedDraw], bool]) -> str:
    return str(sum(map(counts, measured)))
