"""The prepared problem: what a scene asks, as arrays over its agents, made once and handed to every stage.

A problem that is planned (`prepare_local`) is in local units, one that is looked at in those of its scene.
Seeders, the optimiser, explanations and pictures all read the same arrays; nothing here changes while a
scene is planned. Arrays are over the A agents in scene order.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from stplan.arrays import BoolArray, FloatArray
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.memory import require_memory
from stplan.problem.arrivals import free_arrival
from stplan.problem.planning_frame import PlanningFrame
from stplan.problem.written_scene import WrittenScene
from stplan.scene.horizon import with_horizon
from stplan.scene.interactions import Interactions, Meeting, scene_interactions, scene_meetings
from stplan.scene.model import Scene
from stplan.scene.presence import present_until

if TYPE_CHECKING:
    from stplan.world.free_space import FreeSpace

# Agents that plan their motion get at least so many knots where the scene does not say how many.
LEAST_AUTO_KNOTS = 30


@dataclass(frozen=True)
class PlanningProblem:
    """What curves have to satisfy.

    Attributes:
        scene: what all of this was made from.
        free_space: the map, None in the open plane.
        written: the scene and its map as the user wrote them, and the frame that the others are in.
        agent_ids: for messages.
        starts, goals: (A, 2) in m.
        start_times, max_times: (A,) in s.
        preferred_times: (A,) when an agent would like to arrive (s), see `stplan.problem.arrivals`:
            `max_times` where no time has weight, because slow is cheap.
        radii, masses: (A,) in m and kg.
        stays: (A,) whether the agent stands on its goal until `final_time`.
        interactions: who keeps which distance from whom, and how strongly.
        meetings: who has to meet whom.
        heeds_walls: (A,).
        boundary: the walls, None in the open plane.
        waypoints: one (w, 2) array an agent.
        paths: the whole (n, 3) curve of agents whose motion is prescribed, else None.
    """

    scene: Scene
    free_space: FreeSpace | None
    written: WrittenScene
    agent_ids: tuple[str, ...]
    starts: FloatArray
    goals: FloatArray
    start_times: FloatArray
    max_times: FloatArray
    preferred_times: FloatArray
    radii: FloatArray
    masses: FloatArray
    stays: BoolArray
    interactions: Interactions
    meetings: tuple[Meeting, ...]
    heeds_walls: BoolArray
    boundary: BoundaryGrid | None
    waypoints: tuple[FloatArray, ...]
    paths: tuple[FloatArray | None, ...]

    @staticmethod
    def from_scene(
        scene: Scene, free_space: FreeSpace | None, written: WrittenScene | None = None
    ) -> PlanningProblem:
        """The problem of `scene` in `free_space` (None is the open plane), both as they are `written`."""
        agents = scene.agents
        walls = None if free_space is None else free_space.boundary_segments
        return PlanningProblem(
            scene=scene,
            free_space=free_space,
            written=WrittenScene(scene, free_space) if written is None else written,
            agent_ids=tuple(agent.id for agent in agents),
            starts=np.array([agent.start for agent in agents], dtype=np.float64),
            goals=np.array([agent.goal for agent in agents], dtype=np.float64),
            start_times=np.array([agent.start_time for agent in agents], dtype=np.float64),
            max_times=np.array([agent.max_time for agent in agents], dtype=np.float64),
            preferred_times=np.array([free_arrival(agent) for agent in agents]),
            radii=np.array([agent.radius for agent in agents], dtype=np.float64),
            masses=np.array([agent.mass for agent in agents], dtype=np.float64),
            stays=np.array([agent.after_arrival == "stay" for agent in agents], dtype=bool),
            interactions=scene_interactions(scene),
            meetings=scene_meetings(scene),
            heeds_walls=np.array([agent.weights.wall > 0 for agent in agents], dtype=bool),
            boundary=BoundaryGrid.from_segments(walls)
            if walls is not None and len(walls)
            else None,
            waypoints=tuple(
                np.array(agent.waypoints, dtype=np.float64).reshape(-1, 2) for agent in agents
            ),
            paths=tuple(
                None if agent.path is None else np.array(agent.path, dtype=np.float64)
                for agent in agents
            ),
        )

    def __getstate__(self) -> dict[str, Any]:
        """The fields alone, without squares of all pairs that the scene says."""
        state = {one.name: getattr(self, one.name) for one in fields(self)}
        if self.interactions.equals(scene_interactions(self.scene)):
            del state["interactions"]
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        if "interactions" not in state:
            state["interactions"] = scene_interactions(state["scene"])
        vars(self).update(state)

    @property
    def frame(self) -> PlanningFrame:
        """The frame of all places and times, and its units."""
        return self.written.frame

    @cached_property
    def as_written(self) -> PlanningProblem:
        """The same in the coordinates and units of the user: to be looked at, not to be planned."""
        return PlanningProblem.from_scene(self.written.scene, self.written.free_space)

    @cached_property
    def in_frame(self) -> PlanningProblem:
        """The same in the frame that suits it: where ways are measured as well far from the origin."""
        if self.frame != PlanningFrame():
            return self
        written = WrittenScene.framed(self.written.scene, self.written.free_space)
        return PlanningProblem.from_scene(written.local_scene, written.local_space, written)

    @property
    def num_agents(self) -> int:
        """Number of agents A."""
        return len(self.radii)

    @property
    def time_scale(self) -> float:
        """c of the space-time metric, m/s."""
        return self.scene.time_scale

    @cached_property
    def final_time(self) -> float:
        """Until when staying agents stand on their goals, s."""
        return self.scene.final_time

    @property
    def collides(self) -> BoolArray:
        """(A, A) pairs that keep their distance."""
        return self.interactions.collides

    @property
    def distance(self) -> FloatArray:
        """(A, A) R_ab in m."""
        return self.interactions.distance

    @cached_property
    def prescribed(self) -> BoolArray:
        """(A,) agents whose motion is prescribed."""
        return np.array([path is not None for path in self.paths], dtype=bool)

    @cached_property
    def stops(self) -> tuple[FloatArray, ...]:
        """Start, waypoints and goal (w + 2, 2) of every agent, m; (0, 2) where its motion is prescribed."""
        return tuple(
            np.empty((0, 2)) if path is not None else np.vstack([start, waypoints, goal])
            for path, start, waypoints, goal in zip(
                self.paths, self.starts, self.waypoints, self.goals, strict=True
            )
        )

    def present_until(self, arrivals: FloatArray) -> FloatArray:
        """(A,) until when every agent is there, s, given when each arrives (A,)."""
        return present_until(self.stays, arrivals, self.final_time)

    def rod(self, agent: int, curve: FloatArray) -> FloatArray:
        """The rod of `curve` in (x, y, c t), its tail included where the agent stays; m."""
        rod = curve * [1.0, 1.0, self.time_scale]
        if self.stays[agent] and curve[-1, 2] < self.final_time:
            tail = [rod[-1, 0], rod[-1, 1], self.time_scale * self.final_time]
            rod = np.vstack([rod, tail])
        return np.ascontiguousarray(rod)

    def wall_edges_heeded(self, agent: int) -> BoundaryGrid | None:
        """The walls `agent` keeps its radius from, None where there are none for it."""
        return self.boundary if self.heeds_walls[agent] else None


def prepare(scene: Scene) -> PlanningProblem:
    """The problem of `scene` as it is written: to be looked at.

    Raises:
        SceneError: the scene does not fit into memory, or its agents do not fit their map.
    """
    return PlanningProblem.from_scene(scene, _fitted(scene))


def prepare_local(scene: Scene) -> PlanningProblem:
    """The problem of `scene` in the frame that suits it: to be planned. Raises like `prepare`."""
    written = WrittenScene.framed(scene, _fitted(scene))
    return PlanningProblem.from_scene(written.local_scene, written.local_space, written)


def at_horizon(problem: PlanningProblem, horizon: float) -> PlanningProblem:
    """`problem` with another `horizon`, in the user's time."""
    written = problem.written
    local = float(written.frame.local_times(np.array([horizon]))[0])
    scene = with_horizon(problem.scene, local)
    return replace(
        problem,
        scene=scene,
        written=replace(written, scene=with_horizon(written.scene, horizon)),
        max_times=np.array([agent.max_time for agent in scene.agents], dtype=np.float64),
        preferred_times=np.array([free_arrival(agent) for agent in scene.agents]),
    )


def within(problem: PlanningProblem, horizon: float) -> PlanningProblem:
    """`problem`, to be planned within an earlier `horizon` of its frame; what is written stays."""
    agents = tuple(
        agent if agent.path is not None else replace(agent, max_time=min(agent.max_time, horizon))
        for agent in problem.scene.agents
    )
    return replace(
        problem,
        scene=replace(problem.scene, horizon=horizon, agents=agents),
        max_times=np.array([agent.max_time for agent in agents], dtype=np.float64),
    )


def _fitted(scene: Scene) -> FreeSpace | None:
    """The free space, into which the agents fit; None in the open plane."""
    planned = scene.solver.knots or LEAST_AUTO_KNOTS
    knots = sum(planned if agent.path is None else len(agent.path) for agent in scene.agents)
    require_memory(scene.name, len(scene.agents), knots)
    if scene.map is None and not any(agent.goal_places for agent in scene.agents):
        return None
    from stplan.world.placement import fitted_free_space

    return fitted_free_space(scene)
