"""A scene that must be refused, and the valid scenes that malformed ones are made from."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import yaml

# What stands beside a scene: bytes, or what makes them when they are many.
Content = bytes | Callable[[], bytes]


@dataclass(frozen=True)
class Case:
    """A malformed scene.

    Attributes:
        name: of the case.
        text: of the scene file.
        files: what stands beside it.
        path: is named, or begins what is named, by one of the messages.
        status: expected exit status.
    """

    name: str
    text: bytes
    files: Mapping[str, Content] = field(default_factory=dict)
    path: str = ""
    status: int = 2


FLOOR = b"v 0 0 0\nv 10 0 0\nv 10 8 0\nv 0 8 0\nf 1 2 3 4\n"

_AGENT: dict[str, Any] = {
    "start_time": 0.5,
    "max_time": 18.0,
    "preferred_time": 9.0,
    "radius": 0.25,
    "mass": 70.0,
    "after_arrival": "stay",
    "waypoints": [[3.0, 5.0], [4.0, 5.5]],
    "weights": {"kinetic": 2.0, "acceleration": 0.1, "arrival": 1.0, "regularity": 0.2,
                "collision": 3.0, "wall": 0.5},
}  # fmt: skip
_ROOM: dict[str, Any] = {
    "stplan": 1,
    "name": "room",
    "description": "every key",
    "map": {
        "rectangle": [0.0, 0.0, 10.0, 8.0],
        "obstacles": [
            {"rectangle": [5.0, 2.0, 6.0, 3.0]},
            {"circle": {"center": [8.0, 6.5], "radius": 0.5}},
            {"polygon": [[5.0, 6.0], [6.0, 6.0], [6.0, 7.0]]},
        ],
        "resolution": 0.5,
    },
    "horizon": 20.0,
    "time_scale": 1.5,
    "defaults": {"mass": 80.0, "radius": 0.3, "weights": {"wall": 2.0}},
    "agents": [
        {"id": "sam", "start": [1.0, 1.0], "goal": [9.0, 1.0], **_AGENT},
        {"id": "ann", "start": [1.0, 4.0], "goal": [9.0, 4.0]},
        {"id": "cart", "path": [[1.0, 7.0, 0.0], [3.0, 7.0, 6.0], [4.0, 7.0, 20.0]]},
    ],
    "pairs": [
        {"between": ["sam", "ann"], "distance": 1.5},
        {"between": ["sam", "all"], "grouping": 2.0},
        {"between": [["sam", "ann"], "cart"], "collide": False},
    ],
    "seeding": {"method": "search", "layers": 20, "margin": 1.1, "time_limit": 5.0, "rng_seed": 7},
    "solver": {"knots": 30, "mu": 0.1, "mu_decay": 0.5, "outer_iterations": 3,
               "max_iterations": 50, "step_tolerance": 0.001, "alpha": 40.0,
               "clearance_model": "contacts", "barrier_range": 0.4, "hessian": "exact",
               "linear_solver": "mumps"},
}  # fmt: skip
_HALL: dict[str, Any] = {
    "stplan": 1,
    "map": {
        "polygon": [[0.0, 0.0], [12.0, 0.0], [12.0, 9.0], [0.0, 9.0]],
        "holes": [[[5.0, 4.0], [7.0, 4.0], [7.0, 6.0], [5.0, 6.0]]],
    },
    "horizon": 30.0,
    "agents": [
        {"id": "a", "start": [1.0, 1.0], "goal": [11.0, 8.0], "radius": 0.4},
        {"id": "b", "start": [11.0, 1.0], "goal": [1.0, 8.0], "after_arrival": "vanish"},
    ],
}
_FLOOR: dict[str, Any] = {
    "stplan": 1,
    "map": {"mesh": "floor.obj", "up": "z", "obstacles": [{"rectangle": [4.0, 3.0, 5.0, 5.0]}]},
    "agents": [
        {"id": "één", "start": [1.0, 1.0], "goal": [9.0, 7.0], "max_time": 25.0},
        {"id": "二", "start": [9.0, 1.0], "goal": [1.0, 7.0], "max_time": 25.0},
    ],
}
_CROWD: dict[str, Any] = {
    "stplan": 1,
    "horizon": 60.0,
    "agents": [
        {"id": "kim", "start": [-3.0, 0.0], "goal": [-3.0, 9.0], "max_speed": 2.0, "max_acceleration": 1.0,
         "waypoints": [{"at": [-4.0, 4.0], "window": [10.0, 30.0], "dwell": 2.0}, [-4.0, 6.0]]},
        {"id": "lee", "start": [-5.0, 0.0], "goal": [-5.0, 9.0]},
        {"pattern": "circle", "id": "walker", "count": 6, "radius": 0.2, "first_angle": 10.0,
         "turn": 170.0, "circle": {"center": [10.0, 10.0], "radius": 4.0}},
        {"pattern": "line", "id": "east", "count": 4, "start": [[20.0, 0.0], [20.0, 6.0]],
         "goal": [[30.0, 0.0], [30.0, 6.0]]},
        {"pattern": "grid", "id": "block", "rows": 2, "columns": 2, "spacing": [1.5, 1.5],
         "start": [40.0, 0.0], "goal": [40.0, 20.0]},
        {"file": "people.csv", "id": "people", "mass": 60.0},
    ],
    "groups": [{"name": "family", "members": ["kim", "lee"], "grouping": 3.0, "distance": 0.7}],
    "pairs": [{"between": ["kim", "lee"], "meet": {"within": 3.0, "window": [5.0, 40.0]}},
              {"between": ["family", "people"], "distance": 0.8}],
}  # fmt: skip
PEOPLE = """id,start_x,start_y,goal_x,goal_y,radius,max_time,after_arrival,weights.arrival,preferred_time
p1,50,0,50,9,0.25,,vanish,,
p2,52,0,52,9,,30,,1.5,20
"""
BASES = {"room": _ROOM, "hall": _HALL, "floor": _FLOOR, "crowd": _CROWD}


def base(name: str) -> dict[str, Any]:
    """A copy of a valid scene as a tree."""
    return copy.deepcopy(BASES[name])


def dump(tree: Any, *, flow: bool = False) -> bytes:
    """A tree as YAML."""
    style = True if flow else None
    text = yaml.safe_dump(tree, sort_keys=False, allow_unicode=True, default_flow_style=style)
    return text.encode()


def beside(name: str) -> Mapping[str, Content]:
    """The files of a valid scene."""
    return {"floor": {"floor.obj": FLOOR}, "crowd": {"people.csv": PEOPLE.encode()}}.get(name, {})
