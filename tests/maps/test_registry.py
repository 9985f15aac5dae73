"""Readers of maps: keys, schema and areas come from one registry, and files are read once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest
import shapely

from stplan.errors import SceneError
from stplan.maps.reader import MapBase
from stplan.maps.registry import READERS, MapFile
from stplan.scene import scene_schema
from stplan.schema.hashing import added, meaning
from stplan.world import build_free_space
from tests.world.scenes import scene

MESH = "v 0 0 0\nv 4 0 0\nv 4 2 0\nv 0 2 0\nf 1 2 3 4\n"


def test_every_reader_has_its_keys_in_the_format() -> None:
    assert len({reader.key for reader in READERS}) == len(READERS)
    known = scene_schema()["$defs"]["MapFile"]["properties"]
    for reader in READERS:
        assert reader.key in reader.keys.model_fields
        assert set(reader.keys.model_fields) <= set(known)
        assert issubclass(MapFile, reader.keys)


@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader.key)
def test_every_reader_makes_an_area(reader, tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text(MESH)
    (tmp_path / "m.wkt").write_text("POLYGON ((0 0, 4 0, 4 2, 0 2, 0 0))")
    written = {
        "mesh": "m.obj", "file": "m.wkt",
        "rectangle": "[0, 0, 4, 2]", "polygon": "[[0, 0], [4, 0], [4, 2], [0, 2]]"
    }  # fmt: skip
    base = scene(f"{{{reader.key}: {written[reader.key]}}}", folder=tmp_path).map.base
    assert isinstance(base, MapBase)
    assert base.floor().area.equals(shapely.box(0, 0, 4, 2))


def test_a_file_is_read_once(tmp_path: Path) -> None:
    mesh = tmp_path / "m.obj"
    mesh.write_text(MESH)
    before = scene("{mesh: m.obj}", folder=tmp_path)
    mesh.write_text(MESH.replace("4", "3"))
    assert build_free_space(before).polygon.area == 8
    after = scene("{mesh: m.obj}", folder=tmp_path)
    assert after.content_hash != before.content_hash
    mesh.unlink()
    assert build_free_space(before).polygon.area == 8
    assert build_free_space(after).triangles is not None
    with pytest.raises(SceneError, match=r"there is no file 'm\.obj'"):
        scene("{mesh: m.obj}", folder=tmp_path)


def test_new_fields_at_their_default_leave_hashes_as_they_were() -> None:
    @dataclass(frozen=True)
    class Setting:
        old: tuple[float, ...] = (1, 2)
        young: int = added(3)

    assert meaning(Setting()) == {"old": (1, 2)}
    assert meaning((Setting((), 4), None)) == [{"old": (), "young": 4}, None]
    spec = scene("{rectangle: [0, 0, 9, 9]}").map
    assert meaning(spec) == {
        "base": {"outer": ((0, 0), (9, 0), (9, 9), (0, 9)), "holes": ()},
        "obstacles": (),
        "resolution": None,
    }
