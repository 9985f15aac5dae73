"""YAML files of other programs, read by the bounded reader of scenes."""

from __future__ import annotations

from typing import Any

from stplan.errors import SceneError
from stplan.maps.files import FileContent
from stplan.maps.formats.drawing import FormatError
from stplan.schema.yaml_nodes import LARGEST_FILE
from stplan.schema.yaml_tree import read_tree


def read_yaml_mapping(file: FileContent) -> dict[str, Any]:
    """The mapping that a file holds; keys that are no text are left out.

    Raises:
        FormatError: it is no YAML that is read.
    """
    if len(file.content) > LARGEST_FILE:
        raise FormatError(f"is larger than {LARGEST_FILE // 2**20} MiB")
    try:
        tree = read_tree(file.content.decode("utf-8-sig", "replace"), "", located=True)
    except SceneError as error:
        line, _, rest = str(error).lstrip(":").partition(":")
        text = rest.partition(": ")[2]
        raise FormatError(
            f"cannot be read: {text}", int(line) if line.isdigit() else None
        ) from error
    if not isinstance(tree.value, dict):
        raise FormatError("holds no mapping of keys to values", 1)
    return tree.value
