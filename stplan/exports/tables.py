"""Tables of a run at fixed steps: CSV, CSV for Blender, HDF5 and Parquet."""

from __future__ import annotations

import io

import numpy as np

from stplan.exports.frames import Frames
from stplan.exports.settings import ExportSettings
from stplan.optional import require
from stplan.viewing.run_view import RunView


def csv_frames(view: RunView, settings: ExportSettings) -> bytes:
    """``agent,t,x,y,heading``: m, s, rad; agents in the order of the run, in time."""
    frames = settings.frames(view)
    lines = ["agent,t,x,y,heading"]
    for a, name in enumerate(view.lines.agent_ids):
        for k in frames.rows(a):
            x, y = frames.places[a, k].tolist()
            lines.append(
                f"{name},{frames.times[k]:.9g},{x:.9f},{y:.9f},{frames.headings[a, k]:.6f}"
            )
    return ("\n".join(lines) + "\n").encode()


def blender_csv(view: RunView, settings: ExportSettings) -> bytes:
    """``frame,agent,x,y,z,heading,radius``: a row an agent and frame, frames from 1, z upwards, rad."""
    frames = settings.frames(view)
    lines = ["frame,agent,x,y,z,heading,radius"]
    rows = [(k, a) for a in range(view.num_agents) for k in frames.rows(a)]
    for k, a in sorted(rows):
        x, y = frames.places[a, k].tolist()
        where = f"{x:.6f},{y:.6f},0,{frames.headings[a, k]:.6f}"
        lines.append(f"{k + 1},{view.lines.agent_ids[a]},{where},{view.radii[a]:g}")
    return ("\n".join(lines) + "\n").encode()


def hdf5_bytes(view: RunView, settings: ExportSettings) -> bytes:
    """Datasets `times` (T,), `places` (A, T, 2), `headings` (A, T), `agents`, `radii` (A,), and the knots."""
    h5py = require("h5py", "an HDF5 file", "export")
    frames = settings.frames(view)
    buffer = io.BytesIO()
    with h5py.File(buffer, "w", track_order=True) as file:
        file.attrs["step"] = frames.step
        file.attrs["heading_smoothing"] = settings.smoothing
        file.create_dataset("times", data=frames.times, track_times=False)
        file.create_dataset("places", data=frames.places, track_times=False)
        file.create_dataset("headings", data=frames.headings, track_times=False)
        names = np.array([name.encode() for name in view.lines.agent_ids])
        file.create_dataset("agents", data=names, track_times=False)
        file.create_dataset("radii", data=view.radii, track_times=False)
        file.create_dataset("knots", data=view.lines.knots, track_times=False)
        file.create_dataset("offsets", data=view.lines.offsets, track_times=False)
        if settings.geometry(view):
            file.attrs["geometry"] = settings.geometry(view)
    return buffer.getvalue()


def parquet_bytes(view: RunView, settings: ExportSettings) -> bytes:
    """Columns agent, t, x, y, heading, radius: a row an agent and step."""
    arrow = require("pyarrow", "a Parquet file", "export")
    parquet = require("pyarrow.parquet", "a Parquet file", "export")
    frames = settings.frames(view)
    agents, rows = _present(frames)
    table = arrow.table(
        {
            "agent": arrow.array(np.array(view.lines.agent_ids, dtype=object)[agents]),
            "t": frames.times[rows],
            "x": frames.places[agents, rows, 0],
            "y": frames.places[agents, rows, 1],
            "heading": frames.headings[agents, rows],
            "radius": view.radii[agents],
        }
    )
    buffer = io.BytesIO()
    parquet.write_table(table, buffer)
    return buffer.getvalue()


def _present(frames: Frames) -> tuple[np.ndarray, np.ndarray]:
    """(agent, frame) of everybody who is there."""
    agents, rows = np.nonzero(~np.isnan(frames.places[:, :, 0]))
    return agents, rows
