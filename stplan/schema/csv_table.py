"""CSV as other programs write it: what separates its fields, decimal commas, names of columns.

Spreadsheets of half the world write semicolons between fields and commas in numbers, and put a mark of
the byte order in front.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

# What may stand between fields, by how it is called in messages.
DELIMITERS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars"}
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")
_DECIMAL_COMMA = re.compile(r"\s*[-+]?[0-9]*,[0-9]+(?:[eE][-+]?[0-9]+)?\s*\Z")
# Units that change nothing, as in "x [m]", "t (s)" or "time/s".
_UNIT = re.compile(r"\s*(?:\[\s*(?:m|s)\s*\]|\(\s*(?:m|s)\s*\)|/\s*(?:m|s))\s*\Z")


@dataclass(frozen=True)
class CsvTable:
    """The text of a CSV file, and what stands between its fields."""

    text: str
    delimiter: str

    @staticmethod
    def of(content: bytes) -> CsvTable:
        """The table that a file holds, in UTF-8, or in UTF-16 that begins with the mark of the byte order.

        Raises:
            UnicodeDecodeError: it is in neither.
        """
        marked = content.startswith(_UTF_16) and len(content) > len(_UTF_16[0])
        text = content.decode("utf-16" if marked else "utf-8-sig")
        header = text.lstrip("\r\n").partition("\n")[0]
        counts = {mark: header.count(mark) for mark in DELIMITERS}
        return CsvTable(text, max(counts, key=counts.__getitem__))

    def rows(self) -> Any:
        """A strict reader of the rows, as `csv.reader`."""
        return csv.reader(io.StringIO(self.text, newline=""), strict=True, delimiter=self.delimiter)

    def number(self, cell: str) -> str:
        """A number as Python writes it: without a decimal comma, where commas separate no fields."""
        comma = self.delimiter != "," and _DECIMAL_COMMA.match(cell)
        return cell.replace(",", ".") if comma else cell

    def separation(self, header: Sequence[str]) -> str:
        """What to say of the delimiter where a column of the `header` is missing; empty with commas."""
        if len(header) > 1:
            return "" if self.delimiter == "," else f", separated by {DELIMITERS[self.delimiter]}"
        return f" with {', '.join(DELIMITERS.values())} between them; it has none of these"


def known_columns(header: Sequence[str], names: Mapping[str, Sequence[str]]) -> list[str]:
    """The columns of a `header` by the names they are known under; those that are not stay as they are.

    Args:
        names: what else a column may be called, in small letters, by its own name.
    """
    known = {other: name for name, others in names.items() for other in (name, *others)}
    plain = [cell.strip() for cell in header]
    folded = [re.sub(r"[\s-]+", "_", _UNIT.sub("", cell).lower()) for cell in plain]
    return [known.get(fold, cell) for fold, cell in zip(folded, plain, strict=True)]
