"""Initial curves by a portfolio of two families, each falling back on the other.

In the open, relaxation: straight rods pushed apart, no search. In tight spaces, search on a roadmap.
`method: auto` starts with relaxation where every agent's straight way is clear of the walls and with
search elsewhere; `method: dijkstra` is the paper's own. Whatever found them, curves are polished,
given their knots, and proven clear.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stplan.arrays import FloatArray
from stplan.errors import SeedingError
from stplan.scene.model import Scene
from stplan.seeding.diagnosis import hopeless
from stplan.seeding.dijkstra import dijkstra_curves
from stplan.seeding.geodesic import geodesic_curves
from stplan.seeding.meeting_places import MeetingPlace, with_meeting_places
from stplan.seeding.polish import prepare_seed
from stplan.seeding.relaxation import relax
from stplan.seeding.rods import RodProblem, verify, wall_clearance
from stplan.seeding.search import search_curves
from stplan.world import FreeSpace, build_seeding_mesh, disconnected_agents
from stplan.world_lines import WorldLines

Progress = Callable[[str], None]

# Knots of a string while it relaxes.
RELAXATION_KNOTS = 40
# Sweeps before search takes over, where it may.
PATIENT_SWEEPS = 400
MOST_SWEEPS = 4000


@dataclass(frozen=True)
class Seed:
    """Initial curves, proven clear.

    Attributes:
        found_by: the part of the portfolio that found them.
        record: repeatable figures of the search, for the report.
        meetings: places that the curves pass so that pairs meet there, at any times.
    """

    world_lines: WorldLines
    found_by: str
    record: dict[str, Any] = field(default_factory=dict)
    meetings: tuple[MeetingPlace, ...] = ()


@dataclass
class _Attempts:
    """What has been tried so far."""

    curves: list[FloatArray] | None = None
    found_by: str = ""
    record: dict[str, Any] = field(default_factory=dict)
    reasons: list[str] = field(default_factory=list)


def find_seed(scene: Scene, free_space: FreeSpace | None, *, progress: Progress) -> Seed:
    """Clear initial curves for every agent of `scene`.

    Raises:
        SeedingError: none were found; the message says whom it concerns, and whether that is proven.
    """
    problem = RodProblem.from_scene(scene, free_space)
    problem, meetings = with_meeting_places(problem, scene, free_space)
    attempts = _Attempts()
    _refuse_hopeless(scene, problem, free_space)
    for part in _parts(scene, problem):
        if part == "relaxation":
            _relax(scene, problem, free_space, attempts, progress)
        else:
            _search(scene, problem, free_space, attempts, progress)
        if attempts.curves is not None:
            break
    if attempts.curves is None:
        raise SeedingError("no collision-free initial curves: " + "\n  ".join(attempts.reasons))
    curves = prepare_seed(
        problem,
        attempts.curves,
        scene.solver.knots,
        scene.seeding.margin,
        scene.seeding.rng_seed,
    )
    faults = verify(problem, curves)
    if faults:
        raise SeedingError("initial curves are not clear: " + "; ".join(faults))
    progress(f"seed found by {attempts.found_by}")
    lines = WorldLines.from_curves(problem.agent_ids, curves)
    return Seed(lines, attempts.found_by, attempts.record, meetings)


def _refuse_hopeless(scene: Scene, problem: RodProblem, free_space: FreeSpace | None) -> None:
    """Raise where it is proven that no clear curves exist: no search could help."""
    sentences = [sentence for _, sentence in disconnected_agents(scene, free_space)]
    sentences = sentences or [reason.sentence for reason in hopeless(problem, free_space)]
    if sentences:
        raise SeedingError("no collision-free curves exist: " + "\n  ".join(sentences))


def _parts(scene: Scene, problem: RodProblem) -> list[str]:
    """Parts of the portfolio in the order they are tried."""
    method = scene.seeding.method
    if method != "auto":
        return [method]
    if _straight_ways_are_clear(problem):
        return ["relaxation", "search"]
    return ["search", "relaxation"]


def _straight_ways_are_clear(problem: RodProblem) -> bool:
    """Whether walls leave every agent its straight way through its waypoints."""
    for agent in range(problem.num_agents):
        stops = np.vstack([problem.starts[agent], problem.waypoints[agent], problem.goals[agent]])
        way = np.column_stack([stops, np.arange(len(stops))])
        if wall_clearance(problem, agent, way) <= problem.radii[agent]:
            return False
    return True


def _relax(
    scene: Scene,
    problem: RodProblem,
    free_space: FreeSpace | None,
    attempts: _Attempts,
    progress: Progress,
) -> None:
    settings = scene.seeding
    ways = None
    if not _straight_ways_are_clear(problem):
        found = geodesic_curves(problem, free_space)
        ways = [way for way in found if way is not None]
        if len(ways) < len(found):
            attempts.reasons.append("relaxation needs a way along the walls for every agent")
            return
    progress("seeding by relaxation")
    result = relax(
        problem,
        ways,
        num_knots=scene.solver.knots or RELAXATION_KNOTS,
        margin=settings.margin,
        time_limit=settings.time_limit,
        rng_seed=settings.rng_seed,
        max_sweeps=PATIENT_SWEEPS if settings.method == "auto" else MOST_SWEEPS,
    )
    if result.solved:
        attempts.curves = result.curves
        attempts.found_by = "relaxation"
        attempts.record = {"sweeps": result.sweeps, "retensions": result.retensions}
        return
    names = ", ".join(
        f"{problem.agent_ids[a]} and {problem.agent_ids[b]}" for a, b in result.stuck[:5]
    )
    attempts.reasons.append(f"relaxation left {len(result.stuck)} pairs touching: {names}")


def _search(
    scene: Scene,
    problem: RodProblem,
    free_space: FreeSpace | None,
    attempts: _Attempts,
    progress: Progress,
) -> None:
    settings = scene.seeding
    if settings.method == "dijkstra":
        mesh = build_seeding_mesh(scene, free_space)
        result = dijkstra_curves(problem, free_space, mesh, settings=settings, progress=progress)
    else:
        result = search_curves(problem, free_space, settings=settings, progress=progress)
    if result.curves is not None:
        attempts.curves = result.curves
        attempts.found_by = (
            "dijkstra" if settings.method == "dijkstra" else f"search ({result.part})"
        )
        attempts.record = {"margin": result.margin, "tries": result.tries}
        return
    for reason in result.diagnosis:
        proof = "proven" if reason.proven else "not found within the limit"
        attempts.reasons.append(f"{reason.sentence} ({proof})")
    if not result.diagnosis:
        attempts.reasons.append(
            f"not found within {scene.seeding.time_limit:g} s; raise seeding.time_limit to go on"
        )
