"""Trajectory files of JuPedSim: SQLite, version 2 of its schema; frames from the run's begin."""

from __future__ import annotations

import sqlite3

import numpy as np
import shapely

from stplan.exports.settings import ExportSettings
from stplan.viewing.run_view import RunView

_SCHEMA = (
    "CREATE TABLE trajectory_data (frame INTEGER NOT NULL, id INTEGER NOT NULL, pos_x REAL NOT NULL, "
    "pos_y REAL NOT NULL, ori_x REAL NOT NULL, ori_y REAL NOT NULL)",
    "CREATE TABLE metadata (key TEXT NOT NULL UNIQUE, value TEXT NOT NULL)",
    "CREATE TABLE geometry (hash INTEGER NOT NULL, wkt TEXT NOT NULL)",
    "CREATE TABLE frame_data (frame INTEGER NOT NULL, geometry_hash INTEGER NOT NULL)",
    "CREATE TABLE agent_names (id INTEGER NOT NULL, name TEXT NOT NULL)",
)


def sqlite_bytes(view: RunView, settings: ExportSettings) -> bytes:
    """Agents are numbered from 1; a table `agent_names` more than the schema asks says who is who."""
    frames = settings.frames(view)
    wkt = settings.geometry(view)
    if not wkt:
        low, high = np.array(view.bounds).reshape(2, 2)
        wkt = shapely.to_wkt(shapely.box(*low, *high), rounding_precision=9)
    west, south, east, north = shapely.from_wkt(wkt).bounds
    rows = [
        (k, a + 1, *frames.places[a, k].tolist(), float(np.cos(angle)), float(np.sin(angle)))
        for a in range(view.num_agents)
        for k in frames.rows(a)
        for angle in (frames.headings[a, k],)
    ]
    metadata = [("version", "2"), ("fps", f"{1 / frames.step:g}")]
    metadata += [
        ("xmin", str(west)),
        ("xmax", str(east)),
        ("ymin", str(south)),
        ("ymax", str(north)),
    ]
    shown = [(k,) for k in range(len(frames.times))]
    connection = sqlite3.connect(":memory:")
    try:
        for statement in _SCHEMA:
            connection.execute(statement)
        fill = connection.executemany
        fill("INSERT INTO trajectory_data VALUES (?, ?, ?, ?, ?, ?)", sorted(rows))
        fill("INSERT INTO metadata VALUES (?, ?)", metadata)
        fill("INSERT INTO geometry VALUES (1, ?)", [(wkt,)])
        fill("INSERT INTO frame_data VALUES (?, 1)", shown)
        fill("INSERT INTO agent_names VALUES (?, ?)", enumerate(view.lines.agent_ids, 1))
        connection.commit()
        return connection.serialize()
    finally:
        connection.close()
