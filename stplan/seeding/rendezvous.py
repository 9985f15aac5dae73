"""Where pairs that have to meet should do so: a place each, on ways that are cheap for both.

A place and a time are chosen for every meeting as if the two were alone: among many candidates and orders
of their other stops those of least kinetic cost along shortest ways, given the meetings before. Seeding
then passes the place like a waypoint; when is settled afterwards, and both exactly by the optimiser.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.deadline import heed
from stplan.problem.planning_problem import PlanningProblem
from stplan.scene.interactions import Meeting
from stplan.scene.model import Agent

# Candidates in the open: so many along every way, and so many from one way to the other.
ALONG = 25
ACROSS = 9
# Common times tried, and directions in which the second agent stands beside the first.
TIMES = 40
DIRECTIONS = 16
# Two that collide stand so many times their distance apart, if the meeting leaves that much.
BESIDE = 1.25
# Places keep so many radii from the walls.
ROOM = 1.1
# Ways take so many times as long as limits of motion allow: the first of these that leaves a choice.
SPARES = (1.1, 1.0, 0.0)

# Lengths of shortest ways (P, C) from points (P, 2) to the candidates, for an agent.
Distances = Callable[[int, FloatArray], FloatArray]


class Rendezvous(NamedTuple):
    """Where two agents are to meet: (2,) a place for each, m, and about when, s."""

    agents: tuple[int, int]
    places: tuple[FloatArray, FloatArray]
    time: float


@dataclass
class _Itinerary:
    """Stops of an agent in order (S, 2), and when it has to be there, s (nan: any time)."""

    stops: FloatArray
    times: FloatArray


def with_rendezvous(
    problem: PlanningProblem,
) -> tuple[PlanningProblem, tuple[Rendezvous, ...]]:
    """`problem` with a further waypoint for each agent of a meeting that finds its own way, and where.

    Meetings for which there is no good place are left out.
    """
    if not problem.meetings:
        return problem, ()
    itineraries = []
    for agent in range(problem.num_agents):
        stops = np.vstack([problem.starts[agent], problem.waypoints[agent], problem.goals[agent]])
        times = np.full(len(stops), np.nan)
        times[[0, -1]] = problem.start_times[agent], problem.max_times[agent]
        itineraries.append(_Itinerary(stops, times))
    found = []
    for meeting in problem.meetings:
        heed()
        place = _place(problem, meeting, itineraries)
        if place is not None:
            found.append(place)
    waypoints = tuple(itinerary.stops[1:-1] for itinerary in itineraries)
    return replace(problem, waypoints=waypoints), tuple(found)


def _place(
    problem: PlanningProblem,
    meeting: Meeting,
    itineraries: list[_Itinerary],
) -> Rendezvous | None:
    """A place, which becomes a stop of those who have to go there; None where there is no good one."""
    # One whose motion is prescribed comes first: the other one stands beside it.
    pair = (meeting.first, meeting.second)
    a, b = pair if problem.paths[pair[1]] is None else pair[::-1]
    if problem.paths[b] is not None:
        return None
    window = meeting.meet.window or (-np.inf, np.inf)
    low = max(problem.start_times[a], problem.start_times[b], window[0])
    high = min(problem.max_times[a], problem.max_times[b], window[1])
    if low >= high:
        return None
    times = np.linspace(low, high, TIMES + 2)[1:-1]
    path = problem.paths[a]
    positions = None if path is None else _at(path, times)
    movers = [b] if path is not None else [a, b]
    stops = {agent: itineraries[agent].stops for agent in movers}
    candidates, distances = _candidates(problem, stops, positions)
    for spare in SPARES:
        by_leg = {
            agent: _costs(problem, agent, itineraries[agent], distances, times, spare)
            for agent in movers
        }
        total = np.sum([cost.min(axis=0) for cost in by_leg.values()], axis=0)
        if positions is not None:
            # It is at a candidate at that candidate's time only.
            total = np.where(np.eye(len(times), dtype=bool), total, np.inf)
        if np.isfinite(total).any():
            break
    if not len(candidates) or not np.isfinite(total).any():
        return None
    c, k = np.unravel_index(int(total.argmin()), total.shape)
    legs = {agent: int(cost[:, c, k].argmin()) for agent, cost in by_leg.items()}
    ends = stops[b][legs[b] : legs[b] + 2]
    beside = _beside(problem, (a, b), meeting.meet.within, candidates[c], ends)
    if beside is None:
        return None
    places = {a: candidates[c], b: beside}
    for agent in movers:
        own, at = itineraries[agent], legs[agent] + 1
        own.stops = np.insert(own.stops, at, places[agent], axis=0)
        own.times = np.insert(own.times, at, times[k])
    return Rendezvous(pair, (places[pair[0]], places[pair[1]]), float(times[k]))


def _at(curve: FloatArray, times: FloatArray) -> FloatArray:
    """(T, 2) positions on a curve at `times` (s)."""
    return np.column_stack([np.interp(times, curve[:, 2], curve[:, x]) for x in range(2)])


def _candidates(
    problem: PlanningProblem,
    stops: dict[int, FloatArray],
    positions: FloatArray | None,
) -> tuple[FloatArray, Distances]:
    """(C, 2) places for agents with `stops` (those in `positions` where given), and ways to them."""
    movers = list(stops)
    free_space = problem.free_space
    if free_space is None or not problem.heeds_walls[movers].any():
        if positions is not None:
            candidates = positions
        else:
            ways = [_spread(own, ALONG) for own in stops.values()]
            share = np.linspace(0.0, 1.0, ACROSS)[:, None, None]
            candidates = ((1.0 - share) * ways[0] + share * ways[1]).reshape(-1, 2)

        def straight(agent: int, points: FloatArray) -> FloatArray:
            del agent
            step = points[:, None] - candidates[None]
            return np.hypot(step[:, :, 0], step[:, :, 1])

        return candidates, straight
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    from stplan.seeding.search.roadmap import build_roadmap

    radii = problem.radii[movers]
    graph = build_roadmap(free_space, np.vstack(list(stops.values())), radii).graph
    if positions is not None:
        candidates, vertices = positions, _nearest(graph.vertices, positions)
    else:
        room = free_space.clearance(graph.vertices) > ROOM * float(radii.max())
        candidates, vertices = graph.vertices[room], np.flatnonzero(room)

    def along_walls(agent: int, points: FloatArray) -> FloatArray:
        free = graph.free_moves(float(problem.radii[agent]))[graph.num_vertices :]
        moves = graph.num_vertices + np.flatnonzero(free)
        edges = (graph.move_from[moves], graph.move_to[moves])
        shape = (graph.num_vertices, graph.num_vertices)
        lengths = csr_array((graph.length[moves], edges), shape=shape)
        return dijkstra(lengths, indices=_nearest(graph.vertices, points))[:, vertices]

    return candidates, along_walls


def _nearest(vertices: FloatArray, points: FloatArray) -> IntArray:
    """(P,) the vertex nearest to each point."""
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(vertices).query(points)[1], dtype=np.int64)


def _spread(stops: FloatArray, count: int) -> FloatArray:
    """`count` points evenly along a polyline."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(stops, axis=0).T))])
    at = np.linspace(0.0, along[-1], count)
    return np.column_stack([np.interp(at, along, stops[:, x]) for x in range(2)])


def _costs(
    problem: PlanningProblem,
    agent: int,
    own: _Itinerary,
    distances: Distances,
    times: FloatArray,
    spare: float,
) -> FloatArray:
    """(legs, C, T) least kinetic cost of passing a candidate on a leg at a time.

    Infinite where that is out of the order of its times, or its ways there and on, taken `spare` times as
    long as they are, ask for more than its limits of motion.
    """
    to_stop = distances(agent, own.stops)
    steps = np.hypot(*np.diff(own.stops, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    timed = np.flatnonzero(np.isfinite(own.times))
    mass = 0.5 * float(problem.masses[agent])
    moving = problem.scene.agents[agent]
    costs = []
    for leg in range(len(own.stops) - 1):
        before, after = timed[timed <= leg].max(), timed[timed > leg].min()
        first = along[leg] - along[before] + to_stop[leg]
        second = to_stop[leg + 1] + along[after] - along[leg + 1]
        early, late = times - own.times[before], own.times[after] - times
        possible = (early > 0) & (late > 0)
        possible = possible & (early >= spare * _least(moving, first))
        possible = possible & (late >= spare * _least(moving, second))
        early, late = np.where(possible, early, 1.0), np.where(possible, late, 1.0)
        # What the piece costs without the detour counts in every choice, so only the rest compares.
        least = (along[after] - along[before]) ** 2 / (own.times[after] - own.times[before])
        cost = first[:, None] ** 2 / early + second[:, None] ** 2 / late - least
        costs.append(np.where(possible, mass * cost, np.inf))
    return np.array(costs)


def _least(agent: Agent, lengths: FloatArray) -> FloatArray:
    """(C, 1) how long ways of `lengths` (C,) take at least, s: one end may be passed at full speed."""
    least = 0.0 * lengths
    if agent.max_speed is not None:
        least = lengths / agent.max_speed
    if agent.max_acceleration is not None:
        least = np.maximum(least, np.sqrt(2.0 * lengths / agent.max_acceleration))
    return np.asarray(least)[:, None]


def _beside(
    problem: PlanningProblem,
    pair: tuple[int, int],
    within: float,
    place: FloatArray,
    ends: FloatArray,
) -> FloatArray | None:
    """Where the second agent stands when the first is at `place`, None where there is no room.

    `ends` (2, 2) are the stops between which it comes there.
    """
    a, b = pair
    if not problem.collides[a, b]:
        return place
    least = float(problem.distance[a, b])
    apart = min(BESIDE * least, 0.5 * (least + within))
    angle = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    places = place + apart * np.column_stack([np.cos(angle), np.sin(angle)])
    detour = np.hypot(*(places - ends[0]).T) + np.hypot(*(places - ends[1]).T)
    free_space = problem.free_space
    if free_space is not None and problem.heeds_walls[b]:
        ahead = np.broadcast_to(place, places.shape)
        room = free_space.clearance(places) > ROOM * float(problem.radii[b])
        detour[~(room & (free_space.segment_clearance(ahead, places) > 0))] = np.inf
    best = int(detour.argmin())
    return places[best] if np.isfinite(detour[best]) else None
