"""Scenes that are well-formed but for which it is proven that nobody can plan them."""

from __future__ import annotations

from collections.abc import Iterator

from tests.refusals.case import Case

_WALL = "{rectangle: [0, 0, 10, 6], obstacles: [{rectangle: [4, 0, 5, %s]}, {rectangle: [4, %s, 5, 6]}]}"
_OPEN = "{rectangle: [0, 0, 10, 6]}"


def _scene(world: str, *agents: str, more: str = "") -> bytes:
    listed = "".join(f"  - {{{agent}}}\n" for agent in agents)
    return f"stplan: 1\nhorizon: 20\n{more}map: {world}\nagents:\n{listed}".encode()


def cases() -> Iterator[Case]:
    """Each ends with exit status 3 and names the agents."""
    sam = "id: sam, start: [1, 3], goal: [9, 3], radius: %s"
    for gap in (0.0, 0.1, 0.3, 0.5, 0.59):
        world = _WALL % (3 - gap / 2, 3 + gap / 2)
        yield Case(f"gap of {gap} m", _scene(world, sam % 0.3), {}, "sam", 3)
    for radius in (0.6, 0.8, 0.99):
        world = _WALL % (2.5, 3.5)
        yield Case(f"radius of {radius} m", _scene(world, sam % radius), {}, "sam", 3)
    for waypoint in ("[4.5, 3]", "[9, 5], [1, 5]"):
        text = _scene(_WALL % (2.95, 3.05), f"{sam % 0.02}, waypoints: [{waypoint}]", sam.replace(
            "sam", "ann") .replace("3]", "1]") % 0.3)  # fmt: skip
        yield Case(f"only one fits, by {waypoint}", text, {}, "ann", 3)
    islands = "{rectangle: [0, 0, 10, 6], obstacles: [{rectangle: [4, -1, 5, 7]}]}"
    yield Case("islands", _scene(islands, sam % 0.3), {}, "sam", 3)
    tram = "id: tram, path: [[2, 3, 0], [8, 3, 20]], radius: 0.5"
    yield Case(
        "starts on a given path",
        _scene(_OPEN, tram, "id: sam, start: [2.5, 3.2], goal: [2, 5], start_time: 1"),
        {}, "sam", 3,
    )  # fmt: skip
