"""What is said of curves: who waits for whom, who is late, who goes further, what is tight."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from stplan.certify.certificate import certify
from stplan.explain.detours import detours, ways_alone
from stplan.explain.explanation import FEW, metres, names
from stplan.explain.lateness import lateness
from stplan.explain.run import explain_run
from stplan.explain.tightness import tight_pairs, tight_walls
from stplan.explain.waiting import waiting, waits
from stplan.files.json_file import json_bytes
from stplan.problem.planning_problem import prepare
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import PairRule, Scene
from stplan.scene.reading.load import parse_scene
from stplan.world import build_free_space


def scene_of(*agents: str, top: str = "") -> Scene:
    listed = "".join(f"  - {{{agent}, radius: 0.5}}\n" for agent in agents)
    return parse_scene(f"stplan: 1\nname: small\nhorizon: 20\n{top}agents:\n{listed}")


SAM = "id: sam, start: [-5, 0], goal: [5, 0], after_arrival: vanish"
ANN = "id: ann, start: [0, -4], goal: [0, 4], preferred_time: 9"
EVE = "id: eve, start: [-5, 9], goal: [5, 9]"
CURVES = {
    "sam": [[-5, 0, 0], [5, 0, 10]],
    # Half way to sam's line ann stands for five seconds, until he has passed.
    "ann": [[0, -4, 0], [0, -2, 2], [0, -2, 7], [0, 4, 13]],
    "eve": [[-5, 9, 0], [0, 10, 8], [5, 9, 20]],
}


def lines_of(scene: Scene, **other: list[list[float]]) -> WorldLines:
    ids = [agent.id for agent in scene.agents]
    return WorldLines.from_curves(ids, [np.array((CURVES | other)[i], dtype=float) for i in ids])


def test_who_waits_where_and_for_whom():
    scene = scene_of(SAM, ANN, EVE)
    (wait,) = waits(scene, lines_of(scene))
    assert (wait.agent, wait.begin, wait.end) == ("ann", 2.0, 7.0)
    assert wait.pace == pytest.approx(8 / 13)
    assert (wait.speed, wait.lost, wait.place) == (0.0, 5.0, (0.0, -2.0))
    assert wait.meeting is not None
    assert wait.meeting.agent == "sam"
    # Going on from (0, -2) at 8 / 13 m/s she crosses his line at 5.25 s, a quarter of a metre off.
    assert wait.meeting.overlap == pytest.approx(1.0 - 0.25 * (8 / 13) / np.hypot(1, 8 / 13))
    assert wait.meeting.time == pytest.approx(5.25, abs=0.3)
    assert wait.sentence().startswith(
        "ann waits for sam: it stands still from t = 2.00 to 7.00 s near (0, -2), "
    )
    section = waiting(scene, [wait])
    assert section.lead == (
        "1 of 3 agents waits or holds back; sam is waited for most, 5.0 s in all:"
    )


def test_nobody_is_blamed_who_is_not_in_the_way():
    scene = scene_of(SAM, ANN, EVE)
    for other in (
        replace(scene, pairs=(PairRule((0,), (1,), collide=False),)),
        replace(scene, pairs=(PairRule((0,), (1,), distance=0.01),)),
    ):
        (wait,) = waits(other, lines_of(other))
        assert wait.meeting is None
        assert wait.sentence().endswith("nobody is in its way then, it has time")
    # Sam is gone before ann would be there.
    early = lines_of(scene, sam=[[-5, 0, 0], [5, 0, 3]])
    assert waits(scene, early)[0].meeting is None


def test_going_on_slowly_is_no_wait_but_holding_back_for_somebody():
    scene = scene_of(SAM, ANN)
    # A tenth slower than on average.
    slow = [[0, -4, 0], [0, 0.4, 8], [0, 4, 13]]
    assert waits(scene, lines_of(scene, ann=slow)) == []
    slower = [[0, -4, 0], [0, -0.5, 7], [0, 4, 11]]
    (wait,) = waits(scene, lines_of(scene, ann=slower))
    assert not wait.is_wait
    assert wait.sentence().startswith("ann holds back for sam: it goes at 0.5 m/s from t = 0.00")
    steady = lines_of(scene, ann=[[0, -4, 0], [0, 4, 16]])
    assert waits(scene, steady) == []
    assert waiting(scene, []).lead == "Nobody waits or holds back for anybody."


def test_agents_that_stand_or_move_as_told_do_not_wait():
    told = "id: ann, path: [[0, -4, 0], [0, -2, 2], [0, -2, 7], [0, 4, 13]]"
    scene = scene_of(SAM, told, "id: eve, start: [3, 3], goal: [3, 3]")
    still = lines_of(scene, eve=[[3, 3, 0], [3, 3, 20]])
    assert waits(scene, still) == []


def test_who_is_late():
    scene = scene_of(SAM, ANN, "id: bob, start: [9, 9], goal: [9, 0], preferred_time: 9")
    lines = lines_of(scene, bob=[[9, 9, 0], [9, 0, 9]])
    section = lateness(scene, lines, waits(scene, lines))
    assert section.lead == "1 of 2 agents with a preferred time are late:"
    assert [fact.sentence() for fact in section.facts] == [
        "ann arrives at t = 13.00 s, 4.00 s later than the 9 s it prefers; waiting cost it 5.00 s"
    ]
    nobody = scene_of(SAM)
    assert not lateness(nobody, lines_of(nobody), []).facts


def test_detours_in_the_open_and_round_walls():
    scene = scene_of(SAM, EVE)
    section = detours(scene, lines_of(scene), ways_alone(prepare(scene)))
    (detour,) = section.facts
    assert detour.agent == "eve"
    assert (detour.alone, detour.length) == pytest.approx((10.0, 2 * np.hypot(5, 1)))
    walled = scene_of(
        "id: sam, start: [-5, 0], goal: [5, 0]",
        top="map: {rectangle: [-9, -9, 9, 9], obstacles: [{rectangle: [-1, -6, 1, 1]}]}\n",
    )
    around = [[-5, 0, 0], [-1.5, 1.5, 4], [1.5, 1.5, 8], [5, 0, 12]]
    alone = ways_alone(prepare(walled))
    # The wall's corners have to be passed, so this is no detour although it is not straight.
    assert detours(walled, lines_of(walled, sam=around), alone).facts == ()
    wide = [[-5, 0, 0], [0, 6, 6], [5, 0, 12]]
    (detour,) = detours(walled, lines_of(walled, sam=wide), alone).facts
    assert 10.5 < detour.alone < 10.9


def test_the_tightest_come_first():
    scene = scene_of(
        SAM, ANN, EVE, "id: kim, start: [-5, 1.01], goal: [5, 1.01], after_arrival: vanish"
    )
    lines = lines_of(scene, kim=[[-5, 1.01, 0], [5, 1.01, 10]])
    section = tight_pairs(scene, certify(scene, None, lines))
    assert section.facts[0].who == ("sam", "kim")
    assert section.facts[0].sentence() == (
        "sam and kim: 10 mm to spare beyond their 1 m, at t = 0.00 s near (-5, 0.51)"
    )
    assert [fact.share for fact in section.facts] == sorted(fact.share for fact in section.facts)
    assert tight_walls(scene, certify(scene, None, lines)).lead == "No agent has walls to mind."
    apart = scene_of(SAM, EVE)
    section = tight_pairs(apart, certify(apart, None, lines_of(apart)))
    assert section.lead == "Nothing is tight among 1 pair that may not touch; the least room is:"


def test_walls_that_are_tight():
    scene = scene_of(SAM, top="map: {rectangle: [-9, -0.51, 9, 9]}\n")
    certificate = certify(scene, build_free_space(scene), lines_of(scene))
    (fact,) = tight_walls(scene, certificate).facts
    assert fact.who == ("sam",)
    assert fact.sentence().startswith("sam: 10 mm to spare beyond its radius of 0.5 m, at t = ")


def test_a_run_whatever_the_order_of_its_agents():
    scene = scene_of(SAM, ANN, EVE)
    lines = lines_of(scene)
    turned = WorldLines.from_curves(lines.agent_ids[::-1], [*lines.curves()][::-1])
    explanation, certificate = explain_run(scene, lines)
    assert certificate.holds
    assert explain_run(scene, turned)[0] == explanation
    assert explanation.headline == "small: 3 agents, the certificate holds."
    report = {"status": "limit", "advice": "raise solver.max_iterations to go on"}
    text = "\n".join(explain_run(scene, lines, report)[0].lines())
    assert text.startswith("small: planning ended as 'limit'; the certificate holds.\n")
    assert "Raise solver.max_iterations to go on." in text


def test_a_broken_run():
    scene = scene_of(SAM, ANN)
    meeting = lines_of(scene, ann=[[0, -4, 0], [0, 4, 10]])
    explanation, certificate = explain_run(scene, meeting)
    assert not certificate.holds
    text = "\n".join(explanation.lines())
    assert "sam and ann: 1 m too near at t = 5.00 s near (0, 0), where 1 m have to be kept" in text
    # Curves without sound ends say nothing about the rest.
    away = lines_of(scene, ann=[[0, -4, 0], [1, 4, 10]])
    explanation, _ = explain_run(scene, away)
    assert [section.key for section in explanation.sections] == ["violations"]


def test_one_agent_and_many():
    alone = scene_of(SAM)
    text = "\n".join(explain_run(alone, lines_of(alone))[0].lines())
    assert "No two agents have to keep apart." in text
    ids = [f"a{k}" for k in range(200)]
    crowd = scene_of(*(f"id: {i}, start: [0, {1.01 * k}], goal: [9, {1.01 * k}]"
                       for k, i in enumerate(ids)))  # fmt: skip
    bent = {i: [[0, 1.01 * k, 0], [4, 1.01 * k + 1, 9], [9, 1.01 * k, 20]]
            for k, i in enumerate(ids)}  # fmt: skip
    explanation, _ = explain_run(crowd, lines_of(crowd, **bent))
    short, whole = explanation.lines(), explanation.lines(everything=True)
    assert len(short) < 40
    assert "  and 194 more; --all lists them" in short
    assert sum(line.startswith("  - ") for line in whole) > 390
    # JSON is complete in any case.
    content = json.loads(json_bytes(explanation.as_dict()))
    assert len(content["sections"]["pairs"]["facts"]) == 199
    assert content["sections"]["detours"]["facts"][0].keys() == {
        "sentence", "agent", "length", "alone",
    }  # fmt: skip
    assert FEW == 5


def test_words():
    assert metres(0.0004) == "0.4 mm"
    assert metres(0.09996) == "100 mm"
    assert metres(1.25) == "1.25 m"
    assert names(["a"]) == "a"
    assert names(["a", "b", "c"]) == "a, b and c"
    assert names(list("abcdefg")) == "a, b, c, d and 3 more"


def test_limits_and_meetings():
    scene = scene_of(
        f"{SAM}, max_speed: 1.05", f"{ANN}, max_speed: 9",
        top="pairs: [{between: [sam, ann], collide: false, meet: {within: 2.5}}]\n",
    )  # fmt: skip
    explanation, certificate = explain_run(scene, lines_of(scene))
    assert certificate.holds
    text = "\n".join(explanation.lines())
    assert (
        "1 of 2 limits of motion are used up to within 10%:\n  - sam: speed 1 of 1.05 m/s" in text
    )
    assert "1 of 1 meeting takes place:\n  - sam and ann meet at t = 5.00 s near (0, -1), " in text


def test_setting_off_from_rest_is_no_wait():
    scene = scene_of("id: sam, start: [0, 0], goal: [9, 0], max_acceleration: 0.5")
    lines = lines_of(scene, sam=[[0, 0, 0], [1, 0, 4], [8, 0, 10], [9, 0, 14]])
    assert waits(scene, lines) == []
    free = scene_of("id: sam, start: [0, 0], goal: [9, 0]")
    assert len(waits(free, lines)) == 2
