"""CSV tables beside a scene: their rows, and everything that is wrong with them at once."""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from stplan.schema.csv_table import CsvTable
from stplan.schema.mapping import Fault

LARGEST_TABLE = 16 * 1024 * 1024
# Faults of a table that are shown.
MOST_FAULTS = 20

Read = TypeVar("Read")
# The cells of a row by their columns -> what it says, and its faults.
ReadRow = Callable[[dict[str, str]], tuple[Read, list[str]]]


def table_rows(
    name: str,
    directory: Path,
    path: str,
    faults: list[Fault],
    *,
    needed: Sequence[str],
    known: Sequence[str],
    most: int,
    read: ReadRow[Read],
) -> list[Read]:
    """What the rows of a table say; nothing where there are new faults.

    Args:
        name: of the file, relative to the `directory` of the scene.
        path: where the scene names it.
        needed, known: columns that must be there, and all that may be.
        most: rows.
        read: given stripped cells, numbers without decimal commas; commas separate fields or nothing.
    """
    table = _table(name, directory, path, faults)
    if table is None:
        return []
    rows = table.rows()
    found: list[Read] = []
    bad: list[str] = []
    try:
        header = [cell.strip() for cell in next(rows, [])]
        bad = _header_faults(header, table, needed, known)
        for row in () if bad else rows:
            if not any(cell.strip() for cell in row):
                continue
            if len(row) != len(header):
                wrong = [f"{len(row)} values; {len(header)} are expected"]
            else:
                cells = (table.number(cell).strip() for cell in row)
                values, wrong = read(dict(zip(header, cells, strict=True)))
                if not wrong:
                    found.append(values)
            bad += [f"line {rows.line_num}: {sentence}" for sentence in wrong]
            if len(found) > most or len(bad) > most:
                bad.insert(0, f"has more than {most} rows")
                break
    except csv.Error as error:
        bad.append(f"line {rows.line_num}: is not well-formed CSV: {error}")
    if not bad and not found:
        bad.append("there is no row after the header")
    more = len(bad) - MOST_FAULTS
    bad = bad[:MOST_FAULTS] + ([f"and {more} more faults"] if more > 0 else [])
    faults += [(path, f"{name}: {sentence}") for sentence in bad]
    return [] if bad else found


def _table(name: str, directory: Path, path: str, faults: list[Fault]) -> CsvTable | None:
    """The CSV table of a name beside the scene; None with a new fault."""
    source = directory / name
    try:
        if Path(name).is_absolute():
            text = f"is {name!r}, an absolute path; one relative to the scene file is expected"
            faults.append((path, text))
            return None
        if "\x00" in name or not source.is_file():
            faults.append((path, f"there is no file {name!r} beside the scene"))
            return None
        if source.stat().st_size > LARGEST_TABLE:
            faults.append((path, f"{name!r} is larger than {LARGEST_TABLE // 2**20} MiB"))
            return None
        return CsvTable.of(source.read_bytes())
    except UnicodeDecodeError:
        faults.append((path, f"{name!r} is not UTF-8; a text is expected"))
    except OSError as error:
        faults.append((path, f"{name[:100]!r} cannot be read: {error.strerror}"))
    return None


def _header_faults(
    header: Sequence[str], table: CsvTable, needed: Sequence[str], known: Sequence[str]
) -> list[str]:
    missing = [name for name in needed if name not in header]
    if missing and len(header) == 1:
        return [f"the header lacks {', '.join(missing)}; columns{table.separation(header)}"]
    faults = [f"the header lacks {name}" for name in missing]
    faults += [
        f"the header has {name!r}; known columns are {', '.join(known)}"
        for name in header
        if name not in known
    ]
    if not faults and len(set(header)) < len(header):
        faults.append("the header has a column twice")
    return faults
