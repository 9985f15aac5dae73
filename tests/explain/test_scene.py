"""What is said of a scene that nobody has planned."""

from __future__ import annotations

import numpy as np

from stplan.explain.scene import explain_scene, passage_section
from stplan.problem.planning_problem import prepare
from stplan.scene.model import Scene
from stplan.scene.reading.load import parse_scene

# A wall at x = 5 with a gap of 0.6 m around y = 1.8.
GAP = (
    "{rectangle: [0, 0, 10, 4], obstacles: "
    "[{rectangle: [4.9, 0, 5.1, 1.5]}, {rectangle: [4.9, 2.1, 5.1, 4]}]}"
)


def scene_of(*agents: str, world: str = "", top: str = "") -> Scene:
    listed = "".join(f"  - {{{agent}}}\n" for agent in agents)
    head = f"map: {world}\n" if world else ""
    return parse_scene(f"stplan: 1\nhorizon: 20\n{top}{head}agents:\n{listed}")


def told(scene: Scene, time_limit: float = 0.0) -> tuple[str, bool]:
    explanation, plannable = explain_scene(scene, time_limit=time_limit)
    return "\n".join(explanation.lines(everything=True)), plannable


SAM = "id: sam, start: [1, 2], goal: [9, 2], radius: 0.25"
ANN = "id: ann, start: [9, 1], goal: [1, 1], radius: 0.2"


def test_a_narrow_place_and_who_has_to_pass_it():
    (fact,) = passage_section(prepare(scene_of(SAM, ANN, world=GAP))).facts
    assert fact.sentence == (
        "the way of sam and ann is 0.6 m wide near (5, 1.8), which leaves 50 mm on either side "
        "of a radius of 0.25 m; one at a time"
    )
    assert fact.as_dict()["agents"] == ("sam", "ann")


def test_side_by_side():
    small = (SAM.replace("0.25", "0.1"), ANN.replace("0.2", "0.1"))
    section = passage_section(prepare(scene_of(*small, world=GAP.replace("2.1", "2.0"))))
    assert "one at a time" not in section.facts[0].sentence


def test_a_stop_near_a_wall():
    scene = scene_of("id: sam, start: [0.26, 2], goal: [4, 2], radius: 0.25", world=GAP)
    assert passage_section(prepare(scene)).facts[0].sentence == (
        "the stop (0.26, 2) of sam is 0.26 m from a wall, "
        "which leaves 10 mm beyond a radius of 0.25 m"
    )


def test_where_nothing_is_narrow():
    wide = scene_of("id: sam, start: [5, 5], goal: [9, 5]", world="{rectangle: [0, 0, 20, 10]}")
    lead = passage_section(prepare(wide)).lead
    assert lead == "Nobody has to pass a place narrower than 8 of its radii."
    assert passage_section(prepare(scene_of(SAM))).lead == "No agent has walls to mind."


def test_a_goal_that_cannot_be_reached():
    scene = scene_of(SAM.replace("0.25", "0.31"), ANN, world=GAP)
    text, plannable = told(scene, time_limit=5.0)
    assert not plannable
    assert text.startswith("scene: a valid scene, but there is no way to start.")
    assert (
        "the way of sam and ann is 0.6 m wide near (5, 1.8), too narrow for sam: "
        "a radius of 0.31 m needs 20 mm more" in text
    )
    assert "the widest lets a radius of 0.3 m through, the agent's is 0.31 m" in text


def test_agents_that_cannot_get_past_each_other():
    scene = scene_of(
        "id: sam, start: [1, 0.5], goal: [9, 0.5]",
        "id: ann, start: [9, 0.5], goal: [1, 0.5]",
        world="{rectangle: [0, 0, 10, 1]}",
        top="seeding: {time_limit: 600}\n",
    )
    text, plannable = told(scene, time_limit=600.0)
    assert not plannable
    assert "sam and ann would be 0.6 m too near at t = 10.00 s, (5, 0.5)" in text
    assert "No collision-free initial curves:\n  - " in text
    assert "sam and ann" in text.partition("Initial curves")[2]


def test_a_search_cut_short_is_not_said_to_be_a_proof():
    text, plannable = told(scene_of(SAM, ANN), time_limit=1e-9)
    assert not plannable
    assert text.startswith(
        "scene: a valid scene, but no initial curves were found within 1e-09 s; `stplan solve` looks for "
        "60 s, as does --time-limit 60."
    )
    assert "Everybody can" not in text


def test_who_is_there_and_who_would_meet():
    scene = scene_of(
        "id: sam, start: [-5, 0], goal: [5, 0], mass: 80",
        "id: ann, start: [0, -5], goal: [0, 5], radius: 0.5",
        "id: tram, path: [[-5, 9, 0], [5, 9, 9]]",
        top="pairs: [{between: [tram, all], collide: false}, {between: [sam, ann], grouping: 2}]\n",
    )
    text, plannable = told(scene)
    assert plannable
    assert "3 agents of radius 0.3 to 0.5 m and mass 1 to 80 kg, within 20 s:" in text
    assert "1 of 3 pairs of agents may not touch" in text
    assert "1 pair of agents are drawn together" in text
    assert "1 agent moves as prescribed" in text
    assert "1 of 1 pair would come too near:" in text
    assert "sam and ann would be 0.8 m too near at t = 10.00 s, (0, 0)" in text
    assert "Initial curves" not in text


def test_initial_curves_are_explained_where_they_are_found():
    # Patient, for a busy machine that compiles the first time.
    scene = scene_of(SAM, ANN, top="seeding: {time_limit: 600}\n")
    text, plannable = told(scene, time_limit=600.0)
    assert plannable
    assert "On their shortest ways, at constant speed, no two would come too near." in text
    assert "Initial curves\n  Found by relaxation." in text
    assert "Nobody waits or holds back for anybody." in text


def test_the_same_words_every_time():
    generator = np.random.default_rng(4)
    agents = [
        f"id: a{k}, start: [{x:.3f}, {k}], goal: [{y:.3f}, {9 - k}], radius: 0.2"
        for k, (x, y) in enumerate(generator.uniform(0, 9, (10, 2)))
    ]
    world = (
        "{rectangle: [-1, -1, 10, 10], obstacles: [{circle: {center: [4.5, 4.5], radius: 0.3}}]}"
    )
    assert told(scene_of(*agents, world=world)) == told(scene_of(*agents, world=world))
