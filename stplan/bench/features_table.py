"""The features of planners as a page and as CSV."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from stplan.bench.csv_table import csv_table
from stplan.bench.features import FEATURES, RIVALS, Finding
from stplan.bench.markdown import number, table

INTRODUCTION = """# Features, measured

Written by `stplan bench features -o docs`: for every feature a small scene that needs it, given to this
planner and to the rivals that are installed (`pip install 'stplan[rivals]'`), and a figure of the motion that
comes out, whoever made it. A feature is there where everybody arrives, nobody overlaps anything by more than
a hundredth of its radius, and the figure is within its bounds. Rivals get what they have an input for:
places, radii, walls, each agent's shortest way, and a speed (what the preferred arrival asks for, if any).
None takes masses or meetings, and none is asked to.

Of the planners that the paper compares with only RVO is a package that can be run here. Repulsive curves are
their energy, written anew on space-time rods a tenth longer than straight ones, on open floors
([performance](performance.md#repulsive-curves)). Implicit crowds, NH-TTC, continuum crowds, space-time plans
with parameterised locomotion, and modular steering are not run. The other planners are those of
[the comparison](comparison.md), whose scenes are harder: in the gap of three agents here RVO2 arrives, in
that of six there it does not.
"""
TOUCHING = """
The last row counts the scenes, of those that were run, in which everybody arrives and nothing touches at any
time, by however little: what the certificate demands of our plans.
"""


def files(findings: Sequence[Finding]) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    return {
        "features.csv": csv_table([asdict(one) for one in findings]).encode(),
        "features.md": _page(findings).encode(),
    }


def _page(findings: Sequence[Finding]) -> str:
    planners = list(dict.fromkeys(one.planner for one in findings))
    known = {(one.feature, one.planner): one for one in findings}
    measured = [feature for feature in FEATURES if (feature.name, planners[0]) in known]
    rows = [
        (
            feature.name,
            feature.measured,
            feature.asked,
            *(_cell(known.get((feature.name, planner))) for planner in planners),
        )
        for feature in measured
    ]
    counts = [_untouched([one for one in findings if one.planner == own]) for own in planners]
    rows.append(("touching nothing", "scenes", "all", *counts))
    head = ("feature", "measured", "asked", *planners)
    missing = [planner for planner, _, _ in RIVALS if planner not in planners]
    absent = f"\nNot installed, so not run: {', '.join(missing)}.\n" if missing else ""
    return f"{INTRODUCTION}\n{table(head, rows, words=range(len(head)))}{TOUCHING}{absent}"


def _cell(one: Finding | None) -> str:
    if one is None:
        return "-"
    word = "yes" if one.there else "no"
    figure = one.note if one.note or np.isnan(one.figure) else number(one.figure, ".3g")
    return f"{word}: {figure}"


def _untouched(findings: Sequence[Finding]) -> str:
    count = sum(one.arrived and one.clearance > 0 for one in findings)
    return f"{count} of {len(findings)}"
