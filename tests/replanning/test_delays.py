"""Plans that forgive delays."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stplan.analysis.precedence import endurance, longest_delay, precedence
from stplan.errors import StoppedError
from stplan.files.csv_file import csv_bytes
from stplan.files.json_file import json_bytes
from stplan.multistart import own_cost
from stplan.planned import Plan
from stplan.replanning.delays import with_copies_ahead
from stplan.replanning.execution import check, plan
from stplan.scene import parse_scene
from stplan.scene.interactions import scene_interactions
from stplan.status import Status

TRAM = """\
stplan: 1
name: tram
horizon: 16
defaults: {radius: 0.4}
seeding: {time_limit: 4}
agents:
  - {id: ann, start: [0, -4], goal: [0, 4], max_time: 7}
  - {id: tram, radius: 0.8, path: [[-7, 0, 0], [7, 0, 14]]}
"""
# Ann stands where the tram comes after 5.5 s: no plan survives more than that.
IN_THE_WAY = TRAM.replace("start: [0, -4]", "start: [0, 0.5]").replace(
    "max_time: 7", "max_time: 16"
)


def proven(found: Plan) -> float:
    assert found.trajectories is not None
    return longest_delay(precedence(found.scene, found.trajectories))


@pytest.fixture(scope="module")
def forgiving() -> Plan:
    return plan(parse_scene(TRAM + "robust: {delay: 2.0}\n"))


def test_what_is_asked_is_survived(forgiving) -> None:
    careless = plan(parse_scene(TRAM))
    assert proven(careless) < 2.0 <= proven(forgiving) < math.inf
    assert forgiving.trajectories is not None
    assert forgiving.status in (Status.CONVERGED, Status.LIMIT)
    scene = parse_scene(TRAM)
    assert check(scene, forgiving.trajectories).holds
    assert check(scene, forgiving.seed).holds
    assert endurance(precedence(scene, forgiving.trajectories), 2.0).survives
    assert careless.report.robustness is None


def test_what_is_said_of_the_plan_is_without_copies(forgiving) -> None:
    assert forgiving.seed.agent_ids == ("ann", "tram")
    report = forgiving.report.as_dict()
    parts = [report[key] for key in ("scene", "certificate", "metrics", "seed", "bound")]
    assert "tram, 1" not in json_bytes(parts).decode()
    assert forgiving.scene.content_hash == parse_scene(TRAM + "robust: {delay: 2.0}\n").content_hash
    assert report["robustness"]["survives"] is True
    assert report["robustness"]["proven_delay"] == proven(forgiving)
    lines = forgiving.trajectories
    assert report["bound"]["cost"] == pytest.approx(own_cost(forgiving.scene, lines))


def test_where_nothing_survives_it_what_is_survived_is_said() -> None:
    scene = parse_scene(IN_THE_WAY + "robust: {delay: 9}\n")
    found = plan(scene)
    assert found.status is Status.FRAGILE
    assert found.exit_status == 4
    assert found.certificate.holds
    careless = plan(parse_scene(IN_THE_WAY))
    assert proven(careless) < proven(found) < 5.5
    robust = found.report.robustness
    assert robust is not None
    assert not robust.holds
    assert robust.proven == proven(found)
    assert robust.sentences[0].startswith("survives a stop of")
    assert robust.sentences[0].endswith("s of the 9 s asked")
    again = plan(scene)
    assert again.trajectories is not None
    assert found.trajectories is not None
    assert csv_bytes(again.trajectories) == csv_bytes(found.trajectories)


def test_who_may_wait_forgives_any_delay() -> None:
    text = TRAM.replace("path: [[-7, 0, 0], [7, 0, 14]]", "start: [-7, 0], goal: [7, 0]")
    found = plan(parse_scene(text + "robust: {delay: 2.0}\n"))
    robust = found.report.robustness
    assert robust is not None
    assert robust.proven == math.inf
    assert robust.as_dict()["proven_delay"] is None
    careless = plan(parse_scene(text))
    assert careless.trajectories is not None
    assert found.trajectories is not None
    assert csv_bytes(found.trajectories) == csv_bytes(careless.trajectories)


def test_copies_cover_every_moment_ahead() -> None:
    """Whoever keeps clear of all copies keeps clear of the motion at every moment up to the delay ahead."""
    text = TRAM.replace("[7, 0, 14]", "[0, 0, 5], [0, 6, 8]")
    scene, ahead = parse_scene(text), 3.0
    given = with_copies_ahead(scene, ["tram"], ahead)
    pairs = scene_interactions(given)
    copies = range(2, len(given.agents))
    assert not pairs.collides[1, 2:].any()
    assert not pairs.collides[2:, 2:].any()
    assert pairs.collides[0, 1:].all()
    path, need = np.array(scene.agents[1].path), scene_interactions(scene).distance[0, 1]
    rng = np.random.default_rng(0)

    def where(curve, times):
        return np.column_stack([np.interp(times, curve[:, 2], curve[:, x]) for x in range(2)])

    for _ in range(200):
        now, moment = rng.uniform(0, 8 - ahead), rng.uniform(0, ahead)
        angle, far = rng.uniform(0, 2 * np.pi), need * np.sqrt(rng.uniform())
        place = where(path, [now + moment])[0] + far * np.array([np.cos(angle), np.sin(angle)])
        gaps = [
            np.hypot(*(where(np.array(given.agents[k].path), [now])[0] - place))
            - pairs.distance[0, k]
            for k in copies
        ]
        assert min(gaps) <= 1e-9


def test_stopped_in_the_middle_it_keeps_the_plan_it_has() -> None:
    asked = []

    def stop() -> bool:
        return "planning" in asked

    def hear(line: str) -> None:
        if "free ahead of tram" in line:
            asked.append("planning")

    scene = parse_scene(TRAM + "robust: {delay: 2.0}\n")
    try:
        found = plan(scene, progress=hear, stop=stop)
    except StoppedError:
        pytest.fail("there was a plan to keep")
    assert asked
    assert found.certificate.holds


def test_the_executed_whole_says_what_it_forgives() -> None:
    events = "events: [{at: 7.5, remove: ann}]\n"
    found = plan(parse_scene(TRAM + "robust: {delay: 0.5}\n" + events))
    robust = found.report.robustness
    assert robust is not None
    assert robust.proven == proven(found)
    assert robust.holds == (robust.proven >= 0.5)
