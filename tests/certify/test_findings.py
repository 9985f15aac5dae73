"""What is found is a value, is the same whenever it happens, and is said in full."""

from __future__ import annotations

import pkgutil
from dataclasses import FrozenInstanceError, fields, is_dataclass
from importlib import import_module

import numpy as np
import pytest

import stplan.certify
from stplan.certify.certificate import Certificate, certify
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene
from stplan.world import build_free_space

CURVES = {
    "ann": [[0, 0, 0], [1, 0.5, 2], [4, 0, 4], [4, 0, 6], [8, 0, 10]],
    "sam": [[0, 9, 1], [4, 1.5, 6], [8, 9, 9]],
    "tram": [[1, -3, 2], [9, -3, 8]],
}


def check(delay: float, dwell: float = 1.5, within: float = 1.6) -> Certificate:
    """The certificate of three who do all that can be asked for, `delay` seconds later."""
    from_, until = 3.5 + delay, 6 + delay
    scene = parse_scene(
        f"stplan: 1\nhorizon: {10 + delay}\nmap: {{rectangle: [-2, -5, 12, 11]}}\nagents:\n"
        f"  - {{id: ann, start: [0, 0], goal: [8, 0], start_time: {delay}, start_velocity: [0.5, 0.25],\n"
        f"     start_duration: 1.75, max_speed: 2, max_acceleration: 9,\n"
        f"     waypoints: [{{at: [4, 0], window: [{from_}, {until}], dwell: {dwell}}}]}}\n"
        f"  - {{id: sam, start: [0, 9], goal: [8, 9], start_time: {1 + delay}, max_speed: 3}}\n"
        f"  - {{id: tram, path: [[1, -3, {2 + delay}], [5, -3, {5 + delay}], [9, -3, {8 + delay}]]}}\n"
        f"pairs: [{{between: [ann, sam], meet: {{within: {within}, window: [{from_}, {until}]}}}}]\n"
    )
    later = np.array([0.0, 0.0, delay])
    curves = [np.array(curve) + later for curve in CURVES.values()]
    return certify(scene, build_free_space(scene), WorldLines.from_curves(list(CURVES), curves))


def rows(found: Certificate) -> list[list[float]]:
    """All numbers of a certificate, times last."""
    spots = [[spot.clearance, *spot.place, spot.time] for spot in (*found.pairs, *found.walls)]
    return [
        *spots,
        *([peak.allowed, peak.reached, peak.time] for peak in found.limits),
        *([one.distance, *one.place, one.time] for one in found.meetings),
    ]


@pytest.mark.parametrize("delay", [64.0, 1024.0])
def test_all_that_is_asked_is_the_same_at_any_time(delay: float) -> None:
    now, later = check(0.0), check(delay)
    assert now.holds
    assert later.holds
    assert len(now.pairs) == len(now.walls) == len(now.limits) == 3
    for first, second in zip(rows(now), rows(later), strict=True):
        assert second[:-1] == pytest.approx(first[:-1], abs=1e-9)
        assert second[-1] == pytest.approx(first[-1] + delay, abs=1e-9)
    assert [one.partition(" between ")[0] for one in check(delay, dwell=2.25).violations] == [
        "ann: does not pass waypoint 1 (4.0, 0.0) in order"
    ]
    (sentence,) = check(delay, within=1.4).violations
    assert sentence.startswith("ann and sam: come no nearer than 1.5 m")


def test_everything_is_in_the_report() -> None:
    found = check(0.0)
    shown = found.as_dict()
    assert shown["meetings"]["rows"] == [["ann", "sam", 1.6, 1.5, 6.0, 4.0, 0.75]]
    assert [row[:2] for row in shown["limits"]["rows"]] == [
        ["ann", "speed"], ["ann", "acceleration"], ["sam", "speed"],
    ]  # fmt: skip
    for key, spots in (("pairs", found.pairs), ("walls", found.walls)):
        columns = shown[key]["columns"]
        for row, spot in zip(shown[key]["rows"], spots, strict=True):
            named = dict(zip(columns, row, strict=True))
            assert (named["x"], named["y"]) == spot.place
            assert (named["clearance"], named["time"]) == (spot.clearance, spot.time)
    assert shown["smallest_clearance"][:2] == list(found.smallest.who)
    assert shown["not_demanded"] == {"pairs": 0, "walls": 0}
    assert 0.0 < shown["rounding"] < 1e-12


def test_of_equal_moments_the_first_is_named() -> None:
    scene = parse_scene(
        "stplan: 1\nhorizon: 9\nagents:\n  - {id: a, start: [0, 0], goal: [8, 0]}\n"
        "  - {id: b, start: [0, 1], goal: [8, 1]}\n"
    )
    curves = [np.array([[0, y, 0], [2, y, 2], [4, y, 4], [8, y, 8.0]]) for y in (0.0, 1.0)]
    (spot,) = certify(scene, None, WorldLines.from_curves(["a", "b"], curves)).pairs
    assert (spot.clearance, spot.time, spot.place) == (pytest.approx(0.4), 0.0, (0.0, 0.5))


def test_goals_that_are_places_are_reached_anywhere_in_them() -> None:
    scene = parse_scene(
        "stplan: 1\nhorizon: 9\nplaces: {exit: {line: [[8, 0], [8, 4]]}, den: {rectangle: [0, 6, 2, 9]}}\n"
        "agents:\n  - {id: a, start: [0, 0], goal: {any: [exit, den]}}\n"
    )

    def ending(x: float, y: float) -> Certificate:
        curve = np.array([[0.0, 0.0, 0.0], [x, y, 9.0]])
        return certify(scene, None, WorldLines.from_curves(["a"], [curve]))

    assert ending(8, 3.5).holds
    assert ending(1, 7).holds
    assert ending(7.75, 3.5).violations == (
        "a: ends at (7.75, 3.5), 0.25 m outside place exit or place den",
    )


def test_what_is_found_cannot_be_changed() -> None:
    found = check(0.0)
    for value in (found, found.pairs[0], found.walls[0], found.limits[0], found.meetings[0]):
        for field in fields(value):
            with pytest.raises(FrozenInstanceError):
                setattr(value, field.name, None)
    # Nor can anything that is handed on before.
    made = [
        value
        for module in pkgutil.iter_modules(stplan.certify.__path__, "stplan.certify.")
        for name, value in vars(import_module(module.name)).items()
        if is_dataclass(value) and value.__module__ == module.name and not name.startswith("_")
    ]
    assert len(made) > 8
    assert all(value.__dataclass_params__.frozen for value in made)
