"""World lines as text: `agent,knot,x,y,t`, a row a knot, numbers that read back exactly."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

import numpy as np

from stplan.amounts import LARGEST
from stplan.errors import UsageError
from stplan.problem.world_lines import WorldLines
from stplan.schema.csv_table import CsvTable, known_columns

COLUMNS = ("agent", "knot", "x", "y", "t")
# What other programs call them.
NAMES = {
    "agent": (
        "agent_id", "agentid", "id", "name", "ped", "ped_id", "pedestrian", "pedestrian_id", "person",
        "person_id", "track", "track_id", "robot", "robot_id",
    ),
    "knot": ("index", "step", "node", "vertex"),
    "x": ("pos_x", "position_x", "x_pos", "x_m"),
    "y": ("pos_y", "position_y", "y_pos", "y_m"),
    "t": ("time", "timestamp", "t_s", "time_s", "seconds"),
}  # fmt: skip


def csv_bytes(lines: WorldLines) -> bytes:
    """`lines` as CSV in UTF-8; floats in the shortest form that round-trips to the same bits."""
    rows = [",".join(COLUMNS) + "\n"]
    for agent_id, curve in zip(lines.agent_ids, lines.curves(), strict=True):
        name = _field(agent_id)
        rows += [
            f"{name},{knot},{x!r},{y!r},{t!r}\n" for knot, (x, y, t) in enumerate(curve.tolist())
        ]
    return "".join(rows).encode()


def _field(text: str) -> str:
    """`text` as a field of a row, in quotes where it needs them."""
    row = io.StringIO(newline="")
    csv.writer(row, lineterminator="\n").writerow((text, 0))
    return row.getvalue().removesuffix(",0\n")


def read_csv(path: Path) -> WorldLines:
    """Read trajectories, written by this program or not; columns may stand in any order.

    Fields are separated by commas, semicolons, tabs or bars, and columns may have the names of other
    programs (`NAMES`). Rows of an agent are contiguous, its knots are numbered 0, 1, 2, ... and are at
    least two. Without a column of knots they are counted as they come, and rows of agents may alternate.
    No number is beyond `LARGEST`: so far out, distances of metres would be rounding.
    That times increase is not asked here: it is one of the promises that a certificate checks.

    Raises:
        UsageError: headed by file and line.
    """
    path = Path(path)
    try:
        table = CsvTable.of(path.read_bytes())
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise UsageError(f"{path}: not a text file in UTF-8: {error}") from error
    return _Reader(path, table).read()


class _Reader:
    """One pass over the rows, knowing where it is."""

    def __init__(self, path: Path, table: CsvTable) -> None:
        self.path, self.table = path, table
        self.line = 1
        self.num_columns = 0
        self.agent_ids: list[str] = []
        self.curves: list[list[tuple[float, float, float]]] = []
        # Where the curve of every agent is.
        self.seen: dict[str, int] = {}

    def read(self) -> WorldLines:
        rows = self.table.rows()
        try:
            places = self._header(next(rows, []))
            for row in rows:
                self.line = rows.line_num
                if row:
                    self._row(row, places)
        except csv.Error as error:
            self.line = rows.line_num
            raise self._error(f"not well-formed CSV: {error}") from error
        if not self.agent_ids:
            raise self._error("there is no row after the header")
        for agent_id in self.agent_ids:
            self._close_agent(agent_id)
        return WorldLines.from_curves(self.agent_ids, [np.array(curve) for curve in self.curves])

    def _header(self, row: list[str]) -> list[int | None]:
        """Where each of `COLUMNS` stands; None where knots are not numbered."""
        names = known_columns(row, NAMES)
        self.num_columns = len(names)
        numbered = "knot" in names or not set(COLUMNS) - {"knot"} <= set(names)
        wanted = [name for name in COLUMNS if numbered or name != "knot"]
        missing = [name for name in wanted if name not in names]
        expected = f"expected {','.join(COLUMNS)}"
        if missing:
            more = self.table.separation(row)
            raise self._error(f"the header lacks {', '.join(missing)}; {expected}{more}")
        if len(names) != len(wanted):
            others = [name for name in names if name not in wanted]
            which = ": " + ", ".join(others) if others else " twice"
            raise self._error(f"the header has other columns{which}; {expected}")
        return [names.index(name) if name in names else None for name in COLUMNS]

    def _row(self, row: list[str], places: list[int | None]) -> None:
        if len(row) != self.num_columns:
            raise self._error(f"{len(row)} values; expected {self.num_columns}")
        agent_id, knot, x, y, t = (None if place is None else row[place] for place in places)
        if not agent_id:
            raise self._error("the agent has no id")
        numbered = knot is not None
        if agent_id not in self.seen or (numbered and agent_id != self.agent_ids[-1]):
            self._open_agent(agent_id, numbered=numbered)
        curve = self.curves[self.seen[agent_id]]
        if knot is not None and knot.strip() != str(len(curve)):
            raise self._error(f"knot {knot!r} of agent {agent_id!r}; expected {len(curve)}")
        curve.append(
            (self._number("x", x or ""), self._number("y", y or ""), self._number("t", t or ""))
        )

    def _open_agent(self, agent_id: str, *, numbered: bool) -> None:
        if agent_id in self.seen:
            raise self._error(f"the rows of agent {agent_id!r} are not contiguous")
        if self.agent_ids and numbered:
            self._close_agent(self.agent_ids[-1])
        self.seen[agent_id] = len(self.curves)
        self.agent_ids.append(agent_id)
        self.curves.append([])

    def _close_agent(self, agent_id: str) -> None:
        if len(self.curves[self.seen[agent_id]]) < 2:
            raise self._error(f"agent {agent_id!r} has one knot; at least 2 are needed")

    def _number(self, name: str, text: str) -> float:
        try:
            value = float(self.table.number(text))
        except ValueError:
            value = math.nan
        # Python reads 1_000 as a number; no other reader of CSV does.
        if not math.isfinite(value) or "_" in text:
            raise self._error(f"{name} is {text!r}; expected a finite number")
        if abs(value) > LARGEST:
            raise self._error(f"{name} is {text!r}; expected no number beyond {LARGEST:g}")
        return value

    def _error(self, message: str) -> UsageError:
        return UsageError(f"{self.path}:{self.line}: {message}")
