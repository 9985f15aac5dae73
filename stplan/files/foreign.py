"""Trajectories that other programs wrote: places of agents in frames or at times, straight in between.

Text of JuPedSim and PedPy (``.txt``), its trajectory files (``.sqlite``), tables with columns of other
names (``.csv``, ``.traj`` of Vadere), bags of ROS 2 with a path an agent (``.mcap``) and lines with times
(``.geojson``).
"""

from __future__ import annotations

import io
import json
import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stplan.amounts import LARGEST
from stplan.errors import UsageError
from stplan.optional import require
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene

LARGEST_FILE = 256 * 1024 * 1024
# Of bags, what chunks unpack to.
LARGEST_UNPACKED = 512 * 1024 * 1024
_AGENT = {
    "agent", "id", "agent_id", "agentid", "ped", "pedestrian", "pedestrianid", "pedestrian_id", "pid",
    "name", "person",
}  # fmt: skip
_TIME = {"t", "time", "t/s", "time/s", "time_s", "seconds", "timestamp", "simtime"}
_FRAME = {"frame", "fr", "frame_id", "frameid", "timestep", "step"}
_FORMS = ("{}", "pos_{}", "position_{}", "{}/m", "{}_m", "start{}", "{}/cm")
_PLACE = {axis: {form.format(axis) for form in _FORMS} for axis in "xy"}
Row = tuple[str, float, float, float]


def read_foreign(path: Path, fps: float | None = None) -> WorldLines:
    """The trajectories in a file of another program.

    Args:
        fps: frames a second, where the file counts frames and does not say.

    Raises:
        UsageError: it cannot be read; the message is located.
    """
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise UsageError(f"{path}: is larger than {LARGEST_FILE // 2**20} MiB")
        content = path.read_bytes()
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror}") from error
    return _lines(READERS[path.suffix.lower()](path, content, fps), path)


def is_foreign_table(path: Path) -> bool:
    """Whether the head of a CSV names agents, places and times, and is not this program's own."""
    try:
        with path.open("rb") as file:
            head = file.readline(10_000).decode("utf-8-sig", "replace")
    except OSError:
        return False
    names = [_plain(word) for word in _words(head)]
    return "knot" not in names and _columns(names) is not None


def renamed(lines: WorldLines, scene: Scene) -> WorldLines:
    """The curves under the ids of a scene whose agents begin where they do, where the ids are others.

    Raises:
        UsageError: they are more or fewer, or it is not clear who is who.
    """
    names = {agent.id for agent in scene.agents}
    if set(lines.agent_ids) == names or lines.num_agents != len(names):
        return lines
    begins = np.array([curve[0] for curve in lines.curves()])
    found: list[int] = []
    for agent in scene.agents:
        x, y = agent.start
        gaps = np.hypot(begins[:, 0] - x, begins[:, 1] - y) + np.abs(
            begins[:, 2] - agent.start_time
        )
        found.append(int(np.argmin(gaps)))
    if len(set(found)) < len(found):
        raise UsageError(
            "the trajectories have other ids than the scene, and their begins do not tell who is who"
        )
    order = [scene.agents[found.index(k)].id for k in range(lines.num_agents)]
    return WorldLines.from_curves(order, list(lines.curves()))


def _lines(rows: Iterable[Row], path: Path) -> WorldLines:
    """Rows of any order -> a curve an agent, in time; agents in the order in which they appear."""
    curves: dict[str, list[tuple[float, float, float]]] = {}
    for agent, time, x, y in rows:
        curves.setdefault(agent, []).append((time, x, y))
    if not curves:
        raise UsageError(f"{path}: holds no trajectories")
    made = []
    for agent, points in curves.items():
        curve = np.array(sorted(points))[:, [1, 2, 0]]
        if not (np.abs(curve) <= LARGEST).all():
            raise UsageError(
                f"{path}: agent {agent!r} has a place or time that is not finite or too large"
            )
        if len(curve) < 2:
            raise UsageError(
                f"{path}: agent {agent!r} is there only once; at least 2 rows are expected"
            )
        if (np.diff(curve[:, 2]) <= 0).any():
            raise UsageError(f"{path}: agent {agent!r} has two places at one time")
        made.append(curve)
    return WorldLines.from_curves(list(curves), made)


def _words(line: str) -> list[str]:
    """The cells of a line, separated by commas, semicolons, tabs or blanks."""
    for separator in ",;\t":
        if separator in line:
            return [cell.strip().strip('"') for cell in line.rstrip("\r\n").split(separator)]
    return line.split()


def _plain(name: str) -> str:
    """A column's name without Vadere's number of a processor."""
    return re.sub(r"-pid\d+$", "", name.strip().lower())


def _columns(names: Sequence[str]) -> tuple[int, int, bool, int, int] | None:
    """Indices of agent and time, whether time counts frames, indices of x and y; None if any is missing."""

    def find(known: set[str]) -> int:
        return next((k for k, name in enumerate(names) if name in known), -1)

    agent, time, frame = find(_AGENT), find(_TIME), find(_FRAME)
    x, y = find(_PLACE["x"]), find(_PLACE["y"])
    if min(agent, x, y) < 0 or max(time, frame) < 0:
        return None
    return agent, time if time >= 0 else frame, time < 0, x, y


def _table(path: Path, content: bytes, fps: float | None) -> list[Row]:
    """A table with a head; or text of JuPedSim, whose head is a comment."""
    names: list[str] = []
    rows: list[Row] = []
    called: dict[str, str] = {}
    scale = 1.0
    columns: tuple[int, int, bool, int, int] | None = (0, 1, True, 2, 3)
    for number, line in enumerate(content.decode("utf-8-sig", "replace").splitlines(), 1):
        text = line.strip()
        if not text:
            continue
        if text.startswith("#"):
            fps = _rate(text) or fps
            if match := re.match(r"#\s*id (\d+): (.+)$", text):
                called[match[1]] = match[2]
            scale = 0.01 if re.search(r"\bx\s*(/|\[|in )\s*cm", text) else scale
            continue
        words = _words(text)
        if not rows and not names and not _is_number(words[-1]):
            names = [_plain(word) for word in words]
            columns = _columns(names)
            scale = 0.01 if "x/cm" in names else 1.0
            continue
        if columns is None:
            raise UsageError(
                f"{path}:1: the head names no columns of agents, times (or frames), x and y"
            )
        who, when, counts, right, up = columns
        if len(words) <= max(who, when, right, up):
            raise UsageError(f"{path}:{number}: {len(words)} values are too few")
        at = [_number(words[k], path, number) for k in (when, right, up)]
        if counts:
            if fps is None:
                raise UsageError(
                    f"{path}: counts frames and does not say how many a second; --fps says it"
                )
            at[0] /= fps
        rows.append((words[who], at[0], at[1] * scale, at[2] * scale))
    return [(called.get(agent, agent), time, x, y) for agent, time, x, y in rows]


def _rate(comment: str) -> float | None:
    """Frames a second as comments of trajectory text say them."""
    match = re.search(r"frame\s*rate\s*[:=]?\s*([0-9.]+)", comment, re.IGNORECASE)
    return float(match[1]) if match and _is_number(match[1]) and float(match[1]) > 0 else None


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return "_" not in text


def _number(text: str, path: Path, line: int) -> float:
    if not _is_number(text):
        raise UsageError(f"{path}:{line}: {text[:40]!r} is no number")
    return float(text)


def _database(path: Path, content: bytes, fps: float | None) -> list[Row]:
    """A trajectory file of JuPedSim."""
    from stplan.maps.formats.drawing import FormatError
    from stplan.maps.formats.sqlite_file import query

    try:
        tables, metadata, rows = query(
            content,
            [
                "SELECT name FROM sqlite_master",
                "SELECT key, value FROM metadata",
                "SELECT id, frame, pos_x, pos_y FROM trajectory_data",
            ],
        )
        named = ("agent_names",) in tables
        names = dict(query(content, ["SELECT id, name FROM agent_names"])[0]) if named else {}
        rate = float(dict(metadata).get("fps", fps or 0.0))
        if rate <= 0:
            raise UsageError(f"{path}: does not say how many frames a second it has; --fps says it")
        return [(str(names.get(i, i)), float(k) / rate, float(x), float(y)) for i, k, x, y in rows]
    except FormatError as error:
        raise UsageError(f"{path}: {error.text}") from error
    except (TypeError, ValueError) as error:
        raise UsageError(f"{path}: is no trajectory file of JuPedSim: {error}") from error


def _bag(path: Path, content: bytes, fps: float | None) -> list[Row]:
    """Every topic of nav_msgs/Path is an agent, called by its topic."""
    del fps
    stream = require("mcap.stream_reader", "an MCAP file", "export")
    records = require("mcap.records", "an MCAP file", "export")
    reader = require("mcap.reader", "an MCAP file", "export")
    decoder = require("mcap_ros2.decoder", "an MCAP file", "export")
    try:
        chunks = stream.StreamReader(io.BytesIO(content), emit_chunks=True).records
        unpacked = sum(one.uncompressed_size for one in chunks if isinstance(one, records.Chunk))
        if unpacked > LARGEST_UNPACKED:
            raise UsageError(f"{path}: unpacks to more than {LARGEST_UNPACKED // 2**20} MiB")
        rows: list[Row] = []
        made = reader.make_reader(io.BytesIO(content), decoder_factories=[decoder.DecoderFactory()])
        for schema, channel, _, message in made.iter_decoded_messages():
            if schema is None or schema.name not in ("nav_msgs/msg/Path", "nav_msgs/Path"):
                continue
            name = channel.topic.strip("/").removeprefix("agents/").removesuffix("/path")
            for pose in message.poses:
                stamp, at = pose.header.stamp, pose.pose.position
                rows.append((name, stamp.sec + stamp.nanosec / 1e9, float(at.x), float(at.y)))
        return rows
    except (UsageError, MemoryError):
        raise
    except Exception as error:  # a hostile file may raise anything at all inside the reader
        raise UsageError(
            f"{path}: is no MCAP file that can be read: {type(error).__name__}"
        ) from error


def _geojson(path: Path, content: bytes, fps: float | None) -> list[Row]:
    """Lines with as many `times` as places."""
    del fps
    rows: list[Row] = []
    try:
        tree: Any = json.loads(content)
        for feature in tree["features"]:
            properties = feature.get("properties") or {}
            if "times" not in properties:
                continue
            places = feature["geometry"]["coordinates"]
            name = str(properties.get("agent", len(rows)))
            pairs = zip(places, properties["times"], strict=True)
            rows += [(name, float(t), float(x), float(y)) for (x, y, *_), t in pairs]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise UsageError(f"{path}: is no GeoJSON of lines with times") from error
    return rows


READERS: dict[str, Callable[[Path, bytes, float | None], list[Row]]] = {
    ".txt": _table,
    ".traj": _table,
    ".csv": _table,
    ".sqlite": _database,
    ".mcap": _bag,
    ".geojson": _geojson,
}
