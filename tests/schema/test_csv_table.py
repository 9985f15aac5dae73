"""Files of spreadsheets and of other programs are read as what they are."""

from __future__ import annotations

from pathlib import Path

import pytest

from stplan.errors import SceneError, UsageError
from stplan.files.csv_file import read_csv
from stplan.scene import parse_scene
from stplan.schema.csv_table import CsvTable, known_columns

ROWS = [("agent", "knot", "x", "y", "t"), ("a", 0, 0.5, 1, 0), ("a", 1, 2.25, -1, 3)]
CURVE = [[0.5, 1.0, 0.0], [2.25, -1.0, 3.0]]


def table(delimiter: str, comma: bool = False, rows: list[tuple[object, ...]] = ROWS) -> str:
    """The rows as text."""
    text = "\n".join(delimiter.join(map(str, row)) for row in rows) + "\n"
    return text.replace(".", ",") if comma else text


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("comma", [False, True])
def test_trajectories(tmp_path: Path, delimiter: str, encoding: str, comma: bool) -> None:
    path = tmp_path / "t.csv"
    path.write_bytes(table(delimiter, comma and delimiter != ",").encode(encoding))
    lines = read_csv(path)
    assert lines.agent_ids == ("a",)
    assert lines.knots.tolist() == CURVE


@pytest.mark.parametrize(
    "header",
    [
        "id,step,pos_x,pos_y,time", "Agent ID,Index,X [m],Y [m],T [s]", "ped,node,x_m,y_m,time_s",
        "track-id,vertex,x (m),y (m),t/s", '"Name","knot","Position X","Position Y","Timestamp"',
    ],
)  # fmt: skip
def test_columns_of_other_programs(tmp_path: Path, header: str) -> None:
    path = tmp_path / "t.csv"
    path.write_text(f"{header}\na,0,0.5,1,0\na,1,2.25,-1,3\n")
    assert read_csv(path).knots.tolist() == CURVE


def test_knots_need_not_be_numbered_nor_rows_be_sorted(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("time;id;x;y\n0;a;0,5;1\n0;b;7;7\n3;a;2,25;-1\n4;b;8;7\n")
    lines = read_csv(path)
    assert lines.agent_ids == ("a", "b")
    assert lines.curve(0).tolist() == CURVE
    assert lines.curve(1).tolist() == [[7, 7, 0], [8, 7, 4]]
    path.write_text("time,id,x,y\n0,a,0,1\n0,b,7,7\n3,a,2,-1\n")
    with pytest.raises(UsageError, match="agent 'b' has one knot"):
        read_csv(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("agent;knot;x;y\n", "lacks t; expected agent,knot,x,y,t, separated by semicolons"),
        ("agent knot x y t\n", "commas, semicolons, tabs, bars between them; it has none"),
        ("agent,knot,x [mm],y [mm],t\n", "the header lacks x, y"),
        ("agent,knot,x,y,t,v,w\n", "the header has other columns: v, w; expected agent,knot"),
        ("agent,knot,x,y,t,time\n", "the header has other columns twice"),
    ],
)
def test_what_is_not_understood_is_named(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "t.csv"
    path.write_text(text)
    with pytest.raises(UsageError) as caught:
        read_csv(path)
    assert str(caught.value).startswith(f"{path}:1: ")
    assert message in str(caught.value)


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|"])
@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_tables_of_agents(tmp_path: Path, delimiter: str, encoding: str) -> None:
    rows: list[tuple[object, ...]] = [
        ("id", "start_x", "start_y", "goal_x", "goal_y", "radius"), ("a", 0, 0, 9.5, 2, 0.25),
    ]  # fmt: skip
    (tmp_path / "a.csv").write_bytes(table(delimiter, delimiter != ",", rows).encode(encoding))
    text = "stplan: 1\nhorizon: 9\nagents: [{file: a.csv}]\n"
    (agent,) = parse_scene(text, directory=tmp_path).agents
    assert (agent.goal, agent.radius) == ((9.5, 2.0), 0.25)


def test_a_table_without_a_delimiter(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("id start_x start_y goal_x goal_y\na 0 0 9 9\n")
    with pytest.raises(
        SceneError, match="commas, semicolons, tabs, bars between them; it has none"
    ):
        parse_scene("stplan: 1\nhorizon: 9\nagents: [{file: a.csv}]\n", directory=tmp_path)


def test_commas_in_numbers_only_where_they_separate_nothing() -> None:
    assert CsvTable("", ";").number("1,5") == "1.5"
    assert CsvTable("", ";").number("-,5e3") == "-.5e3"
    assert CsvTable("", ";").number("1,000,000") == "1,000,000"
    assert CsvTable("", ",").number("1,5") == "1,5"
    assert known_columns([" X ", "speed"], {"x": ()}) == ["x", "speed"]
