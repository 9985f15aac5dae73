"""Whole plans of many agents: time and memory over their number, and what a cluster would make of it.

Every scene is planned in a process of its own, by one process and by as many as there are cores, so that
both are measured in one run. Processor time adds up all processes.

For a cluster the plan of a wide field is taken apart: parts are optimised at the same time as far as there
are workers for them, what one process does (preparation, initial curves, the split, certificate and files)
is not, and everybody's curves travel to the workers once a group of parts. Each is fitted to a power of the
number of agents.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from stplan.bench import families_open as wide
from stplan.bench import families_tight as tight
from stplan.bench.scaling import growth
from stplan.bench.solves import in_own_process, warm_up, written_plan
from stplan.callbacks import Progress
from stplan.errors import SeedingError, StplanError
from stplan.memory import MIB, processor_time, total_peak
from stplan.scene.model import Scene

FIELD = "open field, ways of at most 60 m"
# Bytes a second that a cluster's network carries: 1 Gbit/s.
BANDWIDTH = 125e6
# Clusters that are foretold: of so many workers, for so many agents.
AGENTS, WORKERS = (10_000, 100_000), (1, 8, 64)
# Everybody's curves travel so often: in three sweeps, each in some eight groups of parts, and there and back.
JOURNEYS = 3 * 8 * 2
# For initial curves of halls, s.
SEEDING_TIME = 150.0


@dataclass(frozen=True)
class ScaleCase:
    """A scene of many agents.

    Attributes:
        asked: seconds with two cores, None where nothing is asked.
        small: whether it is measured when no full measurement is asked for.
    """

    family: str
    agents: int
    scene: Callable[[], Scene]
    asked: float | None = None
    small: bool = False


@dataclass(frozen=True)
class Scaled:
    """A scene as it was planned.

    Attributes:
        workers: processes that optimise parts.
        seconds: of wall time, from the free space to the files.
        processor_seconds: of all processes.
        parts_seconds: of them, those for parts that were optimised on their own.
        peak_mib: greatest resident memory of the process, and of the largest worker.
        knots: of all agents.
        kinetic: cost over that of straight lines.
    """

    family: str
    agents: int
    workers: int
    asked: float | None
    status: str
    certified: bool = False
    seconds: float = np.nan
    processor_seconds: float = np.nan
    seed_seconds: float = np.nan
    parts_seconds: float = np.nan
    peak_mib: float = np.nan
    knots: int = 0
    kinetic: float = np.nan


def cases() -> list[ScaleCase]:
    """All cases, in the order of the table."""
    fields = [(250, None, True), (500, None, True), (1000, 15.0, False), (2000, None, False)]
    fields += [(4000, 90.0, False), (8000, None, False), (10000, 300.0, False)]
    found = [
        ScaleCase(FIELD, count, partial(wide.wide_field, count), asked, small)
        for count, asked, small in fields
    ]
    found += [
        ScaleCase(f"crossing flows, density {density:g}", 512, scene, asked)
        for density, asked, scene in (
            (0.12, 8.0, partial(wide.crossing_flows, 512, 0.5)),
            (0.24, 20.0, partial(wide.crossing_flows, 512, 0.5, density=0.24)),
        )
    ]
    found += [
        ScaleCase(
            "warehouse, single-lane aisles", robots, partial(_warehouse, *size), asked, robots < 50
        )
        for robots, asked, size in (
            (40, None, (40, 8, 6)),
            (200, 35.0, (200, 17, 15)),
            (500, 150.0, (500, 27, 24)),
        )
    ]
    found += [
        ScaleCase("pillars, single-lane gaps", count, partial(_pillars, count), asked)
        for count, asked in ((200, 35.0), (400, 150.0))
    ]
    return found


def _warehouse(robots: int, columns: int, rows: int) -> Scene:
    rng = np.random.default_rng(0)
    return _with_time(tight.warehouse(rng, robots=robots, columns=columns, rows=rows))


def _pillars(count: int) -> Scene:
    return _with_time(tight.pillars(np.random.default_rng(0), agents=count))


def _with_time(scene: Scene) -> Scene:
    """`scene` with as much time for initial curves as the largest halls are asked to be planned in."""
    return replace(scene, seeding=replace(scene.seeding, time_limit=SEEDING_TIME))


def measure(
    chosen: Sequence[ScaleCase], *, largest: int, workers: int, progress: Progress
) -> list[Scaled]:
    """Plan every case of at most `largest` agents by one process and by `workers`."""
    found = []
    for case in (one for one in chosen if one.agents <= largest):
        for count in sorted({1, workers}):
            found.append(in_own_process(_measured, case, count))
            progress(outcome(found[-1]))
    return found


def _measured(case: ScaleCase, workers: int) -> Scaled:
    warm_up()
    scene = case.scene()
    cpu, wall = processor_time(), time.perf_counter()
    blank = Scaled(case.family, len(scene.agents), workers, case.asked, "not found")
    try:
        planned = written_plan(scene, num_workers=workers)
    except SeedingError:
        return blank
    except StplanError as error:
        return replace(blank, status=str(error))
    times = planned.run.optimisation
    return replace(
        blank,
        status=planned.status,
        certified=planned.certificate.holds,
        seconds=time.perf_counter() - wall,
        processor_seconds=processor_time() - cpu,
        seed_seconds=planned.run.seconds["seed"],
        parts_seconds=np.nan if times is None else times.parts,
        peak_mib=total_peak() / MIB,
        knots=len(planned.seed.knots),
        kinetic=planned.report.metrics.kinetic_over_straight or np.nan,
    )


def outcome(one: Scaled) -> str:
    """A plan in one line."""
    return (
        f"{one.family}: {one.agents} agents, {one.workers} processes: {one.status}, {one.seconds:.1f} s, "
        f"{one.processor_seconds:.1f} s of processor time, {one.peak_mib:.0f} MiB"
    )


@dataclass(frozen=True)
class Cluster:
    """What a field of many agents would take on so many workers, s.

    Attributes:
        alone: what one process does.
        parts: the parts, shared out.
        transfer: curves on their way to the workers and back.
    """

    agents: int
    workers: int
    alone: float
    parts: float
    transfer: float

    @property
    def seconds(self) -> float:
        """All of it."""
        return self.alone + self.parts + self.transfer


def clusters(measured: Sequence[Scaled]) -> list[Cluster]:
    """Foretold from plans of wide fields by one process, of at least two sizes; else none."""
    fields = [
        one
        for one in measured
        if one.family == FIELD and one.workers == 1 and one.parts_seconds > 0
    ]
    sizes = [float(one.agents) for one in fields]
    if len(set(sizes)) < 2:
        return []
    rest = [one.processor_seconds - one.parts_seconds for one in fields]
    parts = [one.parts_seconds for one in fields]
    knots = float(np.mean([one.knots / one.agents for one in fields]))
    found = []
    for count in AGENTS:
        alone, shared = (_foretold(sizes, values, count) for values in (rest, parts))
        # Every worker gets all curves, through one cable.
        sent = JOURNEYS * count * knots * 3 * 8 / BANDWIDTH
        found += [Cluster(count, many, alone, shared / many, many * sent) for many in WORKERS]
    return found


def _foretold(sizes: Sequence[float], values: Sequence[float], size: float) -> float:
    """The fitted power at a `size`, through the largest value."""
    return values[-1] * (size / sizes[-1]) ** growth(sizes, values)
