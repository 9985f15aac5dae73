"""SQLite files of unknown origin, read within bounds: what a table is called may be a view without end."""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from typing import Any

from stplan.maps.formats.drawing import FormatError
from stplan.maps.formats.json_tree import LARGEST_TEXT

MOST_ROWS = 10_000_000
# Instructions of SQLite's machine: so many for any file, and for every byte of it; and between two counts.
BASE_WORK, WORK_A_BYTE, STRIDE = 20_000_000, 2, 10_000


def query(content: bytes, statements: Sequence[str]) -> list[list[Any]]:
    """The rows that each statement gives.

    Raises:
        FormatError: the file is no database, lacks what is asked for, or takes too much work.
    """
    connection = sqlite3.connect(":memory:")
    left = BASE_WORK + WORK_A_BYTE * len(content)

    def enough() -> bool:
        nonlocal left
        left -= STRIDE
        return left < 0

    try:
        connection.deserialize(content)
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_TEXT)
        connection.execute("PRAGMA trusted_schema = OFF")
        connection.set_progress_handler(enough, STRIDE)
        found = []
        for statement in statements:
            rows = connection.execute(statement).fetchmany(MOST_ROWS + 1)
            if len(rows) > MOST_ROWS:
                raise FormatError(f"has more than {MOST_ROWS} rows")
            found.append(rows)
        return found
    except (sqlite3.Error, OverflowError) as error:
        raise FormatError(f"is no trajectory file of JuPedSim: {error}") from error
    finally:
        connection.close()
