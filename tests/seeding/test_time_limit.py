"""The time limit: whatever is going on ends at its next look at the clock, and looks are never far apart."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

from stplan import deadline
from stplan.bench import families_tight as tight
from stplan.errors import SeedingError
from stplan.multistart import best_seeds
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.verification import verify
from stplan.scene.model import Scene
from stplan.world import build_free_space
from tests.seeding.tight_families import door

NO_END = 1e9
# Looks that may follow the one at which time was up: those who called the work look once more themselves.
LAST_LOOKS = 12


class Clock:
    """Goes on by a second whenever somebody looks at it."""

    def __init__(self) -> None:
        self.looks = 0
        self.heard: list[Callable[[], None]] = []

    def thread_time(self) -> float:
        self.looks += 1
        for look in self.heard:
            look()
        return float(self.looks)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made = Clock()
    monkeypatch.setattr("stplan.compiled.time", made)
    return made


SCENES: dict[str, Callable[[], Scene]] = {
    "door": lambda: door(np.random.default_rng(3), per_side=3),
    "warehouse": lambda: tight.warehouse(np.random.default_rng(1), robots=5),
    "dijkstra": lambda: with_method(door(np.random.default_rng(1), per_side=2), "dijkstra"),
    "search": lambda: with_method(door(np.random.default_rng(3), per_side=4), "search"),
}


def with_method(scene: Scene, method: str) -> Scene:
    return replace(scene, seeding=replace(scene.seeding, method=method))


ENDED = {"time limit", "unprepared"}


def seeded(scene: Scene, limit: float) -> bool:
    """Whether there are seeds within a limit; they are clear, and else it is said that the limit ended it."""
    scene = replace(scene, seeding=replace(scene.seeding, time_limit=limit))
    problem = PlanningProblem.from_scene(scene, build_free_space(scene))
    seeds, kinds = (), set()
    try:
        seeds = best_seeds(problem, progress=lambda line: None).seeds
    except SeedingError as error:
        kinds = {reason.kind for reason in error.reasons}
    assert bool(seeds) != bool(kinds & ENDED)
    for seed in seeds:
        assert not verify(problem, list(seed.world_lines.curves()))
    return bool(seeds)


@pytest.mark.parametrize("name", SCENES)
def test_all_ends_soon_after_the_limit_wherever_it_strikes(name: str, clock: Clock) -> None:
    scene = SCENES[name]()
    assert seeded(scene, NO_END)
    whole = clock.looks
    found = set()
    for limit in np.unique(np.geomspace(1.0, 0.9 * whole, 5).astype(int)).tolist():
        began = clock.looks
        found.add(seeded(scene, float(limit)))
        # A tenth more is for the preparation of what was found.
        assert clock.looks - began <= 1.1 * limit + LAST_LOOKS
    assert False in found


WORK = (
    "stplan.seeding.search.safe_interval._search",
    "stplan.seeding.search.layered_dijkstra._settle",
    "stplan.seeding.search.joint._search",
    "stplan.seeding.search.joint_search.explore",
    "stplan.seeding.search.shortest_ways.shortest_path",
    "stplan.seeding.search.shortest_ways.triangulated",
    "stplan.seeding.search.graph._fill_hops",
    "stplan.seeding.search.medial_points.Voronoi",
    "stplan.seeding.shortcutting.shortcuts.shortcut_round",
    "stplan.seeding.elastic_bands.relaxation.sweep_bands",
)
# Calls of any of them between two looks, at most: an agent's legs, or its tries of even knots.
MOST_CALLS = 3


def test_between_two_looks_little_is_done(clock: Clock, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = dict.fromkeys(WORK, 0)
    seen = dict.fromkeys(WORK, False)

    def look() -> None:
        assert max(calls.values()) <= MOST_CALLS, calls
        calls.update(dict.fromkeys(WORK, 0))

    for path in WORK:
        module, _, name = path.rpartition(".")
        work = getattr(import_module(module), name)

        def counted(*values: object, path: str = path, work: Callable = work) -> object:
            calls[path] += 1
            seen[path] = True
            return work(*values)

        monkeypatch.setattr(path, counted)
    clock.heard.append(look)
    for make in SCENES.values():
        assert seeded(make(), NO_END)
    assert sum(seen.values()) >= len(WORK) - 2, seen


@pytest.mark.parametrize(
    ("chunk", "scene"),
    [
        ("stplan.seeding.search.safe_interval.CHUNK", "search"),
        ("stplan.seeding.search.layered_dijkstra.CHUNK", "dijkstra"),
        ("stplan.seeding.search.joint.CHUNK", "search"),
        ("stplan.seeding.shortcutting.shortcuts.CHUNK", "warehouse"),
    ],
)
def test_curves_do_not_depend_on_how_often_one_looks(
    chunk: str, scene: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def knots() -> bytes:
        made = SCENES[scene]()
        problem = PlanningProblem.from_scene(made, build_free_space(made))
        seeds = best_seeds(problem, progress=lambda line: None).seeds
        return b"".join(seed.world_lines.knots.tobytes() for seed in seeds)

    rarely = knots()
    monkeypatch.setattr(chunk, 1)
    assert knots() == rarely


def test_a_deadline_holds_within_its_block_only(clock: Clock) -> None:
    deadline.heed()
    with deadline.until(-NO_END):
        assert deadline.passed()
        with pytest.raises(deadline.OutOfTimeError):
            deadline.heed()
        with deadline.until(NO_END):
            deadline.heed()
        assert deadline.passed()
    assert not deadline.passed()
