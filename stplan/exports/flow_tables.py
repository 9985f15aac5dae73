"""Flow figures as tables and words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.arrays import FloatArray
from stplan.exports.flow import FLOW_SPAN, FlowFigures


def csv_files(figures: FlowFigures) -> dict[str, bytes]:
    """Names and contents of the tables: one of the evacuation, one or two a line, one an area."""
    files = {"evacuation.csv": _csv(("time_s", "on_the_way", "arrived"), figures.evacuation)}
    for line in figures.lines:
        name = line.probe.name
        files[f"crossings-{name}.csv"] = _csv(("time_s", "crossed"), line.crossings)
        files[f"flow-{name}.csv"] = _csv(("flow_per_s", "mean_speed_m_per_s"), line.flows)
    head = (
        "time_s", "density_per_m2", "voronoi_density_per_m2", "voronoi_speed_m_per_s",
        "specific_flow_per_m_s",
    )  # fmt: skip
    for area in figures.areas:
        files[f"fundamental-diagram-{area.probe.name}.csv"] = _csv(head, area.rows)
    return files


def sentences(figures: FlowFigures) -> list[str]:
    """What the tables come to."""
    table = figures.evacuation
    whole = int(table[-1, 2])
    found = [f"{whole} have arrived at {table[-1, 0]:.2f} s"]
    half = np.flatnonzero(table[:, 2] >= 0.5 * whole)
    if whole and len(half):
        found[0] += f", half of them at {table[half[0], 0]:.2f} s"
    for line in figures.lines:
        text = f"{line.probe.name}: {int(line.crossings[-1, 1])} cross"
        if line.mean_flow is not None:
            length = float(np.hypot(*np.diff(np.array(line.probe.points), axis=0)[0]))
            text += (
                f", {line.mean_flow:.2f} a second, {line.mean_flow / length:.2f} a second and metre"
            )
        found.append(text)
    for area in figures.areas:
        if len(area.rows):
            dense, slow = float(area.rows[:, 2].max()), float(np.nanmean(area.rows[:, 3]))
            found.append(
                f"{area.probe.name}: up to {dense:.2f} a square metre, {slow:.2f} m/s on average"
            )
    found.append(
        f"flows are taken over {FLOW_SPAN:g} s; agents are discs without headings or body ellipses"
    )
    return found


def _csv(head: Sequence[str], rows: FloatArray) -> bytes:
    lines = [",".join(head)]
    lines += [",".join("" if np.isnan(x) else f"{x:.6g}" for x in row) for row in rows]
    return ("\n".join(lines) + "\n").encode()
