"""Trajectories as the text that JuPedSim writes and PedPy analyses: `ID FRAME X Y Z` a line."""

from __future__ import annotations

import numpy as np
import shapely

from stplan.analysis.paths import positions
from stplan.viewing.run_view import RunView


def jupedsim_bytes(view: RunView, fps: float = 25.0) -> bytes:
    """Everybody's place at `fps` frames a second from the run's begin, in m, numbered from 1.

    Agents are in the file while they are present. Who has which number, and the map as well-known text, stand
    in comments at its end, where no reader takes them for anything else.
    """
    count = int(np.floor((view.end - view.begin) * fps + 1e-9)) + 1
    times = view.begin + np.arange(count) / fps
    places = positions(view.lines, view.leaves, times)
    lines = [f"#framerate: {fps:g}", "#ID\tFR\tx/m\ty/m\tz/m"]
    for a in range(view.num_agents):
        there = np.flatnonzero(~np.isnan(places[a, :, 0])).tolist()
        lines += [f"{a + 1}\t{k}\t{places[a, k, 0]:.9f}\t{places[a, k, 1]:.9f}\t0" for k in there]
    lines += [f"#id {a + 1}: {name}" for a, name in enumerate(view.lines.agent_ids)]
    if view.free_space is not None:
        lines.append(f"#geometry: {shapely.to_wkt(view.free_space.polygon, rounding_precision=9)}")
    return ("\n".join(lines) + "\n").encode()
