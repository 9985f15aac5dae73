"""The manifest of a run's folder: digests of all its files, in run.json, which is written last.

A set of files is renamed one by one, so a process killed among the renames leaves files of two runs side
by side. The manifest tells: it fits only the files it was made for.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path

from stplan.errors import UsageError
from stplan.files.json_file import read_json
from stplan.files.recorded import RUN_RECORD

# Where it stands in run.json.
KEY = "sha256"


def manifest(contents: Mapping[str, bytes]) -> dict[str, str]:
    """The SHA-256 of every file, by name."""
    return {name: hashlib.sha256(content).hexdigest() for name, content in contents.items()}


def why_incomplete(folder: Path) -> str:
    """Why the files in `folder` are not the whole of one run; empty where they are."""
    try:
        record = read_json(folder / RUN_RECORD)
    except UsageError as error:
        return "not planned yet" if not (folder / RUN_RECORD).exists() else str(error)
    digests = record.get(KEY)
    if not isinstance(digests, dict) or not digests:
        return f"{RUN_RECORD} holds no digests of the other files"
    for name, digest in digests.items():
        # Only names that a run gives: a manifest is no licence to read elsewhere.
        if Path(name).name != name:
            return f"{RUN_RECORD} names {name!r}, which is not a file of a run"
        try:
            with (folder / name).open("rb") as stream:
                found = hashlib.file_digest(stream, "sha256").hexdigest()
        except OSError as error:
            return f"{name}: {error.strerror or error}"
        if found != digest:
            return f"{name} is not the file that this run wrote"
    return ""
