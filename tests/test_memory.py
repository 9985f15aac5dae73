"""Memory: what there is, what a scene needs at least, and who is refused."""

from __future__ import annotations

import json
import math
import resource

import pytest

from stplan import memory
from stplan.bench.families_open import circle
from stplan.cli.app import main
from stplan.errors import SceneError
from stplan.planner import plan
from stplan.problem.planning_problem import LEAST_AUTO_KNOTS

SCENE = """
stplan: 1
horizon: 10.0
agents:
- {id: a, start: [0, 0], goal: [4, 0], radius: 0.3}
- {id: b, start: [4, 1], goal: [0, 1], radius: 0.3}
"""


def test_need_grows_with_knots_and_pairs():
    plain = memory.least_need(2, 100)
    assert memory.least_need(2, 200) - plain == 100 * memory.A_KNOT
    assert memory.least_need(4, 100) - plain == 5 * memory.A_PAIR


def test_a_scene_needs_no_less_than_what_is_said_before_it_starts():
    scene = circle(6, 6.0, 12.0)
    planned = plan(scene)
    least = memory.least_need(6, 6 * LEAST_AUTO_KNOTS)
    assert planned.run.peak_memory_mib * memory.MIB > least
    assert memory.peak() >= least


@pytest.fixture
def scene_file(tmp_path):
    path = tmp_path / "pair.yaml"
    path.write_text(SCENE)
    return path


@pytest.mark.parametrize("command", ["solve", "seed"])
def test_a_scene_that_cannot_fit_is_refused_before_it_starts(
    command, scene_file, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(memory, "available", lambda: 100.0 * memory.MIB)
    monkeypatch.setattr("stplan.planner.best_seeds", None)
    with pytest.raises(SystemExit) as left:
        main([command, str(scene_file), "-o", str(tmp_path / "out"), "--json"])
    assert left.value.code == 2
    record = json.loads(capsys.readouterr().out)
    assert record["scenes"][0]["messages"] == [
        "pair: needs at least 0.2 GiB of memory, and 0.1 GiB are available: "
        "2 agents make 1 pairs, and 60 knots"
    ]
    assert not (tmp_path / "out").exists()


def test_a_million_agents_do_not_fit_anywhere_yet():
    with pytest.raises(SceneError, match="needs at least 37"):
        memory.require_memory("crowd", 1_000_000, 20_000_000)


def test_the_tightest_limit_counts(monkeypatch):
    monkeypatch.setattr(
        resource, "getrlimit", lambda kind: (3 * memory.MIB, resource.RLIM_INFINITY)
    )
    assert memory.available() == 3 * memory.MIB
    monkeypatch.setattr(resource, "getrlimit", lambda kind: (resource.RLIM_INFINITY,) * 2)
    assert memory.available() > memory.PROGRAM


def test_limits_are_read_as_the_system_writes_them(tmp_path):
    table, limit = tmp_path / "meminfo", tmp_path / "memory.max"
    assert math.isinf(memory._system(table))
    assert math.isinf(memory._container(limit))
    table.write_text(
        "MemTotal:       24000000 kB\nMemAvailable:    2048 kB\nHugePages_Total:       0\n"
    )
    assert memory._system(table) == 2 * memory.MIB
    limit.write_text("max\n")
    assert math.isinf(memory._container(limit))
    limit.write_text("1048576\n")
    assert memory._container(limit) == memory.MIB
