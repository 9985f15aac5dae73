"""First scenes: a few places that everybody knows, with agents that fit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stplan.imports.crowd import Placer, no_room
from stplan.imports.draft import SceneDraft, free_space_of

RADIUS = 0.3
_Agents = tuple[Mapping[str, Any], ...]


@dataclass(frozen=True)
class Template:
    """A scene to begin with.

    Attributes:
        comments: what it shows, and what to change.
        map: keys of its map.
        horizon: s.
        agents: makes those that stand in it unless others are asked for.
    """

    comments: tuple[str, ...]
    map: Mapping[str, Any]
    horizon: float
    agents: Callable[[], _Agents]


def _corridor() -> _Agents:
    """Four from either end."""
    places = [(round(1.0 + 0.9 * (k // 2), 2), 1.0 + 1.2 * (k % 2)) for k in range(4)]
    east = [
        {"id": f"east-{k}", "start": [x, y], "goal": [20 - x, y]}
        for k, (x, y) in enumerate(places, 1)
    ]
    west = [
        {"id": f"west-{k}", "start": [20 - x, y], "goal": [x, y]}
        for k, (x, y) in enumerate(places, 1)
    ]
    return (*east, *west)


def _room() -> _Agents:
    """Six that leave by a door, one after another."""
    places = [(2.0 + 1.5 * (k % 3), 2.5 + 2.5 * (k // 3)) for k in range(6)]
    return tuple(
        {"id": f"a{k}", "start": [x, y], "goal": [9.0 + 1.0 * (k % 2), 1.5 + 1.0 * ((k - 1) // 2)]}
        for k, (x, y) in enumerate(places, 1)
    )


def _warehouse() -> _Agents:
    """Six carts that change sides along the aisles between shelves."""
    rows = [1.0 + 2.6 * k for k in range(3)]
    east = [
        {"id": f"cart-{k}", "start": [1.0, y], "goal": [19.0, y]} for k, y in enumerate(rows, 1)
    ]
    west = [
        {"id": f"cart-{k}", "start": [19.0, y], "goal": [1.0, y]}
        for k, y in enumerate(rows[::-1], 4)
    ]
    return (*east, *west)


TEMPLATES: dict[str, Template] = {
    "corridor": Template(
        ("Two groups meet in a corridor.",), {"rectangle": [0.0, 0.0, 20.0, 3.2]}, 40.0, _corridor
    ),
    "room": Template(
        ("Six agents leave a room by its door. A wall is a line, with or without thickness.",),
        {
            "rectangle": [0.0, 0.0, 12.0, 8.0],
            "obstacles": [
                {"line": [[7.0, 0.0], [7.0, 3.4]], "thickness": 0.2},
                {"line": [[7.0, 4.6], [7.0, 8.0]], "thickness": 0.2},
            ],
        },
        40.0, _room,
    ),
    "warehouse": Template(
        ("Carts change sides in a warehouse, along aisles wide enough for two.",),
        {
            "rectangle": [0.0, 0.0, 20.0, 7.2],
            "obstacles": [
                {"rectangle": [x, y, x + 5.0, y + 0.6]} for y in (2.0, 4.6) for x in (3.0, 12.0)
            ],
        },
        60.0, _warehouse,
    ),
}  # fmt: skip


def draft_of_template(
    name: str,
    folder: Path,
    comment: str,
    *,
    agents: int | None,
    rng_seed: int,
    radius: float | None,
) -> SceneDraft:
    """A template's scene, its own agents or `agents` others at random places.

    Raises:
        UsageError: so many do not fit.
    """
    template = TEMPLATES[name]
    size = radius or RADIUS
    members = template.agents()
    if agents is not None or radius is not None:
        count = len(members) if agents is None else agents
        free_space, _ = free_space_of(template.map, folder)
        trips = Placer(free_space, size, np.random.default_rng(rng_seed)).trips(count)
        if len(trips) < count:
            raise no_room(len(trips), count, size)
        members = tuple(
            {"id": f"a{k}", "start": list(one.start), "goal": list(one.goal)}
            for k, one in enumerate(trips, 1)
        )
    comments = (*template.comments, comment, "Lengths in m, times in s; keys: docs/scene-format.md")
    return SceneDraft(name, comments, template.map, template.horizon, {"radius": size}, members)
