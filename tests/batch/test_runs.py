"""Which runs a batch consists of, and what they are called."""

from __future__ import annotations

from pathlib import Path

import pytest

from stplan.batch.runs import list_runs
from stplan.batch.sweep import LONGEST_LABEL, combinations
from stplan.batch.worker import execute
from stplan.errors import UsageError


@pytest.fixture(autouse=True)
def _here(place, monkeypatch):
    monkeypatch.chdir(place)


def names(*sources, **options):
    return [run.name for run in list_runs(sources, output=Path("results"), **options)]


def test_files_folders_and_patterns_each_scene_once():
    assert names("scenes") == ["one", "room", "three", "two"]
    assert names("scenes/two.yaml", "scenes") == ["two", "one", "room", "three"]
    assert names("scenes/t*.yaml") == ["three", "two"]
    assert names("**/o*.yaml", "./scenes/one.yaml") == ["one"]
    Path("scenes/deep/er").mkdir(parents=True)
    Path("scenes/two.yaml").rename("scenes/deep/er/four.yml")
    assert names("scenes") == ["four", "one", "room", "three"]


def test_a_folder_that_is_searched_leaves_out_the_results_and_what_is_hidden():
    for folder in ("results", ".hidden"):
        Path(folder).mkdir()
        (Path(folder) / "copy.yaml").write_text(Path("scenes/one.yaml").read_text())
    assert "copy" not in names(".")
    assert names("results/copy.yaml") == ["copy"]


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("none.yaml", "cannot read none.yaml: no such file"),
        ("none*.yaml", r"none\*.yaml: no file matches this pattern"),
        ("empty", "empty: the folder holds no scene files"),
    ],
)
def test_a_source_that_gives_nothing(source, message):
    Path("empty").mkdir()
    with pytest.raises(UsageError, match=message):
        names("scenes", source)


def test_a_file_whose_name_looks_like_a_pattern():
    Path("scenes/one.yaml").rename("scenes/a[1].yaml")
    assert names("scenes/a[1].yaml") == ["a-1"]


def test_two_scenes_of_one_name_are_refused():
    Path("other").mkdir()
    Path("other/one.yaml").write_text(Path("scenes/one.yaml").read_text())
    with pytest.raises(UsageError, match=r"scenes/one.yaml and other/one.yaml both make a run"):
        names("scenes", "other")


def test_a_sweep_runs_every_combination_under_a_name_of_its_own():
    runs = list_runs(
        ["scenes/one.yaml"], output=Path("results"), overrides=["horizon=9"],
        sweeps=["solver.mu=0.1,1", "agents.sam.radius=0.2,0.3"],
    )  # fmt: skip
    assert [run.name for run in runs] == [
        "one--solver.mu=0.1--agents.sam.radius=0.2",
        "one--solver.mu=0.1--agents.sam.radius=0.3",
        "one--solver.mu=1--agents.sam.radius=0.2",
        "one--solver.mu=1--agents.sam.radius=0.3",
    ]
    assert runs[1].overrides == ("horizon=9", "solver.mu=0.1", "agents.sam.radius=0.3")
    assert len({run.content_hash for run in runs}) == 4


def test_a_value_of_a_sweep_may_hold_commas_in_brackets_and_quotes():
    chosen = combinations(["agents[0].start=[1, 2],[3,4]", "description='a,b',c"])
    assert [combination.overrides for combination in chosen] == [
        ("agents[0].start=[1, 2]", "description='a,b'"),
        ("agents[0].start=[1, 2]", "description=c"),
        ("agents[0].start=[3,4]", "description='a,b'"),
        ("agents[0].start=[3,4]", "description=c"),
    ]


def test_labels_are_safe_distinct_and_short():
    values = ["[1,2]", "[1 ,2]", "a/b", "a b", "../..", "x" * 500, "x" * 500 + "y"]
    labels = [combination.label for combination in combinations(["key=" + ",".join(values)])]
    assert len(set(labels)) == len(values)
    for label in labels:
        assert len(label) <= LONGEST_LABEL
        assert not set(label) - set("abcdefghijklmnopqrstuvwxyz0123456789._=+-")


@pytest.mark.parametrize(
    "sweeps", [["mu"], ["=1,2"], ["mu="], ["mu=1,,2"], ["mu=1,1"], ["mu=1", "mu=2"]]
)
def test_a_sweep_that_is_none(sweeps):
    with pytest.raises(UsageError, match="--sweep"):
        combinations(sweeps)


def test_filters_keep_the_runs_so_named():
    sweep = {"sweeps": ["solver.mu=1,2"]}
    assert names("scenes", filters=["t*mu=1", "room*"], **sweep) == [
        "room--solver.mu=1", "room--solver.mu=2", "three--solver.mu=1", "two--solver.mu=1",
    ]  # fmt: skip
    with pytest.raises(UsageError, match="no run matches --filter none"):
        names("scenes", filters=["none"])


def test_a_scene_that_is_refused_is_a_run_too():
    Path("scenes/one.yaml").write_text("stplan: 1\n")
    Path("scenes/two.yaml").write_bytes(b"\xff")
    runs = {run.name: run for run in list_runs(["scenes"], output=Path("results"))}
    assert list(runs) == ["scenes/one.yaml", "room", "three", "scenes/two.yaml"]
    assert "agents" in runs["scenes/one.yaml"].refusal[0]
    assert "not UTF-8" in runs["scenes/two.yaml"].refusal[0]
    assert not runs["room"].refusal


def test_a_scene_that_changed_since_the_batch_began_is_not_planned():
    """Its results would stand under the hash of another scene."""
    Path("room.obj").write_text("v 0 0 0\nv 6 0 0\nv 6 3 0\nv 0 3 0\nf 1 2 3 4\n")
    text = Path("scenes/one.yaml").read_text() + "map: {mesh: ../room.obj}\n"
    Path("scenes/one.yaml").write_text(text)
    (run,) = list_runs(["scenes/one.yaml"], output=Path("results"))
    Path("room.obj").write_text("v 0 0 0\nv 7 0 0\nv 7 3 0\nv 0 3 0\nf 1 2 3 4\n")
    outcome = execute(run, None, lambda line: None)
    assert outcome.state == "refused"
    assert outcome.messages == (
        "scenes/one.yaml: its files have changed since the batch began; run it again",
    )
