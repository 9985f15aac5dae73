"""What options do, and what they refuse."""

from __future__ import annotations

import json
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import shapely
from PIL import Image

from stplan.errors import SceneError
from stplan.maps.formats.drawing import repaired
from stplan.world import build_free_space
from tests.maps.formats.samples import ROOMS, SAMPLES, building, dxf, movingai, occupancy
from tests.world.scenes import scene


def floor_of(folder: Path, **options: object) -> shapely.Geometry:
    return build_free_space(scene(json.dumps(options), folder=folder)).area


def test_walls_drawn_as_lines_stand_with_or_without_thickness(tmp_path: Path) -> None:
    document = ezdxf.new()
    space = document.modelspace()
    for ends in (
        ((0, 0), (9, 0)),
        ((9, 0), (9, 6)),
        ((9, 6), (0, 6)),
        ((0, 6), (0, 0)),
        ((4, 0), (4, 4)),
    ):
        space.add_line(*ends)
    document.saveas(tmp_path / "lines.dxf")
    free = build_free_space(scene("{file: lines.dxf}", folder=tmp_path))
    assert free.area.equals(shapely.box(0, 0, 9, 6))
    assert free.clearance(np.array([[4.5, 2.0]])) == pytest.approx(0.5)
    thick = build_free_space(scene("{file: lines.dxf, thickness: 0.4}", folder=tmp_path))
    assert thick.clearance(np.array([[4.5, 2.0]])) == pytest.approx(0.3)


def test_gaps_are_closed_only_when_asked(tmp_path: Path) -> None:
    document = ezdxf.new()
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (9, 0), (9, 6), (0, 6), (0, 0.05)])
    document.saveas(tmp_path / "gap.dxf")
    open_floor = build_free_space(scene("{file: gap.dxf}", folder=tmp_path))
    closed = build_free_space(scene("{file: gap.dxf, weld: 0.1}", folder=tmp_path))
    assert open_floor.area.area == closed.area.area == 54
    assert len(closed.slits) <= len(open_floor.slits) + 1


def test_a_curved_wall_never_gives_floor_away(tmp_path: Path) -> None:
    document = ezdxf.new()
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (9, 0), (9, 9), (0, 9)], close=True)
    space.add_circle((4.5, 4.5), 2.0)
    document.saveas(tmp_path / "column.dxf")
    area = floor_of(tmp_path, file="column.dxf")
    true = shapely.Point(4.5, 4.5).buffer(2.0, quad_segs=512).boundary
    assert area.intersection(true).length == 0


def test_doors_are_open_or_closed(tmp_path: Path) -> None:
    name = building(tmp_path)
    opened = build_free_space(scene(f"{{file: {name}}}", folder=tmp_path))
    closed = build_free_space(scene(f"{{file: {name}, doors: closed}}", folder=tmp_path))
    middle = np.array([[6.5, -4.5]])
    assert opened.clearance(middle) > closed.clearance(middle)


def test_the_threshold_says_how_light_free_pixels_are(tmp_path: Path) -> None:
    Image.fromarray(np.array([[250, 150, 60, 10]], dtype=np.uint8)).save(tmp_path / "grey.png")
    for threshold, count in ((0.9, 1), (0.5, 2), (0.2, 3)):
        assert floor_of(tmp_path, file="grey.png", threshold=threshold).area == count


def test_unknown_cells_of_occupancy_maps_are_no_floor(tmp_path: Path) -> None:
    values = np.array([[254, 254, 205, 0]], dtype=np.uint8)
    (tmp_path / "m.pgm").write_bytes(b"P5 4 1 255\n" + values.tobytes())
    (tmp_path / "m.yaml").write_text(
        "image: m.pgm\nresolution: 1.0\norigin: [0, 0, 0]\nfree_thresh: 0.196\n"
    )
    assert floor_of(tmp_path, file="m.yaml").equals(shapely.box(0, 0, 2, 1))


def test_an_occupancy_map_is_turned_about_its_origin(tmp_path: Path) -> None:
    name = occupancy(tmp_path)
    text = (tmp_path / name).read_text()
    (tmp_path / name).write_text(text.replace("[-3.0, -4.0, 0.0]", "[0, 0, 1.5707963267948966]"))
    expected = shapely.affinity.rotate(ROOMS, 90, origin=(0, 0))
    assert floor_of(tmp_path, file=name).symmetric_difference(expected).area < 1e-6


def test_layers_choose_what_blocks(tmp_path: Path) -> None:
    name = dxf(tmp_path)
    all_layers = floor_of(tmp_path, file=name)
    walls = floor_of(tmp_path, file=name, layers=["walls"])
    assert walls.area > all_layers.area
    groups = (
        '<svg viewBox="0 0 10 10"><g id="hall"><rect width="10" height="10"/></g>'
        '<g class="desks"><rect x="2" y="2" width="1" height="1"/></g>'
        '<g id="text"><path d="M0 5 L10 5" stroke="black"/></g></svg>'
    )
    (tmp_path / "named.svg").write_text(groups)
    assert floor_of(tmp_path, file="named.svg", floor=["hall"], layers=["desks"]).area == 99


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"file": "rooms.map", "threshold": 0.5}, r"map\.threshold: is no option of a MovingAI map"),
        ({"file": "rooms.map", "level": "L1"}, r"map\.level: is no option"),
        ({"rectangle": [0, 0, 1, 1], "scale": 2.0}, r"map\.scale: belongs to a file"),
        ({"file": "missing.map"}, r"map\.file: there is no file"),
        ({"file": "rooms.xyz"}, r"map\.file: is 'rooms\.xyz'; a file that ends in"),
        ({"file": "rooms.map", "scale": 0.0}, r"map\.scale"),
        ({"file": "rooms.map", "scale": 1e9}, r"far away|not finite"),
    ],
)  # fmt: skip
def test_wrong_options_are_refused(options, said: str, tmp_path: Path) -> None:
    movingai(tmp_path)
    (tmp_path / "rooms.xyz").write_text("")
    with pytest.raises(SceneError, match=said):
        build_free_space(scene(json.dumps(options), folder=tmp_path))


def test_floors_that_do_not_connect_are_listed(tmp_path: Path) -> None:
    SAMPLES["wkt"].write(tmp_path)
    (tmp_path / "two.wkt").write_text(
        "POLYGON ((0 0, 4 0, 4 4, 0 4, 0 0))\nPOLYGON ((5 0, 6 0, 6 1, 5 1, 5 0))\n"
    )
    notes = scene("{file: two.wkt}", folder=tmp_path).map.base.floor().notes
    assert "2 floors that do not connect: 16 m2, 1 m2" in notes[-1].text


def test_dirty_polygons_are_mended_with_a_note(tmp_path: Path) -> None:
    (tmp_path / "bow.wkt").write_text("POLYGON ((0 0, 4 4, 4 0, 0 4, 0 0))")
    floor = scene("{file: bow.wkt}", folder=tmp_path).map.base.floor()
    assert floor.area.is_valid
    assert floor.area.area == 8
    assert any(
        "1 polygons are not simple, of which the first touches or crosses itself at (2, 2); mended"
        in note.sentence
        for note in floor.notes
    )


SPARED = "of which the first touches or crosses itself at .*; map.repair: true mends it"


@pytest.mark.parametrize("wanted", [True, None, False])
@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("bow.wkt", "POLYGON ((0 0, 4 4, 4 0, 0 4, 0 0))"),
        (
            "bow.geojson",
            '{"type": "Polygon", "coordinates": [[[0, 0], [4, 4], [4, 0], [0, 4], [0, 0]]]}',
        ),
    ],
)
def test_dirty_polygons_are_refused_where_nothing_is_to_be_mended(
    name: str, content: str, wanted: bool | None, tmp_path: Path
) -> None:
    (tmp_path / name).write_text(content)
    options = {"file": name} | ({} if wanted is None else {"repair": wanted})
    dirty = scene(json.dumps(options), folder=tmp_path)
    if wanted is False:
        with pytest.raises(SceneError, match=SPARED):
            build_free_space(dirty)
    else:
        mended = build_free_space(dirty).polygon
        assert mended.is_valid
        assert mended.area > 0


def test_what_is_in_doubt_in_a_file_is_not_free() -> None:
    # A square that goes around the middle of it twice.
    twice = shapely.Polygon([(0, 0), (6, 0), (6, 4), (3, 4), (3, 1), (5, 1), (5, 5), (0, 5)])
    frame = shapely.box(-9, -9, 20, 20).exterior
    room = shapely.Polygon(frame, [twice.exterior])
    floor, wall, hall, block = (
        sum(part.area for part in repaired([shape], "shapes", blocked=blocked)[0])
        for shape in (twice, room)
        for blocked in (False, True)
    )
    assert (floor, wall) == (23, 29)
    assert (841 - hall, 841 - block) == (29, 23)
