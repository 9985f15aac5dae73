"""The same two rooms come out of every format, and never more floor than the file says."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import shapely

from stplan.maps.formats.registry import FORMATS, SUFFIXES
from stplan.world import build_free_space
from tests.maps.formats.samples import ROOMS, SAMPLES, lif
from tests.world.scenes import scene


def floor_of(folder: Path, name: str, **options: object) -> shapely.Geometry:
    tree = json.dumps({"file": name, **options})
    return build_free_space(scene(tree, folder=folder)).area


@pytest.mark.parametrize("name", SAMPLES)
def test_the_rooms_are_read_as_they_are(name: str, tmp_path: Path) -> None:
    sample = SAMPLES[name]
    area = floor_of(tmp_path, sample.write(tmp_path), **sample.options)
    # To the tolerance to which GEOS unites, and the earth is round.
    assert area.difference(ROOMS).area <= sample.loss
    assert ROOMS.difference(area).area <= sample.loss


@pytest.mark.parametrize("name", SAMPLES)
def test_options_move_the_rooms(name: str, tmp_path: Path) -> None:
    sample = SAMPLES[name]
    x, y = sample.options.get("origin", (0.0, 0.0))
    options = {**sample.options, "origin": [x + 100.0, y - 50.0], "flip": "both"}
    area = floor_of(tmp_path, sample.write(tmp_path), **options)
    turned = shapely.affinity.rotate(ROOMS, 180, origin=(6, 4))
    expected = shapely.affinity.translate(turned, 100.0, -50.0)
    assert area.symmetric_difference(expected).area < 0.01


def test_every_format_has_a_sample(tmp_path: Path) -> None:
    from stplan.maps.files import FileContent
    from stplan.maps.formats.registry import format_of

    names = [sample.write(tmp_path) for sample in SAMPLES.values()] + [lif(tmp_path)]
    read = {format_of(FileContent(tmp_path / n, (tmp_path / n).read_bytes())).name for n in names}
    assert {form.name for form in FORMATS} - read == {"MovingAI scenario"}
    assert len(SUFFIXES) == len(set(SUFFIXES))


def test_the_hash_is_of_the_bytes_and_the_options(tmp_path: Path) -> None:
    name = SAMPLES["occupancy"].write(tmp_path)
    first = scene(f"{{file: {name}}}", folder=tmp_path).content_hash
    assert scene(f"{{file: {name}, scale: 1.0}}", folder=tmp_path).content_hash != first
    (tmp_path / name).rename(tmp_path / "other.yaml")
    assert scene("{file: other.yaml}", folder=tmp_path).content_hash == first
    image = tmp_path / "occupancy.pgm"
    content = bytearray(image.read_bytes())
    content[-1] = 0
    image.write_bytes(content)
    assert scene("{file: other.yaml}", folder=tmp_path).content_hash != first


def test_lanes_of_a_layout_are_as_wide_as_asked(tmp_path: Path) -> None:
    area = floor_of(tmp_path, lif(tmp_path), thickness=1.0)
    lanes = shapely.MultiLineString([[(2, 4), (10, 4)], [(6, 4), (6, 7)]])
    assert area.difference(lanes.buffer(0.5, quad_segs=64)).area < 1e-9
    assert area.covers(lanes.buffer(0.45))
