"""One agent of a file: its own keys over `defaults` over what the format promises."""

from __future__ import annotations

import math
from typing import Any

from stplan.amounts import distinct
from stplan.amounts import place as in_full
from stplan.arrays import Point
from stplan.scene.format.agents import AgentFile, SharedFields, WaypointFile
from stplan.scene.format.moving_goals import MovingGoalFile
from stplan.scene.format.places import GoalPlaceFile, StartPlaceFile
from stplan.scene.model import Agent, Visit, Weights
from stplan.scene.moving_goals import MovingGoal
from stplan.scene.places import Place
from stplan.scene.reading.faults import Hints
from stplan.scene.reading.moving_goals import moving_goal
from stplan.scene.reading.patterns import Listed
from stplan.scene.reading.places import Places
from stplan.schema.mapping import Fault

DEFAULT_RADIUS = 0.3
DEFAULT_MASS = 1.0


def merged_agent(
    defaults: SharedFields,
    own: AgentFile,
    listed: Listed,
    horizon: float | None,
    places: Places,
    faults: list[Fault],
    hints: Hints,
) -> Agent:
    """The agent of `listed`; with new `faults` it must not be used.

    Where it starts in a place, its start is any point of that, to be drawn.
    """
    return _Merge(defaults, own, listed, faults, places, hints).agent(horizon)


def _point(values: list[float]) -> Point:
    return (values[0], values[1])


def _visit(entry: list[float] | WaypointFile) -> Visit:
    if not isinstance(entry, WaypointFile):
        return Visit()
    window = None if entry.window is None else (entry.window[0], entry.window[1])
    return Visit(window, entry.dwell or 0.0)


class _Merge:
    """One agent: its own keys over `defaults` over what the format promises."""

    def __init__(
        self,
        defaults: SharedFields,
        own: AgentFile,
        listed: Listed,
        faults: list[Fault],
        places: Places,
        hints: Hints,
    ) -> None:
        self._defaults, self._own, self._listed, self._faults = defaults, own, listed, faults
        self._places, self._hints = places, hints

    def _value(self, key: str, fallback: Any) -> Any:
        for part in (self._own, self._defaults):
            value = getattr(part, key)
            if value is not None:
                return value
        return fallback

    def _fault(self, key: str, text: str) -> None:
        """A fault of `key`, told where its value stands: with the agent, or in `defaults`."""
        here: Any = self._own
        there: Any = self._defaults
        for step in key.partition("[")[0].split("."):
            here, there = getattr(here, step, None), getattr(there, step, None)
        shared = here is None and there is not None
        self._faults.append((f"defaults.{key}" if shared else self._listed.place(key), text))

    def agent(self, horizon: float | None) -> Agent:
        """The agent; with new faults it must not be used."""
        own = self._own
        path: tuple[tuple[float, float, float], ...] | None = None
        moving: MovingGoal | None = None
        weights = self._weights()
        if own.path is not None:
            path = tuple((x, y, t) for x, y, t in own.path)
            self._check_path(path)
            start, goal = path[0][:2], path[-1][:2]
            start_time, max_time = path[0][2], path[-1][2]
            waypoints: tuple[Point, ...] = ()
            visits: tuple[Visit, ...] = ()
            max_speed = max_acceleration = start_velocity = None
            start_duration = 0.0
            goal_places: tuple[Place, ...] = ()
        else:
            goal_places = self._goal_places()
            start = self._end("start")
            if isinstance(own.goal, MovingGoalFile):
                moving, goal = self._moving_goal(own.goal), start
            else:
                goal = goal_places[0].points[0] if goal_places else self._end("goal")
            start_time, max_time = self._times(horizon)
            entries = self._value("waypoints", [])
            waypoints = tuple(self._waypoint(k, entry) for k, entry in enumerate(entries))
            visits = tuple(_visit(entry) for entry in entries)
            visits = visits if any(visit != Visit() for visit in visits) else ()
            max_speed = self._value("max_speed", None)
            max_acceleration = self._value("max_acceleration", None)
            start_velocity = self._start_velocity(max_speed)
            start_duration = self._start_duration(start_velocity, start_time, max_time)
            self._check_preferred_time(weights, start_time, max_time)
            self._check_visits(visits, start_time, max_time)
        return Agent(
            id=own.id,
            start=start,
            goal=goal,
            start_time=start_time,
            max_time=max_time,
            preferred_time=self._value("preferred_time", None),
            radius=self._value("radius", DEFAULT_RADIUS),
            mass=self._value("mass", DEFAULT_MASS),
            after_arrival=self._value("after_arrival", "stay"),
            waypoints=waypoints,
            weights=weights,
            path=path,
            max_speed=max_speed,
            max_acceleration=max_acceleration,
            visits=visits,
            clearance=self._value("clearance", 0.0),
            goal_places=goal_places,
            start_velocity=start_velocity,
            start_duration=start_duration,
            moving_goal=moving,
            sight=None if own.path is not None else self._sight(),
            line_of_sight=own.path is None and self._line_of_sight(),
        )

    def _weights(self) -> Weights:
        values: dict[str, Any] = {}
        for part in (self._defaults.weights, self._own.weights):
            for key in () if part is None else part.model_fields_set:
                value = getattr(part, key)
                values[key] = None if value == "auto" else value
        return Weights(**values)

    def _end(self, key: str) -> Point:
        value = getattr(self._own, key)
        if value is None:
            text = "is missing; a point [x, y] in m is expected, or a path"
            self._faults.append((self._listed.place(key), text))
        if isinstance(value, StartPlaceFile):
            found = self._places.of_start(value, self._listed.place(key), self._faults, self._hints)
            return found[0].points[0] if found else (0.0, 0.0)
        return _point(value if isinstance(value, list) else [0.0, 0.0])

    def _waypoint(self, k: int, entry: list[float] | WaypointFile) -> Point:
        """A waypoint; of a place any point, the one that is passed is chosen later."""
        if not isinstance(entry, WaypointFile):
            return _point(entry)
        if entry.at is not None and entry.place is not None:
            self._fault(f"waypoints[{k}]", "has both at and place; one of them is expected")
        if entry.at is None and entry.place is None:
            text = "is missing; a point [x, y] in m is expected, or a place"
            self._fault(f"waypoints[{k}].at", text)
        if entry.place is not None:
            key = f"waypoints[{k}].place"
            own = self._own.waypoints is not None
            path = self._listed.place(key) if own else f"defaults.{key}"
            place = self._places.named(entry.place, path, self._faults, self._hints)
            return place.points[0] if place is not None else (0.0, 0.0)
        return _point(entry.at or [0.0, 0.0])

    def _goal_places(self) -> tuple[Place, ...]:
        goal = self._own.goal
        if not isinstance(goal, GoalPlaceFile):
            return ()
        return self._places.of_goal(goal, self._listed.place("goal"), self._faults, self._hints)

    def _sight(self) -> float | None:
        perception = self._value("perception", None)
        return None if perception is None else float(perception.radius)

    def _line_of_sight(self) -> bool:
        perception = self._value("perception", None)
        return perception is not None and bool(perception.line_of_sight)

    def _moving_goal(self, entry: MovingGoalFile) -> MovingGoal | None:
        path = self._listed.place("goal")
        return moving_goal(entry, path, self._places, self._faults, self._hints)

    def _start_velocity(self, max_speed: float | None) -> tuple[float, float] | None:
        value = self._value("start_velocity", None)
        if value is None:
            return None
        velocity = _point(value)
        speed = math.hypot(*velocity)
        if max_speed is not None and speed > max_speed:
            given, most = distinct(speed, max_speed)
            self._fault(
                "start_velocity", f"is {given} m/s; no more than max_speed {most} m/s is expected"
            )
        return velocity

    def _start_duration(
        self, velocity: tuple[float, float] | None, start_time: float, max_time: float
    ) -> float:
        lasts = float(self._value("start_duration", 0.0))
        if lasts > 0.0 and velocity is None:
            self._fault("start_duration", "belongs to a start_velocity, and there is none")
        elif 0.0 < max_time - start_time <= lasts:
            given, most = distinct(lasts, max_time - start_time)
            self._fault(
                "start_duration", f"is {given} s; less than the {most} s there are is expected"
            )
        return lasts

    def _times(self, horizon: float | None) -> tuple[float, float]:
        start_time: float = self._value("start_time", 0.0)
        max_time: float | None = self._value("max_time", horizon)
        if max_time is None:
            text = "is missing; a time in s is expected, or a max_time of every agent"
            self._faults.append(("horizon", text))
            return start_time, start_time + 1.0
        if max_time <= start_time:
            given = self._own.max_time is not None or self._defaults.max_time is not None
            key = "max_time" if given else "start_time"
            early, late = distinct(start_time, max_time)
            text = (
                f"max_time {late} s is not after start_time {early} s"
                if given
                else f"is {early} s; less than the horizon {late} s is expected"
            )
            self._fault(key, text + ("; a later one is expected" if given else ""))
        return start_time, max_time

    def _check_preferred_time(self, weights: Weights, start_time: float, max_time: float) -> None:
        preferred: float | None = self._value("preferred_time", None)
        if preferred is None:
            if weights.arrival > 0:
                self._fault(
                    "weights.arrival",
                    f"is {weights.arrival:g}, but preferred_time is missing; a time in s is expected",
                )
        elif not start_time < preferred <= max_time:
            wanted, early, late = distinct(preferred, start_time, max_time)
            self._fault(
                "preferred_time",
                f"is {wanted} s; after start_time {early} s and no later than max_time {late} s is expected",
            )

    def _check_visits(self, visits: tuple[Visit, ...], start_time: float, max_time: float) -> None:
        """Every visit fits into its window, and all of them one after another into the time."""
        now = start_time
        for k, visit in enumerate(visits):
            begin, end = visit.window or (start_time, max_time)
            if visit.window is not None and begin >= end:
                text = f"reaches from {begin:g} s to {end:g} s; a later end is expected"
                self._fault(f"waypoints[{k}].window", text)
                return
            now = max(now, begin) + visit.dwell
            if now > min(end, max_time):
                earliest, latest = distinct(now, min(end, max_time))
                text = f"cannot be left before {earliest} s; no later than {latest} s is expected"
                self._fault(f"waypoints[{k}]", text)
                return

    def _check_path(self, path: tuple[tuple[float, float, float], ...]) -> None:
        """Times of a given path rise, and what repeats it says the same."""
        own, here = self._own, self._listed.path
        for k in range(1, len(path)):
            if path[k][2] <= path[k - 1][2]:
                text = f"is at {path[k][2]:g} s; later than the knot before is expected"
                self._faults.append((f"{here}.path[{k}][2]", f"{text} ({path[k - 1][2]:g} s)"))
        for key, place in (("start", path[0]), ("goal", path[-1])):
            value = getattr(own, key)
            if value is not None and (not isinstance(value, list) or _point(value) != place[:2]):
                text = f"is not the path's end {in_full(place[0], place[1])}; leave it out"
                self._faults.append((f"{here}.{key}", text))
        if own.start_time is not None and own.start_time != path[0][2]:
            given, first = distinct(own.start_time, path[0][2])
            text = f"is {given} s, the path starts at {first} s; leave it out"
            self._faults.append((f"{here}.start_time", text))
        if own.max_time is not None and own.max_time < path[-1][2]:
            given, last = distinct(own.max_time, path[-1][2])
            text = f"is {given} s, the path ends at {last} s; leave it out"
            self._faults.append((f"{here}.max_time", text))
        for key in ("max_speed", "max_acceleration", "start_velocity", "start_duration"):
            if getattr(own, key) is not None:
                text = "belongs to agents that find their way; the motion of one with a path is prescribed"
                self._faults.append((f"{here}.{key}", text))
        if own.waypoints:
            text = "belongs to agents that find their way; one with a path passes its knots"
            self._faults.append((f"{here}.waypoints", text))
