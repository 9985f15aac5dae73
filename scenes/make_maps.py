"""Write the mesh maps of the scenes from drawings: every `.` is a square of floor, split into triangles.

Run it after changing a drawing: `python scenes/make_maps.py`. The same drawing gives the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos, pi, sin
from pathlib import Path

HERE = Path(__file__).parent

GAP = ["." * 19 + "##" + "." * 19] * 8 + ["." * 40] * 3 + ["." * 19 + "##" + "." * 19] * 9

BLOCKS = [
    "....................",
    "....................",
    "..####..####..####..",
    "..####..####..####..",
    "..####..####..####..",
    "..####..####..####..",
    "........####........",
    "........####........",
    "..####..####..####..",
    "..####..####..####..",
    "..####........####..",
    "..####........####..",
    "..####..####..####..",
    "..####..####..####..",
    "....................",
    "....................",
    "..####..####..####..",
    "..####..####..####..",
    "..####..####..####..",
    "..####..####..####..",
    "....................",
    "....................",
]
# Hedges and paths of 2 m on 50 m: every way of the corn maze is a detour, and most of it a single lane.
CORN = [
    ".........................",
    ".###.#######.#.#####.###.",
    ".#...#.....#.#.....#...#.",
    ".#.###.###.#.#####.###.#.",
    "...#...#.......#.....#...",
    ".#.#.###.#####.#.###.#.#.",
    ".#.#.#...#...#.#...#...#.",
    ".#.#.#.###.#.#.###.###.#.",
    ".#.....#...#.....#...#.#.",
    ".#.###.#.#########.#.#.#.",
    ".....#.#.#.......#.#.....",
    ".###.#...#.......#...###.",
    "...#.###...............#.",
    ".#.#...#.#.......#.#.#.#.",
    ".#.###.#.#.......#.#.#.#.",
    ".#.....#.####.####.#.....",
    ".#.###.#.....#.....#.###.",
    ".#.#...###.#.#.#.###...#.",
    "...#.#...#.#.#.#.....#...",
    ".#.#.###.#.#...#.###.#.#.",
    ".#.#...#...#.#.#...#.#.#.",
    ".#.###.#####.#.###.#.#.#.",
    ".#.....#.........#...#.#.",
    ".###.#.#.#######.#.###.#.",
    ".........................",
]

# Rings of the circular maze from the inside out, a mark every five degrees, and their radii in m.
_OPEN, _GATE = "." * 72, 3
RADII = (1.0, 3.4, 3.8, 6.4, 6.8, 9.4, 9.8, 12.4)


def ring(*gates: int) -> str:
    """A wall all round but for gates that begin at these marks."""
    marks = ["#"] * 72
    for gate in gates:
        marks[gate : gate + _GATE] = "." * _GATE
    return "".join(marks)


def barriers(*places: int) -> str:
    """An open ring with walls across it at these marks."""
    return "".join("#" if k in places else "." for k in range(72))


RINGS = [
    _OPEN,
    ring(10, 46),
    barriers(3, 39),
    ring(26, 62),
    barriers(18, 54),
    ring(8, 30, 44, 66),
    barriers(0, 36),
]


def on_square(size: float) -> Callable[[int, int], tuple[float, float]]:
    """Corners of squares of `size` m."""
    return lambda i, j: (i * size, j * size)


def on_rings(radii: tuple[float, ...], sectors: int) -> Callable[[int, int], tuple[float, float]]:
    """Corners on circles of these radii, `sectors` on each."""

    def place(i: int, j: int) -> tuple[float, float]:
        angle = 2 * pi * i / sectors
        return round(radii[j] * cos(angle), 6), round(radii[j] * sin(angle), 6)

    return place


def obj_text(drawing: list[str], place: Callable[[int, int], tuple[float, float]]) -> str:
    """An OBJ mesh of the floor; the first line of the drawing is the row at `place(i, 0)`."""
    corners: dict[tuple[float, float], int] = {}
    faces = []
    for j, line in enumerate(drawing):
        for i, mark in enumerate(line):
            if mark != ".":
                continue
            a, b, c, d = (
                corners.setdefault(place(*corner), len(corners) + 1)
                for corner in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
            )
            # Diagonals alternate, so that no direction is favoured.
            faces += [(a, b, c), (a, c, d)] if (i + j) % 2 else [(a, b, d), (b, c, d)]
    lines = [f"v {x:g} {y:g} 0" for x, y in corners]
    lines += [f"f {a} {b} {c}" for a, b, c in faces]
    return "\n".join(lines) + "\n"


MAPS = {
    "bottleneck/gap.obj": (GAP, on_square(0.5)),
    "roomba/maze.obj": (BLOCKS, on_square(0.25)),
    "mazes/corn.obj": (CORN, on_square(2.0)),
    "mazes/rings.obj": (RINGS, on_rings(RADII, 72)),
}


def main() -> None:
    """Write every map beside its scene."""
    for path, (drawing, place) in MAPS.items():
        (HERE / path).write_text(obj_text(drawing, place), encoding="utf-8")


if __name__ == "__main__":
    main()
