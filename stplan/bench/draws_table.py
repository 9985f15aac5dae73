"""What default plans of random draws cost over the best ones found, as a CSV and as a Markdown table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from stplan.bench.csv_table import csv_table
from stplan.bench.draws import DEFAULT, DrawTrial
from stplan.bench.markdown import number, table
from stplan.bench.result_files import result_files

# Shares over the best that count as near.
NEAR, NOT_FAR = 0.02, 0.05
_HEAD = (
    "family",
    "draws",
    "planned",
    f"within {NEAR:.0%}",
    f"within {NOT_FAR:.0%}",
    "median %",
    "worst %",
    "s",
    "best by",
)
_WORDS = (0, 8)


def files(measured: Sequence[DrawTrial]) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    return result_files("draws", csv_text(measured), markdown_text(measured))


def csv_text(measured: Sequence[DrawTrial]) -> str:
    """One row a draw."""
    return csv_table(
        [
            {
                "family": one.family,
                "draw": one.draw,
                "agents": one.agents,
                "seconds": one.seconds,
                "best": one.best,
                "excess": one.excess,
                **one.costs,
            }
            for one in measured
        ]
    )


def markdown_text(measured: Sequence[DrawTrial]) -> str:
    """One row a family, and one for all; draws that nothing has planned count in `draws` only."""
    families = list(dict.fromkeys(one.family for one in measured))
    rows = [_row(name, [one for one in measured if one.family == name]) for name in families]
    if len(families) > 1:
        rows.append(_row("all", measured))
    return table(_HEAD, rows, _WORDS)


def _row(name: str, draws: Sequence[DrawTrial]) -> tuple[str, ...]:
    excess = np.array([one.excess for one in draws if one.best])
    planned = sum(not np.isnan(one.costs[DEFAULT]) for one in draws)
    dearer = Counter(one.best for one in draws if one.excess > NEAR)
    return (
        name,
        str(len(draws)),
        str(planned),
        _share(excess <= NEAR),
        _share(excess <= NOT_FAR),
        number(100.0 * float(np.median(excess)) if len(excess) else np.nan, ".1f"),
        number(100.0 * float(excess.max()) if len(excess) else np.nan, ".1f"),
        f"{np.median([one.seconds for one in draws]):.1f}",
        ", ".join(f"{method} {count}" for method, count in dearer.most_common()) or "-",
    )


def _share(near: np.ndarray) -> str:
    return f"{near.mean():.0%}" if len(near) else "-"
