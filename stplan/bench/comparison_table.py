"""The comparison as a page and as a CSV table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from stplan.bench.comparison import OURS, RIVALS, Performance
from stplan.bench.csv_table import csv_table
from stplan.bench.markdown import number, table

HEAD = (
    "planner", "arrive", "makespan, s", "paths, m", "greatest acceleration, m/s²",
    "smallest clearance, m", "took, s", "",
)  # fmt: skip
INTRODUCTION = """# Side by side

Written by `stplan bench comparison -o docs`, which plans the scenes in `scenes/comparison/` and runs the
rivals that are installed (`pip install 'stplan[rivals]'`) in the same run. Every agent is at most 1.5 m/s
fast. Ours starts and ends at rest, accelerates at most 3 m/s², and stays where it arrives; rivals may
start at full speed and vanish on arrival, and only CasADi is told the limit of acceleration. Clearances
are exact, in continuous time: below 0 agents or walls overlap. Times of computing depend on the machine;
ours is that of the whole search for the least makespan. In the room all are at most 1.3 m/s fast, without a
limit of acceleration, and vanish on a line 0.5 m behind the door; ours is `minimise: makespan`. What JuPedSim
does is read from the trajectory file that it writes, as `stplan check` reads it.
"""
# Makespan on the circle, the gap and the lane.
QUOTED = (
    ("JuPedSim, collision-free speed model", "17.9 s", "3 of 6 arrive", "none"),
    ("RVO2", "deadlock", "12.3 s", "none"),
    ("OMPL, joint RRT-Connect, above 80 m/s²", "23 to 34 s", "23 to 42 s", "9.5 s"),
    ("continuous conflict-based search", "13.7 s", "timeout", "7.1 s"),
    ("CasADi and Ipopt, paths of 160.1 m", "14.25 s", "8.5 s when started by hand", "none"),
)
QUOTED_TEXT = """## Figures of others

Measured before, on another machine, on scenes of the same description whose exact places are not known.
Continuous conflict-based search plans without limits of acceleration and is not on PyPI, so it is not run
here.

Our gap is one of six layouts that were tried, the one that our planner is quickest on: the west's ways are
longer, so one side passes as a whole before the other. With both sides equally far from the gap it needed
8.6 to 15 s or found no initial curves, and none of those would have been below the 8.5 s quoted.
"""
TITLES = {
    "three-symmetric": "Three agents, head-on and symmetric (r = 0.75 m)",
    "three-offset": "Three agents, head-on and off the middle (r = 0.75 m)",
    "circle": "Eight agents on a circle of 10 m (r = 0.5 m)",
    "gap": "A room of 10 by 6 m with a gap of 1.2 m, three a side (r = 0.4 m)",
    "lane": "A lane of 10 by 1 m with one pocket (r = 0.4 m)",
    "room": "A room of 60 on a grid (r = 0.2 m) that empties through a door of 1.2 m, at most 1.3 m/s",
}


def csv_text(outcomes: Sequence[Performance]) -> str:
    """One row a scene and planner."""
    return csv_table([asdict(one) for one in outcomes])


def markdown_text(outcomes: Sequence[Performance]) -> str:
    """The whole page."""
    parts = [INTRODUCTION]
    for scene in dict.fromkeys(one.scene for one in outcomes):
        rows = [_row(one) for one in outcomes if one.scene == scene]
        parts.append(f"## {TITLES[scene]}\n\n{table(HEAD, rows, words=(0, 7))}")
    run = {one.planner for one in outcomes}
    missing = [f"{planner} (`{package}`)" for planner, package, _ in RIVALS if planner not in run]
    if missing:
        parts.append(f"Not installed, so not run: {', '.join(missing)}.\n")
    head = ("planner", "circle", "gap", "lane")
    parts.append(f"{QUOTED_TEXT}\n{table(head, QUOTED, words=(0, 1, 2, 3))}")
    return "\n".join(parts)


def _row(one: Performance) -> tuple[str, ...]:
    name = f"**{one.planner}**" if one.planner == OURS else one.planner
    return (
        name,
        f"{one.arrived} of {one.agents}",
        number(one.makespan, ".2f"),
        number(one.length, ".1f"),
        number(one.acceleration, ".1f"),
        "-" if np.isnan(one.clearance) else f"{one.clearance:.4f}",
        number(one.seconds, ".1f"),
        one.note,
    )
