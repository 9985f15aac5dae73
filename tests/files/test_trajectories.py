"""Both formats give back what was written, to the bit; and are the same bytes every time."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stplan.errors import UsageError
from stplan.files.csv_file import csv_bytes, read_csv
from stplan.files.npz_file import npz_bytes, read_npz
from stplan.files.trajectories import read_trajectories, write_files
from stplan.problem.world_lines import WorldLines
from tests.files.examples import random_lines, scene_of, straight_lines

IDS = ["a", 'b,"é', "line\nfeed", " c ", "0"]

allowed = st.floats(-1e9, 1e9)
curves = st.lists(st.tuples(allowed, allowed, allowed), min_size=2, max_size=5)


def _assert_same(a: WorldLines, b: WorldLines) -> None:
    assert a.agent_ids == b.agent_ids
    assert a.offsets.dtype == b.offsets.dtype == np.int64
    assert a.knots.tobytes() == b.knots.tobytes()
    np.testing.assert_array_equal(a.offsets, b.offsets)


@given(st.lists(curves, min_size=1, max_size=4))
def test_any_numbers_survive_both_formats(tmp_path_factory, knots):
    lines = WorldLines.from_curves(
        IDS[: len(knots)], [np.array(curve, dtype=float) for curve in knots]
    )
    folder = tmp_path_factory.mktemp("round")
    scene = scene_of(lines.agent_ids)
    for path in write_files(folder, scene, {"trajectories": lines}):
        _assert_same(read_trajectories(path), lines)


def test_csv_layout():
    scene = scene_of(["sam", "ann"])
    assert csv_bytes(straight_lines(scene, 2)).decode() == (
        "agent,knot,x,y,t\n"
        "sam,0,0.0,0.0,0.0\nsam,1,4.0,0.0,5.0\n"
        "ann,0,0.0,1.0,0.0\nann,1,4.0,1.0,5.0\n"
    )


def test_npz_holds_what_the_contract_says(tmp_path):
    scene = scene_of(["sam", "ann"])
    lines = straight_lines(scene)
    (tmp_path / "t.npz").write_bytes(npz_bytes(lines, scene))
    with np.load(tmp_path / "t.npz", allow_pickle=False) as archive:
        assert archive.files == [
            "agent_ids", "offsets", "knots", "radii", "masses", "time_scale", "format",
        ]  # fmt: skip
        assert archive["agent_ids"].tolist() == ["sam", "ann"]
        assert archive["offsets"].tolist() == [0, 3, 6]
        assert archive["knots"].shape == (6, 3)
        assert archive["radii"].tolist() == [0.25, 0.375]
        assert archive["masses"].tolist() == [70.0, 71.0]
        assert archive["time_scale"] == 1.5
        assert archive["format"] == 1
    content = read_npz(tmp_path / "t.npz")
    assert content.time_scale == 1.5
    assert content.radii is not None
    assert content.masses is not None
    assert content.radii.tolist() == [0.25, 0.375]


def test_npz_takes_radii_by_id_not_by_place(tmp_path):
    scene = scene_of(["sam", "ann"])
    lines = straight_lines(scene)
    swapped = WorldLines.from_curves(["ann", "sam"], [lines.curve(1), lines.curve(0)])
    (tmp_path / "t.npz").write_bytes(npz_bytes(swapped, scene))
    radii = read_npz(tmp_path / "t.npz").radii
    assert radii is not None
    assert radii.tolist() == [0.375, 0.25]


def test_same_curves_same_bytes_at_any_time(monkeypatch):
    scene = scene_of(["sam", "ann"])
    lines = straight_lines(scene)
    first = npz_bytes(lines, scene)
    monkeypatch.setattr("time.time", lambda: 2.0e9)
    assert npz_bytes(lines, scene) == first
    with zipfile.ZipFile(io.BytesIO(first)) as archive:
        assert {entry.date_time for entry in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def test_a_folder_reads_the_npz_first(tmp_path):
    scene = scene_of(["sam"])
    lines = straight_lines(scene)
    write_files(tmp_path, scene, {"trajectories": lines})
    (tmp_path / "trajectories.csv").write_text("broken")
    _assert_same(read_trajectories(tmp_path), lines)
    (tmp_path / "trajectories.npz").unlink()
    with pytest.raises(UsageError, match=r"trajectories\.csv:1: the header lacks"):
        read_trajectories(tmp_path)


def test_a_folder_of_a_seed_says_so(tmp_path):
    scene = scene_of(["sam"])
    write_files(tmp_path, scene, {"seed": straight_lines(scene)})
    with pytest.raises(UsageError, match=r"holds no trajectories.*name .*seed\.npz"):
        read_trajectories(tmp_path)


def test_a_foreign_csv_with_columns_in_another_order(tmp_path):
    path = tmp_path / "foreign.csv"
    path.write_bytes(b"\xef\xbb\xbft, x, y, agent, knot\r\n0,1e0,-0.0,a,0\r\n\r\n2, 3 ,4,a,1\r\n")
    lines = read_csv(path)
    assert lines.agent_ids == ("a",)
    assert lines.knots.tolist() == [[1.0, -0.0, 0.0], [3.0, 4.0, 2.0]]


HEAD = "agent,knot,x,y,t\na,0,0,0,0\na,1,1,1,1\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "t.csv:1: the header lacks agent, knot, x, y, t; expected agent,knot,x,y,t"),
        ("agent,knot,x,y\n", "t.csv:1: the header lacks t"),
        ("agent,knot,x,y,t,v\n", "t.csv:1: the header has other columns"),
        ("agent,knot,x,y,t\n", "t.csv:1: there is no row after the header"),
        (HEAD + "a,2,1,1\n", "t.csv:4: 4 values; expected 5"),
        (HEAD + "a,3,1,1,2\n", "t.csv:4: knot '3' of agent 'a'; expected 2"),
        (HEAD + "a,x,1,1,2\n", "t.csv:4: knot 'x' of agent 'a'; expected 2"),
        (HEAD + "a,2,nan,1,2\n", "t.csv:4: x is 'nan'; expected a finite number"),
        (HEAD + "a,2,1,inf,2\n", "t.csv:4: y is 'inf'"),
        (HEAD + "a,2,1,1,1e999\n", "t.csv:4: t is '1e999'"),
        (HEAD + "a,2,1_0,1,2\n", "t.csv:4: x is '1_0'"),
        (HEAD + "a,2,,1,2\n", "t.csv:4: x is ''"),
        (HEAD + "a,2,1e17,1,2\n", "t.csv:4: x is '1e17'; expected no number beyond 1e+09"),
        (HEAD + "a,2,1,1,-1000000000.1\n", "t.csv:4: t is '-1000000000.1'; expected no"),
        (HEAD + ",0,1,1,2\n", "t.csv:4: the agent has no id"),
        (HEAD + "b,0,1,1,2\n", "t.csv:4: agent 'b' has one knot; at least 2 are needed"),
        (HEAD + "b,0,1,1,2\nc,0,1,1,2\n", "t.csv:5: agent 'b' has one knot"),
        (HEAD + "b,0,1,1,2\nb,1,1,1,3\na,0,1,1,4\n", "t.csv:6: the rows of agent 'a' are not"),
        (HEAD + '"a,2,1,1,2\n', "t.csv:4: not well-formed CSV"),
    ],
)
def test_a_broken_csv_is_located(tmp_path, monkeypatch, text, message):
    monkeypatch.chdir(tmp_path)
    Path("t.csv").write_text(text)
    with pytest.raises(UsageError) as caught:
        read_csv(Path("t.csv"))
    assert str(caught.value).startswith(message)


def test_a_csv_that_is_no_text(tmp_path):
    path = tmp_path / "t.csv"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(UsageError, match="UTF-8"):
        read_csv(path)


def _arrays() -> dict[str, object]:
    lines = random_lines(["a", "b"], np.random.default_rng(1))
    return {"agent_ids": np.array(lines.agent_ids), "offsets": lines.offsets, "knots": lines.knots}


def test_a_foreign_npz_needs_the_curves_only(tmp_path):
    np.savez_compressed(tmp_path / "t.npz", **_arrays())
    content = read_npz(tmp_path / "t.npz")
    assert content.world_lines.num_agents == 2
    assert content.radii is content.masses is content.time_scale is None


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"knots": None}, "lacks knots"),
        ({"format": np.array(2)}, "format: is 2; this version reads 1"),
        ({"agent_ids": np.array([1, 2])}, "agent_ids: expected"),
        ({"agent_ids": np.array(["a", "a"])}, "agent_ids: an id stands there twice"),
        ({"agent_ids": np.array([{}, {}])}, "not a readable .npz"),
        ({"offsets": np.array([0.0, 2.0, 4.0])}, "offsets: expected 3 whole numbers"),
        ({"offsets": np.array([0, 2])}, "offsets: expected 3 whole numbers"),
        ({"offsets": np.array([0, 2, 99])}, "offsets: expected to run from 0"),
        ({"offsets": np.array([1, 2, 4]), "knots": np.zeros((4, 3))}, "offsets: expected to run"),
        ({"offsets": np.array([0, 3, 4]), "knots": np.zeros((4, 3))}, "offsets: every agent"),
        ({"knots": np.zeros((4, 2))}, "knots: expected numbers of shape"),
        ({"knots": np.full((4, 3), np.nan)}, r"knots: the number at \(0, 0\) is not finite"),
        ({"knots": np.full((4, 3), -2e9)}, r"knots: the number at \(0, 0\) is beyond 1e\+09"),
        ({"radii": np.ones(3)}, r"radii: expected numbers of shape \(2,\)"),
    ],
)
def test_a_broken_npz_is_located(tmp_path, changes, message):
    arrays = {k: v for k, v in (_arrays() | changes).items() if v is not None}
    np.savez(tmp_path / "t.npz", **arrays)
    with pytest.raises(UsageError, match=message):
        read_npz(tmp_path / "t.npz")


@pytest.mark.parametrize("content", [b"", b"text", b"PK\x03\x04 cut off"])
def test_an_npz_that_is_none(tmp_path, content):
    path = tmp_path / "t.npz"
    path.write_bytes(content)
    with pytest.raises(UsageError, match="not a readable"):
        read_npz(path)


def test_a_damaged_npz(tmp_path):
    scene = scene_of(["sam"])
    content = bytearray(npz_bytes(straight_lines(scene), scene))
    place = bytes(content).index(np.float64(4.0).tobytes())
    content[place] ^= 1
    (tmp_path / "t.npz").write_bytes(content)
    with pytest.raises(UsageError, match="not a readable"):
        read_npz(tmp_path / "t.npz")


def test_a_lone_array_is_no_npz(tmp_path):
    with (tmp_path / "t.npz").open("wb") as stream:
        np.save(stream, np.zeros(3))
    with pytest.raises(UsageError, match="not a readable"):
        read_npz(tmp_path / "t.npz")


def test_missing_files_and_other_suffixes(tmp_path):
    for name in ("no.csv", "no.npz", "no.txt"):
        with pytest.raises(UsageError, match="no such file"):
            read_trajectories(tmp_path / name)
    (tmp_path / "t.doc").write_text("x")
    with pytest.raises(UsageError, match=r"expected a \.csv file"):
        read_trajectories(tmp_path / "t.doc")
