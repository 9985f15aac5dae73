"""Untrusted YAML text -> a plain tree and the place of everything in it.

The meaning is that of `yaml.safe_load`, with more refusals: duplicate keys, keys that are no text, aliases
that grow without bound or contain themselves, deep nesting, more than one document, large files.
"""

from __future__ import annotations

import re
from typing import Any

import yaml

from stplan.errors import SceneError

LARGEST_FILE = 16 * 1024 * 1024
MOST_VALUES = 2_000_000
DEEPEST = 40

Location = tuple[int, int]


class _Loader(yaml.SafeLoader):
    """The safe loader, which also reads 1e-3 as a number."""


class _FastLoader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """The same on the compiled parser where there is one."""


_FLOAT = re.compile(
    r"""^[-+]?(?:\d[\d_]*\.[\d_]*(?:[eE][-+]?\d+)?|\d[\d_]*[eE][-+]?\d+
    |\.\d[\d_]*(?:[eE][-+]?\d+)?|\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))$|^[-+]\.(?:inf|Inf|INF)$""",
    re.X,
)
for _loader in (_Loader, _FastLoader):
    _loader.add_implicit_resolver("tag:yaml.org,2002:float", _FLOAT, list("-+0123456789."))


class Tree:
    """A parsed file: `value`, and the (line, column) of every path in `locations`, from 1."""

    def __init__(self, value: Any, locations: dict[str, Location]) -> None:
        self.value = value
        self.locations = locations


def read_tree(text: str, name: str) -> Tree:
    """Parse YAML `text`; `name` heads every message.

    Raises:
        SceneError: the text is no YAML this reader accepts.
    """
    if len(text) > LARGEST_FILE:
        raise SceneError(f"{name}:1:1: the file is larger than {LARGEST_FILE // 2**20} MiB")
    loader = _FastLoader(text)
    try:
        node = loader.get_single_node()
        if node is None:
            raise SceneError(f"{name}:1:1: the file is empty; a scene is expected")
        builder = _Builder(loader, name)
        value = builder.build(node, "", 0)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
        raise SceneError(f"{name}:{line}:{column}: not valid YAML: {error.problem}") from error
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        first = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise SceneError(f"{name}:1:1: not valid YAML: {first}") from error
    finally:
        loader.dispose()
    if builder.faults:
        raise SceneError(builder.faults)
    return Tree(value, builder.locations)


class _Builder:
    """Constructs values from nodes, noting places, and refusing what could explode."""

    def __init__(self, loader: Any, name: str) -> None:
        self._loader = loader
        self._name = name
        self._count = 0
        self._open: set[int] = set()
        self.locations: dict[str, Location] = {}
        self.faults: list[str] = []

    def build(self, node: yaml.Node, path: str, depth: int) -> Any:
        place = (node.start_mark.line + 1, node.start_mark.column + 1)
        self.locations.setdefault(path, place)
        self._count += 1
        if self._count > MOST_VALUES:
            raise SceneError(
                f"{self._name}:{place[0]}:{place[1]}: the file expands to more than {MOST_VALUES} "
                "values; aliases that repeat other aliases are not expected in a scene"
            )
        if depth > DEEPEST or id(node) in self._open:
            raise SceneError(
                f"{self._name}:{place[0]}:{place[1]}: nested more than {DEEPEST} levels deep "
                "or containing itself"
            )
        if isinstance(node, yaml.ScalarNode):
            if node.tag == "tag:yaml.org,2002:timestamp":
                return node.value
            if len(node.value) > 4000 and node.tag.endswith((":int", ":float")):
                raise SceneError(f"{self._name}:{place[0]}:{place[1]}: {path}: number too long")
            return self._loader.construct_object(node)
        self._open.add(id(node))
        try:
            if isinstance(node, yaml.SequenceNode):
                return [
                    self.build(child, f"{path}[{k}]", depth + 1)
                    for k, child in enumerate(node.value)
                ]
            if isinstance(node, yaml.MappingNode):
                return self._mapping(node, path, depth)
        finally:
            self._open.discard(id(node))
        raise SceneError(f"{self._name}:{place[0]}:{place[1]}: {path}: not a plain value")

    def _mapping(self, node: yaml.MappingNode, path: str, depth: int) -> dict[str, Any]:
        result: dict[str, Any] = {}
        for key_node, value_node in node.value:
            line, column = key_node.start_mark.line + 1, key_node.start_mark.column + 1
            where = f"{self._name}:{line}:{column}"
            if not isinstance(key_node, yaml.ScalarNode) or (
                key_node.tag != "tag:yaml.org,2002:str"
            ):
                self.faults.append(f"{where}: {path or 'scene'}: keys are plain text")
                continue
            key = key_node.value
            inner = f"{path}.{key}" if path else key
            if key in result:
                self.faults.append(f"{where}: {inner}: this key stands here twice")
                continue
            self.locations[inner] = (line, column)
            result[key] = self.build(value_node, inner, depth + 1)
        return result
