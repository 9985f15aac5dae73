"""The scene file's format, version 1: every key with type, bounds, unit and default.

One model validates and prints the JSON Schema. Defaults of an agent are left out here (None) where the
scene's `defaults` may fill them in; `stplan.scene.load` resolves them.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema

FORMAT = 1
MOST_AGENTS = 10_000
# Coordinates and times beyond this are a mistake of units.
LARGEST = 1e9


def _auto(value: Any) -> Any:
    return None if value == "auto" else value


def _auto_schema(inner: dict[str, Any]) -> WithJsonSchema:
    return WithJsonSchema({"anyOf": [{"const": "auto"}, inner]})


Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, le=LARGEST, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, le=LARGEST, allow_inf_nan=False)]
Tolerance = Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)]
Point = Annotated[list[Number], Field(min_length=2, max_length=2)]
Knot = Annotated[list[Number], Field(min_length=3, max_length=3)]
Ring = Annotated[list[Point], Field(min_length=3, max_length=1_000_000)]
Rectangle = Annotated[list[Number], Field(min_length=4, max_length=4)]
Identifier = Annotated[
    str, Field(min_length=1, max_length=100, pattern=r"^[^\s,;\"'\x00-\x1f\x7f]+$")
]
AutoNotNegative = Annotated[
    NotNegative | None, BeforeValidator(_auto), _auto_schema({"type": "number", "minimum": 0})
]
AutoPositive = Annotated[
    Annotated[float, Field(gt=0, le=LARGEST)] | None,
    BeforeValidator(_auto),
    _auto_schema({"type": "number", "exclusiveMinimum": 0}),
]


def _auto_count(low: int, high: int) -> Any:
    schema = {"type": "integer", "minimum": low, "maximum": high}
    return Annotated[
        Annotated[int, Field(ge=low, le=high)] | None, BeforeValidator(_auto), _auto_schema(schema)
    ]


def _reach(value: Any) -> Any:
    return (
        {"auto": None, "inf": float("inf")}.get(value, value) if isinstance(value, str) else value
    )


BarrierRange = Annotated[
    Annotated[float, Field(gt=0, allow_inf_nan=True)] | None,
    BeforeValidator(_reach),
    WithJsonSchema(
        {"anyOf": [{"enum": ["auto", "inf"]}, {"type": "number", "exclusiveMinimum": 0}]}
    ),
]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class WeightsFile(_Model):
    """The paper's K, all >= 0."""

    kinetic: NotNegative | None = Field(None, description="K^K, default 1")
    acceleration: NotNegative | None = Field(None, description="K^A, default 0")
    arrival: NotNegative | None = Field(None, description="K^T, default 0; needs preferred_time")
    regularity: AutoNotNegative = Field(None, description="K^R, default auto: from the seed's cost")
    collision: NotNegative | None = Field(
        None, description="K^C, default 1; a pair of zeros is off"
    )
    wall: NotNegative | None = Field(None, description="K^M, default 1; 0 switches walls off")


class SharedFields(_Model):
    """What agents may set and `defaults` may set for all."""

    start_time: Number | None = Field(None, description="s, default 0")
    max_time: Number | None = Field(None, description="T^max in s, default the horizon")
    preferred_time: Number | None = Field(None, description="T^p in s, felt with weights.arrival")
    radius: Positive | None = Field(None, description="radius of comfort in m, default 0.3")
    mass: Positive | None = Field(None, description="kg, default 1")
    after_arrival: Literal["stay", "vanish"] | None = Field(
        None, description="stay (default) on the goal until the horizon, or vanish on arrival"
    )
    waypoints: list[Point] | None = Field(None, description="passed in order at free times, m")
    weights: WeightsFile | None = None


class AgentFile(SharedFields):
    """One agent."""

    id: Identifier
    start: Point | None = Field(None, description="(x, y) in m")
    goal: Point | None = Field(None, description="(x, y) in m, reached exactly")
    path: Annotated[list[Knot], Field(min_length=2)] | None = Field(
        None, description="(x, y, t) in m and s: the agent moves as told, everyone else makes way"
    )


class CircleFile(_Model):
    """A disc."""

    center: Point
    radius: Positive


class ObstacleFile(_Model):
    """Exactly one shape that is cut out of the map."""

    rectangle: Rectangle | None = Field(None, description="xmin, ymin, xmax, ymax in m")
    polygon: Ring | None = Field(None, description="a ring of (x, y) in m")
    circle: CircleFile | None = None


class MapFile(_Model):
    """Where agents may be: exactly one base (mesh, polygon or rectangle), less the obstacles."""

    mesh: str | None = Field(None, description="flat mesh file, relative to the scene file")
    up: Literal["x", "y", "z"] | None = Field(None, description="axis of the mesh that is dropped")
    polygon: Ring | None = Field(None, description="outer ring of (x, y) in m")
    holes: list[Ring] | None = Field(None, description="rings cut out of the polygon")
    rectangle: Rectangle | None = Field(None, description="xmin, ymin, xmax, ymax in m")
    obstacles: list[ObstacleFile] | None = None
    resolution: Positive | None = Field(None, description="edge length of the seeding mesh, m")


class PairFile(_Model):
    """An override for pairs; later entries win."""

    between: Annotated[list[Identifier | list[Identifier]], Field(min_length=2, max_length=2)] = (
        Field(description="an id, `all` or a list of ids on either side")
    )
    distance: Positive | None = Field(
        None, description="comfort distance in m instead of r_a + r_b"
    )
    grouping: NotNegative | None = Field(None, description="K^G, draws the pair together")
    collide: bool | None = Field(None, description="false switches the pair's collision off")


class SeedingFile(_Model):
    """How initial curves are found."""

    method: Literal["auto", "dijkstra", "search", "relaxation"] = "auto"
    layers: _auto_count(2, 100_000) = Field(None, description="time layers")  # type: ignore[valid-type]
    margin: Annotated[float, Field(ge=1, le=10, allow_inf_nan=False)] = Field(
        1.05, description="factor on distances while seeding, where there is room"
    )
    time_limit: Positive = Field(60.0, description="s")
    rng_seed: Annotated[int, Field(ge=0, le=2**63 - 1)] = 0


class SolverFile(_Model):
    """How curves are optimised."""

    knots: _auto_count(3, 10_000) = Field(None, description="knots per agent")  # type: ignore[valid-type]
    mu: AutoPositive = Field(None, description="first barrier weight, auto scales with the costs")
    mu_decay: Annotated[float, Field(gt=0, le=1, allow_inf_nan=False)] = 0.75
    outer_iterations: Annotated[int, Field(ge=1, le=1000)] = 5
    max_iterations: Annotated[int, Field(ge=0, le=1_000_000)] = Field(
        100, description="Ipopt iterations per outer iteration"
    )
    step_tolerance: Tolerance = 1.0e-2
    optimality_tolerance: Tolerance = 1.0e-2
    alpha: Positive = Field(50.0, description="sharpness of the smooth minimum, 1/m")
    clearance_model: Literal["contacts", "smooth-minimum"] = "contacts"
    barrier_range: BarrierRange = Field(None, description="clearance in m where repulsion starts")
    hessian: Literal["gauss-newton", "exact", "limited-memory"] = "gauss-newton"
    linear_solver: Annotated[str, Field(min_length=1, max_length=40)] = "mumps"
    ipopt: dict[str, str | int | float] = Field(
        default_factory=dict, description="further Ipopt options, passed on"
    )


class SceneFile(_Model):
    """A scene file of format 1. Lengths in m, times in s, masses in kg."""

    stplan: Literal[1] = Field(description="version of this format")
    name: Annotated[str, Field(max_length=100, pattern=r"^[a-z0-9][a-z0-9_-]*$")] | None = None
    description: str = ""
    map: MapFile | None = None
    horizon: Positive | None = Field(None, description="T^max of agents without max_time, s")
    time_scale: Positive = Field(1.0, description="c in m/s")
    defaults: SharedFields = SharedFields()
    agents: Annotated[list[AgentFile], Field(min_length=1, max_length=MOST_AGENTS)]
    pairs: list[PairFile] = []
    seeding: SeedingFile = SeedingFile()
    solver: SolverFile = SolverFile()


def scene_schema() -> dict[str, Any]:
    """The JSON Schema of scene files, for editors."""
    schema = SceneFile.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "stplan scene, format 1"
    return schema
