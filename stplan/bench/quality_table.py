"""How near plans are to the best ones known, as a CSV and as a Markdown table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from stplan.bench.csv_table import csv_table
from stplan.bench.ledger import Entry, beaten_by
from stplan.bench.markdown import number, table
from stplan.bench.quality import Quality
from stplan.bench.result_files import result_files

_HEAD = (
    "scene",
    "agents",
    "by default",
    "s",
    "improved",
    "moves",
    "kept",
    "s",
    "best known",
    "default over best %",
    "improved over best %",
    "certified",
)
_WORDS = (0, 11)


def files(ledger: Mapping[str, Entry], measured: Sequence[Quality]) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    return result_files(
        "quality", csv_text(ledger, measured), markdown_text(ledger, measured)
    )  # fmt: skip


def csv_text(ledger: Mapping[str, Entry], measured: Sequence[Quality]) -> str:
    """One row a scene."""
    return csv_table(
        [
            {
                "scene": one.scene,
                "agents": one.agents,
                "planned": one.planned,
                "planned_seconds": one.planned_seconds,
                "improved": one.improved,
                "moves": one.moves,
                "accepted": one.accepted,
                "improve_seconds": one.improve_seconds,
                "best_known": _known(ledger, one),
                "certified": one.certified,
            }
            for one in measured
        ]
    )


def markdown_text(ledger: Mapping[str, Entry], measured: Sequence[Quality]) -> str:
    """The table, and which scenes beat the ledger."""
    rows = [_row(one, _known(ledger, one)) for one in measured]
    text = table(_HEAD, rows, _WORDS)
    beaten = beaten_by(ledger, [entry for one in measured for entry in one.entries()])
    for entry in beaten:
        known = ledger.get(entry.scene)
        before = "no plan was known" if known is None else f"{known.cost:.6g} was known"
        text += f"\n{entry.scene} is a record: {entry.cost:.6g}, {before}.\n"
    return text


def _row(one: Quality, known: float) -> tuple[str, ...]:
    return (
        one.scene,
        str(one.agents),
        f"{one.planned:.5g}",
        f"{one.planned_seconds:.1f}",
        f"{one.improved:.5g}",
        str(one.moves),
        str(one.accepted),
        f"{one.improve_seconds:.1f}",
        number(known, ".5g"),
        number(100.0 * (one.planned / known - 1.0), ".1f"),
        number(100.0 * (one.improved / known - 1.0), ".1f"),
        "yes" if one.certified else "no",
    )


def _known(ledger: Mapping[str, Entry], one: Quality) -> float:
    """The least cost known of a scene, nan where none is."""
    entry = ledger.get(one.scene)
    return np.nan if entry is None else entry.cost
