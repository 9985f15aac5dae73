"""The history of benchmarks: what is recorded, and how records compare across machines."""

from __future__ import annotations

from pathlib import Path

import pytest

from stplan.bench import history
from stplan.bench.history import compared, measured_in, read_history, record, trends
from stplan.cli import bench
from stplan.cli.app import main
from stplan.errors import UsageError

FIGURES = "figure,conflicts,total_seconds\ncircle of 8,28,{circle}\ndoor,3,{door}\nlost,3,\n"
SEEDING = "family,draw,cpu_seconds\ndoor,0,1.0\ndoor,1,9.0\ndoor,2,2.0\n"


def _folder(path: Path, circle: float, door: float) -> Path:
    path.mkdir()
    (path / "figures.csv").write_text(FIGURES.format(circle=circle, door=door))
    (path / "seeding.csv").write_text(SEEDING)
    return path


def test_a_machine_twice_as_slow_records_the_same_ratios(tmp_path):
    fast, slow = _folder(tmp_path / "fast", 0.5, 4.0), _folder(tmp_path / "slow", 1.0, 12.0)
    path = tmp_path / "history.csv"
    said: list[str] = []
    first = record(fast, path, progress=said.append, loop=0.05)
    assert first.count("new") == 3
    second = record(slow, path, progress=said.append, loop=0.10)
    rows = {line.split("|")[2].strip(): line for line in second.splitlines()[2:]}
    assert "| =" in " ".join(rows["circle of 8"].split())
    assert "1.50 times" in second
    entries = read_history(path)
    assert len(entries) == 6
    assert {one.case for one in entries} == {"circle of 8", "door"}
    assert [one.seconds for one in entries if one.benchmark == "seeding"] == [2.0, 2.0]
    assert entries[0].ratio == pytest.approx(10.0)
    assert said[-1] == f"recorded 3 cases in {path}"


def test_the_loop_takes_time_and_the_commit_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(history, "ROUNDS", 1)
    assert history.fixed_loop() > 0
    assert history.commit_of(tmp_path) == ""
    (one, *_) = measured_in(_folder(tmp_path / "out", 1.0, 1.0), 0.5)
    assert " x " in one.machine
    assert one.day.count("-") == 2


def test_what_is_no_history_is_left_alone(tmp_path):
    path = tmp_path / "history.csv"
    path.write_text("a,b\n1,2\n")
    with pytest.raises(UsageError, match="is no history of benchmarks: expected the columns day"):
        record(_folder(tmp_path / "out", 1.0, 1.0), path, progress=print, loop=1.0)
    assert path.read_text() == "a,b\n1,2\n"
    (tmp_path / "none").mkdir()
    with pytest.raises(UsageError, match="holds no benchmark"):
        record(tmp_path / "none", tmp_path / "new.csv", progress=print, loop=1.0)


def test_trends_show_every_record_of_a_case(tmp_path):
    path = tmp_path / "history.csv"
    for name, circle in (("a", 1.0), ("b", 1.5), ("c", 0.5)):
        record(_folder(tmp_path / name, circle, 2.0), path, progress=lambda said: None, loop=0.5)
    rows = {line.split("|")[2].strip(): line for line in trends(read_history(path)).splitlines()}
    assert "| 2, 3, 1 |" in " ".join(rows["circle of 8"].split())
    assert "0.50 times" in rows["circle of 8"]
    assert "| = |" in " ".join(rows["door"].split())
    assert trends([]).count("\n") == trends(read_history(path)).count("\n") - 3


def test_nothing_before_is_nothing_to_compare_with(tmp_path):
    found = measured_in(_folder(tmp_path / "out", 1.0, 1.0), 0.5)
    assert compared([], found).count("new") == len(found)


def test_all_records_what_its_benchmarks_left(tmp_path, monkeypatch, capsys):
    def figures(console, *, output, full):
        _folder(output / "now", 1.0, 2.0)
        for file in (output / "now").iterdir():
            file.rename(output / file.name)
        return 0

    monkeypatch.setattr(bench, "figures", figures)
    for name in ("startup", "_sweep", "rival", "seeding", "convergence"):
        monkeypatch.setattr(bench, name, lambda console, *rest, **options: 0)
    monkeypatch.chdir(Path(__file__).parents[2])
    path = tmp_path / "history.csv"
    with pytest.raises(SystemExit) as left:
        main(["bench", "all", "--record", "--history", str(path), "-o", str(tmp_path / "out")])
    assert left.value.code == 0, capsys.readouterr().err
    assert len(read_history(path)) == 3
    assert "times the loop" in (tmp_path / "out" / "history.md").read_text()
