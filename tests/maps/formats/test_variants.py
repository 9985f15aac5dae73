"""Ways in which files of the same format differ in the wild."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import shapely
from PIL import Image

from stplan.errors import SceneError, UsageError
from stplan.maps.files import FileContent
from stplan.maps.formats.drawing import FormatError
from stplan.maps.formats.svg_shapes import outlines
from stplan.maps.formats.xml_tree import read_xml
from stplan.world import build_free_space
from tests.maps.formats.samples import SAMPLES
from tests.world.scenes import scene


def floor_of(folder: Path, name: str, text: str | bytes, more: str = "") -> shapely.Geometry:
    (folder / name).write_bytes(text.encode() if isinstance(text, str) else text)
    return build_free_space(scene(f"{{file: {name}{more}}}", folder=folder)).area


def test_grids_with_other_line_ends(tmp_path: Path) -> None:
    text = "type octile\r\nheight 2\r\nwidth 3\r\nmap\r\n...\r\n.@.\r\n"
    assert floor_of(tmp_path, "m.map", text).area == 5


def test_pictures_of_other_kinds(tmp_path: Path) -> None:
    ascii_grey = "P2\n# by hand\n3 2\n255\n255 255 0\n0 255 255\n"
    assert floor_of(tmp_path, "a.pgm", ascii_grey, ", simplify: 0.0").area == 4
    deep = b"P5 2 1 65535\n" + np.array([65535, 0], dtype=">u2").tobytes()
    assert floor_of(tmp_path, "b.pgm", deep).area == 1
    Image.fromarray(np.array([[[0, 0, 0, 0], [0, 0, 0, 255]]], dtype=np.uint8)).save(
        tmp_path / "c.png"
    )
    assert floor_of(tmp_path, "c.png", (tmp_path / "c.png").read_bytes()).area == 1


def test_what_is_transparent_in_an_occupancy_map_is_not_known_to_be_free(tmp_path: Path) -> None:
    pixels = np.array([[[255, 255, 255, 255], [255, 255, 255, 0]]], dtype=np.uint8)
    Image.fromarray(pixels).save(tmp_path / "m.png")
    text = "image: m.png\nresolution: 1.0\norigin: [0, 0, 0]\n"
    assert floor_of(tmp_path, "m.yaml", text).equals(shapely.box(0, 0, 1, 1))


def test_well_known_text_in_many_pieces(tmp_path: Path) -> None:
    text = (
        "SRID=25832;POLYGON Z ((0 0 1, 4 0 1, 4 4 1, 0 4 1, 0 0 1))\nPOLYGON EMPTY\n"
        "GEOMETRYCOLLECTION(MULTIPOLYGON(((3 0, 9 0, 9 4, 3 4, 3 0))), POINT (1 1))\n"
    )
    assert floor_of(tmp_path, "m.wkt", text).area == 36


def test_drawings_of_programs_that_abbreviate_namespaces(tmp_path: Path) -> None:
    head = '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "svg11.dtd" [<!ENTITY n "http://www.w3.org/2000/svg">]>'
    body = '<svg xmlns="&n;" width="10cm" height="5cm"><rect x="4" width="1" height="3"/></svg>'
    page = 10 * 96 / 2.54 * 5 * 96 / 2.54
    assert floor_of(tmp_path, "m.svg", head + body).area == pytest.approx(page - 3, rel=1e-12)
    with pytest.raises(FormatError, match="declares entities"):
        read_xml(b'<!DOCTYPE x [<!ENTITY a "b"><!ENTITY c "&a;&a;">]><x/>')
    with pytest.raises(FormatError, match="declares entities"):
        read_xml(
            b'<!DOCTYPE x [<!ENTITY a "' + b"b" * 100_000 + b'">]><x>' + b"&a;" * 1000 + b"</x>"
        )


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        ("M0 0h4v3h-4z", shapely.box(0, 0, 4, 3)),
        ("m1,1 2,0 0,2 -2,0z m1 -1", shapely.box(1, 1, 3, 3)),
        ("M3 0A3 3 0 0 1 -3 0A3 3 0 0 1 3 0z", shapely.Point(0, 0).buffer(3, quad_segs=200)),
        ("M0 0Q2 4 4 0T8 0z", None),
        ("M0 0C0 2 4 2 4 0S8 -2 8 0z", None),
    ],
)
def test_paths_are_drawn_within_a_tolerance(data: str, expected) -> None:
    element = read_xml(f'<svg><path d="{data}"/></svg>'.encode()).children[0]
    lines, _ = outlines(element, np.eye(3), 1e-3)
    drawn = max(
        (shapely.Polygon(line) for line in lines if len(line) > 3),
        key=lambda shape: abs(shape.area),
    )
    if expected is not None:
        assert drawn.symmetric_difference(expected).area < 0.03
    else:
        # The second half is the first one, turned.
        (line,) = lines
        x, y = line.T
        assert np.interp(2.0, x, y) == pytest.approx(-np.interp(6.0, x, y), abs=2e-3)


def test_buildings_in_metres_with_keys_that_are_numbers(tmp_path: Path) -> None:
    text = (
        "graphs: {0: {name: fleet}}\ncoordinate_system: cartesian_meters\nlevels:\n  L1:\n    vertices:\n"
        '      - [0, 0, 0, "", {}]\n      - [9, 0, 0, 7]\n      - [9, 9, 0, spot]\n      - [0, 9, 0, ""]\n'
        "    walls: [[0, 1, {}], [1, 2, {}], [2, 3, {}], [3, 0, {}]]\n"
    )
    assert floor_of(tmp_path, "m.building.yaml", text).equals(shapely.box(0, 0, 9, 9))


def test_obstacles_that_are_in_another_file_are_not_forgotten(tmp_path: Path) -> None:
    text = '<Experiment><ObstacleSet type="nav_mesh" file_name="x.nav" class="1"/></Experiment>'
    with pytest.raises(SceneError, match="obstacles of the type 'nav_mesh'"):
        floor_of(tmp_path, "m.xml", text)


@pytest.mark.parametrize(
    ("name", "module", "extra"),
    [("picture", "PIL.Image", "maps"), ("dxf", "ezdxf", "maps"), ("degrees", "pyproj", "maps"),
     ("ifc", "ifcopenshell", "bim")],
)  # fmt: skip
def test_a_missing_package_says_the_one_command(
    name: str, module: str, extra: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = SAMPLES[name].write(tmp_path)
    base = scene(f"{{file: {file}}}", folder=tmp_path).map.base
    assert isinstance(base.file, FileContent)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(UsageError, match=rf"pip install 'stplan\[{extra}\]'"):
        base.floor()
