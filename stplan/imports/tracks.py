"""A scene that asks no more of trajectories than that nobody touches anybody or a wall of a map."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from stplan.errors import UsageError
from stplan.files.trajectories import read_trajectories
from stplan.imports.draft import SceneDraft, identifiers, scene_name
from stplan.imports.files import map_keys
from stplan.maps.formats.drawing import FileOptions
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene
from stplan.scene.model import Scene

# While it is read, so that agents on one another are found by the certificate, not refused as a scene.
_TINY = 1e-6


def scene_of_tracks(
    map_file: Path, trajectories: Path, radius: float, fps: float | None = None
) -> tuple[Scene, WorldLines]:
    """A scene of agents of one radius (m) that go from their first places to their last, and the curves.

    Raises:
        UsageError: the trajectories cannot be read.
        SceneError: the map cannot.
    """
    lines = read_trajectories(trajectories, fps)
    names = identifiers(lines.agent_ids)
    lines = WorldLines.from_curves(names, list(lines.curves()))
    agents = []
    for name, curve in zip(names, lines.curves(), strict=True):
        (x, y, begin), (goal_x, goal_y, end) = curve[0].tolist(), curve[-1].tolist()
        agents.append(
            {
                "id": name, "start": [x, y], "goal": [goal_x, goal_y], "start_time": begin, "max_time": end,
                "after_arrival": "vanish",
            }
        )  # fmt: skip
    if len(agents) > 10_000:
        raise UsageError(f"{trajectories}: {len(agents)} agents, at most 10000 are checked")
    draft = SceneDraft(
        scene_name(trajectories.stem), (), map_keys(map_file, FileOptions(), Path()), None,
        {"radius": _TINY}, tuple(agents),
    )  # fmt: skip
    scene = parse_scene(draft.text(), directory=Path())
    sized = tuple(replace(agent, radius=radius) for agent in scene.agents)
    return replace(scene, agents=sized), lines
