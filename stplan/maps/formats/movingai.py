"""Grid maps and scenarios of the MovingAI benchmarks: ``.map`` and ``.scen``.

A map is a head (`type`, `height`, `width`, `map`) and a letter a cell. Agents need `.`, `G` or, in
water, `S` and `W`; swamp and water are ground to whoever asks with `floor`. A scenario line names
columns and rows from the top left corner.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import Point
from stplan.maps.files import FileContent
from stplan.maps.formats.cells import cell_polygons, check_cells
from stplan.maps.formats.drawing import (
    Beside,
    Drawing,
    DrawnAgent,
    FileOptions,
    ForeignFormat,
    FormatError,
    finite,
)

_FREE = ".GS"
_HEAD = 4


def read_map(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """The free cells, one unit wide, merged exactly; y upwards from the last row."""
    del beside
    lines = file.content.decode("latin-1").splitlines()
    height, width, start = _head(lines)
    check_cells(width, height)
    letters = "".join(options.floor) or _FREE
    rows = lines[start : start + height]
    if len(rows) < height:
        raise FormatError(f"has {len(rows)} rows, {height} are announced", len(lines))
    for number, row in enumerate(rows, start + 1):
        if len(row) < width:
            raise FormatError(f"has a row of {len(row)} cells, {width} are announced", number)
    text = "".join(row[:width] for row in rows)
    cells = np.frombuffer(text.encode("latin-1"), dtype=np.uint8).reshape(height, width)
    free = np.isin(cells, np.frombuffer(letters.encode("latin-1", "ignore"), dtype=np.uint8))
    if not free.any():
        raise FormatError(f"has no free cell: none of {letters}")
    return Drawing(floors=cell_polygons(free), grid=1.0, height=float(height))


def _head(lines: list[str]) -> tuple[int, int, int]:
    """Height, width, and the index of the first row."""
    sizes: dict[str, int] = {}
    for number, line in enumerate(lines[:16], 1):
        words = line.split()
        if words == ["map"]:
            if {"height", "width"} <= sizes.keys():
                return sizes["height"], sizes["width"], number
            break
        if len(words) == 2 and words[0] in ("height", "width"):
            if not (words[1].isascii() and words[1].isdigit() and len(words[1]) < 9):
                raise FormatError(f"has the {words[0]} {words[1][:40]!r}", number)
            sizes[words[0]] = int(words[1])
    raise FormatError("has no head with height, width and map", 1)


def read_scenario(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """The agents of a ``.scen``: a line each, cells as the map has them."""
    del options, beside
    agents: list[DrawnAgent] = []
    name = ""
    for number, line in enumerate(file.content.decode("latin-1").splitlines(), 1):
        words = line.split("\t") if "\t" in line else line.split()
        if not words or words[0].lower().startswith("version"):
            continue
        if len(words) != 9:
            raise FormatError(f"has {len(words)} words in a line, 9 are expected", number)
        height = finite(words[3], "the height", number)
        name = name or words[1]
        x, y, goal_x, goal_y = (finite(word, "a cell", number) for word in words[4:8])

        def cell(column: float, row: float, height: float = height) -> Point:
            return column + 0.5, height - row - 0.5

        agents.append(DrawnAgent(f"a{len(agents) + 1}", cell(x, y), cell(goal_x, goal_y)))
        if len(agents) > 100_000:
            raise FormatError("has more than 100000 agents", number)
    if not agents:
        raise FormatError("has no agents", 1)
    return Drawing(agents=tuple(agents), grid=1.0, names=(name.rpartition("/")[2],))


MAP = ForeignFormat("MovingAI map", (".map",), read_map, frozenset({"floor"}))
SCENARIO = ForeignFormat("MovingAI scenario", (".scen",), read_scenario)
