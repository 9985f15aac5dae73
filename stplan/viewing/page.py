"""The interactive page of a run: one HTML file that needs no network.

The page itself (`page/source/`, JavaScript with three.js) is built once by `make page` and carried in the
package; here a run is put into it.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib import resources
from typing import Any

import numpy as np
import shapely

from stplan.analysis.paths import path_length, segment_speeds
from stplan.analysis.tightness import REACH, TightSpot, pair_spots, wall_spots
from stplan.analysis.waiting import Wait, waits
from stplan.arrays import FloatArray
from stplan.viewing.clearances import smallest_clearance, touching_point
from stplan.viewing.page_comparison import other_content
from stplan.viewing.palette import hex_colours
from stplan.viewing.run_view import RunView

_SAMPLES = 600
# So many tightest moments are listed.
_MOMENTS = 10_000


def page_bytes(view: RunView, other: RunView | None = None, titles: Sequence[str] = ()) -> bytes:
    """The page with `view` in it, and with an `other` run over it where there is one.

    Args:
        titles: of both; the runs' own where left out.
    """
    template = resources.files("stplan.viewing").joinpath("page/built/page.html").read_text("utf-8")
    # JSON may hold any text; without this one letter none of it can end the element it stands in.
    content = json.dumps(page_content(view, other, titles), separators=(",", ":"), allow_nan=False)
    return template.replace("__RUN__", content.replace("<", "\\u003c"), 1).encode()


def page_content(
    view: RunView, other: RunView | None = None, titles: Sequence[str] = ()
) -> dict[str, Any]:
    """What the page's scripts read: lengths in m, times in s, agents by their index."""
    waiting = sorted(waits(view.crowd), key=lambda wait: wait.begin)
    spots = pair_spots(view.crowd) + wall_spots(view.crowd)
    spots.sort(key=lambda spot: spot.clearance)
    colours = hex_colours(view.num_agents)
    own, others = titles or (view.title, "" if other is None else other.title)
    shown = [view] if other is None else [view, other]
    end = max(each.end for each in shown)
    corners = np.array([each.bounds for each in shown])
    return {
        "title": own,
        "description": view.description,
        "notes": [*dict.fromkeys(note for each in shown for note in each.notes)],
        "begin": min(each.begin for each in shown),
        "end": end,
        "arrived": view.end,
        "bounds": [*corners[:, :2].min(axis=0).tolist(), *corners[:, 2:].max(axis=0).tolist()],
        "map": _rings(view),
        "agents": [_agent(view, a, colour, waiting, end) for a, colour in enumerate(colours)],
        "other": None if other is None else other_content(view, other, others, colours),
        "seed": _seed(view),
        "moments": [_moment(view, spot) for spot in spots[:_MOMENTS]],
        "clearance": _clearance(view),
        "events": _events(view),
    }


def _events(view: RunView) -> list[dict[str, Any]]:
    """What happened when, and which agents it stopped itself, each with until when, s."""
    changes = () if view.scene is None else view.scene.changes
    return [
        {
            "time": round(when, 6),
            "what": what,
            "still": [
                {"a": view.rows[name], "until": round(when + lasts, 6)}
                for name, lasts in change.delays
            ],
        }
        for (when, what), change in zip(view.events, changes, strict=True)
    ]


def _agent(view: RunView, a: int, colour: str, waiting: list[Wait], end: float) -> dict[str, Any]:
    curve = view.lines.curve(a)
    length, name = path_length(curve), view.lines.agent_ids[a]
    preferred = float(view.crowd.preferred[a])
    return {
        "id": name,
        "colour": colour,
        "radius": float(view.radii[a]),
        "knots": _rounded(curve),
        "leaves": float(view.seen_until(end)[a]),
        "preferred": None if np.isnan(preferred) else preferred,
        "length": length,
        "mean": length / float(curve[-1, 2] - curve[0, 2]),
        "top": float(segment_speeds(curve).max()),
        "waits": [
            {
                "begin": wait.begin,
                "end": wait.end,
                "b": None if wait.meeting is None else view.rows[wait.meeting.agent],
            }
            for wait in waiting
            if wait.agent == name
        ],
    }


def _moment(view: RunView, spot: TightSpot) -> dict[str, Any]:
    a, *b = (view.rows[name] for name in spot.who)
    x, y = touching_point(view, spot)
    return {
        "a": a,
        "b": b[0] if b else None,
        "clearance": float(f"{spot.clearance:.6g}"),
        "time": round(spot.time, 6),
        "x": round(x, 6),
        "y": round(y, 6),
    }


def _rings(view: RunView) -> list[list[list[list[float]]]] | None:
    """Polygons as an outer ring and holes, none of them closed."""
    if view.free_space is None:
        return None
    return [
        [_rounded(np.asarray(ring.coords)[:-1, :2]) for ring in (part.exterior, *part.interiors)]
        for part in shapely.get_parts(view.free_space.polygon)
    ]


def _seed(view: RunView) -> list[list[list[float]]] | None:
    """Initial curves in the order of the agents, None where they are not all known."""
    if view.seed is None or set(view.seed.agent_ids) != set(view.lines.agent_ids):
        return None
    place = {agent_id: a for a, agent_id in enumerate(view.seed.agent_ids)}
    return [_rounded(view.seed.curve(place[name])) for name in view.lines.agent_ids]


def _clearance(view: RunView) -> dict[str, Any]:
    times = np.linspace(view.begin, view.end, _SAMPLES)
    between, to_walls = smallest_clearance(view, times)
    return {
        "times": _rounded(times),
        "reach": REACH * float(np.median(view.radii)),
        "pairs": [float(f"{v:.4g}") if np.isfinite(v) else None for v in between.tolist()],
        "walls": [float(f"{v:.4g}") if np.isfinite(v) else None for v in to_walls.tolist()],
    }


def _rounded(numbers: FloatArray) -> Any:
    """As lists, to a micrometre and a microsecond."""
    return np.round(numbers, 6).tolist()
