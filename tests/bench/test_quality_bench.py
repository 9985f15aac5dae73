"""Plans beside the least costs known: the ledger, the table, the command."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from stplan.bench import quality
from stplan.bench.ledger import Entry, beaten_by, ledger_text, read_ledger
from stplan.bench.named_scenes import chosen_scenes
from stplan.bench.quality_table import csv_text, markdown_text
from stplan.cli.app import main
from stplan.errors import UsageError

ROOT = Path(__file__).parents[2]
KNOWN = {name: Entry(name, cost, "stplan solve x") for name, cost in (("a", 2.0), ("b", 3.0))}
CABIN = quality.Quality(
    scene="tight/cabin", agents=6, planned=0.75, planned_seconds=1.0, improved=0.66, improve_seconds=5.0,
    moves=40, accepted=3, certified=True, file=Path("scenes/tight/cabin.yaml"),
)  # fmt: skip


def stplan(*arguments: object) -> int:
    with pytest.raises(SystemExit) as left:
        main([str(argument) for argument in arguments])
    return int(left.value.code or 0)


def test_only_what_is_cheaper_or_new_beats_a_ledger():
    found = [Entry("a", 2.0 - 1e-9, "n"), Entry("b", 2.9, "n"), Entry("c", 9.0, "n")]
    assert beaten_by(KNOWN, found) == found[1:]


def test_a_ledger_is_read_as_it_was_written_and_only_improves(tmp_path):
    path = tmp_path / "ledger.csv"
    assert read_ledger(path) == {}
    path.write_text(ledger_text(KNOWN, [Entry("b", 2.9, "new"), Entry("a", 2.5, "dearer")]))
    assert read_ledger(path) == {"a": KNOWN["a"], "b": Entry("b", 2.9, "new")}


@pytest.mark.parametrize("text", ["", "scene,cost\na,1\n", "scene,cost,command\na,dear,x\n"])
def test_what_is_no_ledger_is_refused(text, tmp_path):
    (tmp_path / "ledger.csv").write_text(text)
    with pytest.raises(UsageError, match="is no ledger"):
        read_ledger(tmp_path / "ledger.csv")


def test_entries_say_how_to_get_there():
    assert CABIN.entries() == [
        Entry("tight/cabin", 0.66, "stplan solve scenes/tight/cabin.yaml --improve 40")
    ]
    unimproved = replace(CABIN, improved=0.75, accepted=0)
    assert unimproved.entries()[0].command == "stplan solve scenes/tight/cabin.yaml"
    assert replace(CABIN, certified=False).entries() == []


def test_the_table_says_how_far_from_the_best_and_what_is_a_record():
    known = {"tight/cabin": Entry("tight/cabin", 0.6, "")}
    text = markdown_text(known, [CABIN])
    assert "25.0" in text
    assert "10.0" in text
    assert "record" not in text
    assert "tight/cabin is a record: 0.66, 0.7 was known" in markdown_text(
        {"tight/cabin": Entry("tight/cabin", 0.7, "")}, [CABIN]
    )
    assert "no plan was known" in markdown_text({}, [CABIN])
    assert (
        csv_text(known, [CABIN]).splitlines()[1].startswith("tight/cabin,6,0.75,1,0.66,40,3,5,0.6")
    )


_chosen = partial(
    chosen_scenes, ROOT / "scenes", small=quality.SMALL_SCENES, every=quality.FULL_SCENES
)


def test_scenes_are_chosen_by_name():
    assert list(_chosen([], full=False)) == list(quality.SMALL_SCENES)
    assert list(_chosen([], full=True)) == list(quality.FULL_SCENES)
    assert list(_chosen(["door"], full=False)) == ["tight/door"]
    with pytest.raises(UsageError, match="no scene 'moon'"):
        _chosen(["moon"], full=False)


def test_the_command_records_only_where_it_is_asked_to(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(quality, "measure", lambda files, moves, progress: [CABIN])
    ledger = tmp_path / "ledger.csv"
    command = ("bench", "quality", "--scenes", ROOT / "scenes", "--ledger", ledger, "-o", tmp_path)
    assert stplan(*command) == 0
    assert not ledger.exists()
    assert "is a record" in capsys.readouterr().out
    assert stplan(*command, "--record") == 0
    assert read_ledger(ledger)["tight/cabin"] == CABIN.entries()[0]
    capsys.readouterr()
    assert stplan(*command, "--record") == 0
    assert "is a record" not in capsys.readouterr().out
    assert {path.name for path in tmp_path.iterdir()} == {"ledger.csv", "quality.csv", "quality.md"}


def test_a_small_scene_is_measured(tmp_path, monkeypatch):
    monkeypatch.setattr(quality, "warm_up", lambda: None)
    scene = tmp_path / "two.yaml"
    scene.write_text(
        "stplan: 1\nhorizon: 9\nsolver: {knots: 12}\nagents:\n"
        "  - {id: a, start: [0, 0], goal: [4, 0.1], radius: 0.4}\n"
        "  - {id: b, start: [4, 0], goal: [0, 0], radius: 0.4}\n"
    )
    (found,) = quality.measure({"two": scene}, 2, progress=lambda line: None)
    assert found.certified
    assert 0.0 < found.improved <= found.planned
    assert found.moves == 2
