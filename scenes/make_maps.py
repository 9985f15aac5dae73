"""Write the mesh maps of the scenes from drawings: every `.` is a square of floor, split into triangles.

Run it after changing a drawing: `python scenes/make_maps.py`. The same drawing gives the same bytes.
"""

from __future__ import annotations

from pathlib import Path

HERE = Path(__file__).parent

GAP = (["." * 19 + "##" + "." * 19] * 8 + ["." * 40] * 3 + ["." * 19 + "##" + "." * 19] * 9, 0.5)

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
ROOMBA = (BLOCKS, 0.25)


def obj_text(drawing: list[str], size: float) -> str:
    """An OBJ mesh of the floor; the first line of the drawing is the lowest row, `size` m a square."""
    corners: dict[tuple[int, int], int] = {}
    faces = []
    for j, line in enumerate(drawing):
        for i, mark in enumerate(line):
            if mark != ".":
                continue
            a, b, c, d = (
                corners.setdefault(place, len(corners) + 1)
                for place in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
            )
            # Diagonals alternate, so that no direction is favoured.
            faces += [(a, b, c), (a, c, d)] if (i + j) % 2 else [(a, b, d), (b, c, d)]
    lines = [f"v {i * size:g} {j * size:g} 0" for i, j in corners]
    lines += [f"f {a} {b} {c}" for a, b, c in faces]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write every map beside its scene."""
    for path, (drawing, size) in {"bottleneck/gap.obj": GAP, "roomba/maze.obj": ROOMBA}.items():
        (HERE / path).write_text(obj_text(drawing, size), encoding="utf-8")


if __name__ == "__main__":
    main()
