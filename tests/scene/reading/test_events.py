"""Events of a file: which worlds they lead to, and what is wrong with them."""

from __future__ import annotations

import pytest

from stplan.scene import parse_scene
from tests.scene.samples import refusal, scene_text


def events(*entries: str, top: str = "map: {rectangle: [-1, -1, 9, 9]}") -> str:
    lines = "\n".join(f"  - {{{entry}}}" for entry in entries)
    return scene_text(top=f"{top}\nevents:\n{lines}")


def test_every_world_has_what_happened_before() -> None:
    scene = parse_scene(
        events(
            "at: 9, set: {agents.ann.radius: 0.2, horizon: 30}",
            "at: 3, agent: sam, goal: [5, 1], because: an order came",
            "at: 3, agent: ann, delay: 2",
            "at: 4, obstacle: {rectangle: [7, 7, 8, 8]}, until: 6",
            "at: 5, add: {id: eve, start: [0, 5], goal: [5, 5]}",
            "at: 8, remove: eve",
        )
    )
    changes = scene.changes
    assert [change.at for change in changes] == [3, 4, 5, 6, 8, 9]
    assert changes[0].causes == ("an order came", "ann stands still for 2 s")
    assert changes[0].delays == (("ann", 2),)
    assert [change.scene.agents[0].goal for change in changes] == [(5, 1)] * 6
    assert [len(change.scene.map.obstacles) for change in changes if change.scene.map] == [
        0,
        1,
        1,
        0,
        0,
        0,
    ]
    assert [len(change.scene.agents) for change in changes] == [2, 2, 3, 3, 3, 3]
    assert changes[2].scene.agents[2].start_time == 5
    assert [sorted(change.removed) for change in changes] == [[], [], [], [], ["eve"], ["eve"]]
    assert changes[5].scene.agents[1].radius == 0.2
    assert changes[5].scene.horizon == 30
    assert scene.agents[0].goal == (5, 0)


def test_scenes_without_events_keep_their_hash_and_others_have_another() -> None:
    plain = parse_scene(scene_text(top="map: {rectangle: [-1, -1, 9, 9]}"))
    hashes = {
        plain.content_hash,
        parse_scene(events("at: 3, agent: sam, delay: 2")).content_hash,
        parse_scene(events("at: 3, agent: sam, delay: 3")).content_hash,
        parse_scene(events("at: 4, agent: sam, delay: 3")).content_hash,
        parse_scene(events("at: 4, agent: sam, goal: [5, 1]")).content_hash,
    }
    assert len(hashes) == 5
    named = parse_scene(events("at: 4, agent: sam, goal: [5, 1], because: of her"))
    assert named.content_hash in hashes


@pytest.mark.parametrize(
    ("entry", "path", "sentence"),
    [
        ("at: 3", "events[0]", "has none of agent, add, remove, obstacle and set; one is expected"),
        ("at: 3, remove: ann, agent: sam, delay: 1", "events[0]", "has agent and remove of"),
        (
            "at: 3, agent: sam",
            "events[0]",
            "has none of goal, delay and max_speed; one is expected",
        ),
        ("at: 3, remove: ann, delay: 1", "events[0].delay", "belongs to an agent"),
        ("at: 3, remove: ann, until: 5", "events[0].until", "belongs to an obstacle"),
        (
            "at: 3, obstacle: {rectangle: [7, 7, 8, 8]}, until: 3",
            "events[0].until",
            "later than 3 s",
        ),
        ("at: 0, remove: ann", "events[0].at", "a time between 0 s and 20 s is expected"),
        ("at: 20, remove: ann", "events[0].at", "a time between 0 s and 20 s is expected"),
        ("at: 3, remove: zoe", "events[0]", "there is no agent 'zoe'"),
        ("at: 3, agent: zoe, delay: 1", "events[0]", "there is no agent 'zoe'"),
        (
            "at: 3, agent: annn, goal: [1, 1]",
            "events[0]",
            "agents has no entry 'annn'; did you mean 'ann'?",
        ),
        ("at: 3, agent: sam, goal: [1, x]", "events[0].goal[1]", "a number is expected"),
        ("at: 3, set: {solver.mu: 1}", "events[0].set", "'solver.mu' does not change on the way"),
        (
            "at: 3, set: {agents.sam.radius: -1}",
            "events[0]",
            "agents[0].radius: is -1; more than 0",
        ),
        ("at: 3, agent: sam, goal: [5, 2.1]", "events[0]", "both stay on their goals"),
        (
            "at: 3, add: {id: eve, start: [0, 5], goal: [5, 5], start_time: 2}",
            "events[0]",
            "'eve' starts at 2 s, before it is added",
        ),
    ],
)
def test_fault(entry, path, sentence) -> None:
    message = refusal(events(entry))
    assert f": {path}: " in message
    assert sentence in message


def test_an_obstacle_needs_a_map() -> None:
    entry = "at: 3, obstacle: {rectangle: [7, 7, 8, 8]}"
    assert "needs a map" in refusal(events(entry, top=""))


def test_who_has_to_meet_cannot_be_surprised() -> None:
    top = "pairs: [{between: [sam, ann], meet: {within: 1}}]"
    assert "do not go together" in refusal(events("at: 3, agent: sam, delay: 1", top=top))


def test_events_go_with_the_usual_objective_alone() -> None:
    text = events("at: 3, agent: sam, delay: 1")
    message = refusal(
        text.replace("agents:", "minimise: makespan\ndefaults: {max_speed: 2}\nagents:", 1)
    )
    assert (
        ": events: need a horizon that is stated, and go with `minimise: energy` alone" in message
    )


def test_nothing_happens_to_who_was_taken_away_before() -> None:
    entry = "at: 3, remove: ann}\n  - {at: 5, agent: ann, delay: 1"
    assert "events[1]: 'ann' was taken away before" in refusal(events(entry))
