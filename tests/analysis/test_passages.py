"""Narrow places on the widest ways: where, how wide, and who has to pass them."""

from __future__ import annotations

import pytest

from stplan.analysis.passages import passages
from stplan.problem.planning_problem import prepare
from stplan.scene.model import Scene
from stplan.scene.reading.load import parse_scene

# A wall at x = 5 with a gap of 0.6 m around y = 1.8.
GAP = (
    "{rectangle: [0, 0, 10, 4], obstacles: "
    "[{rectangle: [4.9, 0, 5.1, 1.5]}, {rectangle: [4.9, 2.1, 5.1, 4]}]}"
)
SAM = "id: sam, start: [1, 2], goal: [9, 2], radius: 0.25"
ANN = "id: ann, start: [9, 1], goal: [1, 1], radius: 0.2"


def scene_of(*agents: str, world: str = "") -> Scene:
    listed = "".join(f"  - {{{agent}}}\n" for agent in agents)
    head = f"map: {world}\n" if world else ""
    return parse_scene(f"stplan: 1\nhorizon: 20\n{head}agents:\n{listed}")


def test_a_narrow_place_and_who_has_to_pass_it():
    (passage,) = passages(prepare(scene_of(SAM, ANN, world=GAP)))
    assert passage.agents == ("sam", "ann")
    assert passage.half_width == pytest.approx(0.3, abs=1e-3)
    assert passage.radius == 0.25
    assert passage.place == pytest.approx((5.0, 1.8), abs=0.01)
    assert (passage.blocked, passage.stop, passage.side_by_side) == ((), False, False)


def test_who_does_not_fit_through():
    (passage,) = passages(prepare(scene_of(SAM.replace("0.25", "0.31"), ANN, world=GAP)))
    assert passage.blocked == ("sam",)


def test_side_by_side():
    small = (SAM.replace("0.25", "0.1"), ANN.replace("0.2", "0.1"))
    (passage,) = passages(prepare(scene_of(*small, world=GAP.replace("2.1", "2.0"))))
    assert passage.side_by_side


def test_a_stop_near_a_wall():
    scene = scene_of("id: sam, start: [0.26, 2], goal: [4, 2], radius: 0.25", world=GAP)
    (passage,) = passages(prepare(scene))
    assert (passage.stop, passage.place) == (True, (0.26, 2.0))
    assert passage.half_width == pytest.approx(0.26)


def test_a_corridor_is_narrow_somewhere_within():
    scene = scene_of(
        "id: sam, start: [0.6, 0.5], goal: [9, 0.5], radius: 0.3",
        world="{rectangle: [0, 0, 10, 1]}",
    )
    (passage,) = passages(prepare(scene))
    assert passage.half_width == pytest.approx(0.5, abs=1e-3)
    assert 0.5 < passage.place[0] < 9.5


def test_wide_places_and_agents_without_walls_are_passed_over():
    wide = scene_of("id: sam, start: [5, 5], goal: [9, 5]", world="{rectangle: [0, 0, 20, 10]}")
    assert passages(prepare(wide)) == []
    assert passages(prepare(scene_of(SAM + ", weights: {wall: 0}", world=GAP))) is None
    assert passages(prepare(scene_of(SAM))) is None
