"""Scenes made in code: agents as dataclasses and arrays in, a validated scene out."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np

from stplan.scene import Scene, parse_scene


@dataclass(frozen=True)
class AgentSpec:
    """An agent of `build_scene`; what is None has the default of the scene format.

    Lengths in m, times in s, mass in kg. Points are (x, y), as sequences or arrays.

    Attributes:
        id: its name, unique.
        start, goal: where it goes from and to; a goal may be ``{"place": NAME}`` or ``{"any": [...]}``.
        path: (n, 3) x, y, t instead of start and goal: its motion is prescribed.
        waypoints: (w, 2), passed in this order.
        weights: of the costs by name, as in ``{"arrival": 1.0}``.
    """

    id: str
    start: Any = None
    goal: Any = None
    radius: float | None = None
    mass: float | None = None
    start_time: float | None = None
    max_time: float | None = None
    preferred_time: float | None = None
    max_speed: float | None = None
    max_acceleration: float | None = None
    clearance: float | None = None
    after_arrival: str | None = None
    waypoints: Any = None
    path: Any = None
    weights: Mapping[str, float] = field(default_factory=dict)


def build_scene(
    agents: Sequence[AgentSpec | Mapping[str, Any]],
    *,
    map: Any = None,
    horizon: float | str | None = None,
    name: str = "scene",
    directory: str | Path = ".",
    **sections: Any,
) -> Scene:
    """A scene made in code, checked like one that is read from a file.

    Args:
        agents: `AgentSpec`, or mappings with the keys of the scene format.
        map: None for the open plane, an outer ring (n, 2), or a mapping as in a scene file.
        horizon: latest arrival of agents that have none of their own, s; or "auto".
        directory: where map files are looked for.
        sections: further keys of a scene: ``defaults``, ``pairs``, ``seeding``, ``solver``, ...

    Raises:
        SceneError: all that is wrong, each with its key such as ``agents[2].radius``.

    >>> import stplan
    >>> scene = stplan.build_scene(
    ...     [stplan.AgentSpec("sam", (0, 0), (4, 0)), stplan.AgentSpec("ann", (4, 0.1), (0, 0.1))],
    ...     horizon=8,
    ... )
    >>> [agent.radius for agent in scene.agents]
    [0.3, 0.3]
    """
    text = scene_text(agents, map=map, horizon=horizon, name=name, **sections)
    return parse_scene(text, directory=Path(directory), label=name)


def scene_text(
    agents: Sequence[AgentSpec | Mapping[str, Any]],
    *,
    map: Any = None,
    horizon: float | str | None = None,
    name: str = "scene",
    **sections: Any,
) -> str:
    """The scene file of `build_scene`, to be kept and given to the commands.

    >>> import stplan
    >>> print(stplan.scene_text([stplan.AgentSpec("sam", (0, 0), (4, 0))], horizon=8), end="")
    stplan: 1
    name: "scene"
    horizon: 8
    agents:
      - {"id": "sam", "start": [0, 0], "goal": [4, 0]}
    """
    keys: dict[str, Any] = {"stplan": 1, "name": name}
    if map is not None:
        keys["map"] = map if isinstance(map, Mapping) else {"polygon": map}
    if horizon is not None:
        keys["horizon"] = horizon
    lines = [f"{key}: {_flow(value)}" for key, value in (keys | sections).items()]
    # A line an agent, so that a fault names the line of its agent.
    lines += ["agents:", *(f"  - {_flow(_mapping(agent))}" for agent in agents)]
    return "\n".join(lines) + "\n"


def _mapping(agent: AgentSpec | Mapping[str, Any]) -> Mapping[str, Any]:
    if isinstance(agent, Mapping):
        return agent
    given = {one.name: getattr(agent, one.name) for one in fields(agent)}
    return {
        key: value
        for key, value in given.items()
        if value is not None and not (key == "weights" and not value)
    }


def _flow(value: Any) -> str:
    """A value on one line; JSON is YAML."""
    return json.dumps(value, default=_plain, ensure_ascii=False)


def _plain(value: Any) -> Any:
    """Arrays and numbers of numpy, and other mappings, as JSON has them."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{type(value).__name__} is no value of a scene")
