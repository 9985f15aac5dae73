"""The scene as the rest of the package sees it: immutable, complete, every default filled in.

The file format itself (keys, validation, JSON Schema) is `stplan.scene.format.file`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from stplan.arrays import Point
from stplan.maps.spec import MapSpec
from stplan.scene.moving_goals import MovingGoal
from stplan.scene.places import Assignment, Place
from stplan.scene.tasks import RobotTask
from stplan.schema.hashing import added

# How initial curves may be found: by one seeder, or by the portfolio of them.
SeedingMethod = Literal["auto", "dijkstra", "search", "relaxation"]
# What is to be least: the energy of the motion (with all other costs), the sum of arrival times, the latest.
Objective = Literal["energy", "arrivals", "makespan"]


@dataclass(frozen=True)
class Weights:
    """The paper's K of one agent, all >= 0. `regularity` None means auto (scaled by the seed)."""

    kinetic: float = 1.0
    acceleration: float = 0.0
    arrival: float = 0.0
    regularity: float | None = None
    collision: float = 1.0
    wall: float = 1.0
    clearance: float = added(1.0)


@dataclass(frozen=True)
class Visit:
    """When an agent is on a waypoint (`window`, s) and for how long at least (`dwell`, s)."""

    window: tuple[float, float] | None = None
    dwell: float = 0.0


@dataclass(frozen=True)
class Agent:
    """One agent. Lengths in m, times in s, mass in kg.

    `visits` has one entry a waypoint, or none at all where no waypoint asks for anything. With a
    `max_acceleration` (m/s^2) the agent starts and ends at rest; `max_speed` is in m/s. With a
    `start_velocity` (m/s) it starts in motion: its first segment has just that velocity, or one that
    `max_acceleration` lets it reach from there; with a `start_duration` (s) it keeps it for so long.
    `clearance` (m) is wished for beyond the radius.
    `path`, where given, is the whole world line ((x, y, t), ...): the motion is prescribed, and
    `start`, `goal`, `start_time` and `max_time` repeat its ends. With `goal_places` the agent ends anywhere
    in one of them, and `goal` is a point of them that planning begins with. With a `moving_goal` it ends
    wherever that leads, and `goal` repeats its start. With a `sight` (m) it knows of those alone whose
    centres are no further away, and, with `line_of_sight`, that no wall hides from it.
    """

    id: str
    start: Point
    goal: Point
    start_time: float
    max_time: float
    preferred_time: float | None
    radius: float
    mass: float
    after_arrival: Literal["stay", "vanish"]
    waypoints: tuple[Point, ...]
    weights: Weights
    path: tuple[tuple[float, float, float], ...] | None = None
    max_speed: float | None = None
    max_acceleration: float | None = None
    visits: tuple[Visit, ...] = ()
    clearance: float = added(0.0)
    goal_places: tuple[Place, ...] = added(())
    start_velocity: tuple[float, float] | None = added(None)
    start_duration: float = added(0.0)
    moving_goal: MovingGoal | None = added(None)  # noqa: RUF009
    sight: float | None = added(None)
    line_of_sight: bool = added(False)

    @property
    def starts_as_given(self) -> bool:
        """Whether its first segment has just the `start_velocity`."""
        given = self.start_velocity is not None
        return given and (self.max_acceleration is None or self.start_duration > 0.0)


@dataclass(frozen=True)
class Meet:
    """Centres at most `within` m apart at one common instant, inside `window` (s) where given."""

    within: float
    window: tuple[float, float] | None = None


@dataclass(frozen=True)
class PairRule:
    """An override for every pair with one agent (index) in `left` and the other in `right`."""

    left: tuple[int, ...]
    right: tuple[int, ...]
    distance: float | None = None
    grouping: float | None = None
    collide: bool | None = None
    meet: Meet | None = None
    collision: float | None = added(None)
    clearance: float | None = added(None)


@dataclass(frozen=True)
class SeedingSettings:
    """How initial curves are found; `layers` None means auto."""

    method: SeedingMethod = "auto"
    layers: int | None = None
    margin: float = 1.05
    time_limit: float = 60.0
    rng_seed: int = 0
    shortcuts: bool = added(True)


@dataclass(frozen=True)
class SolverSettings:
    """How curves are optimised; None means auto, `barrier_range` inf the unbounded logarithm."""

    knots: int | None = None
    effort: Literal["quick", "normal", "best"] = added("normal")
    starts: int | None = None
    mu: float | None = None
    mu_decay: float = 0.5
    outer_iterations: int = 5
    max_iterations: int = 200
    step_tolerance: float = 1.0e-2
    optimality_tolerance: float = 1.0e-2
    alpha: float = 50.0
    clearance_model: Literal["contacts", "smooth-minimum"] = "contacts"
    barrier_range: float | None = None
    hessian: Literal["gauss-newton", "exact", "limited-memory"] = "gauss-newton"
    linear_solver: str | None = "mumps"
    ipopt: Mapping[str, Any] = field(default_factory=dict)
    alpha_rule: Literal["half-clearance", "stepped"] = added("half-clearance")
    hessian_cutoff: float = added(0.0)
    convergence: Literal["decrease", "first-order"] = added("decrease")
    blocks: int | Literal["all"] | None = added(None)


@dataclass(frozen=True)
class Robust:
    """What a plan has to forgive.

    Attributes:
        delay: any one agent may stop for so long, s, if all keep the order of passing.
        tracking: everybody may be so far off its trajectory, m. Radii and distances of a `Scene` hold it.
    """

    delay: float = 0.0
    tracking: float = 0.0


@dataclass(frozen=True)
class WorldChange:
    """What becomes different while a scene is executed, and nobody knew beforehand.

    Attributes:
        at: when, s.
        scene: the world from then on, with everybody's own start in it.
        removed: ids of agents that are gone by then.
        delays: (id, s): who stands still from then on, for how long.
        causes: what happens, a sentence without a full stop each.
    """

    at: float
    scene: Scene
    removed: frozenset[str] = frozenset()
    delays: tuple[tuple[str, float], ...] = ()
    causes: tuple[str, ...] = ()

    def meaning(self) -> dict[str, Any]:
        """What it means, as it is hashed."""
        return {
            "at": self.at,
            "scene": self.scene.content_hash,
            "removed": sorted(self.removed),
            "delays": [list(delay) for delay in self.delays],
        }


@dataclass(frozen=True)
class Scene:
    """A whole planning problem.

    Attributes:
        name: names the output folder.
        source: the scene file, or None for a scene built in memory.
        content_hash: SHA-256 of the scene's meaning and of its mesh's bytes.
        horizon: T^max of agents without their own (s).
        time_scale: c in m/s; the space-time metric is dx^2 + dy^2 + (c dt)^2.
        metric: whether `time_scale` is the scene's own, is yet to be chosen (1 until then), or was.
        turning: c of the turns of acceleration costs where the metric was chosen, so that costs compare.
        locations: (line, column), from 1, of every path of the file such as ``agents[2].radius``.
        overridden: the ``--set`` argument that decided a path, where one did.
        overrides: the ``--set`` arguments that the file was read with, in order.
        agent_paths: where every agent stands in the file, ``agents[2]`` where left out.
        places: parts of the plane that have names.
        assignments: groups of agents of which everybody ends on one of some points.
        minimise: what is to be least.
        horizon_rule: whether `horizon` is stated, yet to be chosen (and ample until then), or was chosen.
        changes: what becomes different on the way, in the order of time.
        replan_every: how often goals that move are decided anew, s; None where there are none.
        robust: what the plan has to forgive.
        overlap: whether agents that start too near each other are refused, or eased apart.
        tasks: what robots do one after another, those of each in its order.
    """

    name: str
    description: str
    source: Path | None
    content_hash: str
    map: MapSpec | None
    horizon: float
    time_scale: float
    agents: tuple[Agent, ...]
    pairs: tuple[PairRule, ...]
    seeding: SeedingSettings
    solver: SolverSettings
    locations: Mapping[str, tuple[int, int]] = field(default_factory=dict, repr=False)
    overridden: Mapping[str, str] = field(default_factory=dict, repr=False)
    overrides: tuple[str, ...] = ()
    agent_paths: tuple[str, ...] = field(default=(), repr=False)
    metric: Literal["stated", "auto", "chosen"] = added("stated")
    turning: float | None = added(None)
    places: tuple[Place, ...] = added(())
    assignments: tuple[Assignment, ...] = added(())
    minimise: Literal["energy", "arrivals", "makespan"] = added("energy")
    horizon_rule: Literal["stated", "auto", "chosen"] = added("stated")
    changes: tuple[WorldChange, ...] = added(())
    replan_every: float | None = added(None)
    robust: Robust = added(Robust())  # noqa: RUF009
    overlap: Literal["refuse", "ease"] = added("refuse")
    tasks: tuple[RobotTask, ...] = added(())

    def agent_path(self, agent: int) -> str:
        """Where an agent stands in the file."""
        return self.agent_paths[agent] if self.agent_paths else f"agents[{agent}]"

    def entry_path(self, agent: int) -> str:
        """Where the entry of `agents` stands that an agent comes from, alone or with others."""
        path = self.agent_path(agent)
        return path[: path.find("]") + 1] or path

    def located(self, path: str, message: str) -> str:
        """`message` headed by file, line, column and `path` (or its nearest known ancestor)."""
        name = str(self.source or self.name)
        return located(name, self.locations, self.overridden, path, message)[0]

    @property
    def every_place(self) -> tuple[Place, ...]:
        """Parts of the plane that have names, and those that stand with agents as goals."""
        goals = (place for agent in self.agents for place in agent.goal_places)
        return tuple(dict.fromkeys([*self.places, *goals]))

    @property
    def turning_scale(self) -> float:
        """c of the turns of acceleration costs, m/s."""
        return self.time_scale if self.turning is None else self.turning

    @cached_property
    def final_time(self) -> float:
        """Until when a staying agent stands on its goal: the horizon, or the latest `max_time`."""
        return max(self.horizon, *(agent.max_time for agent in self.agents))


def located(
    name: str,
    locations: Mapping[str, tuple[int, int]],
    overridden: Mapping[str, str],
    path: str,
    message: str,
) -> tuple[str, tuple[int, int] | None]:
    """`message` headed by its place: of `path`, of its nearest ancestor in the file, or a ``--set``.

    The place alone comes second, None for an override.
    """
    text = f"{path}: {message}" if path else message
    known = path
    while known:
        if known in overridden:
            return f"--set {overridden[known]}: {text}", None
        known = known[: max(known.rfind("."), known.rfind("["), 0)]
    if path and path not in locations:
        # Neither in the file nor set: perhaps a section that an override made on its way.
        for key, override in overridden.items():
            if key.startswith((f"{path}.", f"{path}[")):
                return f"--set {override}: {text}", None
    known = path
    while known not in locations and known:
        known = known[: max(known.rfind("."), known.rfind("["), 0)]
    line, column = locations.get(known, (1, 1))
    return f"{name}:{line}:{column}: {text}", (line, column)
