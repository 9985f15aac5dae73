"""What is said of a run, whoever wrote its curves."""

from __future__ import annotations

import json

from stplan.explain.explanation import FEW
from stplan.explain.run import explain_run
from stplan.files.json_file import json_bytes
from stplan.files.recorded import RecordedReport
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene
from tests.analysis.crowds import ANN, EVE, SAM, lines_of, scene_of


def test_a_run_whatever_the_order_of_its_agents():
    scene = scene_of(SAM, ANN, EVE)
    lines = lines_of(scene)
    turned = WorldLines.from_curves(lines.agent_ids[::-1], [*lines.curves()][::-1])
    explanation, certificate = explain_run(scene, lines)
    assert certificate.holds
    assert explain_run(scene, turned)[0] == explanation
    assert explanation.headline == "small: 3 agents, the certificate holds."
    report = RecordedReport("limit", "raise solver.max_iterations to go on")
    text = "\n".join(explain_run(scene, lines, report)[0].lines())
    assert text.startswith("small: planning ended as 'limit'; the certificate holds.\n")
    assert "Raise solver.max_iterations to go on." in text


def test_what_happened_is_listed_below_its_title():
    scene = parse_scene(
        "stplan: 1\nhorizon: 20\nagents: [{id: ann, start: [0, 0], goal: [8, 0]}]\n"
        "events: [{at: 3, agent: ann, goal: [8, 3], because: the door is closed}]\n"
    )
    turned = lines_of(scene, ann=[[0, 0, 0], [3, 0, 3], [8, 3, 9]])
    said = explain_run(scene, turned)[0].lines()
    title = said.index("What happened on the way")
    assert said[title + 1] == "  - At 3 s the door is closed."


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
