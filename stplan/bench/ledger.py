"""The ledger: the least cost known of every scene, certified, with the command that reached it.

A CSV with the columns scene, cost (`own_costs` of all agents in the scene as it is shipped) and command. It
only ever improves.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from stplan.bench.csv_table import csv_table
from stplan.errors import UsageError

_COLUMNS = ("scene", "cost", "command")
# Costs that differ by less than this share are the same: other machines round differently.
SAME = 1e-6


@dataclass(frozen=True)
class Entry:
    """The best plan known of a scene.

    Attributes:
        scene: its file below the folder of all scenes, without the suffix.
        command: of stplan, that plans it at this cost.
    """

    scene: str
    cost: float
    command: str


def read_ledger(path: Path) -> dict[str, Entry]:
    """The entries by scene; none where there is no such file yet.

    Raises:
        UsageError: it is not a ledger.
    """
    if not path.exists():
        return {}
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            reader = csv.DictReader(stream, strict=True)
            if tuple(reader.fieldnames or ()) != _COLUMNS:
                raise ValueError(f"expected the columns {', '.join(_COLUMNS)}")
            entries = [Entry(row["scene"], float(row["cost"]), row["command"]) for row in reader]
    except (OSError, UnicodeDecodeError, ValueError, TypeError, csv.Error) as error:
        raise UsageError(f"{path} is no ledger: {error}") from error
    return {entry.scene: entry for entry in entries}


def beaten_by(ledger: Mapping[str, Entry], found: Iterable[Entry]) -> list[Entry]:
    """Those of `found` that are cheaper than the ledger's, or new to it."""
    return [
        entry
        for entry in found
        if entry.scene not in ledger or entry.cost < (1.0 - SAME) * ledger[entry.scene].cost
    ]


def ledger_text(ledger: Mapping[str, Entry], found: Iterable[Entry]) -> str:
    """The ledger with what is cheaper of `found`, sorted by scene."""
    merged = {**ledger, **{entry.scene: entry for entry in beaten_by(ledger, found)}}
    return csv_table(
        [
            {"scene": name, "cost": f"{merged[name].cost:.8g}", "command": merged[name].command}
            for name in sorted(merged)
        ]
    )
