"""Crowds in rooms, corridors and on platforms, with places for starts and goals, as scene files say them.

Discs of 0.2 m, on a grid of 0.5 m or as dense as that, leave rooms through a door of 1.2 m. `FAMILIES` names
the families; each makes a scene of its size from a seed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType

from stplan.scene.model import Scene
from stplan.scene.reading.load import parse_scene

PITCH, DOOR, WALL = 0.5, 1.2, 0.2
# How far beyond the door those who leave a room vanish, and how far the floor goes on behind that, m.
BEYOND, BEHIND = 0.5, 1.5
# Time to leave a room: so much, and so much more for everybody in it, s.
LEAST_TIME, TIME_EACH = 20.0, 0.5

_HEAD = "stplan: 1\ndefaults: {radius: 0.2, after_arrival: vanish}\ntime_scale: 1.3\n"


def grid_room(count: int, rng_seed: int) -> Scene:
    """A room that is full: everybody on a grid, one door."""
    rows = _rows(count)
    width, height = _size(count)
    points = [
        [
            round(width - PITCH * (0.5 + k // rows), 6),
            round(height / 2 + PITCH * (k % rows - (rows - 1) / 2), 6),
        ]
        for k in range(count)
    ]
    return _room(f"grid-room-{count}", count, f"{{points: {points}}}", rng_seed)


def random_room(count: int, rng_seed: int) -> Scene:
    """A room as dense as a full one, everybody somewhere."""
    width, height = _size(count)
    start = f"{{rectangle: [0, 0, {width}, {height}]}}"
    return _room(f"random-room-{count}", count, start, rng_seed)


def counterflow(count: int, rng_seed: int) -> Scene:
    """A corridor 4 m wide, `count` agents in all, half of them each way."""
    half, length = count // 2, 0.24 * count
    far = 10.0 + length
    return parse_scene(
        f"{_HEAD}name: counterflow-{count}\nhorizon: 60\n"
        f"map: {{rectangle: [0, 0, {far + length}, 4]}}\n"
        f"places:\n  west: {{rectangle: [0, 0, {length}, 4]}}\n"
        f"  east: {{rectangle: [{far}, 0, {far + length}, 4]}}\n"
        f"seeding: {{rng_seed: {rng_seed}}}\nagents:\n"
        f"  - {{id: e, count: {half}, start: {{place: west}}, "
        f"goal: {{line: [[{far + 0.5}, 0], [{far + 0.5}, 4]]}}}}\n"
        f"  - {{id: w, count: {half}, start: {{place: east}}, "
        f"goal: {{line: [[{length - 0.5}, 0], [{length - 0.5}, 4]]}}}}\n"
    )


def exchange(count: int, rng_seed: int) -> Scene:
    """A platform and a train with three doors of 1.3 m: half of `count` get off, half get on."""
    half, length = count // 2, 18.0
    doors = [(0.5 + k) * length / 3 for k in range(3)]
    gaps = [0.0, *(x for door in doors for x in (door - 0.65, door + 0.65)), length]
    walls = ", ".join(
        f"{{rectangle: [{gaps[k]}, 2.6, {gaps[k + 1]}, 2.8]}}" for k in range(0, len(gaps), 2)
    )
    return parse_scene(
        f"{_HEAD}name: exchange-{count}\nhorizon: 60\n"
        f"map: {{rectangle: [0, 0, {length}, 9], obstacles: [{walls}]}}\n"
        f"places:\n  train: {{rectangle: [0, 0, {length}, 2.6]}}\n"
        f"  platform: {{rectangle: [0, 4.5, {length}, 7.5]}}\n"
        f"  stairs: {{line: [[0, 8.5], [{length}, 8.5]]}}\n"
        f"seeding: {{rng_seed: {rng_seed}}}\nagents:\n"
        f"  - {{id: leaver, count: {half}, start: {{place: train}}, goal: {{place: stairs}}}}\n"
        f"  - {{id: boarder, count: {half}, start: {{place: platform}}, goal: {{place: train}}, "
        "after_arrival: stay}\n"
    )


def stream(count: int, rng_seed: int) -> Scene:
    """A corridor 4 m wide in which `count` agents appear at random times, one a second, both ways."""
    agents = "".join(
        f"  - {{id: {name}, source: {{rectangle: [{x}, {low}, {x + 0.7}, {low + 1.4}]}}, "
        f"goal: {{line: [[{end}, {low - 0.2}], [{end}, {low + 1.7}]]}}, rate: 0.5, "
        f"during: [0, {count}], arrivals: poisson, allowed_time: 40}}\n"
        for name, x, end, low in (("e", 0.3, 29.5, 0.3), ("w", 29.0, 0.5, 2.3))
    )
    return parse_scene(
        f"{_HEAD}name: stream-{count}\nhorizon: {count + 45}\nmap: {{rectangle: [0, 0, 30, 4]}}\n"
        f"seeding: {{rng_seed: {rng_seed}}}\nagents:\n{agents}"
    )


def assigned(count: int, rng_seed: int) -> Scene:
    """An open square in which `count` agents form rows: who goes where is to be found."""
    side, columns = 1.5 * math.sqrt(count), math.ceil(math.sqrt(count))
    points = [[side + 2 + 0.8 * (k // columns), 0.8 * (k % columns)] for k in range(count)]
    return parse_scene(
        f"{_HEAD}name: assigned-{count}\nhorizon: 30\nseeding: {{rng_seed: {rng_seed}}}\nagents:\n"
        f"  - {{id: a, count: {count}, start: {{rectangle: [0, 0, {side}, {side}]}}, "
        f"goal: {{assign: {points}}}, after_arrival: stay}}\n"
    )


def _rows(count: int) -> int:
    return math.ceil(count / math.ceil(math.sqrt(count)))


def _size(count: int) -> tuple[float, float]:
    """Width and height of a room that a grid of so many fills, m."""
    return PITCH * math.ceil(count / _rows(count)), max(PITCH * _rows(count), DOOR + 2 * WALL)


def _room(name: str, count: int, start: str, rng_seed: int) -> Scene:
    width, height = _size(count)
    low, high = height / 2 - DOOR / 2, height / 2 + DOOR / 2
    door, leave = width + WALL, width + WALL + BEYOND
    return parse_scene(
        f"{_HEAD}name: {name}\nhorizon: {LEAST_TIME + TIME_EACH * count}\n"
        f"map:\n  rectangle: [0, 0, {leave + BEHIND}, {height}]\n  obstacles:\n"
        f"    - {{rectangle: [{width}, 0, {door}, {low}]}}\n"
        f"    - {{rectangle: [{width}, {high}, {door}, {height}]}}\n"
        f"places: {{exit: {{line: [[{leave}, 0], [{leave}, {height}]]}}}}\n"
        f"seeding: {{rng_seed: {rng_seed}}}\nagents:\n"
        f"  - {{id: p, count: {count}, start: {start}, goal: {{place: exit}}}}\n"
    )


Family = Callable[[int, int], Scene]
FAMILIES: Mapping[str, Family] = MappingProxyType(
    {
        "grid room": grid_room,
        "random room": random_room,
        "counterflow": counterflow,
        "exchange": exchange,
        "stream": stream,
        "assigned": assigned,
    }
)
