"""Many agents, measured: the cases, what clusters would take, the tables."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from stplan.bench import scale
from stplan.bench.families_open import wide_field
from stplan.bench.scale import FIELD, Scaled
from stplan.bench.scale_table import markdown_text
from stplan.cli.app import main
from stplan.world import build_free_space, check_scene_in_world


def field(agents: int, workers: int, seconds: float) -> Scaled:
    """A plan whose parts take 2 ms an agent and whose rest takes 1 us a pair."""
    rest, parts = 1e-6 * agents**2, 2e-3 * agents
    return Scaled(
        FIELD, agents, workers, 15.0, "converged", True, seconds, rest + parts, 1.0, parts,
        100.0, 40 * agents, 1.01,
    )  # fmt: skip


def test_small_cases_are_valid_scenes() -> None:
    small = [case for case in scale.cases() if case.small]
    assert {case.family for case in small} == {FIELD, "warehouse, single-lane aisles"}
    for case in small:
        scene = case.scene()
        assert len(scene.agents) == case.agents
        assert check_scene_in_world(scene, build_free_space(scene)) == []
    longest = max(np.hypot(*np.subtract(one.goal, one.start)) for one in small[0].scene().agents)
    assert longest <= 60.0


def test_clusters_are_foretold_from_what_each_part_grows_with() -> None:
    measured = [field(1000, 1, 3.0), field(1000, 2, 2.0), field(4000, 1, 24.0)]
    found = {(one.agents, one.workers): one for one in scale.clusters(measured)}
    alone, many = found[100_000, 1], found[100_000, 64]
    assert alone.alone == many.alone == pytest.approx(1e4)
    assert alone.parts == pytest.approx(200.0)
    assert many.parts == pytest.approx(200.0 / 64)
    assert many.transfer == pytest.approx(64 * 48 * 1e5 * 40 * 24 / 125e6)
    assert scale.clusters(measured[:2]) == []


def test_one_process_stands_beside_all_cores() -> None:
    measured = [field(1000, 1, 3.0), field(1000, 2, 2.0), field(4000, 1, 24.0)]
    text = markdown_text(measured, scale.clusters(measured))
    first = next(line for line in text.splitlines() if "| 1000" in line.replace("   ", " "))
    assert [cell.strip() for cell in first.split("|")[3:8]] == [
        "certified", "3.0", "2.0", "15", "1.50",
    ]  # fmt: skip
    assert "agents^1.50 (fitted)" in text
    assert "Foretold for clusters" in text


def test_the_command_measures_and_writes(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    few = scale.ScaleCase(FIELD, 6, partial(wide_field, 6), small=True)
    large = scale.ScaleCase(FIELD, 9, partial(wide_field, 9))
    monkeypatch.setattr(scale, "cases", lambda: [few, large])
    monkeypatch.setattr(scale, "in_own_process", lambda work, *arguments: work(*arguments))
    monkeypatch.setattr(scale, "warm_up", lambda: None)
    with pytest.raises(SystemExit) as ended:
        main(["bench", "scale", "-o", str(tmp_path)])
    assert ended.value.code == 0
    with pytest.raises(SystemExit) as refused:
        main(["bench", "scale", "--families", "closed", "-o", str(tmp_path / "none")])
    assert refused.value.code == 2
    assert (tmp_path / "scale.md").read_text().count("certified") == 1
    assert (tmp_path / "scale.csv").read_text().count("converged") == 2
