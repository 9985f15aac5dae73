"""The plan from a change on: those whom it concerns, and those in their way, are planned anew.

They are planned among the rods of all others. Where that leads nowhere, those whom their own ways alone would
touch join them, in the end everybody. Then all are optimised, from the rest of what they had planned.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from stplan import planner
from stplan.arrays import FloatArray
from stplan.callbacks import Progress, Stop, never, unheard
from stplan.errors import SceneError, SeedingError
from stplan.multistart import best_seeds
from stplan.optimize.continuation import Optimisation, optimise
from stplan.optimize.restoration import restore
from stplan.problem.clearance import rod_clearances, wall_clearance
from stplan.problem.continuation import continued_scene, curves_of
from stplan.problem.launches import Launches
from stplan.problem.metric import sharpened
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.restriction import restricted
from stplan.problem.verification import Fault, verify
from stplan.problem.world_lines import WorldLines
from stplan.replanning.easing import easing_of
from stplan.replanning.pacing import even_pace, paced_curves
from stplan.scene.model import Scene, WorldChange
from stplan.seeding.elastic_bands.geodesics import geodesic_curves
from stplan.seeding.infeasibility import hopeless
from stplan.seeding.search.shortest_ways import WayFinder

# Mended plans are optimised so many outer iterations before the end.
FROM_END = 2
# Agents join those who keep their ways so often.
ROUNDS = 4
# Where that leads nowhere, search takes these shares of the time limit: for some agents, and for everybody.
SEARCH, SEARCH_FOR_ALL = 1 / 15, 1 / 6
# Knots of the same place and time up to rounding, m and s.
SAME = 1e-9

Curves = dict[str, FloatArray]


@dataclass(frozen=True)
class Mended:
    """A plan from a change on.

    Attributes:
        scene: of those who go on, as the user's.
        curves: theirs, as the user's, by id.
        seed: what the optimisation began with.
        replanned: ids of those who were planned anew.
    """

    scene: Scene
    curves: Curves
    seed: Curves
    replanned: tuple[str, ...]
    optimisation: Optimisation


def mend(
    planned: Scene,
    earlier: Scene,
    history: Mapping[str, FloatArray],
    change: WorldChange,
    *,
    progress: Progress | None = None,
    stop: Stop | None = None,
) -> Mended:
    """The plan from `change` on, given the whole curves so far.

    Args:
        planned: the scene as it was planned first, with its metric.
        earlier: the world before the change.

    Raises:
        SeedingError: there is none.
    """
    progress, stop = progress or unheard, stop or never
    scene = continued_scene(earlier, history, change)
    if planned.metric == "chosen":
        scene = replace(
            scene, time_scale=planned.time_scale, metric="chosen", turning=planned.turning
        )
    easing = easing_of(scene, [name for name, _ in change.delays])
    try:
        problem = planner.prepare(scene if easing is None else easing.scene)
    except SceneError as error:
        raise SeedingError(f"there is no way to go on after {change.at:g} s: {error}") from error
    work = _Mending(problem, earlier, history, change, () if easing is None else easing.pieces)
    lines = work.clear_lines(progress)
    lines = restore(problem, lines, progress=progress, stop=stop)
    sharp = sharpened(problem, lines)
    begin = max(scene.solver.outer_iterations - FROM_END, 0)
    optimised = optimise(sharp, lines, progress=progress, stop=stop, begin=begin)
    written = sharp.written
    seed, curves = (
        work.on_their_knots(curves_of(written.outside(one)))
        for one in (lines, optimised.world_lines)
    )
    if easing is not None:
        seed, curves = easing.joined(seed), easing.joined(curves)
    return Mended(written.scene, curves, seed, work.replanned, optimised)


class _Mending:
    """Clear curves for the agents of a `problem` that go on from a change."""

    def __init__(
        self,
        problem: PlanningProblem,
        earlier: Scene,
        history: Mapping[str, FloatArray],
        change: WorldChange,
        eased: Collection[str],
    ) -> None:
        self._problem, self._history, self._change = problem, history, change
        before = {agent.id: agent for agent in earlier.agents}
        after = {agent.id: agent for agent in change.scene.agents}
        delayed = {name for name, _ in change.delays}
        self._concerned = {
            a
            for a, name in enumerate(problem.agent_ids)
            if before.get(name) != after.get(name)
            or name in delayed
            or name in eased
            or name not in history
        } - set(np.flatnonzero(problem.prescribed).tolist())
        self._planning = set(np.flatnonzero(~problem.prescribed).tolist())
        fixed = {a for a, name in enumerate(problem.agent_ids) if name in delayed}
        self._launches = Launches.of(problem, fixed)
        self._rest = problem if self._launches is None else self._launches.problem
        self._moved: set[int] = set()

    @property
    def replanned(self) -> tuple[str, ...]:
        """Ids of those who were planned anew."""
        return tuple(self._problem.agent_ids[a] for a in sorted(self._moved))

    def clear_lines(self, progress: Progress) -> WorldLines:
        """Curves that touch nothing, those of whom nothing stands in the way as they were."""
        curves = self._kept_curves()
        group = self._with_blocked(curves)
        if group:
            progress(f"planning {len(group)} of {self._problem.num_agents} agents anew")
            found = self._on_their_ways(group, curves) or self._searched(group, curves, progress)
            self._moved = set(found)
            curves |= found
        whole = [curves[a] for a in range(self._rest.num_agents)]
        if self._launches is not None:
            whole = self._launches.joined(whole)
        return WorldLines.from_curves(self._problem.agent_ids, whole)

    def on_their_knots(self, curves: Curves) -> Curves:
        """Curves as the user's, whose first segments end on the knots they did before to the last bit."""
        for name, curve in curves.items():
            if name not in self._history:
                continue
            old = self._history[name]
            later = old[old[:, 2] > self._change.at]
            if len(later) and np.abs(later[0] - curve[1]).max() <= SAME:
                curve[1] = later[0]
        return curves

    def _kept_curves(self) -> dict[int, FloatArray]:
        """What is left of everybody's curve in the frame, where it is not concerned; launches too."""
        curves: dict[int, FloatArray] = {}
        for a in range(self._problem.num_agents):
            path = self._problem.paths[a]
            if path is not None:
                curves[a] = path
            elif a not in self._concerned:
                curves[a] = self._kept_curve(a)
        for number in range(self._problem.num_agents, self._rest.num_agents):
            path = self._rest.paths[number]
            if path is not None:
                curves[number] = path
        return curves

    def _kept_curve(self, agent: int) -> FloatArray:
        """What is left of a curve, from where its launch ends; who arrived stands."""
        rest, frame, at = self._rest, self._problem.frame, self._change.at
        start = np.append(rest.starts[agent], rest.start_times[agent])
        old = self._history[self._problem.agent_ids[agent]]
        later = old[old[:, 2] > at]
        if not len(later):
            return np.vstack([start, np.append(rest.goals[agent], rest.max_times[agent])])
        begun = bool(old[0, 2] < at)
        kept = later if begun else old
        local = np.column_stack([frame.local_points(kept[:, :2]), frame.local_times(kept[:, 2])])
        if begun:
            local = np.vstack([start, local[local[:, 2] > start[2] + SAME]])
        local[0] = start
        if not self._problem.scene.agents[agent].goal_places:
            local[-1, :2] = rest.goals[agent]
        local[-1, 2] = min(local[-1, 2], rest.max_times[agent])
        return local

    def _with_blocked(self, curves: dict[int, FloatArray]) -> set[int]:
        """The agents concerned, and those whose curves touch something by now."""
        group = set(self._concerned)
        rest = self._rest
        for a in range(self._problem.num_agents):
            if a in curves and not self._problem.prescribed[a]:
                gap = wall_clearance(rest, a, curves[a])
                if gap <= rest.radii[a]:
                    group.add(a)
        return group.union(*(pair & self._planning for pair in self._touching(curves)))

    def _on_their_ways(
        self, group: set[int], curves: Mapping[int, FloatArray]
    ) -> dict[int, FloatArray] | None:
        """Curves of a `group` along the ways it had, or the shortest ones; None where there are none.

        Those in whose way it would be at an even pace join it, a few times.
        """
        ways: dict[int, FloatArray] = {}
        for _ in range(ROUNDS):
            for a in group - ways.keys():
                way = self._way(a, curves.get(a))
                if way is None or self._rest.scene.agents[a].visits:
                    return None
                ways[a] = way
            part = self._among(group, curves)
            found = paced_curves(part, sorted(group), curves, ways)
            if found is not None and not self._faults({**curves, **found}):
                return found
            trial = {a: even_pace(self._rest, a, ways[a]) for a in group}
            wider = group | self._touched(dict(curves) | trial, group)
            if wider == group:
                return None
            group = wider
        return None

    def _searched(
        self, group: set[int], curves: Mapping[int, FloatArray], progress: Progress
    ) -> dict[int, FloatArray]:
        """Curves of a `group` that leave the ways it had, of more agents where there are none.

        Raises:
            SeedingError: there are none for everybody.
        """
        reasons = hopeless(self._problem)
        if reasons:
            raise SeedingError(reasons)
        groups = (group, self._wider(group, curves), self._planning)
        for part in dict.fromkeys(map(frozenset, groups)):
            progress(f"searching for {len(part)} of {self._problem.num_agents} agents")
            try:
                return self._found(part, curves)
            except SeedingError as error:
                last = error
        raise last

    def _found(
        self, group: Collection[int], curves: Mapping[int, FloatArray]
    ) -> dict[int, FloatArray]:
        """Curves of a `group` that search finds among those of all others. Raises likewise."""
        everybody = len(group) == len(self._planning)
        part = _hurried(self._among(group, curves), everybody=everybody)
        every = list(best_seeds(part, progress=unheard).seeds[0].world_lines.curves())
        found = {a: every[a] for a in group}
        faults = self._faults({**curves, **found})
        if faults:
            raise SeedingError("; ".join(map(str, faults)))
        return found

    def _among(self, group: Collection[int], curves: Mapping[int, FloatArray]) -> PlanningProblem:
        """The problem in which a `group` plans among the curves of all others."""
        return _among(self._rest, {a: curve for a, curve in curves.items() if a not in group})

    def _faults(self, curves: Mapping[int, FloatArray]) -> list[Fault]:
        return verify(self._rest, [curves[a] for a in range(self._rest.num_agents)])

    def _way(self, agent: int, curve: FloatArray | None) -> FloatArray | None:
        """The way (n, 2) an agent had, where it still leads to its goal, or else the shortest."""
        rest = self._rest
        name = self._problem.agent_ids[agent]
        start, goal = rest.starts[agent], rest.goals[agent]
        way = None if curve is None else curve[:, :2]
        if way is None and name in self._history:
            old = self._history[name]
            later = self._problem.frame.local_points(old[old[:, 2] > self._change.at, :2])
            if len(later) and np.abs(later[-1] - goal).max() <= SAME:
                way = np.vstack([start, later[:-1], goal])
        radius = float(rest.radii[agent])
        if way is not None and wall_clearance(rest, agent, way) > radius:
            return way
        space = rest.free_space
        if space is None or not rest.heeds_walls[agent]:
            return rest.stops[agent]
        found = WayFinder(space).way(rest.stops[agent], radius)
        return None if found is None else found.points

    def _wider(self, group: set[int], curves: Mapping[int, FloatArray]) -> set[int]:
        """The group, and those whom its own ways alone would touch; everybody where these are known."""
        rest = self._rest
        ways = geodesic_curves(rest)
        trial = dict(curves)
        for a in group:
            way = ways[a]
            if way is not None:
                trial[a] = way
        wider = group | self._touched(trial, group)
        return wider if wider > group else self._planning

    def _touched(self, curves: Mapping[int, FloatArray], group: set[int]) -> set[int]:
        """Those who plan, and whose curves touch one of a `group`, or are touched."""
        touching = self._touching(curves)
        return {a for pair in touching if pair & group for a in pair & self._planning}

    def _touching(self, curves: Mapping[int, FloatArray]) -> list[set[int]]:
        """Pairs whose curves touch."""
        known = sorted(curves)
        part = restricted(self._rest, np.array(known))
        pairs = rod_clearances(part, [curves[a] for a in known]).violations
        return [{known[one], known[other]} for one, other, _ in pairs]


def _hurried(problem: PlanningProblem, *, everybody: bool) -> PlanningProblem:
    """`problem` with less time to search: a plan is wanted before the world has gone on."""
    seeding = problem.scene.seeding
    share = SEARCH_FOR_ALL if everybody else SEARCH
    seeding = replace(seeding, time_limit=share * seeding.time_limit)
    return replace(problem, scene=replace(problem.scene, seeding=seeding))


def _among(problem: PlanningProblem, curves: Mapping[int, FloatArray]) -> PlanningProblem:
    """`problem`, in which some agents move along `curves`, and the others start anyhow: a quick search."""
    agents = []
    goals, max_times = problem.goals.copy(), problem.max_times.copy()
    for a, agent in enumerate(problem.scene.agents):
        own = replace(agent, start_velocity=None, start_duration=0.0)
        if a in curves:
            curve = curves[a]
            goals[a], max_times[a] = curve[-1, :2], curve[-1, 2]
            x, y, t = curve[-1].tolist()
            own = replace(
                own, path=tuple(map(tuple, curve.tolist())), goal=(x, y), max_time=t, goal_places=(),
                waypoints=(), visits=(), max_speed=None, max_acceleration=None,
            )  # fmt: skip
        agents.append(own)
    solver = replace(problem.scene.solver, effort="quick")
    # Those who cannot give way may graze each other.
    fixed = np.array([a in curves for a in range(problem.num_agents)])
    collides = problem.collides & ~(fixed[:, None] & fixed[None, :])
    return replace(
        problem,
        scene=replace(problem.scene, agents=tuple(agents), solver=solver),
        goals=goals,
        max_times=max_times,
        interactions=replace(problem.interactions, collides=collides),
        waypoints=tuple(
            np.empty((0, 2)) if a in curves else points
            for a, points in enumerate(problem.waypoints)
        ),
        paths=tuple(curves.get(a, path) for a, path in enumerate(problem.paths)),
    )
