"""Who ends where: spots in the places that agents end in, and points that are to be assigned.

Ways are measured on a roadmap of the map, so that nobody is sent through a wall. Where an agent

- stays, it gets a spot of its own (linear assignment, the cheapest kinetic energy on these ways), and moves
  straight on towards where it comes from as far as its place reaches, where nobody else ends in that;
- vanishes, it gets the spot it could leave by first: spots along an exit serve one after another, so that a
  crowd spreads over exits, and over the width of each, as queues at them grow;
- is one of a crowd whose points are assigned, it gets one of these (linear assignment of least length, and
  among assignments as good as that one of even lengths).

These spots are where seeding leads. The optimisation moves the ends of vanishing agents on, wherever in their
place they are cheapest.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from stplan.amounts import amount
from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.errors import SceneError
from stplan.problem.planning_problem import PlanningProblem
from stplan.scene.interactions import PairSettings
from stplan.scene.model import Scene
from stplan.scene.places import Place

if TYPE_CHECKING:
    import shapely

    from stplan.world.places import StandingRoom

# Spots keep so many times the radius from walls, where a place has such.
OFF_WALLS = (1.05, 1.01, 1.0 + 1e-6)
# Spots of staying agents are so many times as far apart as they have to be; the first that leaves enough.
# From twice on others pass between any two of them.
APART = (2.1, 1.6, 1.3, 1.1, 1.05, 1.01)
# A spot is moved nearer by the largest of these shares of the way that is free.
SHARES = np.linspace(1.0, 0.1, 10)
# Points are in a room up to this share of a radius.
ROUNDING = 1e-9
# Spots along an exit.
ABREAST = 1.1
# Spots of an area are at most so many for every agent that ends there, and so many more.
SPOTS_AN_AGENT, MORE_SPOTS = 8, 60
# Where lengths of assignments differ by less than this share, even lengths are better than uneven ones.
EVENNESS = 5e-3
# Without a greatest speed, agents are taken to leave in this share of their time.
SHARE_OF_TIME = 0.5
# More than any way is long, m.
FAR = 1e12


def settle_goals(problem: PlanningProblem) -> PlanningProblem:
    """The problem with a goal for everybody: a spot of its places, or one of the points to be assigned.

    Raises:
        SceneError: a place has too little room for those who stay in it.
    """
    scene = problem.scene
    ending = [a for a, agent in enumerate(scene.agents) if agent.goal_places]
    if not ending and not scene.assignments:
        return problem
    goals = {a: agent.goal for a, agent in enumerate(scene.agents)}
    for assignment in scene.assignments:
        members, points = list(assignment.members), np.array(assignment.points)
        for a, k in zip(members, _least_length(_lengths(problem, members, points)), strict=True):
            goals[a] = assignment.points[k]
    staying = [a for a in ending if problem.stays[a]]
    if staying:
        taken = [a for a in range(problem.num_agents) if problem.stays[a] and a not in staying]
        goals |= _settle_staying(problem, staying, np.array([goals[a] for a in taken]), taken)
    leaving = [a for a in ending if not problem.stays[a]]
    if leaving:
        goals |= _settle_leaving(problem, leaving)
    return with_goals(problem, goals)


def least_assignment(scene: Scene) -> float:
    """The least sum of straight lengths from starts to the points to be assigned, of all crowds, m."""
    total = 0.0
    for assignment in scene.assignments:
        starts = np.array([scene.agents[a].start for a in assignment.members])
        step = starts[:, None] - np.array(assignment.points)[None]
        lengths = np.hypot(*step.transpose(2, 0, 1))
        total += float(lengths[linear_sum_assignment(lengths)].sum())
    return total


def with_goals(problem: PlanningProblem, goals: dict[int, tuple[float, float]]) -> PlanningProblem:
    """The problem with other goals of some agents."""
    agents = tuple(
        replace(agent, goal=goals.get(a, agent.goal))
        for a, agent in enumerate(problem.scene.agents)
    )
    scene = replace(problem.scene, agents=agents)
    written = problem.written.with_local_goals(goals)
    return PlanningProblem.from_scene(scene, problem.free_space, written)


def _least_length(lengths: FloatArray) -> IntArray:
    """Which point everybody gets: (N,) of (N, P) lengths, m.

    The sum exceeds the least one by no more than the share `EVENNESS`: every length weighs between 1 and
    1 + that.
    """
    even = lengths * (1.0 + EVENNESS * lengths / max(float(lengths.max()), 1e-12))
    return np.asarray(linear_sum_assignment(even)[1], dtype=np.int64)


def _settle_staying(
    problem: PlanningProblem, members: list[int], taken: FloatArray, owners: list[int]
) -> dict[int, tuple[float, float]]:
    """Spots for those who stay, apart from each other and from the goals `taken` (T, 2) by `owners`."""
    halves = PairSettings(problem.scene).half_distances()
    widest = 2.0 * float(halves[members].max())
    for apart in APART:
        points, allowed = _spots(problem, members, apart * widest)
        if len(owners):
            gaps = np.hypot(*(points[:, None] - taken[None]).transpose(2, 0, 1))
            free = (gaps > APART[-1] * (0.5 * widest + halves[owners])).all(axis=1)
            points, allowed = points[free], allowed[:, free]
        if len(points) < len(members):
            continue
        lengths = np.where(allowed, _lengths(problem, members, points), FAR)
        spans = (problem.max_times - problem.start_times)[members]
        energy = problem.masses[members, None] * np.minimum(lengths, FAR) ** 2 / spans[:, None]
        energy[lengths >= FAR] = FAR**2
        rows, columns = linear_sum_assignment(energy)
        if (lengths[rows, columns] < FAR).all():
            others = [(taken[k], float(halves[owners[k]])) for k in range(len(owners))]
            ends = _nearer(problem, members, points[columns], halves, others)
            return {a: _point(end) for a, end in zip(members, ends, strict=True)}
    raise _full(problem.written.scene, members, allowed)


def _nearer(
    problem: PlanningProblem,
    members: list[int],
    ends: FloatArray,
    halves: FloatArray,
    others: Sequence[tuple[FloatArray, float]],
) -> FloatArray:
    """`ends` (N, 2), those of agents who are alone in their places nearer to where these come from.

    Args:
        halves: (A,) half of how far everybody keeps others off, m.
        others: who else stays somewhere, and half of how far it keeps others off, m.
    """
    from shapely import distance, points, shortest_line

    from stplan.world.places import StandingRoom

    rooms, agents = StandingRoom(problem.free_space), problem.scene.agents
    enders = Counter(place for agent in agents for place in agent.goal_places)
    ends = ends.copy()
    for k, a in enumerate(members):
        places = agents[a].goal_places
        if any(enders[place] > 1 for place in places):
            continue
        radius = agents[a].radius if problem.heeds_walls[a] else 0.0
        own = [room for place in places if not (room := _room(rooms, place, radius)).is_empty]
        room = min(own, key=lambda one: float(distance(one, points(ends[k]))))
        origin = np.array(problem.stops[a][-2])
        nearest = np.array(shortest_line(room, points(origin)).coords[0])
        tried = ends[k] + SHARES[:, None] * (nearest - ends[k])
        free = distance(room, points(tried)) <= ROUNDING * agents[a].radius
        free &= np.hypot(*(tried - origin).T) < np.hypot(*(ends[k] - origin))
        if radius > 0.0:
            free &= _sees(problem, origin[None], tried, radius)[0]
        beside = [(ends[j], float(halves[b])) for j, b in enumerate(members) if b != a]
        for end, half in (*beside, *others):
            free &= np.hypot(*(tried - end).T) > APART[-1] * (half + halves[a])
        if free.any():
            ends[k] = tried[int(free.argmax())]
    return ends


def _full(scene: Scene, members: Sequence[int], allowed: BoolArray) -> SceneError:
    """No spots were found for all of `members` (N,) who stay, of spots on which they are `allowed` (N, P)."""
    groups: dict[tuple[Place, ...], list[int]] = {}
    for k, a in enumerate(members):
        groups.setdefault(scene.agents[a].goal_places, []).append(k)
    own = list(range(len(members)))
    for some in groups.values():
        if np.count_nonzero(allowed[some].any(axis=0)) < len(some):
            own = some
            break
    agents = [scene.agents[members[k]] for k in own]
    places = dict.fromkeys(str(place) for agent in agents for place in agent.goal_places)
    verb = "has" if len(places) == 1 else "have"
    text = (
        f"{' and '.join(places)} {verb} no room for all of {len(own)} agents of "
        f"{amount(agents[0].radius)} m who stay"
    )
    return SceneError(scene.located(f"{scene.entry_path(members[own[0]])}.goal", text))


def _settle_leaving(problem: PlanningProblem, members: list[int]) -> dict[int, tuple[float, float]]:
    """Spots for those who vanish: everybody takes, nearest first, the one it could leave by first."""
    halves = PairSettings(problem.scene).half_distances()
    widest = 2.0 * float(halves[members].max())
    points, allowed = _spots(problem, members, ABREAST * widest)
    lengths = np.where(allowed, _lengths(problem, members, points), FAR)
    nearest = lengths.min(axis=1)
    spans = (problem.max_times - problem.start_times)[members]
    leisurely = np.where(nearest < FAR, nearest, 0.0) / (SHARE_OF_TIME * spans)
    limits = [problem.scene.agents[a].max_speed for a in members]
    speeds = np.array([float(leisurely.max()) if limit is None else limit for limit in limits])
    speeds = np.maximum(speeds, 1e-9)
    ready = problem.start_times[members, None] + lengths / speeds[:, None]
    headways = 2.0 * halves[members] * np.sqrt(1.0 / speeds**2 + 1.0 / problem.time_scale**2)
    free = np.full(len(points), -np.inf)
    chosen: dict[int, tuple[float, float]] = {}
    for k in np.argsort(ready.min(axis=1), kind="stable").tolist():
        # Of spots where it would leave at one time the nearest.
        leave = np.maximum(ready[k], free)
        best = int(np.lexsort((lengths[k], leave))[0])
        free[best] = leave[best] + headways[k]
        chosen[members[k]] = _point(points[best])
    return chosen


def _spots(
    problem: PlanningProblem, members: list[int], spacing: float
) -> tuple[FloatArray, BoolArray]:
    """Points (P, 2) at least `spacing` (m) apart in each place, and (N, P) who may end on which."""
    from stplan.world.places import StandingRoom, spots

    rooms = StandingRoom(problem.free_space)
    agents = problem.scene.agents
    radius_of = {a: agents[a].radius if problem.heeds_walls[a] else 0.0 for a in members}
    enders: dict[Place, list[int]] = {}
    for a in members:
        for place in agents[a].goal_places:
            enders.setdefault(place, []).append(a)
    points, allowed = [np.empty((0, 2))], [np.empty((len(members), 0), dtype=bool)]
    for place, own in enders.items():
        # One set of spots for all radii that end there: the widest has to fit.
        radius = max(radius_of[a] for a in own)
        room = _room(rooms, place, radius)
        if room.is_empty:
            continue
        wide = np.sqrt(room.area / (SPOTS_AN_AGENT * len(own) + MORE_SPOTS))
        found = spots(room, max(spacing, float(wide)), 0.05 * radius)
        points.append(found)
        may = np.isin(members, own)
        allowed.append(np.repeat(may[:, None], len(found), axis=1))
    return np.vstack(points), np.hstack(allowed)


def _room(rooms: StandingRoom, place: Place, radius: float) -> shapely.Geometry:
    """Where in a place discs of a radius may stand, as far off walls as any of `OFF_WALLS` leaves."""
    found = rooms.within(place, OFF_WALLS[0] * radius)
    for off in OFF_WALLS[1:]:
        found = rooms.within(place, off * radius) if found.is_empty else found
    return found


def _lengths(problem: PlanningProblem, members: list[int], points: FloatArray) -> FloatArray:
    """(N, P) lengths of ways of `members` to `points` (P, 2), from their last waypoints on, m.

    `FAR` where there is none. Straight where walls leave the straight way clear, else along a roadmap.
    """
    from stplan.seeding.search.roadmap import build_roadmap

    origins = np.array([problem.stops[a][-2] for a in members])
    straight = np.hypot(*(origins[:, None] - points[None]).transpose(2, 0, 1))
    heeds = problem.heeds_walls[members]
    if problem.free_space is None or not heeds.any():
        return straight
    radii = problem.radii[members]
    roadmap = build_roadmap(problem.free_space, np.vstack([origins, points]), radii[heeds])
    graph, places = roadmap.graph, roadmap.place_of
    starts, ends = places[: len(members)], places[len(members) :]
    result = straight.copy()
    for radius in np.unique(radii[heeds]):
        own = np.flatnonzero(heeds & (radii == radius))
        free = graph.free_moves(float(radius))[graph.num_vertices :]
        moves = graph.num_vertices + np.flatnonzero(free)
        shape = (graph.num_vertices, graph.num_vertices)
        lengths = csr_array(
            (graph.length[moves], (graph.move_from[moves], graph.move_to[moves])), shape=shape
        )
        reached = dijkstra(lengths, indices=ends)[:, starts[own]].T
        clear = _sees(problem, origins[own], points, float(radius))
        result[own] = np.where(clear, straight[own], np.where(np.isfinite(reached), reached, FAR))
    return result


def _sees(
    problem: PlanningProblem, origins: FloatArray, points: FloatArray, radius: float
) -> BoolArray:
    """(N, P) whether a disc can go straight from origins (N, 2) to points (P, 2)."""
    if problem.free_space is None:
        return np.ones((len(origins), len(points)), dtype=bool)
    heads = np.repeat(origins, len(points), axis=0)
    tails = np.tile(points, (len(origins), 1))
    room = problem.free_space.segment_clearance(heads, tails)
    return np.asarray(room > radius).reshape(len(origins), len(points))


def _point(values: FloatArray) -> tuple[float, float]:
    return float(values[0]), float(values[1])
