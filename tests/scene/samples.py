"""Small scenes as text, and what a refused one says."""

from __future__ import annotations

import copy
import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from stplan.errors import SceneError
from stplan.scene import parse_scene

PLACE = re.compile(r"^scene\.yaml:(\d+):(\d+): (?:([^ :]+): )?(.+)$")

TRIANGLE = "v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n"

PAIR = """\
stplan: 1
name: pair
horizon: 20.0
agents:
  - id: sam
    start: [0.0, 0.0]
    goal: [10.0, 0.0]
    radius: 0.3
  - id: ann
    start: [0.0, 5.0]
    goal: [10.0, 5.0]
    radius: 0.3
"""

FULL = """\
stplan: 1
description: all kinds of keys
map:
  polygon: [[-9, -9], [20, -9], [20, 9], [-9, 9], [-9, -9]]
  holes: [[[-8, -8], [-7, -8], [-7, -7]]]
  obstacles:
    - {rectangle: [1, 6, 2, 7]}
    - {circle: {center: [4, -6], radius: 0.5}}
    - {polygon: [[5, 7], [6, 7], [6, 8]]}
  resolution: 0.5
horizon: 20
time_scale: 2
defaults:
  mass: 80
  start_time: 1
  waypoints: [[3, 1]]
  weights: {acceleration: 0.5, regularity: 7, wall: 2}
agents:
  - id: sam
    start: [0, 0]
    goal: [10, 4]
    radius: 0.25
    max_time: 15
    preferred_time: 12
    weights: {arrival: 3, regularity: auto, wall: 0}
  - {id: ann, start: [0, 3], goal: [10, 1], start_time: 0, waypoints: [], after_arrival: vanish}
  - {id: cart, path: [[0, -5, 2], [5, -5, 4], [10, -5, 9]], radius: 1}
pairs:
  - {between: [sam, all], distance: 2.5}
  - {between: [[ann, cart], sam], grouping: 5, distance: 1.5}
  - {between: [ann, cart], collide: no}
seeding: {method: search, layers: 20, margin: 1.2, time_limit: 5, rng_seed: 7}
solver: {knots: 30, barrier_range: .inf, ipopt: {tol: 1e-6, print_timing_statistics: yes}}
"""


def edited(old: str, new: str, text: str = PAIR) -> str:
    """`text` with its first `old` replaced."""
    assert old in text
    return text.replace(old, new, 1)


def scene_text(own: str = "", top: str = "") -> str:
    """Two agents far apart; `own` is added to the first (line 4), `top` to the scene (line 6 on)."""
    return (
        "stplan: 1\nhorizon: 20\nagents:\n"
        f"  - {{id: sam, start: [0, 0], goal: [5, 0]{own and ', ' + own}}}\n"
        f"  - {{id: ann, start: [0, 2], goal: [5, 2]}}\n{top}\n"
    )


def agents_text(*entries: str, top: str = "") -> str:
    """A scene of these agents, the first in line 4."""
    listed = "".join(f"  - {{{entry}}}\n" for entry in entries)
    return f"stplan: 1\nhorizon: 20\nagents:\n{listed}{top}"


def refusals(text: str, **more: Any) -> list[str]:
    """The messages of a scene, called scene.yaml, that must be refused."""
    with pytest.raises(SceneError) as caught:
        parse_scene(text, source=Path("scene.yaml"), **more)
    assert caught.value.messages
    return caught.value.messages


def refusal(text: str, **more: Any) -> str:
    """The only message of a scene that must be refused."""
    messages = refusals(text, **more)
    assert len(messages) == 1, messages
    return messages[0]


def places(messages: list[str]) -> list[tuple[int, int]]:
    found = [PLACE.match(message) for message in messages]
    assert all(found), messages
    return [(int(match[1]), int(match[2])) for match in found if match]


_AGENT: dict[str, Any] = {
    "clearance": 0.1,
    "start_time": 0.5,
    "max_time": 18.0,
    "preferred_time": 9.0,
    "radius": 0.25,
    "mass": 70.0,
    "after_arrival": "vanish",
    "max_speed": 2.0,
    "max_acceleration": 1.5,
    "start_velocity": [0.5, -0.25],
    "start_duration": 0.2,
    "waypoints": [[2.0, 1.0], {"at": [3.0, 1.5], "window": [2.0, 9.0], "dwell": 1.0}],
    "weights": {
        "kinetic": 2.0,
        "acceleration": 0.1,
        "arrival": 1.0,
        "regularity": 0.2,
        "collision": 3.0,
        "wall": 0.5,
        "clearance": 2.0,
    },
}

_FULL: dict[str, Any] = {
    "stplan": 1,
    "name": "full-scene_2",
    "description": "every key",
    "map": {
        "rectangle": [-10.0, -10.0, 20.0, 20.0],
        "obstacles": [
            {"rectangle": [8.0, 8.0, 9.0, 9.0]},
            {"circle": {"center": [-5.0, -5.0], "radius": 0.5}},
            {"polygon": [[-8.0, 8.0], [-7.0, 8.0], [-7.0, 9.0]]},
        ],
        "resolution": 0.5,
    },
    "horizon": 20.0,
    "time_scale": 1.5,
    "defaults": copy.deepcopy(_AGENT),
    "agents": [
        {"id": "sam", "start": [0.0, 0.0], "goal": [5.0, 0.0], **copy.deepcopy(_AGENT)},
        {"id": "ann", "start": [0.0, 4.0], "goal": [5.0, 4.0]},
        {
            "id": "cart",
            "path": [[0.0, 8.0, 0.0], [3.0, 8.0, 6.0], [5.0, 8.0, 20.0]],
            "preferred_time": 20.0,
        },
    ],
    "groups": [{"name": "walkers", "members": ["sam", "ann"], "grouping": 0.5}],
    "pairs": [
        {"between": ["sam", "ann"], "distance": 1.5, "meet": {"within": 2.0, "window": [3.0, 8.0]}},
        {"between": ["sam", "all"], "grouping": 2.0, "collision": 3.0},
        {"between": [["sam", "ann"], "cart"], "collide": False},
    ],
    "seeding": {
        "method": "search",
        "layers": 20,
        "margin": 1.1,
        "time_limit": 30.0,
        "rng_seed": 7,
        "shortcuts": False,
    },
    "solver": {
        "knots": 30,
        "effort": "best",
        "starts": 4,
        "mu": 0.1,
        "mu_decay": 0.5,
        "outer_iterations": 3,
        "max_iterations": 50,
        "step_tolerance": 0.001,
        "optimality_tolerance": 0.002,
        "alpha": 40.0,
        "clearance_model": "smooth-minimum",
        "barrier_range": 0.4,
        "hessian": "exact",
        "alpha_rule": "stepped",
        "hessian_cutoff": 0.1,
        "convergence": "first-order",
        "blocks": 16,
        "linear_solver": "mumps",
        "ipopt": {"tol": 1.0e-6, "mu_strategy": "adaptive", "print_level": 3},
    },
}


def full_tree() -> dict[str, Any]:
    """A valid scene with every key of the format but those of other bases of the map."""
    return copy.deepcopy(_FULL)


def dump(tree: Any) -> str:
    return yaml.safe_dump(tree, sort_keys=False, allow_unicode=True)
