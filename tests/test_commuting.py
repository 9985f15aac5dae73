"""Plans do not depend on where a scene lies, how it is turned, and in what units it is written."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from stplan.analysis.cost_bound import cost_bound
from stplan.analysis.detours import ways_alone
from stplan.analysis.paths import path_length
from stplan.cli.app import main
from stplan.errors import SeedingError
from stplan.multistart import own_cost
from stplan.planner import Plan, plan
from stplan.problem.planning_problem import PlanningProblem
from stplan.scene import parse_scene
from stplan.world import build_free_space

WALLED = """
stplan: 1
map:
  polygon: [[0, 0], [10, 0], [10, 6], [0, 6]]
  obstacles:
    - {polygon: [[4.6, 0], [5.0, 0], [5.0, 2.3], [4.6, 2.3]]}
    - {polygon: [[4.6, 3.7], [5.0, 3.7], [5.0, 6], [4.6, 6]]}
    - {polygon: [[7, 4], [8, 4.2], [7.6, 5]]}
horizon: 20
time_scale: 1.0
agents:
  - {id: a, start: [1, 1], goal: [9, 1], radius: 0.3, mass: 70, waypoints: [[2.5, 4]]}
  - {id: b, start: [9, 5], goal: [1, 5], radius: 0.35, mass: 80}
  - {id: c, start: [1, 3], goal: [9, 3], radius: 0.3, mass: 60, preferred_time: 14,
     weights: {arrival: 2.0, acceleration: 3.0}}
"""
OPEN = """
stplan: 1
horizon: 12
time_scale: 2.0
agents:
  - {id: a, start: [0, 0], goal: [9, 1], radius: 0.3, mass: 70}
  - {id: b, start: [9, 0], goal: [0, 1.2], radius: 0.35, mass: 80}
  - {id: c, start: [4, -5], goal: [5, 4], radius: 0.3, mass: 60}
"""
# Every setting that has a unit.
DETAILED = """
stplan: 1
map:
  polygon: [[-1, -6], [11, -6], [11, 6], [-1, 6]]
  obstacles: [{polygon: [[4, -1], [5, -1], [5, 1]]}]
  resolution: 0.5
horizon: 30
time_scale: 1.5
agents:
  - {id: a, start: [0, 0], goal: [9, 0.5], radius: 0.3, mass: 70, max_speed: 1.5, max_acceleration: 1.0,
     waypoints: [{at: [3, 2], window: [6, 12], dwell: 1.5}]}
  - {id: b, start: [9, -2], goal: [0, -1.5], radius: 0.4, mass: 50, start_time: 2, max_time: 28,
     start_velocity: [-0.2, -0.4], start_duration: 0.7, clearance: 0.1, weights: {regularity: 2.0}}
  - {id: bus, path: [[3, -4, 1], [6, -4, 9]], radius: 0.5, mass: 200}
  - {id: c, start: [1, -5], goal: [9, -5], radius: 0.3, mass: 60, preferred_time: 20,
     weights: {arrival: 1.0}}
pairs:
  - {between: [a, b], distance: 0.9, meet: {within: 1.2, window: [8, 20]}}
  - {between: [b, c], grouping: 0.5}
solver: {mu: 0.2, alpha: 40, barrier_range: 0.2}
"""
POINTS = ("start", "goal", "at")


@dataclass(frozen=True)
class Copy:
    """x' = length R(angle) x + shift, t' = time t, m' = mass m."""

    length: float = 1.0
    time: float = 1.0
    mass: float = 1.0
    angle: float = 0.0
    shift: tuple[float, float] = (0.0, 0.0)

    @property
    def cost(self) -> float:
        """By which costs are multiplied."""
        return self.mass * self.length**2 / self.time

    def point(self, point: list[float]) -> list[float]:
        cosine, sine = (math.cos(self.angle), math.sin(self.angle)) if self.angle else (1.0, 0.0)
        x, y = (self.length * value for value in point[:2])
        return [cosine * x - sine * y + self.shift[0], sine * x + cosine * y + self.shift[1]]

    def of(self, text: str) -> str:
        """The scene, copied."""
        return yaml.safe_dump(self._copied(yaml.safe_load(text), ""), sort_keys=False)

    def _copied(self, value: Any, key: str) -> Any:
        factors = {
            "horizon": self.time, "start_time": self.time, "start_duration": self.time, "max_time": self.time,
            "preferred_time": self.time, "window": self.time, "dwell": self.time,
            "radius": self.length, "clearance": self.length, "distance": self.length,
            "within": self.length, "resolution": self.length, "barrier_range": self.length,
            "alpha": 1.0 / self.length, "mass": self.mass, "mu": self.cost,
            "time_scale": self.length / self.time, "max_speed": self.length / self.time,
            "max_acceleration": self.length / self.time**2, "acceleration": self.cost,
            "regularity": self.cost, "arrival": self.cost / self.time**2,
            "grouping": self.cost / self.length**2,
        }  # fmt: skip
        if key in ("polygon", "waypoints"):
            return [
                self.point(one) if isinstance(one, list) else self._copied(one, "") for one in value
            ]
        if key == "start_velocity":
            turned = Copy(length=self.length / self.time, angle=self.angle)
            return turned.point(value)
        if key in POINTS and isinstance(value, list):
            return self.point(value)
        if key == "path":
            return [[*self.point(knot), self.time * knot[2]] for knot in value]
        if isinstance(value, dict):
            return {name: self._copied(own, name) for name, own in value.items()}
        if isinstance(value, list):
            return [self._copied(own, key) for own in value]
        return factors[key] * value if key in factors else value


UNITS = {
    "millimetres": Copy(length=1e3),
    "micrometres": Copy(length=1e6),
    "kilometres": Copy(length=1e-3),
    "as small as cells": Copy(length=1e-6),
    "milliseconds": Copy(time=1e3),
    "kiloseconds": Copy(time=1e-3),
    "tonnes": Copy(mass=1e-3),
    "grams": Copy(mass=1e3),
    "all": Copy(length=1e3, time=60.0, mass=0.5),
}
PLACES = {
    "UTM": Copy(shift=(5e5, 4.6e6)),
    "just south of the equator": Copy(shift=(3e5, 9.9e6)),
    "Web Mercator": Copy(shift=(8e6, 8e6)),
    "far": Copy(shift=(1e8, -1e8)),
    "a quarter turn": Copy(angle=0.5 * math.pi),
    "turned": Copy(angle=2.15),
    "turned, millimetres": Copy(length=1e3, angle=-1.0),
}
QUICK = ("solver.effort=quick", "solver.outer_iterations=3")


@cache
def planned(text: str, copy: Copy = Copy()) -> Plan:
    """The plan of a copy; it is certified in the copy's own coordinates."""
    found = plan(parse_scene(copy.of(text), overrides=QUICK))
    assert found.certificate.holds
    return found


def cost(found: Plan) -> float:
    assert found.trajectories is not None
    return own_cost(found.scene, found.trajectories)


@pytest.fixture(scope="module", params=["walled", "open", "detailed"])
def original(request) -> tuple[str, Plan]:
    text = {"walled": WALLED, "open": OPEN, "detailed": DETAILED}[request.param]
    return text, planned(text)


@pytest.mark.parametrize("name", UNITS | PLACES)
def test_a_copy_has_the_same_plan(original, name) -> None:
    text, first = original
    copy = (UNITS | PLACES)[name]
    other = planned(text, copy)
    assert other.exit_status == first.exit_status == 0
    assert cost(other) / copy.cost == pytest.approx(cost(first), rel=1e-6)
    # The same curves, not only as good ones.
    assert first.trajectories is not None
    assert other.trajectories is not None
    knots, moved = first.trajectories.knots, other.trajectories.knots
    places = np.array([copy.point(place) for place in knots[:, :2].tolist()])
    rounding = 1e-6 * copy.length
    assert np.abs(moved[:, :2] - places).max() < rounding + 1e-15 * np.abs(places).max()
    assert np.abs(moved[:, 2] - copy.time * knots[:, 2]).max() < 1e-6 * copy.time


@pytest.mark.parametrize("name", UNITS)
def test_reports_are_in_the_units_of_the_scene(original, name) -> None:
    text, first = original
    copy = UNITS[name]
    ours, theirs = (found.report.as_dict() for found in (first, planned(text, copy)))
    assert set(ours["costs"]) == set(theirs["costs"])
    for term, own in ours["costs"].items():
        assert theirs["costs"][term] / copy.cost == pytest.approx(own, rel=1e-6, abs=1e-9), term
    for key in ("mu", "energy"):
        assert theirs["scales"][key] / copy.cost == pytest.approx(ours["scales"][key], rel=1e-6)
    for key, unit in (("objective", copy.cost), ("mu", copy.cost), ("clearance", copy.length)):
        values = [[done[key] for done in one["outer_iterations"]] for one in (ours, theirs)]
        assert np.array(values[1]) / unit == pytest.approx(np.array(values[0]), rel=1e-6)
    assert theirs["bound"]["least"] / copy.cost == pytest.approx(ours["bound"]["least"], rel=1e-6)


@pytest.mark.parametrize("name", PLACES)
def test_what_is_said_of_a_run_does_not_depend_on_where_it_lies(name) -> None:
    copy = PLACES[name]
    said = []
    for found, unit in ((planned(WALLED), 1.0), (planned(WALLED, copy), copy.length)):
        problem = PlanningProblem.from_scene(found.scene, build_free_space(found.scene))
        assert found.trajectories is not None
        bound = cost_bound(problem.in_frame, found.trajectories)
        assert bound.total == pytest.approx(found.report.as_dict()["bound"]["least"], rel=1e-6)
        lengths = [path_length(way) for way in ways_alone(problem) if way is not None]
        said.append([*(bound.least / unit**2), *(length / unit for length in lengths)])
    assert said[1] == pytest.approx(said[0], rel=1e-6)


NARROW = WALLED.replace("[5.0, 2.3], [4.6, 2.3]", "[5.0, 3.15], [4.6, 3.15]")


@pytest.mark.parametrize("name", UNITS | PLACES)
def test_a_copy_of_what_is_refused_is_refused_for_the_same_reason(name) -> None:
    copy = (UNITS | PLACES)[name]
    found = []
    for one in (Copy(), copy):
        with pytest.raises(SeedingError) as error:
            planned(NARROW, one)
        found.append(error.value.reasons)
    ours, theirs = found
    assert [reason.agents for reason in ours] == [reason.agents for reason in theirs]
    assert ours
    for mine, other in zip(ours, theirs, strict=True):
        assert mine.kind == other.kind == "not connected"
        for figure in ("widest", "radius"):
            assert other.figures[figure] / copy.length == pytest.approx(
                mine.figures[figure], rel=1e-6
            )
        assert mine.place is not None
        assert other.place == pytest.approx(copy.point(list(mine.place)), rel=1e-9)


def test_a_scene_in_utm_from_the_command_line(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    copy = PLACES["just south of the equator"]
    Path("hall.yaml").write_text(copy.of("name: hall" + WALLED), encoding="utf-8")
    settings = [word for one in QUICK for word in ("--set", one)]
    for command in (
        ["solve", "hall.yaml", *settings],
        ["check", "outputs/hall"],
        ["improve", "outputs/hall", "--budget", "2"],
        ["explain", "outputs/hall"],
        ["plot", "outputs/hall"],
    ):
        with pytest.raises(SystemExit) as ended:
            main(command)
        assert ended.value.code == 0, command
    assert "certificate holds" in capsys.readouterr().out
