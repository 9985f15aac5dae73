"""Write the table of the flash mob: a crowd in rows, a smiling face, and who is to be where by when.

Run it after changing the face: `python scenes/make_face.py`. The same face gives the same bytes.
"""

from __future__ import annotations

from math import cos, pi, radians, sin
from pathlib import Path

TARGET = Path(__file__).parent / "flash-mob" / "mob.csv"
EYES = [(x, y) for x in (-2.6, 2.6) for y in (3.4, 2.2, 1.0)]
MOUTH = [
    (4.4 * cos(angle), 4.4 * sin(angle) - 0.2)
    for angle in (radians(205 + 13 * k) for k in range(11))
]
OUTLINE = [
    (7.5 * cos(angle), 7.5 * sin(angle)) for angle in (pi / 2 + 2 * pi * k / 26 for k in range(26))
]
# The crowd: ranks of five, the front rank nearest to the face (m), and the times of arrival (s).
RANK, FRONT, TOP, SPACING = 5, -13.0, 3.0, 1.5
FIRST, APART = 16.0, 0.5


def main() -> None:
    """The face appears from its far side on, so that nobody has to pass where somebody stands already."""
    lines = ["id,start_x,start_y,goal_x,goal_y,preferred_time"]
    parts = {"eye": EYES, "mouth": MOUTH, "outline": OUTLINE}
    named = [
        (f"{part}-{k + 1}", *parts[part][k]) for part in parts for k in range(len(parts[part]))
    ]
    named.sort(key=lambda one: (-round(one[1], 3), one[2]))
    for number, (name, x, y) in enumerate(named):
        rank, file = divmod(number, RANK)
        start = f"{FRONT - SPACING * rank:g},{TOP - SPACING * file:g}"
        lines.append(f"{name},{start},{x:.3f},{y:.3f},{FIRST + APART * number:g}")
    TARGET.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
