"""A second run on the page of the first: agents matched by id, and where they differ most."""

from __future__ import annotations

from typing import Any

import numpy as np

from stplan.analysis.paths import place_at
from stplan.files.compare import compare_trajectories
from stplan.viewing.run_view import RunView


def other_content(view: RunView, other: RunView, title: str, colours: list[str]) -> dict[str, Any]:
    """What the page's scripts read of the `other` run: its agents in its own order, and differences.

    `row` is an agent's place in the first run, None for those who are only in the second, who are grey.
    `differences` are the greatest distances at one instant, the greatest first; `a` is the place in the
    first run.
    """
    return {
        "title": title,
        "begin": other.begin,
        "end": other.end,
        "agents": [
            {
                "id": name,
                "row": view.rows.get(name),
                "colour": colours[view.rows[name]] if name in view.rows else "#888888",
                "radius": float(other.radii[a]),
                "knots": np.round(other.lines.curve(a), 6).tolist(),
                "leaves": float(other.seen_until(max(view.end, other.end))[a]),
            }
            for a, name in enumerate(other.lines.agent_ids)
        ],
        "differences": _differences(view, other),
        "missing": [name for name in view.lines.agent_ids if name not in other.rows],
    }


def _differences(view: RunView, other: RunView) -> list[dict[str, Any]]:
    found = []
    for agent in compare_trajectories(view.lines, other.lines).agents:
        spot = agent.simultaneous
        if spot is None:
            continue
        a = view.rows[agent.agent]
        x, y = place_at(view.lines.curve(a), spot.time)
        later = float(other.arrivals[other.rows[agent.agent]] - view.arrivals[a])
        found.append(
            {
                "a": a,
                "b": None,
                "distance": float(f"{spot.amount:.6g}"),
                "later": round(later, 6),
                "time": round(spot.time, 6),
                "x": round(x, 6),
                "y": round(y, 6),
            }
        )
    return sorted(found, key=lambda one: -one["distance"])
