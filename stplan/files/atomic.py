"""Files that appear whole or not at all: written beside, flushed to disk, then renamed."""

from __future__ import annotations

import os
import secrets
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from stplan.errors import UsageError

_UNFINISHED = ".tmp"


def write_atomically(path: Path, content: bytes) -> Path:
    """Write one file, replacing what was there; raises UsageError where that is impossible."""
    return write_set(path.parent, {path.name: content})[0]


def write_set(folder: Path, contents: Mapping[str, bytes]) -> list[Path]:
    """Write several files into `folder` (made if needed) and return their paths, in order.

    Every file is complete on disk before the first one gets its name, so a full disk or an
    interruption while writing leaves what was there before.

    Raises:
        UsageError: the folder or a file cannot be written; nothing of the set was.
    """
    folder = Path(folder)
    made: list[Path] = []
    waiting: dict[Path, Path] = {}
    try:
        _make_folder(folder, made)
        for name, content in contents.items():
            target = folder / name
            if target.is_dir():
                raise UsageError(f"cannot write {target}: a folder of this name is in the way")
            beside = folder / f".{name}.{os.getpid()}-{secrets.token_hex(6)}{_UNFINISHED}"
            waiting[target] = beside
            _write_flushed(beside, content)
        _rename(waiting)
        _flush_folder(folder)
    except BaseException as error:
        for beside in waiting.values():
            with suppress(OSError):
                beside.unlink(missing_ok=True)
        for path in reversed(made):
            with suppress(OSError):
                path.rmdir()
        if isinstance(error, OSError):
            reason = error.strerror or str(error)
            raise UsageError(f"cannot write into {folder}: {reason}") from error
        raise
    return list(waiting)


def remove_unfinished(folder: Path) -> None:
    """Remove what a writer left behind that was killed; no other may be at work in `folder`."""
    for path in folder.glob(f".*{_UNFINISHED}"):
        path.unlink(missing_ok=True)


def _rename(waiting: Mapping[Path, Path]) -> None:
    """Give every file its name; interrupted between two names it gives the others theirs first."""
    try:
        for target, beside in waiting.items():
            os.replace(beside, target)
    except KeyboardInterrupt:
        for target, beside in waiting.items():
            if beside.exists():
                os.replace(beside, target)
        raise


def _make_folder(folder: Path, made: list[Path]) -> None:
    """Make `folder` and its parents, noting in `made` which ones are new, outermost first."""
    missing = []
    path = folder
    while not path.exists():
        missing.append(path)
        path = path.parent
    for path in reversed(missing):
        path.mkdir(exist_ok=True)
        made.append(path)
    if not folder.is_dir():
        raise UsageError(f"cannot write into {folder}: it is a file, not a folder")


def _write_flushed(path: Path, content: bytes) -> None:
    # Opened by hand for the permissions that the user's umask asks for; tempfile insists on 0600.
    # Windows would write lines its own way without being asked for bytes.
    binary: int = getattr(os, "O_BINARY", 0)
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | binary, 0o666)
    with os.fdopen(descriptor, "wb") as stream:
        stream.write(content)
        stream.flush()
        os.fsync(stream.fileno())


def _flush_folder(folder: Path) -> None:
    """Make the new names durable; some file systems cannot, and their files are whole anyway."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
