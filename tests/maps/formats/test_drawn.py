"""Drawings as programs write them: areas that are painted or drawn in every way their formats know."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest
import shapely

from stplan.maps.files import FileContent
from stplan.maps.formats.drawing import Drawing, FileOptions, FormatError
from stplan.maps.formats.dxf import read_dxf
from stplan.maps.formats.geojson import read_geojson
from stplan.maps.formats.lif import read_layout
from stplan.maps.formats.openrmf import read_building
from stplan.maps.formats.pictures import read_occupancy
from stplan.maps.formats.svg import read_svg
from stplan.maps.formats.vadere import read_scenario


def _nothing_beside(name: str) -> FileContent:
    raise AssertionError(name)


def read(
    reader: Callable[..., Drawing], content: str | bytes, beside: bytes | None = None
) -> Drawing:
    """What a reader makes of a file, with another one beside it."""

    def other(name: str) -> FileContent:
        return _nothing_beside(name) if beside is None else FileContent(Path(name), beside)

    data = content.encode() if isinstance(content, str) else content
    return reader(FileContent(Path("m"), data), FileOptions(), other)


def svg(body: str, head: str = 'viewBox="0 0 10 10"') -> Drawing:
    return read(read_svg, f'<svg xmlns="http://www.w3.org/2000/svg" {head}>{body}</svg>')


_SEEN = '<rect x="9" y="9" width="1" height="1"/>'


@pytest.mark.parametrize(
    ("body", "area"),
    [
        # A background that is as large as the page.
        ('<rect width="100%" height="100%"/><rect x="10%" y="1" width="3" height="30%" fill="#fff"/>', 9),
        ('<rect width="1in" height="1pc" transform="scale(0.01)"/>', 100 - 0.96 * 0.16),
        # Two outlines apart that turn either way, one inside another, two that overlap.
        ('<path d="M1 1h2v2h-2z M5 5v2h2v-2z"/>', 92),
        ('<path d="M1 1h6v6h-6z M3 3v2h2v-2z"/>', 68),
        ('<path d="M1 1h6v6h-6z M3 3h2v2h-2z"/>', 64),
        ('<path fill-rule="evenodd" d="M1 1h6v6h-6z M3 3h2v2h-2z"/>', 68),
        ('<path d="M0 0h4v4h-4z M2 0h4v4h-4z M3 0v1h1v-1z M3 0v1h1v-1z"/>', 77),
        # What cannot be seen.
        (f'<rect width="5" height="5" style="fill:#000;fill-opacity:0"/>{_SEEN}', 99),
        (f'<g opacity="0"><rect width="5" height="5"/></g>{_SEEN}', 99),
        (f'<rect width="5" height="5" fill="rgba(0,0,0,0)"/>{_SEEN}', 99),
        (f'<rect width="5" height="5" fill="#0000"/>{_SEEN}', 99),
        # What is light and hardly there opens nothing.
        ('<rect width="5" height="5"/><rect width="5" height="5" fill="white" opacity="20%"/>', 75),
        # Drawings in drawings.
        ('<svg x="5" y="5" width="5" height="5" viewBox="0 0 1 1"><rect width="1" height="1"/></svg>', 75),
        ('<svg width="4" height="2" viewBox="0 0 1 1"><rect width="1" height="1"/></svg>', 96),
        ('<svg width="4" height="2" viewBox="0 0 1 1" preserveAspectRatio="none">'
         '<rect width="1" height="1"/></svg>', 92),
        ('<defs><symbol id="s" viewBox="0 0 1 1"><rect width="1" height="1"/></symbol></defs>'
         '<use href="#s" x="5" y="5" width="5" height="50%"/>', 75),
        # Ends of strokes, and lines that close.
        ('<line x1="2" y1="5" x2="8" y2="5" stroke="#000" stroke-width="2"/>', 88),
        ('<line x1="2" y1="5" x2="8" y2="5" stroke="#000" stroke-width="2" stroke-linecap="square"/>', 84),
        ('<rect x="3" y="3" width="4" height="4" fill="none" stroke="#000" stroke-width="2"/>', 100 - 36 + 4),
        # Style sheets.
        ("<style><![CDATA[ /* walls */ .w {fill:none !important} ]]></style>"
         f"<rect class='w' width='5' height='5'/>{_SEEN}", 99),
        ("<style>* {fill: none} .w {fill: #000}</style><rect width='5' height='5'/>"
         "<rect class='w' width='1' height='1'/>", 99),
    ],
)  # fmt: skip
def test_what_is_painted_dark_and_nothing_else_blocks(body: str, area: float) -> None:
    drawn = svg(body)
    assert sum(floor.area for floor in drawn.floors) == pytest.approx(area, rel=1e-9)


@pytest.mark.parametrize(
    ("body", "area"),
    [
        ('<path d="M5 5L9 5A4 4 0 015 9Z"/>', 100 - 4 * math.pi),
        ('<path d="M5 5l4 0a4 4 0 0 1-4 4"/>', 100 - 4 * math.pi),
        ('<rect width="10" height="10"/><rect x="1" y="1" width="8" height="8" rx="4" fill="white"/>',
         16 * math.pi),
    ],
)  # fmt: skip
def test_curves_are_blocked_on_the_safe_side(body: str, area: float) -> None:
    floor = sum(one.area for one in svg(body).floors)
    assert area - 0.1 < floor < area


def test_what_a_drawing_has_and_is_not_understood_is_named() -> None:
    drawn = svg(
        '<style>.w rect{fill:#fff}</style><clipPath id="c"><rect width="2" height="2"/></clipPath>'
        '<g clip-path="url(#c)"><rect width="1" height="1"/><text>hall</text></g>'
    )
    (note,) = drawn.notes
    assert "clip-path" in note
    assert "<text>" in note
    assert "selectors of more than one word" in note


def test_paths_of_many_outlines_that_overlap_are_refused() -> None:
    data = "".join(f"M{k / 1000} 0h1v1h-1z" for k in range(400))
    with pytest.raises(FormatError, match="outlines that overlap"):
        svg(f'<path d="{data}"/>')


def dxf(draw: Callable[[Any, Any], object]) -> Drawing:
    document = ezdxf.new()
    document.header["$INSUNITS"] = 6
    draw(document, document.modelspace())
    text = io.StringIO()
    document.write(text)
    return read(read_dxf, text.getvalue())


@pytest.mark.parametrize(
    "draw",
    [
        lambda _, space: space.add_lwpolyline([(0, 5), (9, 5)], dxfattribs={"const_width": 1}),
        lambda _, space: space.add_lwpolyline([(0, 5, 1, 1, 0), (9, 5, 0, 0, 0)]),
        lambda _, space: space.add_polyline2d(
            [(0, 5), (9, 5)], dxfattribs={"default_start_width": 1, "default_end_width": 0.5}
        ),
    ],
)
def test_polylines_with_a_width_block_as_wide_as_drawn(draw: Callable[[Any, Any], object]) -> None:
    drawn = dxf(draw)
    assert not drawn.walls
    assert shapely.union_all(drawn.blocked).equals(shapely.box(0, 4.5, 9, 5.5))


def test_a_closed_polyline_with_a_width_has_square_corners() -> None:
    drawn = dxf(
        lambda _, space: space.add_lwpolyline(
            [(1, 1), (9, 1), (9, 9), (1, 9)], close=True, dxfattribs={"const_width": 2}
        )
    )
    assert drawn.blocked[0].area == pytest.approx(100 - 36)


def test_surfaces_of_drawings_block_below_their_faces() -> None:
    drawn = dxf(
        lambda _, space: space.add_polyface().append_face([(1, 1, 0), (2, 1, 0), (2, 2, 3), (1, 2, 3)])
    )  # fmt: skip
    assert shapely.union_all(drawn.blocked).area == pytest.approx(1)


def _grey(width: int, values: list[int], most: int = 255) -> bytes:
    kind = ">u2" if most > 255 else "u1"
    head = f"P5 {width} {len(values) // width} {most}\n".encode()
    return head + np.array(values, dtype=kind).tobytes()


_OCCUPANCY = "image: m.pgm\nresolution: 1.0\norigin: [0, 0, 0]\n"


@pytest.mark.parametrize("threshold", ["", "free_thresh: 0.25\n", "free_thresh: 0.196\n"])
def test_cells_that_nobody_has_seen_are_not_free(threshold: str) -> None:
    drawn = read(read_occupancy, _OCCUPANCY + threshold, _grey(3, [254, 205, 0]))
    assert shapely.union_all(drawn.floors).equals(shapely.box(0, 0, 1, 1))


def test_dark_pixels_of_16_bits_are_dark() -> None:
    drawn = read(read_occupancy, _OCCUPANCY, _grey(2, [65535, 255, 65535, 200], 65535))
    assert shapely.union_all(drawn.floors).equals(shapely.box(0, 0, 1, 2))


def test_buildings_of_maps_of_cities_block() -> None:
    def square(x: float, size: float) -> dict[str, Any]:
        ring = [[x, x], [x + size, x], [x + size, x + size], [x, x + size], [x, x]]
        return {"type": "Polygon", "coordinates": [ring]}

    features = [
        {"type": "Feature", "properties": properties, "geometry": square(x, size)}
        for properties, x, size in (({}, 0, 9), ({"building": "yes"}, 1, 2), ({"building": "A"}, 5, 1))
    ]  # fmt: skip
    drawn = read(read_geojson, json.dumps({"type": "FeatureCollection", "features": features}))
    assert len(drawn.blocked) == 1
    assert len(drawn.floors) == 2


def test_what_fleets_and_crowds_have_beyond_a_map_is_named() -> None:
    level = {
        "vertices": [[0, 0, 0, ""], [9, 0, 0, ""], [9, 9, 0, ""]],
        "floors": [{"vertices": [0, 1, 2]}], "lanes": [[0, 1, {}]],
    }  # fmt: skip
    building = read(read_building, json.dumps({"levels": {"L1": level}, "lifts": {"a": {}}}))
    assert building.notes == ("1 lanes, 1 lifts were left out",)
    edge = {"startNodeId": "a", "endNodeId": "b",
            "vehicleTypeEdgeProperties": [{"trajectory": {"degree": 2}}]}  # fmt: skip
    nodes = [{"nodeId": name, "nodePosition": {"x": x, "y": 0}} for name, x in (("a", 0), ("b", 9))]
    layout = read(read_layout, json.dumps({"layouts": [{"nodes": nodes, "edges": [edge]}]}))
    assert any("trajectories of 1 edges" in note for note in layout.notes)
    topography = {"attributes": {"bounds": {"x": 0, "y": 0, "width": 9, "height": 9}},
                  "aerosolClouds": [{}], "teleporter": {"shift": 1}}  # fmt: skip
    crowd = read(read_scenario, json.dumps({"topography": topography}))
    assert crowd.notes == ("1 aerosolClouds, a teleporter were left out",)
