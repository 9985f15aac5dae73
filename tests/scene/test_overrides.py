"""`--set KEY=VALUE`."""

from __future__ import annotations

import pytest

from stplan.scene import parse_scene
from tests.scene.samples import refusal, refusals, scene_text


def _scene(*overrides: str, text: str = ""):
    return parse_scene(text or scene_text(), overrides=overrides)


def test_every_way_to_name_a_place():
    scene = _scene(
        "solver.mu=0.1",
        "agents[0].radius=0.4",
        "agents.ann.radius=0.2",
        "agents.sam.weights.wall=0",
        "agents[1].goal[0]=6",
        "agents.sam.waypoints=[[1, 1]]",
        "name=other",
        "horizon=3e1",
    )
    assert scene.solver.mu == 0.1
    assert [agent.radius for agent in scene.agents] == [0.4, 0.2]
    assert scene.agents[0].weights.wall == 0
    assert scene.agents[1].goal == (6, 2)
    assert scene.agents[0].waypoints == ((1, 1),)
    assert (scene.name, scene.horizon) == ("other", 30)


def test_the_last_wins():
    assert _scene("horizon=30", "horizon=40").horizon == 40


def test_whole_mappings_are_replaced():
    assert _scene("solver={knots: 9}", text=scene_text(top="solver: {mu: 2}")).solver.mu is None


def test_overridden_aliases_change_in_one_place():
    text = scene_text("weights: &w {kinetic: 2}").replace(
        "goal: [5, 2]", "goal: [5, 2], weights: *w"
    )
    scene = _scene("agents.sam.weights.kinetic=3", text=text)
    assert [agent.weights.kinetic for agent in scene.agents] == [3, 2]


def test_values_are_validated_and_blamed_on_the_override():
    message = refusal(scene_text(), overrides=["solver.mu=-1"])
    assert "--set solver.mu=-1" in message
    assert "solver.mu: " in message
    assert "scene:" not in message


def test_misspelt_keys():
    assert "did you mean 'solver'?" in refusal(scene_text(), overrides=["sovler.mu=1"])
    assert "did you mean 'radius'?" in refusal(scene_text(), overrides=["agents.sam.radus=1"])
    assert "did you mean 'sam'?" in refusal(scene_text(), overrides=["agents.samm.radius=1"])


@pytest.mark.parametrize(
    "override",
    [
        "",
        "=",
        "=1",
        "horizon",
        ".=1",
        "solver]]mu=1",
        "solver..mu=1",
        "agents[2].radius=1",
        "agents[-1].radius=1",
        "agents[99999999999999999999].radius=1",
        f"agents[{'9' * 5000}].radius=1",
        "agents[0].start[7]=1",
        "horizon.x=1",
        "solver[0]=1",
        "horizon=[1",
        "horizon=.nan",
        "horizon=1\n---\n2",
        "horizon='5'",
        "horizon=true",
        "agents.sam.id=ann",
        "agents=[]",
        "a." * 5000 + "b=1",
    ],
)
def test_refused(override):
    messages = refusals(scene_text(), overrides=[override])
    assert all("--set" in message or message.startswith("scene:") for message in messages)


def test_faults_of_file_and_override_together():
    messages = refusals(scene_text("radius: 0"), overrides=["solver.knots=1"])
    assert len(messages) == 2
    assert sum(message.startswith("scene:4:") for message in messages) == 1
    assert sum("--set solver.knots=1" in message for message in messages) == 1
