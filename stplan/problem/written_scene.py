"""A scene as its user wrote it, and the way between it and the local frame it is planned in.

What a plan costs is measured in J s. With lengths in L, times in T and masses in M a kinetic cost is
S = M L^2 / T times its local value, and a local problem is the same one where every other cost scales alike:
weights of costs without a unit (acceleration, regularity, barriers) are divided by S, those of squared
seconds (arrival) by S / T^2, those of squared metres (grouping) by S / L^2, and c by L / T.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray, Point
from stplan.problem.planning_frame import PlanningFrame, share
from stplan.problem.world_lines import WorldLines
from stplan.reasons import Reason
from stplan.scene.model import (
    Agent,
    Meet,
    PairRule,
    Robust,
    Scene,
    SolverSettings,
    Visit,
    Weights,
)
from stplan.scene.places import Place

if TYPE_CHECKING:
    from stplan.world.free_space import FreeSpace

# Knots this near to a fixed point, arrivals this near to the latest one, are there; local units.
SAME = 1e-9

# Significant digits of a figure that went into the frame and back.
FIGURE_DIGITS = 12

Window = tuple[float, float]


@dataclass(frozen=True)
class WrittenScene:
    """What the user wrote; its curves are what is certified and written.

    Attributes:
        free_space: None in the open plane.
        frame: what the scene is planned in.
    """

    scene: Scene
    free_space: FreeSpace | None
    frame: PlanningFrame = field(default_factory=PlanningFrame)

    @staticmethod
    def framed(scene: Scene, free_space: FreeSpace | None) -> WrittenScene:
        """The scene with the frame that suits it."""
        return WrittenScene(scene, free_space, PlanningFrame.of_scene(scene, free_space))

    @property
    def local_space(self) -> FreeSpace | None:
        """The free space in the frame."""
        return None if self.free_space is None else self.frame.local_space(self.free_space)

    @property
    def local_scene(self) -> Scene:
        """The scene in the frame."""
        scene, frame = self.scene, self.frame
        horizon = float(frame.local_times(np.array([scene.horizon]))[0])
        spec = scene.map
        if spec is not None and spec.resolution is not None:
            spec = replace(spec, resolution=share(spec.resolution, frame.length))
        return replace(
            scene,
            map=spec,
            horizon=horizon,
            time_scale=share(scene.time_scale, frame.speed),
            turning=None if scene.turning is None else share(scene.turning, frame.speed),
            agents=self._local_agents,
            pairs=tuple(_local_rule(rule, frame) for rule in scene.pairs),
            solver=_local_solver(scene.solver, frame),
            places=_local_places(scene.places, frame),
            robust=Robust(
                share(scene.robust.delay, frame.time), share(scene.robust.tracking, frame.length)
            ),
            assignments=tuple(
                replace(one, points=_local_points(one.points, frame)) for one in scene.assignments
            ),
        )

    def with_local_goals(self, goals: Mapping[int, Point]) -> WrittenScene:
        """The scene with other goals of some agents, given in the frame."""
        chosen = {}
        points = {a: one.points for one in self.scene.assignments for a in one.members}
        for a, goal in goals.items():
            among = points.get(a, (self.scene.agents[a].goal,))
            local = _local_points(among, self.frame)
            if goal in local:
                chosen[a] = among[local.index(goal)]
            else:
                ((x, y),) = self.frame.points(np.array([goal])).tolist()
                chosen[a] = (x, y)
        agents = tuple(
            replace(agent, goal=chosen.get(a, agent.goal))
            for a, agent in enumerate(self.scene.agents)
        )
        return replace(self, scene=replace(self.scene, agents=agents))

    @cached_property
    def _local_agents(self) -> tuple[Agent, ...]:
        """The agents in the frame."""
        return tuple(_local_agent(agent, self.frame) for agent in self.scene.agents)

    def outside(self, lines: WorldLines) -> WorldLines:
        """Local `lines`, in scene order, as the user's; what is met in the frame is met to the last bit."""
        return _outside(self.scene.agents, self._local_agents, lines, self.frame)

    def outside_curve(self, agent: Agent, local: FloatArray) -> FloatArray:
        """A `local` curve (n, 3) of one agent of the scene as the user's, alike."""
        lines = WorldLines.from_curves([agent.id], [local])
        return _outside([agent], [_local_agent(agent, self.frame)], lines, self.frame).knots

    def outside_reason(self, reason: Reason) -> Reason:
        """A `reason` of the local problem with its place, times and figures as the user's."""
        frame, place, times = self.frame, reason.place, reason.times
        figures = {name: _figure(name, value, frame) for name, value in reason.figures.items()}
        if place is not None:
            ((x, y),) = frame.points(np.array([place])).tolist()
            place = (x, y)
        if times is not None:
            first, last = frame.times(np.array(times)).tolist()
            times = (first, last)
        return replace(reason, place=place, times=times, figures=figures)

    def inside(self, lines: WorldLines) -> WorldLines:
        """The user's `lines`, in scene order, in the frame."""
        frame = self.frame
        curves = []
        for agent, local, given in zip(
            self.scene.agents, self._local_agents, lines.curves(), strict=True
        ):
            curve = np.column_stack(
                [frame.local_points(given[:, :2]), frame.local_times(given[:, 2])]
            )
            if agent.path is None:
                curve[0] = *local.start, local.start_time
                if tuple(given[-1, :2]) == agent.goal:
                    curve[-1, :2] = local.goal
                for point, own in zip(agent.waypoints, local.waypoints, strict=True):
                    off = np.abs(given[:, :2] - point).max(axis=1)
                    curve[off <= SAME * frame.length, :2] = own
                curve[-1, 2] = min(curve[-1, 2], local.max_time)
            curves.append(curve)
        return WorldLines.from_curves(lines.agent_ids, curves)


def _figure(name: str, value: float, frame: PlanningFrame) -> float:
    """A figure of a reason as the user's, to so many digits that a number shows as it was written."""
    unit = {
        **dict.fromkeys(("distance", "required", "widest", "radius", "length"), frame.length),
        "speed": frame.speed,
        "acceleration": frame.acceleration,
    }
    if name in ("earliest", "latest"):
        value = float(frame.times(np.array([value]))[0])
    elif name in unit:
        value *= unit[name]
    else:
        return value
    return float(f"{value:.{FIGURE_DIGITS}g}")


def _outside(
    agents: Sequence[Agent], local_agents: Sequence[Agent], lines: WorldLines, frame: PlanningFrame
) -> WorldLines:
    """Local `lines` of `agents`, which are `local_agents` in the frame, as the user's."""
    local, offsets, knots = lines.knots, lines.offsets, frame.curve(lines.knots)
    counts = np.diff(offsets)
    at = _places([one.start for one in local_agents], counts, local)
    knots[at, :2] = np.repeat([one.start for one in agents], counts, axis=0)[at]
    for a, (agent, own) in enumerate(zip(agents, local_agents, strict=True)):
        for point, place in zip(agent.waypoints, own.waypoints, strict=True):
            rows = slice(offsets[a], offsets[a + 1])
            at = np.abs(local[rows, :2] - place).max(axis=1) <= SAME
            knots[rows][at, :2] = point
    at = _places([one.goal for one in local_agents], counts, local)
    knots[at, :2] = np.repeat([one.goal for one in agents], counts, axis=0)[at]
    for ends, times, met in (
        (
            offsets[:-1],
            [one.start_time for one in agents],
            [one.start_time for one in local_agents],
        ),
        (offsets[1:] - 1, [one.max_time for one in agents], [one.max_time for one in local_agents]),
    ):
        at = np.abs(local[ends, 2] - met) <= SAME
        knots[ends[at], 2] = np.array(times)[at]
    for a, agent in enumerate(agents):
        if agent.path is not None:
            rows = slice(offsets[a], offsets[a + 1])
            knots[rows] = frame.curve(local[rows])
            _follow(knots[rows], local[rows, 2], np.array(agent.path), frame)
    return lines.with_knots(knots)


def _places(places: Sequence[Point], counts: IntArray, local: FloatArray) -> BoolArray:
    """(M,) which `local` knots (M, 3), so many an agent, are at the place of their agent."""
    return np.abs(local[:, :2] - np.repeat(places, counts, axis=0)).max(axis=1) <= SAME


def _follow(curve: FloatArray, times: FloatArray, path: FloatArray, frame: PlanningFrame) -> None:
    """Put a curve (n, 3), which has local `times` (n,), on its prescribed `path` (p, 3)."""
    own = frame.local_times(path[:, 2])
    nearest = np.clip(np.searchsorted(0.5 * (own[1:] + own[:-1]), times), 0, len(own) - 1)
    on_knot = np.abs(own[nearest] - times) <= SAME
    for axis in range(2):
        curve[:, axis] = np.interp(curve[:, 2], path[:, 2], path[:, axis])
    curve[on_knot] = path[nearest[on_knot]]


def _local_times(times: Sequence[float], frame: PlanningFrame) -> list[float]:
    local: list[float] = frame.local_times(np.array(times, dtype=np.float64)).tolist()
    return local


def _local_points(points: Sequence[Point], frame: PlanningFrame) -> tuple[Point, ...]:
    if not points:
        return ()
    local = frame.local_points(np.array(points, dtype=np.float64).reshape(-1, 2)).tolist()
    return tuple((x, y) for x, y in local)


def _local_places(places: Sequence[Place], frame: PlanningFrame) -> tuple[Place, ...]:
    return tuple(replace(place, points=_local_points(place.points, frame)) for place in places)


def _local_window(window: Window | None, frame: PlanningFrame) -> Window | None:
    if window is None:
        return None
    begin, end = _local_times(window, frame)
    return begin, end


def _local_agent(agent: Agent, frame: PlanningFrame) -> Agent:
    start, goal, *waypoints = _local_points((agent.start, agent.goal, *agent.waypoints), frame)
    path = agent.path
    if path is not None:
        given = np.array(path)
        places, times = frame.local_points(given[:, :2]), frame.local_times(given[:, 2])
        path = tuple(
            (float(x), float(y), float(t)) for (x, y), t in zip(places, times, strict=True)
        )
    wished = agent.preferred_time
    start_time, max_time, *preferred = _local_times(
        (agent.start_time, agent.max_time, *([] if wished is None else [wished])), frame
    )
    return replace(
        agent,
        start=start,
        goal=goal,
        start_time=start_time,
        max_time=max_time,
        preferred_time=preferred[0] if preferred else None,
        radius=share(agent.radius, frame.length),
        mass=share(agent.mass, frame.mass),
        waypoints=tuple(waypoints),
        weights=_local_weights(agent.weights, frame),
        path=path,
        max_speed=_optional(agent.max_speed, frame.speed),
        max_acceleration=_optional(agent.max_acceleration, frame.acceleration),
        visits=tuple(
            Visit(_local_window(visit.window, frame), share(visit.dwell, frame.time))
            for visit in agent.visits
        ),
        clearance=share(agent.clearance, frame.length),
        goal_places=_local_places(agent.goal_places, frame),
        start_velocity=None
        if agent.start_velocity is None
        else frame.local_velocity(agent.start_velocity),
        start_duration=share(agent.start_duration, frame.time),
    )


def _local_weights(weights: Weights, frame: PlanningFrame) -> Weights:
    return replace(
        weights,
        acceleration=share(weights.acceleration, frame.cost),
        arrival=share(weights.arrival, frame.cost / frame.time**2),
        regularity=_optional(weights.regularity, frame.cost),
    )


def _local_rule(rule: PairRule, frame: PlanningFrame) -> PairRule:
    meet = rule.meet
    if meet is not None:
        meet = Meet(share(meet.within, frame.length), _local_window(meet.window, frame))
    return replace(
        rule,
        distance=_optional(rule.distance, frame.length),
        clearance=_optional(rule.clearance, frame.length),
        grouping=_optional(rule.grouping, frame.cost / frame.length**2),
        meet=meet,
    )


def _local_solver(solver: SolverSettings, frame: PlanningFrame) -> SolverSettings:
    return replace(
        solver,
        mu=_optional(solver.mu, frame.cost),
        alpha=share(solver.alpha, 1.0 / frame.length),
        barrier_range=_optional(solver.barrier_range, frame.length),
    )


def _optional(value: float | None, unit: float) -> float | None:
    return None if value is None else share(value, unit)
