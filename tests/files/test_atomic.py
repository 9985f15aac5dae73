"""A set of files appears whole or not at all."""

from __future__ import annotations

import errno
import os
import stat

import pytest

from stplan.errors import UsageError
from stplan.files import atomic
from stplan.files.atomic import write_atomically, write_set


def _names(folder):
    return sorted(path.name for path in folder.rglob("*"))


def test_writes_into_a_new_folder_and_replaces(tmp_path):
    folder = tmp_path / "a" / "b"
    paths = write_set(folder, {"one": b"1", "two": b"2"})
    assert paths == [folder / "one", folder / "two"]
    write_set(folder, {"two": b"22"})
    assert _names(folder) == ["one", "two"]
    assert (folder / "two").read_bytes() == b"22"
    assert write_atomically(folder / "three", b"3").read_bytes() == b"3"


def test_permissions_follow_the_umask(tmp_path):
    before = os.umask(0o027)
    try:
        path = write_atomically(tmp_path / "f", b"")
    finally:
        os.umask(before)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def _fail_at(monkeypatch, number, error):
    """Let the write with this number (from 0) break off halfway."""
    calls = iter(range(100))
    real = atomic._write_flushed

    def failing(path, content):
        if next(calls) == number:
            path.write_bytes(content[: len(content) // 2])
            raise error
        real(path, content)

    monkeypatch.setattr(atomic, "_write_flushed", failing)


@pytest.mark.parametrize("number", [0, 1])
def test_a_full_disk_leaves_what_was_there(tmp_path, monkeypatch, number):
    write_set(tmp_path, {"one": b"old"})
    _fail_at(monkeypatch, number, OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))
    with pytest.raises(UsageError, match="No space left"):
        write_set(tmp_path, {"one": b"new", "two": b"new"})
    assert _names(tmp_path) == ["one"]
    assert (tmp_path / "one").read_bytes() == b"old"


def test_an_interruption_leaves_not_even_folders(tmp_path, monkeypatch):
    _fail_at(monkeypatch, 1, KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        write_set(tmp_path / "a" / "b", {"one": b"new", "two": b"new"})
    assert _names(tmp_path) == []


def test_a_file_in_the_way_of_the_folder(tmp_path):
    (tmp_path / "a").write_text("")
    for folder in (tmp_path / "a", tmp_path / "a" / "b"):
        with pytest.raises(UsageError, match="cannot write into"):
            write_set(folder, {"one": b""})


def test_a_folder_in_the_way_of_a_file(tmp_path):
    (tmp_path / "two").mkdir()
    with pytest.raises(UsageError, match="a folder of this name is in the way"):
        write_set(tmp_path, {"one": b"", "two": b""})
    assert _names(tmp_path) == ["two"]


def test_interrupted_between_two_names_the_others_get_theirs_too(tmp_path, monkeypatch):
    real = os.replace
    calls = iter(range(9))

    def replace(source, target):
        real(source, target)
        if next(calls) == 0:
            raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", replace)
    with pytest.raises(KeyboardInterrupt):
        write_set(tmp_path, {"one": b"1", "two": b"2"})
    assert _names(tmp_path) == ["one", "two"]
