"""What is said of curves: who waits for whom, who is late, who goes further, what is tight."""

from __future__ import annotations

from dataclasses import replace

from stplan.analysis.detours import ways_alone
from stplan.analysis.tightness import certified_spots
from stplan.analysis.waiting import waits
from stplan.certify.certificate import certify
from stplan.explain.curves import (
    detour_section,
    lateness_section,
    pair_section,
    waiting_section,
    wall_section,
)
from stplan.explain.explanation import Section
from stplan.problem.planning_problem import prepare
from stplan.scene.model import PairRule, Scene
from tests.analysis.crowds import ANN, EVE, SAM, crowd_of, scene_of


def waiting(scene: Scene, **curves: list[list[float]]) -> Section:
    crowd = crowd_of(scene, **curves)
    return waiting_section(waits(crowd), crowd.num_agents)


def tight(scene: Scene, **curves: list[list[float]]) -> tuple[Section, Section]:
    """What is said of pairs and of walls."""
    crowd = crowd_of(scene, **curves)
    certificate = certify(scene, crowd.free_space, crowd.lines)
    pairs, walls = certified_spots(crowd, certificate)
    return pair_section(pairs, certificate.num_pairs), wall_section(walls)


def test_who_waits_where_and_for_whom():
    section = waiting(scene_of(SAM, ANN, EVE))
    assert section.facts[0].sentence.startswith(
        "ann waits for sam: it stands still from t = 2.00 to 7.00 s near (0, -2), "
    )
    assert section.lead == (
        "1 of 3 agents waits or holds back; sam is waited for most, 5.0 s in all:"
    )
    assert section.facts[0].as_dict()["meeting"].keys() == {"agent", "overlap", "time", "place"}


def test_nobody_is_blamed_who_is_not_in_the_way():
    scene = scene_of(SAM, ANN, EVE)
    section = waiting(replace(scene, pairs=(PairRule((0,), (1,), collide=False),)))
    assert section.facts[0].sentence.endswith("nobody is in its way then, it has time")
    assert section.lead == "1 of 3 agents waits or holds back:"


def test_holding_back_is_less_than_waiting():
    scene = scene_of(SAM, ANN)
    section = waiting(scene, ann=[[0, -4, 0], [0, -0.5, 7], [0, 4, 11]])
    assert section.facts[0].sentence.startswith(
        "ann holds back for sam: it goes at 0.5 m/s from t = 0.00"
    )
    steady = waiting(scene, ann=[[0, -4, 0], [0, 4, 16]])
    assert steady.lead == "Nobody waits or holds back for anybody."


def test_who_is_late():
    crowd = crowd_of(
        scene_of(SAM, ANN, "id: bob, start: [9, 9], goal: [9, 0], preferred_time: 9"),
        bob=[[9, 9, 0], [9, 0, 9]],
    )
    section = lateness_section(crowd, waits(crowd))
    assert section.lead == "1 of 2 agents with a preferred time are late:"
    assert [fact.sentence for fact in section.facts] == [
        "ann arrives at t = 13.00 s, 4.00 s later than the 9 s it prefers; waiting cost it 5.00 s"
    ]
    assert lateness_section(crowd_of(scene_of(SAM)), []).lead == "No agent has a preferred time."
    early = crowd_of(scene_of(ANN), ann=[[0, -4, 0], [0, 4, 9]])
    assert lateness_section(early, []).lead == "All 1 agents with a preferred time keep it."


def test_detours():
    scene = scene_of(SAM, EVE)
    section = detour_section(crowd_of(scene), ways_alone(prepare(scene)))
    assert section.lead == "1 of 2 agents go further than alone, 0.20 m in all:"
    assert section.facts[0].sentence == (
        "eve goes 10.20 m, 0.20 m (2%) more than its shortest way alone"
    )


def test_the_tightest_come_first():
    scene = scene_of(
        SAM, ANN, EVE, "id: kim, start: [-5, 1.01], goal: [5, 1.01], after_arrival: vanish"
    )
    pairs, walls = tight(scene, kim=[[-5, 1.01, 0], [5, 1.01, 10]])
    assert pairs.facts[0].as_dict()["who"] == ("sam", "kim")
    assert pairs.facts[0].sentence == (
        "sam and kim: 10 mm to spare beyond their 1 m, at t = 0.00 s near (-5, 0.51)"
    )
    assert walls.lead == "No agent has walls to mind."
    pairs, _ = tight(scene_of(SAM, EVE))
    assert pairs.lead == "Nothing is tight among 1 pair that may not touch; the least room is:"
    assert tight(scene_of(SAM))[0].lead == "No two agents have to keep apart."


def test_walls_that_are_tight():
    _, walls = tight(scene_of(SAM, top="map: {rectangle: [-9, -0.51, 9, 9]}\n"))
    (fact,) = walls.facts
    assert fact.sentence.startswith("sam: 10 mm to spare beyond its radius of 0.5 m, at t = ")
