"""Files beside a scene, read once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from stplan.schema.mapping import Fault

LARGEST_FILE = 100 * 1024 * 1024


@dataclass(frozen=True)
class FileContent:
    """A file and what it held when it was read."""

    path: Path
    content: bytes = field(repr=False)

    @property
    def kind(self) -> str:
        """The ending of its name in small letters, without the dot."""
        return self.path.suffix.lower().removeprefix(".")


def read_beside(
    text: str, folder: Path, suffixes: Sequence[str], path: str, noun: str, faults: list[Fault]
) -> FileContent:
    """The file that `text` names, relative to `folder`, empty where there is a fault.

    Args:
        suffixes: endings a name may have, with their dots, in small letters.
        path: of the key that names the file.
        noun: what the file should be, for messages.
    """
    file = folder / text
    fault, content = "", b""
    try:
        if Path(text).is_absolute():
            fault = f"is {text!r}, an absolute path; one relative to the scene file is expected"
        elif "\x00" in text or not file.exists():
            fault = f"there is no file {text!r} beside the scene"
        elif not file.is_file():
            fault = f"{text!r} is no regular file; {noun} is expected"
        elif file.stat().st_size > LARGEST_FILE:
            fault = f"{text!r} is larger than {LARGEST_FILE // 2**20} MiB"
        elif file.suffix.lower() not in suffixes:
            fault = f"is {text!r}; a file that ends in {', '.join(suffixes)} is expected"
        else:
            content = file.read_bytes()
    except OSError as error:
        fault = f"{text[:100]!r} cannot be read: {error.strerror}"
    if fault:
        faults.append((path, fault))
    return FileContent(file, content)
