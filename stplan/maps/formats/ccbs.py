"""XML files of continuous conflict-based search: grid maps, and agents by row (i) and column (j)."""

from __future__ import annotations

import numpy as np

from stplan.maps.files import FileContent
from stplan.maps.formats.cells import cell_polygons, check_cells
from stplan.maps.formats.drawing import (
    Beside,
    Drawing,
    DrawnAgent,
    FileOptions,
    ForeignFormat,
    FormatError,
)
from stplan.maps.formats.xml_tree import Element, read_xml


def read_ccbs(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """A map of cells (0 is free), or agents; rows count from the top of a map that is put beside them."""
    del options, beside
    root = read_xml(file.content)
    map_element = root.first("map")
    if map_element is not None and map_element.first("grid") is not None:
        return _map(map_element)
    agents: list[DrawnAgent] = []
    for agent in root.all("agent"):
        i, j, goal_i, goal_j = (
            agent.number(key) for key in ("start_i", "start_j", "goal_i", "goal_j")
        )
        name = f"a{agent.attributes.get('id', len(agents))}"
        # The height of the map is not known here: its last row is taken for zero.
        agents.append(DrawnAgent(name, (j + 0.5, -i - 0.5), (goal_j + 0.5, -goal_i - 0.5)))
    if not agents:
        raise FormatError("holds neither a grid nor agents", root.line)
    return Drawing(agents=tuple(agents), grid=1.0)


def _map(element: Element) -> Drawing:
    rows = [row.text.split() for row in element.all("row")]
    check_cells(max((len(row) for row in rows), default=0), len(rows))
    for row, source in zip(rows, element.all("row"), strict=True):
        if len(row) != len(rows[0]):
            raise FormatError(
                f"has a row of {len(row)} cells after one of {len(rows[0])}", source.line
            )
    free = np.array([[cell == "0" for cell in row] for row in rows])
    if not free.any():
        raise FormatError("has no free cell", element.line)
    return Drawing(floors=cell_polygons(free), grid=1.0, height=float(len(rows)))


CCBS = ForeignFormat(
    "CCBS file", (".xml",), read_ccbs,
    claims=lambda content: b"<root" in content or b"<map" in content,
)  # fmt: skip
