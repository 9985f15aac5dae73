"""The certificate on hand-made scenes whose outcome is known."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.certify.certificate import Certificate, certify
from stplan.problem.world_lines import WorldLines
from stplan.scene.reading.load import parse_scene
from stplan.world import build_free_space

ROOM = "{rectangle: [0, 0, 10, 4]}"
ONE = "  - {id: a, start: [1, 1], goal: [9, 1], radius: 0.5}"
STRAIGHT = [[1, 1, 0], [9, 1, 10]]


def check(agents: str, curves: dict[str, list], world: str = ROOM, more: str = "") -> Certificate:
    """The certificate of `curves` by id in a scene of `agents`."""
    head = f"map: {world}\n" if world else ""
    made = parse_scene(f"stplan: 1\nhorizon: 10\n{head}{more}agents:\n{agents}\n")
    arrays = [np.array(curve, dtype=float) for curve in curves.values()]
    return certify(made, build_free_space(made), WorldLines.from_curves(list(curves), arrays))


def only(certificate: Certificate) -> str:
    """The only violation."""
    assert not certificate.holds
    assert len(certificate.violations) == 1
    return certificate.violations[0]


def test_a_good_plan() -> None:
    found = check(ONE, {"a": STRAIGHT})
    assert found.holds
    assert found.smallest.who == ("a",)
    assert found.smallest.clearance == pytest.approx(0.5)
    assert found.summary.startswith("certificate holds; tightest a: 0.5 m")
    assert found.as_dict()["walls"]["rows"][0][:2] == ["a", pytest.approx(0.5)]


def test_too_near_a_wall() -> None:
    found = check(ONE, {"a": [[1, 1, 0], [5, 0.3, 5], [9, 1, 10]]})
    assert "a: 0.3 m from a wall at t = 5 s, (5, 0.3)" in only(found)
    assert found.walls[0].clearance == pytest.approx(-0.2)


def test_touching_a_wall_by_the_radius_is_not_enough() -> None:
    touching = only(check(ONE, {"a": [[1, 1, 0], [5, 0.5, 5], [9, 1, 10]]}))
    assert touching.endswith("; more than its radius 0.5 m is needed")
    # Further away by less than rounding could feign.
    hardly = only(check(ONE, {"a": [[1, 1, 0], [5, 0.5 + 1e-15, 5], [9, 1, 10]]}))
    assert "is needed, by more than rounding (1.4e-13 m)" in hardly


def test_outside_between_knots_and_at_a_knot() -> None:
    block = "{rectangle: [0, 0, 10, 4], obstacles: [{rectangle: [4, 0, 5, 2]}]}"
    assert only(check(ONE, {"a": STRAIGHT}, block)).startswith("a: leaves the free space at t = ")
    found = check(ONE, {"a": [[1, 1, 0], [5, 7, 5], [9, 1, 10]]})
    assert "leaves the free space at t = 5 s, (5, 7)" in only(found)
    assert found.walls[0].clearance == pytest.approx(-3.5)


def test_walls_and_pairs_that_are_off_are_counted() -> None:
    agents = (
        "  - {id: a, start: [1, 1], goal: [9, 1], weights: {wall: 0, collision: 0}}\n"
        "  - {id: b, start: [9, 1.1], goal: [1, 1.1], weights: {collision: 0}}\n"
        "  - {id: c, start: [5, 3], goal: [6, 3]}"
    )
    curves = {
        "a": [[1, 1, 0], [5, -9, 5], [9, 1, 10]],
        "b": [[9, 1.1, 0], [1, 1.1, 10]],
        "c": [[5, 3, 0], [6, 3, 10]],
    }
    found = check(agents, curves)
    assert found.holds
    assert (found.ignored_pairs, found.ignored_walls) == (1, 1)
    assert [spot.who for spot in found.pairs] == [("a", "c"), ("b", "c")]
    rule = "pairs:\n  - {between: [all, all], collide: false}\n"
    assert check(agents, curves, more=rule).ignored_pairs == 3
    assert check(agents, curves, more=rule).pairs == ()


@pytest.mark.parametrize(
    ("curve", "words"),
    [
        ([[1, 1, 0], [9, 1, 10.001]], "arrives at 10.001 s, after 10.0 s"),
        ([[1, 1.0000001, 0], [9, 1, 10]], "starts at"),
        ([[1, 1, 0.5], [9, 1, 10]], "starts at"),
        ([[1, 1, 0], [9, 1.0000001, 10]], "ends at"),
        ([[1, 1, 0], [5, 1, 6], [6, 1, 6], [9, 1, 10]], "time does not increase at knot 2"),
        (
            [[1, 1, 0], [2, 1, 5], [5, 1, 4], [6, 1, 3], [9, 1, 10]],
            "time does not increase at knot 2",
        ),
        ([[1, 1, 0], [5, np.nan, 6], [9, 1, 10]], "two finite knots"),
        ([[1, 1, 0]], "two finite knots"),
    ],
)
def test_broken_ends(curve: list, words: str) -> None:
    found = check(ONE, {"a": curve})
    sentence = only(found)
    # Nothing else can be said of such curves.
    assert found == Certificate((sentence,), (), (), 0, 0)
    assert sentence.startswith("a: ")
    assert words in sentence


def test_early_arrival_is_fine() -> None:
    assert check(ONE, {"a": [[1, 1, 0], [9, 1, 4]]}).holds


def test_missing_strange_and_double_agents() -> None:
    sentences = ("a: has no trajectory", "x: is not in the scene")
    assert check(ONE, {"x": STRAIGHT}) == Certificate(sentences, (), (), 0, 0)


def test_waypoints_in_order() -> None:
    agents = ONE.replace("radius", "waypoints: [[3, 2], [6, 2], [3, 2]], radius")
    way = [[1, 1, 0], [3, 2, 2], [6, 2, 4], [2, 2, 7], [9, 1, 10]]
    assert check(agents, {"a": way}).holds
    assert "waypoint 3 (3.0, 2.0) in order" in only(
        check(agents, {"a": [[1, 1, 0], [3, 2, 2], [6, 2, 4], [9, 1, 10]]})
    )
    near = [[1, 1, 0], [3, 2.00001, 2], [6, 2, 4], [2, 2, 7], [9, 1, 10]]
    assert "waypoint" in only(check(agents, {"a": near}))
    swapped = ONE.replace("radius", "waypoints: [[6, 1], [3, 1]], radius")
    assert "waypoint 2" in only(check(swapped, {"a": STRAIGHT}))


def test_one_segment_passes_waypoints_in_its_own_direction() -> None:
    agents = ONE.replace("radius", "waypoints: [[3, 1], [6, 1]], radius")
    assert check(agents, {"a": STRAIGHT}).holds


def test_a_given_path_is_followed() -> None:
    agents = "  - {id: a, path: [[1, 1, 0], [5, 2, 3], [9, 1, 8]], radius: 0.5}"
    given = [[1, 1, 0], [5, 2, 3], [9, 1, 8]]
    assert check(agents, {"a": given}).holds
    assert check(agents, {"a": [[1, 1, 0], [3, 1.5, 1.5], *given[1:]]}).holds
    cut = only(check(agents, {"a": [given[0], given[2]]}))
    assert cut.startswith("a: leaves its given path by ")
    assert "leaves its given path" in only(check(agents, {"a": [*given[:2], [9, 1, 7]]}))
    # In one coordinate alone.
    aside = only(check(agents, {"a": [given[0], [5, 2.5, 3], given[2]]}))
    assert aside == "a: leaves its given path by 0.5 m"
    ahead = only(check(agents, {"a": [given[0], [5.25, 2, 3], given[2]]}))
    assert ahead == "a: leaves its given path by 0.25 m"


def test_distances_are_said_to_six_digits() -> None:
    found = check(ONE, {"a": [[1, 1, 0], [5, 1 / 3, 5], [9, 1, 10]]})
    assert only(found) == (
        "a: 0.333333 m from a wall at t = 5 s, (5, 0.333333); more than its radius 0.5 m is needed"
    )


PAIR = (
    "  - {id: a, start: [1, 2], goal: [5, 2], after_arrival: %s}\n"
    "  - {id: b, start: [9, 2], goal: [1, 2]}"
)


def test_staying_and_vanishing() -> None:
    curves = {"a": [[1, 2, 0], [5, 2, 2]], "b": [[9, 2, 0], [1, 2, 10]]}
    sentence = only(check(PAIR % "stay", curves))
    assert sentence.startswith("a and b: 0 m apart at t = 5 s, (5, 2)")
    found = check(PAIR % "vanish", curves)
    assert found.holds
    # At 2 s the one vanishes at x = 5 while the other is at 9 - 0.8 * 2.
    assert found.pairs[0].clearance == pytest.approx(2.4 - 0.6)


def test_contact_at_exactly_the_distance_is_broken() -> None:
    agents = (
        "  - {id: a, start: [0, 0], goal: [8, 0], radius: 0.5}\n"
        "  - {id: b, start: [8, 1], goal: [0, 1], radius: 0.5}"
    )
    curves = {"a": [[0, 0, 0], [8, 0, 8]], "b": [[8, 1, 0], [0, 1, 8]]}
    assert "more than 1 m is needed" in only(check(agents, curves, world=""))
    closer = "pairs:\n  - {between: [a, b], distance: 0.75}\n"
    found = check(agents, curves, world="", more=closer)
    assert found.holds
    assert found.smallest.clearance == 0.25


def test_order_of_agents_does_not_matter() -> None:
    curves = {"a": [[1, 2, 0], [5, 2, 2]], "b": [[9, 2, 0], [1, 2, 10]]}
    turned = dict(reversed(curves.items()))
    for after in ("stay", "vanish"):
        assert check(PAIR % after, curves) == check(PAIR % after, turned)


@pytest.mark.parametrize("angle", [0.3, 1.9, 4.0])
def test_rigid_motions_change_nothing(angle: float) -> None:
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    def moved(point) -> list[float]:
        return (turn @ np.array(point[:2]) + [17.0, -5.0]).tolist() + list(point[2:])

    def certificate(place) -> Certificate:
        ways = {
            "a": [[1, 1, 0], [4, 2, 3], [9, 3, 9]],
            "b": [[9, 1, 0], [5, 1.2, 5], [1, 3, 10]],
        }
        agents = "\n".join(
            f"  - {{id: {name}, start: {place(way[0][:2])}, goal: {place(way[-1][:2])}}}"
            for name, way in ways.items()
        )
        ring = [place(corner) for corner in ([0, 0], [10, 0], [10, 4], [0, 4])]
        curves = {name: [place(knot) for knot in way] for name, way in ways.items()}
        return check(agents, curves, f"{{polygon: {ring}}}")

    still, gone = certificate(list), certificate(moved)
    assert still.holds
    assert gone.holds
    for before, after in zip(still.pairs + still.walls, gone.pairs + gone.walls, strict=True):
        assert after.clearance == pytest.approx(before.clearance, abs=1e-9)
    assert gone.pairs[0].time == pytest.approx(still.pairs[0].time)
    assert gone.pairs[0].place == pytest.approx(moved(still.pairs[0].place))
