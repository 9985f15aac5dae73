"""What a scene file may be: its encoding, its size, whether it is there."""

from __future__ import annotations

import subprocess
import sys

import pytest

from stplan.errors import SceneError
from stplan.scene import load_scene, parse_scene
from stplan.schema.yaml_nodes import LARGEST_FILE
from tests.scene.samples import PAIR, refusal, scene_text


def test_file_with_byte_order_mark_and_carriage_returns(tmp_path):
    path = tmp_path / "pair.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + PAIR.replace("\n", "\r\n").encode())
    scene = load_scene(path)
    assert scene.locations["agents[1].id"] == (9, 5)
    assert scene.content_hash == parse_scene(PAIR).content_hash


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", ":1:1: the file is empty; a scene is expected"),
        (
            b"stplan: 1\nname: \xff",
            ":2:7: the byte 0xff is not UTF-8; a YAML text is expected",
        ),
        (b"a" * (LARGEST_FILE + 1), ":1:1: the file is larger than 16 MiB"),
        (None, ": no such scene file"),
    ],
)
def test_file_refused(tmp_path, content, message):
    path = tmp_path / "s.yaml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(SceneError) as refused:
        load_scene(path)
    assert str(refused.value) == f"{path}{message}"


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", b"name: \xe4\xf6", b"\x80" * 100])
def test_no_utf8(tmp_path, content):
    path = tmp_path / "latin.yaml"
    path.write_bytes(content)
    with pytest.raises(SceneError, match="UTF-8") as caught:
        load_scene(path)
    assert str(caught.value).startswith(str(path))


def test_too_large(tmp_path):
    assert "larger than" in refusal("#" * (LARGEST_FILE + 1))
    path = tmp_path / "large.yaml"
    path.write_bytes(b"#" * (LARGEST_FILE + 1))
    with pytest.raises(SceneError, match="larger than"):
        load_scene(path)


def test_a_folder_is_no_scene(tmp_path):
    with pytest.raises(SceneError, match="cannot be read: Is a directory"):
        load_scene(tmp_path)
    with pytest.raises(SceneError, match="cannot be read"):
        load_scene("a\0b")


def test_files_that_are_none(tmp_path):
    for path in (tmp_path / "absent.yaml", tmp_path, tmp_path / "a\0b.yaml"):
        with pytest.raises(SceneError):
            load_scene(path)


def test_file_heads_the_message(tmp_path):
    path = tmp_path / "my scene.yaml"
    path.write_text(scene_text("radius: 0"), encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert caught.value.messages[0].startswith(f"{path}:4:")
    assert caught.value.exit_status == 2


def test_reading_needs_no_heavy_library():
    code = (
        "import sys, stplan.scene\n"
        "print([n for n in ('shapely', 'scipy', 'numba', 'trimesh') if n in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
