"""How often and how fast seeds are found, on generated families of scenes.

Every draw is a scene with random parameters that depend on the family's name and the draw's number
alone. Timed is the seeder, not the building of the scene, of its free space or of the certificate;
scenes that go through every part of the portfolio and one of the same kind go first, untimed, so
that no compilation is measured.
"""

from __future__ import annotations

import time
import zlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from stplan.bench import families_open as wide
from stplan.bench import families_tight as tight
from stplan.callbacks import Progress, unheard
from stplan.certify.certificate import certify
from stplan.errors import SeedingError, UsageError
from stplan.problem.kinetic_cost import total_kinetic_cost
from stplan.problem.planning_problem import PlanningProblem
from stplan.scene.model import Scene, SeedingMethod
from stplan.seeding.portfolio import find_seed
from stplan.world import build_free_space

Draw = Callable[[np.random.Generator], Scene]

FIELD = "open field 0.06"
SMALL_DRAWS, FULL_DRAWS = 3, 20
# Seconds (s) a seed may take in search; small crowds need far fewer.
SMALL_LIMIT, FULL_LIMIT = 5.0, 60.0
# Families and methods that between them need every part of the portfolio.
WARM_UP: tuple[tuple[str, SeedingMethod], ...] = (
    ("corridor 3 r", "relaxation"),
    ("plus left", "search"),
)


@dataclass(frozen=True)
class Family:
    """Scenes of one kind and size.

    Attributes:
        kind: what families of different sizes have in common.
        name: unique, starts with the kind.
        draw: one scene from a seeded generator.
        small: whether it is measured when no full measurement is asked for.
        full: whether it is measured when one is.
    """

    kind: str
    name: str
    draw: Draw
    small: bool = True
    full: bool = True


@dataclass(frozen=True)
class Measurement:
    """One draw: `seconds` (s) of the seeder, and of the processor for it; ratio and finder only where
    it succeeded."""

    family: str
    draw: int
    agents: int
    success: bool
    seconds: float
    cpu_seconds: float
    kinetic_over_straight: float
    found_by: str
    reason: str


def open_field(rng: np.random.Generator, *, count: int, density: float) -> Scene:
    """Agents of random starts and goals in a square."""
    return wide.open_field(count, density, int(rng.integers(2**31)))


def crossing_flows(rng: np.random.Generator, *, count: int) -> Scene:
    """Two flows of random places cross at 1 m/s."""
    return wide.crossing_flows(count, 1.0, int(rng.integers(2**31)))


def circle(rng: np.random.Generator, *, count: int) -> Scene:
    """Antipodal agents, 1.6 to 2.4 diameters from their neighbours, at 0.5 to 1 m/s."""
    extent = count * float(rng.uniform(1.6, 2.4)) / (2.0 * np.pi)
    return wide.circle(count, extent, 2.0 * extent / float(rng.uniform(0.5, 1.0)))


def families() -> list[Family]:
    """All families, tight ones first."""
    found = [
        Family(
            "corridor", f"corridor {half:g} r", partial(tight.corridor_with_pocket, half_width=half)
        )
        for half in (3.0, 2.0, 1.5, 1.2, 1.05)
    ]
    found += [
        Family("plus", f"plus {name}", partial(tight.plus_crossing, turn=turn))
        for name, turn in (("straight", 2), ("left", 3), ("right", 1))
    ]
    found += [
        Family("door", f"door {side} a side", partial(tight.door, per_side=side), side < 6)
        for side in (3, 5, 10, 15, 20)
    ]
    found += [
        Family("warehouse", f"warehouse {robots}", partial(tight.warehouse, robots=robots), few)
        for robots, few in ((10, True), (20, False), (30, False))
    ]
    found += [
        Family("cabin", f"cabin {name} deep", partial(tight.cabin, depth=depth), depth == 1)
        for name, depth in (("one", 1), ("two", 2))
    ]
    found += [
        Family("pillars", f"pillars {agents}", partial(tight.pillars, agents=agents), agents == 16)
        for agents in (16, 24)
    ]
    return found + _open_families()


def _open_families() -> list[Family]:
    found = [
        Family(
            "open field",
            f"{FIELD} {count}",
            partial(open_field, count=count, density=0.06),
            count <= 100,
            count >= 50,
        )
        for count in (25, 50, 100, 500, 1000)
    ]
    found += [
        Family(
            "open field",
            f"open field {density:g} 100",
            partial(open_field, count=100, density=density),
            density < 0.2,
        )
        for density in (0.15, 0.25)
    ]
    found += [
        Family("crossing flows", f"crossing flows {count}", partial(crossing_flows, count=count),
               count == 32)
        for count in (32, 128, 512)
    ]  # fmt: skip
    found += [
        Family("lanes", f"lanes {count}, 2 heavy", partial(wide.heavy_lanes, count=count), few, not few)
        for count, few in ((22, True), (102, False))
    ]  # fmt: skip
    found += [
        Family("circle", f"circle {count}", partial(circle, count=count), count == 35)
        for count in (35, 100)
    ]
    return found


def chosen_families(names: Iterable[str], *, full: bool) -> list[Family]:
    """Families of the small or the full measurement; `names` (or kinds) narrows them down.

    A family named in full is measured in either.

    Raises:
        UsageError: a name is neither a family's nor a kind's.
    """
    everything = families()
    usual = [one for one in everything if (one.full if full else one.small)]
    wanted = [name.strip() for name in names if name.strip()]
    known = {one.kind for one in everything} | {one.name for one in everything}
    unknown = [name for name in wanted if name not in known]
    if unknown:
        kinds = ", ".join(dict.fromkeys(one.kind for one in everything))
        raise UsageError(f"there is no family {unknown[0]!r}; expected one of {kinds}")
    if not wanted:
        return usual
    return [
        one for one in everything if one.name in wanted or (one.kind in wanted and one in usual)
    ]


def draw_scene(family: Family, draw: int) -> Scene:
    """The scene of one draw, the same every time."""
    return family.draw(np.random.default_rng([zlib.crc32(family.name.encode()), draw]))


def measure(
    chosen: Sequence[Family], draws: int, time_limit: float, *, progress: Progress
) -> list[Measurement]:
    """Seed every draw of every family, after untimed ones."""
    found: list[Measurement] = []
    progress("warm-up")
    for early in families():
        for name, method in WARM_UP:
            if early.name == name:
                measure_one(early, draws, time_limit, method)
    warm: set[str] = set()
    for family in chosen:
        if family.kind not in warm:
            progress(f"{family.name}: warm-up")
            measure_one(family, draws, time_limit)
            warm.add(family.kind)
        for draw in range(draws):
            one = measure_one(family, draw, time_limit)
            found.append(one)
            outcome = one.found_by if one.success else f"failed, {one.reason}"
            progress(f"{family.name}: draw {draw + 1} of {draws}: {one.seconds:.3f} s, {outcome}")
    return found


def measure_one(
    family: Family, draw: int, time_limit: float, method: SeedingMethod = "auto"
) -> Measurement:
    """Seed one draw; a seed counts when its certificate holds."""
    scene = draw_scene(family, draw)
    scene = replace(scene, seeding=replace(scene.seeding, time_limit=time_limit, method=method))
    free_space = build_free_space(scene)
    problem = PlanningProblem.from_scene(scene, free_space)
    failed = Measurement(family.name, draw, len(scene.agents), False, 0.0, 0.0, np.nan, "", "")
    started, cpu_started = time.perf_counter(), time.process_time()
    try:
        seed = find_seed(problem, progress=unheard)
    except SeedingError as error:
        failed = _timed(failed, started, cpu_started)
        return replace(failed, reason=str(error).splitlines()[0])
    failed = _timed(failed, started, cpu_started)
    certificate = certify(scene, free_space, seed.world_lines)
    if not certificate.holds:
        return replace(failed, reason=certificate.violations[0])
    curves = [seed.world_lines.curve(agent) for agent in range(len(scene.agents))]
    straight = wide.straight_kinetic_cost(scene)
    ratio = total_kinetic_cost(problem.masses, curves) / straight if straight > 0 else np.nan
    return replace(
        failed,
        success=True,
        kinetic_over_straight=ratio,
        found_by=seed.found_by,
    )


def _timed(one: Measurement, started: float, cpu_started: float) -> Measurement:
    """`one` with what the clock and the processor's show since they stood at the given times."""
    return replace(
        one,
        seconds=time.perf_counter() - started,
        cpu_seconds=time.process_time() - cpu_started,
    )


def growth_exponent(measurements: Sequence[Measurement]) -> float | None:
    """Exponent p of median time ~ agents^p on the open field, None of fewer than two sizes."""
    seconds: dict[int, list[float]] = {}
    for one in measurements:
        if one.family.startswith(FIELD) and one.success:
            seconds.setdefault(one.agents, []).append(one.seconds)
    if len(seconds) < 2:
        return None
    sizes = sorted(seconds)
    medians = [float(np.median(seconds[size])) for size in sizes]
    return float(np.polyfit(np.log(sizes), np.log(medians), 1)[0])
