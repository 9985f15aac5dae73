"""The scene file's format, version 1: every key with type, bounds, unit and default.

One model validates and prints the JSON Schema. Defaults of an agent are left out here (None), because
the scene's `defaults` come between; `stplan.scene.reading.compile` fills them in.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from stplan.maps.registry import MapFile
from stplan.scene.format.agents import MOST_AGENTS, AgentEntry, SharedFields
from stplan.scene.format.events import MOST_EVENTS, EventFile
from stplan.scene.format.places import MOST_PLACES, PlaceFile, Side
from stplan.scene.format.tasks import TasksFile
from stplan.scene.model import Objective, SeedingMethod, SeedingSettings, SolverSettings
from stplan.scene.moving_goals import REPLAN_EVERY
from stplan.schema.mapping import GIVEN as _GIVEN
from stplan.schema.mapping import FileModel as _Model
from stplan.schema.mapping import key as _key
from stplan.schema.quantities import (
    BarrierWeight,
    Factor,
    Identifier,
    Interval,
    NotNegative,
    Options,
    Or,
    Positive,
    Version,
    Weight,
)

FORMAT = 1
MOST_PAIRS = 100_000
# Defaults have one home, the model.
_SEEDING = SeedingSettings()
_SOLVER = SolverSettings()
_LAYERS = Annotated[int, Field(ge=2, le=100_000)]
_KNOTS = Annotated[int, Field(ge=3, le=10_000)]
_BLOCKS = Annotated[int, Field(ge=1, le=10_000)]
_STARTS = Annotated[int, Field(ge=1, le=1000)]
_Tolerance = Annotated[Factor, Field(le=1e6)]
_RANGE = Annotated[float, Field(gt=0, allow_inf_nan=True)]


class MeetFile(_Model):
    """Two agents come near each other at some moment at which both are present."""

    within: Positive = Field(description="how near their centres come at least once, m")
    window: Annotated[Interval | None, _GIVEN] = _key("[from, to] in s: when; default: any time")


class PairSettingsFile(_Model):
    """What may differ for a pair."""

    distance: Annotated[Positive | None, _GIVEN] = _key(
        "comfort distance of the centres, m, instead of the sum of the radii"
    )
    grouping: Annotated[Weight | None, _GIVEN] = _key("K^G, above 0 it draws the pair together")
    collision: Annotated[Factor | None, _GIVEN] = _key(
        "K^C of the pair, instead of the mean of both agents'"
    )
    clearance: Annotated[NotNegative | None, _GIVEN] = _key(
        "what the pair would like to keep beyond its distance, m, instead of the greater wish of both"
    )
    collide: Annotated[bool | None, _GIVEN] = _key("false lets the pair pass through each other")
    meet: Annotated[MeetFile | None, _GIVEN] = _key("the two have to meet")


class PairFile(PairSettingsFile):
    """What differs for pairs of agents; of several entries about a pair the later wins."""

    between: Annotated[list[Side], Field(min_length=2, max_length=2)] = Field(
        description="both sides: an id, `all`, a list of ids, or who starts or ends in a place, each"
    )


class GroupFile(PairSettingsFile):
    """Agents whose pairs share settings; entries of `pairs` win over them."""

    name: Annotated[Identifier | None, _GIVEN] = _key("in pairs it means all members")
    members: Annotated[
        list[Annotated[str, Field(min_length=1, max_length=100)]],
        Field(min_length=1, max_length=MOST_AGENTS),
    ] = Field(description="ids of agents, patterns and tables")


class RobustFile(_Model):
    """What a plan has to forgive when it is executed."""

    delay: NotNegative = Field(
        0.0,
        description="any one agent may stop for so long at any moment, s, if all keep the order of passing",
    )
    tracking: NotNegative = Field(
        0.0,
        description="everybody may be so far off its trajectory, m; distances are kept all the same",
    )


class SeedingFile(_Model):
    """How initial curves are found."""

    method: SeedingMethod = Field(
        _SEEDING.method, description="way of finding initial curves; auto tries several"
    )
    layers: Annotated[int | Literal["auto"], Or(_LAYERS, "auto")] = Field(
        "auto", description="number of layers in time of the space-time graph"
    )
    margin: Annotated[float, Field(ge=1, le=10, allow_inf_nan=False)] = Field(
        _SEEDING.margin, description="factor on distances while seeding, where there is room"
    )
    time_limit: Positive = Field(
        _SEEDING.time_limit, description="how long to look for initial curves, s of processor time"
    )
    rng_seed: Annotated[int, Field(ge=0, le=2**63 - 1)] = Field(
        _SEEDING.rng_seed, description="seed of the random generator"
    )
    shortcuts: bool = Field(
        _SEEDING.shortcuts, description="shorten and retime what was found; false: as it was found"
    )


class SolverFile(_Model):
    """How curves are optimised."""

    knots: Annotated[int | Literal["auto"], Or(_KNOTS, "auto")] = Field(
        "auto", description="knots per agent; auto follows the initial curves"
    )
    effort: Literal["quick", "normal", "best"] = Field(
        _SOLVER.effort,
        description="how many initial curves compete, how many are optimised, how long one is improved",
    )
    starts: Annotated[int | Literal["auto"], Or(_STARTS, "auto")] = Field(
        "auto", description="initial curves to choose the cheapest from; auto: as effort asks"
    )
    mu: Annotated[float | Literal["auto"], Or(BarrierWeight, "auto")] = Field(
        "auto", description="first weight of the barriers; auto scales with the costs"
    )
    mu_decay: Annotated[float, Field(gt=0, le=1, allow_inf_nan=False)] = Field(
        _SOLVER.mu_decay,
        description="factor on mu from one outer iteration to the next (the paper's c)",
    )
    outer_iterations: Annotated[int, Field(ge=1, le=1000)] = Field(
        _SOLVER.outer_iterations, description="most values of mu"
    )
    max_iterations: Annotated[int, Field(ge=0, le=1_000_000)] = Field(
        _SOLVER.max_iterations, description="most Ipopt iterations per outer iteration"
    )
    step_tolerance: _Tolerance = Field(
        _SOLVER.step_tolerance,
        description="step of an outer iteration, relative, that counts as converged",
    )
    optimality_tolerance: _Tolerance = Field(
        _SOLVER.optimality_tolerance,
        description="what counts as converged, as `convergence` measures it",
    )
    convergence: Literal["decrease", "first-order"] = Field(
        _SOLVER.convergence,
        description="what the tolerance is of: costs that fall, relative, or the first-order optimality",
    )
    alpha: Positive = Field(
        _SOLVER.alpha, description="alpha_0, sharpness of the smooth minimum distance, 1/m"
    )
    alpha_rule: Literal["half-clearance", "stepped"] = Field(
        _SOLVER.alpha_rule, description="how alpha is raised above alpha_0; stepped is the paper's"
    )
    clearance_model: Literal["contacts", "smooth-minimum"] = Field(
        _SOLVER.clearance_model, description="how clearances enter; smooth-minimum is the paper's"
    )
    barrier_range: Annotated[float | Literal["auto", "inf"], Or(_RANGE, "auto", "inf")] = Field(
        "auto", description="clearance at which repulsion starts, m; inf: the paper's logarithm"
    )
    hessian: Literal["gauss-newton", "exact", "limited-memory"] = Field(
        _SOLVER.hessian, description="second derivatives given to Ipopt"
    )
    hessian_cutoff: Annotated[float, Field(ge=0, lt=1, allow_inf_nan=False)] = Field(
        _SOLVER.hessian_cutoff,
        description="least share in a smooth minimum that counts in the Gauss-Newton Hessian",
    )
    blocks: Annotated[int | Literal["auto", "all"], Or(_BLOCKS, "auto", "all")] = Field(
        "auto", description="agents optimised at a time; auto: 64 where there are more than 400"
    )
    linear_solver: Annotated[
        str, Field(min_length=1, max_length=40, pattern=r"^[a-z][a-z0-9-]*$")
    ] = Field("mumps", description="Ipopt's linear solver; auto: the best it has")
    ipopt: Options = Field({}, description="further Ipopt options by name, passed on as they are")


class SceneFile(_Model):
    """A scene file of format 1. Lengths in m, times in s, masses in kg."""

    stplan: Version = Field(description="version of this format")
    name: Annotated[
        Annotated[str, Field(max_length=100, pattern=r"^[a-z0-9][a-z0-9_-]*$")] | None, _GIVEN
    ] = _key("name of the output folder; default: the file's stem")
    description: Annotated[str, Field(max_length=10_000)] = Field(
        "", description="one line that says what the scene shows"
    )
    preset: Annotated[Literal["paper"] | None, _GIVEN] = _key(
        "whose defaults time_scale, seeding and solver have; paper: as the paper prints its recipe"
    )
    map: Annotated[MapFile | None, _GIVEN] = _key("where agents may be; default: the open plane")
    places: Annotated[dict[Identifier, PlaceFile], Field(max_length=MOST_PLACES)] = Field(
        {}, description="parts of the plane by name, for starts and goals of agents"
    )
    minimise: Objective = Field(
        "energy",
        description="what is to be least: energy (with all other costs), the sum of arrival times, "
        "or the makespan, when the last agent arrives; the latter two need max_speed",
    )
    horizon: Annotated[
        float | Literal["auto", "none"] | None, Or(Positive, "auto", "none"), _GIVEN
    ] = _key(
        "T^max of agents without max_time, and how long agents stay, s; "
        "may be left out where every agent has a max_time or a path; "
        "auto, where arrivals or makespan are minimised: as long as it takes; "
        "none, with tasks: until all are done"
    )
    replan_every: Annotated[Positive | None, _GIVEN] = _key(
        "how often goals that move are decided anew, and robots with tasks planned on, s",
        REPLAN_EVERY,
    )
    tasks: Annotated[TasksFile | None, _GIVEN] = _key(
        "what robots do one after another, without an end; then they go to their goals"
    )
    time_scale: Annotated[float | Literal["auto"], Or(Positive, "auto")] = Field(
        "auto",
        description="c in m/s: the space-time metric is dx^2 + dy^2 + (c dt)^2; auto follows the speeds",
    )
    defaults: SharedFields = Field(SharedFields(), description="values for agents that set none")
    agents: Annotated[list[AgentEntry], Field(min_length=1, max_length=MOST_AGENTS)] = Field(
        description="the moving things, in the order of the outputs"
    )
    events: Annotated[list[EventFile], Field(max_length=MOST_EVENTS)] = Field(
        [], description="what becomes different on the way, and nobody knows beforehand"
    )
    groups: Annotated[list[GroupFile], Field(max_length=MOST_PAIRS)] = Field(
        [], description="agents whose pairs share settings"
    )
    pairs: Annotated[list[PairFile], Field(max_length=MOST_PAIRS)] = Field(
        [], description="what differs from: every pair collides at the sum of its radii"
    )
    overlap: Literal["refuse", "ease"] = Field(
        "refuse",
        description="what becomes of agents that start too near each other; ease: they go apart",
    )
    robust: RobustFile = Field(RobustFile(), description="what the plan has to forgive")
    seeding: SeedingFile = Field(SeedingFile(), description="how initial curves are found")
    solver: SolverFile = Field(SolverFile(), description="how curves are optimised")


def scene_schema() -> dict[str, Any]:
    """The JSON Schema of scene files, for editors."""
    schema = SceneFile.model_json_schema()
    _drop_null_defaults(schema)
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "stplan scene, format 1"
    return schema


def _drop_null_defaults(part: Any) -> None:
    """A key without a default is just optional; null is no value of the format."""
    if isinstance(part, dict):
        if "default" in part and part["default"] is None:
            del part["default"]
        part = list(part.values())
    if isinstance(part, list):
        for inner in part:
            _drop_null_defaults(inner)
