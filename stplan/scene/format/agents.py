"""The scene file's agents: their keys, and the patterns and tables that stand for many of them."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag

from stplan.maps.obstacles import CircleFile
from stplan.scene.format.moving_goals import AgentGoal
from stplan.scene.format.places import CrowdGoal, CrowdStartFile, Goal, Start, StartPlaceFile
from stplan.schema.mapping import GIVEN, FileModel, key
from stplan.schema.quantities import (
    Identifier,
    Interval,
    Knot,
    NotNegative,
    Number,
    Or,
    Point,
    Positive,
    Velocity,
    Weight,
    expected,
)

MOST_AGENTS = 10_000
MOST_KNOTS = 100_000
# Names of the kinds of an entry, as they stand in the places of pydantic's errors.
KINDS = (
    "@point", "@names", "@waypoint", "@place", "@moving", "@agent", "@circle", "@line", "@grid", "@crowd",
    "@stream", "@file",
)  # fmt: skip


class WeightsFile(FileModel):
    """How much an agent minds each cost: the paper's K, all >= 0, without unit."""

    kinetic: Annotated[NotNegative | None, GIVEN] = key("K^K of the kinetic energy", 1.0)
    acceleration: Annotated[Weight | None, GIVEN] = key("K^A of changes of velocity", 0.0)
    arrival: Annotated[Weight | None, GIVEN] = key(
        "K^T of arriving at another time than preferred_time", 0.0
    )
    regularity: Annotated[float | Literal["auto"] | None, Or(Weight, "auto")] = key(
        "K^R of unevenly spaced knots; auto scales it by the seed's kinetic cost", "auto"
    )
    collision: Annotated[NotNegative | None, GIVEN] = key(
        "K^C of nearness to other agents; a pair is switched off where both have 0", 1.0
    )
    wall: Annotated[NotNegative | None, GIVEN] = key(
        "K^M of nearness to walls; 0 switches them off for this agent", 1.0
    )
    clearance: Annotated[NotNegative | None, GIVEN] = key(
        "K^W of missing the wished clearance, over the mean kinetic cost of the agents", 1.0
    )


class WaypointFile(FileModel):
    """A waypoint with a time: where, when and for how long."""

    at: Annotated[Point | None, GIVEN] = key("[x, y] in m")
    place: Annotated[Identifier | None, GIVEN] = key(
        "name of one of `places`, instead of `at`: the point of it nearest to the straight way"
    )
    window: Annotated[Interval | None, GIVEN] = key(
        "[from, to] in s: between these times the agent is there, and stays as long as `dwell` asks"
    )
    dwell: Annotated[NotNegative | None, GIVEN] = key("how long it stays there at least, s", 0.0)


def _waypoint_kind(value: Any) -> str:
    return "@waypoint" if isinstance(value, dict | WaypointFile) else "@point"


Waypoint = Annotated[
    Annotated[Point, Tag("@point")] | Annotated[WaypointFile, Tag("@waypoint")],
    Discriminator(_waypoint_kind),
]


class PerceptionFile(FileModel):
    """What an agent knows of others: those that are near; the others do not exist for it."""

    radius: Positive = Field(description="how far it sees, m between centres")
    line_of_sight: bool = Field(False, description="whether walls hide others from it")


class SharedFields(FileModel):
    """What an agent may set, and `defaults` for all agents."""

    start_time: Annotated[Number | None, GIVEN] = key("when the agent appears, s", 0.0)
    max_time: Annotated[Number | None, GIVEN] = key(
        "T^max, latest arrival, s, after start_time; default: the horizon"
    )
    preferred_time: Annotated[Number | None, GIVEN] = key(
        "T^p, wanted arrival, s, after start_time and no later than max_time; "
        "needed by, and felt through, weights.arrival"
    )
    radius: Annotated[Positive | None, GIVEN] = key("radius of comfort, m", 0.3)
    clearance: Annotated[NotNegative | None, GIVEN] = key(
        "what it would like to keep beyond the radius, from agents and walls, where that is worth it, m",
        0.0,
    )
    mass: Annotated[Positive | None, GIVEN] = key("mass, kg", 1.0)
    after_arrival: Annotated[Literal["stay", "vanish"] | None, GIVEN] = key(
        "stay on the goal until the horizon, or vanish on arrival", "stay"
    )
    max_speed: Annotated[Positive | None, GIVEN] = key("never faster than this, m/s")
    max_acceleration: Annotated[Positive | None, GIVEN] = key(
        "velocity changes no faster than this, m/s^2; the agent starts and ends at rest"
    )
    start_velocity: Annotated[Velocity | None, GIVEN] = key(
        "[vx, vy] in m/s at start_time: the first segment has it, or what max_acceleration allows from "
        "there; default: any, at rest with a max_acceleration"
    )
    start_duration: Annotated[NotNegative | None, GIVEN] = key(
        "how long the agent keeps its start_velocity at least, s", 0.0
    )
    waypoints: Annotated[Annotated[list[Waypoint], Field(max_length=1000)] | None, GIVEN] = key(
        "points [x, y] in m, passed in this order at free times, or mappings with at or place, window, dwell"
    )
    perception: Annotated[PerceptionFile | None, GIVEN] = key(
        "which others it knows of; default: all"
    )
    weights: Annotated[WeightsFile | None, GIVEN] = key(
        "weights of the costs; those left out come from `defaults`, one by one"
    )


class AgentFile(SharedFields):
    """One agent: a disc with a mass that moves from `start` to `goal`, or along a given `path`."""

    id: Identifier = Field(description="name of the agent, unique; `all` is reserved")
    start: Annotated[Start | None, GIVEN] = key(
        "[x, y] in m at start_time, or a place it is drawn from; unless path is given"
    )
    goal: Annotated[AgentGoal | None, GIVEN] = key(
        "[x, y] in m, reached exactly, by max_time, or places it ends in, or others that it follows, "
        "pursues or evades; unless path is given"
    )
    path: Annotated[
        Annotated[list[Knot], Field(min_length=2, max_length=MOST_KNOTS)] | None, GIVEN
    ] = key(
        "[[x, y, t], ...] in m and s, t rising: the agent moves exactly so, everyone else makes way"
    )


class PatternFile(SharedFields):
    """Many agents that share everything but their places; they are called ID-1, ID-2, ..."""

    id: Annotated[Identifier, Field(max_length=90)] = Field(
        description="what the agents' ids begin with; in pairs and groups it means all of them"
    )


_COUNT = Annotated[int, Field(ge=1, le=MOST_AGENTS)]
_LINE = Annotated[list[Point], Field(min_length=2, max_length=1000)]


PATTERNS = ("circle", "line", "grid")


def _pattern(value: Any) -> Any:
    if value not in PATTERNS:
        raise expected("circle, line or grid", PATTERNS)
    return value


class CirclePatternFile(PatternFile):
    """Agents spread evenly over a circle, each going to the opposite point."""

    pattern: Annotated[Literal["circle"], BeforeValidator(_pattern)] = Field(
        description="agents on a circle"
    )
    count: _COUNT = Field(description="how many agents")
    circle: CircleFile = Field(description="the circle they start on")
    first_angle: Annotated[Number | None, GIVEN] = key(
        "where the first one starts, degrees, counterclockwise from the x axis", 0.0
    )
    turn: Annotated[Number | None, GIVEN] = key(
        "angle from every start to its goal, degrees, counterclockwise", 180.0
    )


class LinePatternFile(PatternFile):
    """Agents spread evenly along a line (or a polyline), going to places along another."""

    pattern: Literal["line"] = Field(description="agents along a line")
    count: _COUNT = Field(description="how many agents")
    start: _LINE = Field(description="[[x, y], [x, y], ...] in m, the line of their starts")
    goal: _LINE = Field(description="[[x, y], [x, y], ...] in m, the line of their goals")


class GridPatternFile(PatternFile):
    """Agents in rows and columns, going to the same rows and columns elsewhere."""

    pattern: Literal["grid"] = Field(description="agents in rows and columns")
    rows: _COUNT = Field(description="how many along y")
    columns: _COUNT = Field(description="how many along x")
    spacing: Point = Field(description="[dx, dy] in m, from column to column and from row to row")
    start: Point = Field(description="[x, y] in m, where the first one starts")
    goal: Point = Field(description="[x, y] in m, where the first one goes")


class CrowdFile(PatternFile):
    """Agents that start somewhere in a place and go to places, or to points of which each gets one."""

    count: _COUNT = Field(description="how many agents")
    start: CrowdStartFile = Field(description="the place they start in, or their points")
    goal: CrowdGoal = Field(description="[x, y] in m, places they end in, or points to assign")


class StreamFile(PatternFile):
    """Agents that appear one after another in a place."""

    source: StartPlaceFile = Field(description="the place they appear in, each on a free spot")
    goal: Goal = Field(description="[x, y] in m, or places they end in")
    rate: Positive = Field(description="how many appear in a second, on average")
    during: Interval = Field(description="[from, until] in s: when they appear")
    arrivals: Annotated[Literal["regular", "poisson"] | None, GIVEN] = key(
        "at regular times, or at random ones drawn with seeding.rng_seed", "regular"
    )
    allowed_time: Annotated[Positive | None, GIVEN] = key(
        "how long each may take from its start to its goal, s; default: until max_time"
    )


class AgentsCsvFile(SharedFields):
    """Agents of a table; what its rows leave open comes from here, then from `defaults`."""

    file: Annotated[str, Field(min_length=1, max_length=1000)] = Field(
        description="a CSV table with a header, path relative to the scene file"
    )
    id: Annotated[Identifier | None, GIVEN] = key(
        "in pairs and groups it means all agents of the table"
    )


def _agent_kind(value: Any) -> str:
    """Of which kind an entry of `agents` is; what is no mapping is judged as an agent."""
    if isinstance(value, dict):
        if "pattern" in value:
            word = value["pattern"]
            return f"@{word}" if word in PATTERNS else "@circle"
        if "file" in value:
            return "@file"
        if "source" in value:
            return "@stream"
        return "@crowd" if "count" in value else "@agent"
    kinds: dict[type, str] = {
        CirclePatternFile: "@circle",
        LinePatternFile: "@line",
        GridPatternFile: "@grid",
        CrowdFile: "@crowd",
        StreamFile: "@stream",
        AgentsCsvFile: "@file",
    }
    return kinds.get(type(value), "@agent")


AgentEntry = Annotated[
    Annotated[AgentFile, Tag("@agent")]
    | Annotated[CirclePatternFile, Tag("@circle")]
    | Annotated[LinePatternFile, Tag("@line")]
    | Annotated[GridPatternFile, Tag("@grid")]
    | Annotated[CrowdFile, Tag("@crowd")]
    | Annotated[StreamFile, Tag("@stream")]
    | Annotated[AgentsCsvFile, Tag("@file")],
    Discriminator(_agent_kind),
]
