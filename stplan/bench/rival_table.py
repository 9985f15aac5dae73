"""What the duel with the rival writes: a CSV of duels, a table of sizes, a figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from stplan.bench.csv_table import csv_table
from stplan.bench.markdown import number, table
from stplan.bench.plots import Series, growth_figure
from stplan.bench.result_files import result_files
from stplan.bench.rival import ASKED_COST, ASKED_FASTER, Duel
from stplan.bench.scaling import growth

_HEAD = (
    "agents",
    "ours s",
    "rival s",
    "times faster",
    "asked",
    "our cost over the rival's",
    "asked",
    "our clearance mm",
    "rival's mm",
    "enlarged by %",
    "as asked mm",
)


def files(duels: Sequence[Duel]) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    return result_files("rival", csv_text(duels), markdown_text(duels), picture(duels))


def csv_text(duels: Sequence[Duel]) -> str:
    """One row a duel; `unpadded_` is the rival with distances as asked."""
    rows = []
    for one in duels:
        row = {key: value for key, value in asdict(one).items() if not isinstance(value, dict)}
        row |= {"faster": one.faster, "dearer": one.dearer}
        for name in ("rival", "unpadded"):
            row |= {f"{name}_{key}": value for key, value in asdict(getattr(one, name)).items()}
        rows.append(row)
    return csv_table(rows)


def markdown_text(duels: Sequence[Duel]) -> str:
    """One row a size, medians over the draws, and how both grow."""
    rows = []
    for agents in dict.fromkeys(one.agents for one in duels):
        ones = [one for one in duels if one.agents == agents]
        clear = [one for one in ones if one.rival.certified]
        # Where the rival found nothing clear, its time is what it was given.
        bound = "" if len(clear) == len(ones) else "> "
        rows.append(
            (
                str(agents),
                f"{_median([one.seconds for one in ones]):.2f}",
                f"{bound}{_median([one.rival.seconds for one in ones]):.2f}",
                f"{bound}{_median([one.faster for one in ones]):.1f}",
                f"{ASKED_FASTER[agents]:g}" if agents in ASKED_FASTER else "-",
                number(_median([one.dearer for one in clear]), ".4f"),
                f"{ASKED_COST:g}",
                f"{1e3 * min(one.clearance for one in ones):.0f}",
                number(min((1e3 * one.rival.clearance for one in clear), default=np.nan), ".0f"),
                number(_median([100 * one.rival.padding for one in clear]), ".0f"),
                f"{1e3 * min(one.unpadded.clearance for one in ones):.0f}",
            )
        )
    powers = [one.exponent for one in _series(duels)]
    return (
        f"{table(_HEAD, rows)}\n"
        f"Time ~ agents^{powers[0]:.2f} (ours), agents^{powers[1]:.2f} (rival), fitted.\n"
    )


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if values else float("nan")


def _series(duels: Sequence[Duel]) -> list[Series]:
    """Median seconds over agents, ours and the rival's."""
    sizes = sorted({one.agents for one in duels})
    groups = [[one for one in duels if one.agents == agents] for agents in sizes]
    found = []
    for label, seconds in (
        ("this planner", [_median([one.seconds for one in ones]) for ones in groups]),
        ("CasADi and Ipopt", [_median([one.rival.seconds for one in ones]) for ones in groups]),
    ):
        found.append(Series(label, sizes, seconds, growth(sizes, seconds)))
    return found


def picture(duels: Sequence[Duel]) -> bytes:
    """PNG of seconds over agents."""
    return growth_figure("whole plan of crossing flows", "agents", "s", _series(duels))
