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

COLUMNS = ("agent", "knot", "x", "y", "t")


def csv_bytes(lines: WorldLines) -> bytes:
    """`lines` as CSV in UTF-8; floats in the shortest form that round-trips to the same bits."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for agent_id, curve in zip(lines.agent_ids, lines.curves(), strict=True):
        for knot, (x, y, t) in enumerate(curve.tolist()):
            writer.writerow((agent_id, knot, repr(x), repr(y), repr(t)))
    return text.getvalue().encode()


def read_csv(path: Path) -> WorldLines:
    """Read trajectories, written by this program or not; columns may stand in any order.

    Rows of an agent are contiguous, its knots are numbered 0, 1, 2, ... and are at least two. No number
    is beyond `LARGEST`: so far out, distances of metres would be rounding.
    That times increase is not asked here: it is one of the promises that a certificate checks.

    Raises:
        UsageError: headed by file and line.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise UsageError(f"{path}: not a text file in UTF-8: {error}") from error
    return _Reader(path).read(text)


class _Reader:
    """One pass over the rows, knowing where it is."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.line = 1
        self.agent_ids: list[str] = []
        self.curves: list[list[tuple[float, float, float]]] = []
        self.seen: set[str] = set()

    def read(self, text: str) -> WorldLines:
        rows = csv.reader(io.StringIO(text, newline=""), strict=True)
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
        self._close_agent()
        return WorldLines.from_curves(self.agent_ids, [np.array(curve) for curve in self.curves])

    def _header(self, row: list[str]) -> list[int]:
        names = [name.strip() for name in row]
        missing = [name for name in COLUMNS if name not in names]
        if missing:
            raise self._error(
                f"the header lacks {', '.join(missing)}; expected {','.join(COLUMNS)}"
            )
        if len(names) != len(COLUMNS):
            raise self._error(f"the header has other columns; expected {','.join(COLUMNS)}")
        return [names.index(name) for name in COLUMNS]

    def _row(self, row: list[str], places: list[int]) -> None:
        if len(row) != len(COLUMNS):
            raise self._error(f"{len(row)} values; expected {len(COLUMNS)}")
        agent_id, knot, x, y, t = (row[place] for place in places)
        if not self.agent_ids or agent_id != self.agent_ids[-1]:
            self._open_agent(agent_id)
        curve = self.curves[-1]
        if knot.strip() != str(len(curve)):
            raise self._error(f"knot {knot!r} of agent {agent_id!r}; expected {len(curve)}")
        curve.append((self._number("x", x), self._number("y", y), self._number("t", t)))

    def _open_agent(self, agent_id: str) -> None:
        if not agent_id:
            raise self._error("the agent has no id")
        if agent_id in self.seen:
            raise self._error(f"the rows of agent {agent_id!r} are not contiguous")
        self._close_agent()
        self.seen.add(agent_id)
        self.agent_ids.append(agent_id)
        self.curves.append([])

    def _close_agent(self) -> None:
        if self.curves and len(self.curves[-1]) < 2:
            raise self._error(f"agent {self.agent_ids[-1]!r} has one knot; at least 2 are needed")

    def _number(self, name: str, text: str) -> float:
        try:
            value = float(text)
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
