"""One scene in several variants, which together have every term there is; its maps are made of rectangles."""

from __future__ import annotations

from typing import Any

_SCENE = """
stplan: 1
horizon: 14.0
time_scale: 1.5
{map}
agents:
- {{id: sam, start: [0, 0], goal: [9, 0.2], mass: 3.0, radius: 0.4, {sam}
   weights: {{kinetic: 2.0, acceleration: 0.3, arrival: 0.5, collision: 2.0}}, preferred_time: 9.0}}
- {{id: ann, start: [9, 0.1], goal: [0, -0.3], radius: 0.3, after_arrival: vanish, {ann}
   weights: {{regularity: 0.02, wall: 2.5, collision: 0.5}}}}
- {{id: bus, path: [[4, -4, 0], [4.5, 4, 12]], radius: 0.5, after_arrival: vanish, weights: {{wall: 0}}}}
- {{id: eve, start: [1, 2], goal: [8, 2], max_time: 18.0, radius: 0.25, {eve}
   weights: {{collision: 0.0, wall: 0.0}}}}
{pairs}
seeding: {{margin: 1.6}}
solver: {{outer_iterations: 2, max_iterations: 25, {solver}}}
"""
ROOM = """
map:
  rectangle: [-1, -5, 10, 5]
  obstacles: [{rectangle: [3, -1.6, 3.4, -0.8]}, {rectangle: [6, 0.9, 7, 1.4]}]
"""
FRIENDS = "pairs: [{between: [sam, eve], grouping: 0.7}, {between: [ann, bus], distance: 1.1}]"
MEET = "pairs: [{between: [sam, eve], meet: {within: 1.2}}]"
FAST = {"sam": "max_speed: 0.97,", "ann": "max_acceleration: 0.5,", "eve": "max_speed: 0.45,"}


def scene_text(given: dict[str, Any]) -> str:
    """The scene as YAML, with `given` for its map, pairs, solver and limits."""
    return _SCENE.format(**(dict.fromkeys(("map", "pairs", "solver", *FAST), "") | given))
