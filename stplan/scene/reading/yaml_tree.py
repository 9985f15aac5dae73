"""Untrusted YAML text -> a plain tree and the place of everything in it.

The meaning is that of `yaml.safe_load`, with these differences, all towards fewer surprises:

- refused: duplicate keys, keys that are no text, tags that are no plain data, a second document,
  aliases that contain themselves or repeat more values than `MOST_VALUES`, nesting past `DEEPEST`;
- ``1e-3`` is a number (YAML 1.1 wants ``1.0e-3``);
- ``010`` and ``1:30`` are text (YAML 1.1 reads 8 and 90), and so are dates.

The text is read event by event: bounds are met before memory is spent on what breaks them, and
without recursion over the text, which the compiled composer does not survive on deep nesting.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import yaml

from stplan.errors import SceneError

LARGEST_FILE = 16 * 1024 * 1024
MOST_VALUES = 1_000_000
DEEPEST = 40
# Digits of the longest number; more cannot change a float, and conversion is quadratic in them.
LONGEST_NUMBER = 400
# Characters of the longest key; a path repeats the keys above it for every value below them.
LONGEST_KEY = 100

Location = tuple[int, int]

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_TAG = "tag:yaml.org,2002:"
_INT = re.compile(r"[-+]?(?:0|[1-9][0-9_]*|0x[0-9a-fA-F]+|0o[0-7]+|0b[01]+)\Z")
_PLAIN_INT = re.compile(r"[-+]?(?:0|[1-9][0-9_]*)\Z")
_FLOAT = re.compile(
    r"""[-+]?(?:(?:[0-9][0-9_]*\.[0-9_]*|\.[0-9][0-9_]*)(?:[eE][-+]?[0-9]+)?
    |[0-9][0-9_]*[eE][-+]?[0-9]+|\.(?:inf|Inf|INF))\Z|\.(?:nan|NaN|NAN)\Z""",
    re.X,
)
_BOOLEANS = {
    word: value
    for value, words in ((True, ("true", "yes", "on")), (False, ("false", "no", "off")))
    for lower in words
    for word in (lower, lower.capitalize(), lower.upper())
}
_NULLS = {"", "~", "null", "Null", "NULL"}


@dataclass
class Tree:
    """A parsed file.

    Attributes:
        value: dicts, lists, text, numbers, booleans and None.
        locations: (line, column), from 1, of every path; of a key's path, where its key stands.
        written: how booleans are written where that is neither ``true`` nor ``false``, by path.
        faults: (path, place, sentence) of everything a reader can step over.
    """

    value: Any
    locations: dict[str, Location] = field(default_factory=dict)
    written: dict[str, str] = field(default_factory=dict)
    faults: list[tuple[str, Location, str]] = field(default_factory=list)


@dataclass
class _Node:
    """A value of the text; `size` and `height` count what its aliases stand for."""

    place: Location
    value: Any = None
    written: str = ""
    fault: str = ""
    size: int = 1
    height: int = 1


class _UnreadableError(Exception):
    """The text cannot be read any further."""

    def __init__(self, text: str, place: Location = (1, 1)) -> None:
        super().__init__(text)
        self.text, self.place = text, place


def read_tree(text: str, name: str, *, located: bool = True) -> Tree:
    """Parse YAML `text`; `name` heads every message, followed by the place if `located`.

    Raises:
        SceneError: the text is no YAML this reader accepts.
    """
    try:
        if len(text) > LARGEST_FILE:
            raise _UnreadableError(f"the file is larger than {LARGEST_FILE // 2**20} MiB")
        root = _nodes(text)
        tree = Tree(None)
        tree.value = _build(root, "", tree)
    except _UnreadableError as refusal:
        place = f":{refusal.place[0]}:{refusal.place[1]}" if located else ""
        raise SceneError(f"{name}{place}: {refusal.text}") from refusal
    return tree


def _nodes(text: str) -> _Node:
    """The only document of `text`."""
    try:
        loader = _Loader(text)
    except (yaml.YAMLError, ValueError) as error:
        raise _unreadable(error, text) from error
    try:
        return _document(_events(loader, text))
    finally:
        loader.dispose()


def _events(loader: Any, text: str) -> Iterator[yaml.Event]:
    try:
        while loader.check_event():
            yield loader.get_event()
    except (yaml.YAMLError, ValueError) as error:
        raise _unreadable(error, text) from error


def _unreadable(error: Exception, text: str) -> _UnreadableError:
    """The parser's complaint as ours, with the place it names."""
    if isinstance(error, yaml.MarkedYAMLError):
        mark = error.problem_mark or error.context_mark
        place = (1, 1) if mark is None else (mark.line + 1, mark.column + 1)
        if "maximum nesting depth" in (error.problem or ""):
            # Newer scanners look far ahead and meet a bound of their own before ours.
            return _UnreadableError(f"nested more than {DEEPEST} levels deep", place)
        return _UnreadableError(f"not valid YAML: {error.problem or error.context}", place)
    if isinstance(error, yaml.reader.ReaderError | UnicodeEncodeError):
        # Not every parser counts characters here, so the culprit is looked for.
        for number, line in enumerate(text.split("\n"), 1):
            for column, character in enumerate(line, 1):
                if yaml.reader.Reader.NON_PRINTABLE.match(character):
                    shown = f"the character U+{ord(character):04X} is not allowed in YAML"
                    return _UnreadableError(f"not valid YAML: {shown}", (number, column))
    reason = str(error).partition("\n")[0] or type(error).__name__
    return _UnreadableError(f"not valid YAML: {reason}")


class _Open:
    """A list or mapping whose end has not been met; `keys` alternate with values in a mapping."""

    def __init__(self, event: yaml.CollectionStartEvent, place: Location) -> None:
        self.node = _Node(place)
        self.anchor = event.anchor
        self.is_mapping = isinstance(event, yaml.MappingStartEvent)
        plain = ("!", f"{_TAG}map" if self.is_mapping else f"{_TAG}seq")
        if event.tag is not None and event.tag not in plain:
            self.node.fault = f"the tag {event.tag!r} is not expected in a scene"
        self.children: list[_Node] = []

    def add(self, child: _Node) -> None:
        self.children.append(child)
        self.node.size += child.size
        self.node.height = max(self.node.height, child.height + 1)

    def close(self) -> _Node:
        if self.is_mapping:
            self.node.value = list(zip(self.children[::2], self.children[1::2], strict=True))
        else:
            self.node.value = tuple(self.children)
        return self.node


def _document(events: Iterator[yaml.Event]) -> _Node:
    """Nodes of the first document; everything that could explode is refused on the way."""
    open_nodes: list[_Open] = []
    anchors: dict[str, _Node | None] = {}
    root: _Node | None = None
    total = 0
    for event in events:
        mark = event.start_mark
        place = (mark.line + 1, mark.column + 1) if mark is not None else (1, 1)
        node: _Node
        if isinstance(event, yaml.ScalarEvent):
            node = _scalar(event, place)
            if event.anchor is not None:
                anchors[event.anchor] = node
        elif isinstance(event, yaml.CollectionStartEvent):
            if event.anchor is not None:
                anchors[event.anchor] = None
            open_nodes.append(_Open(event, place))
            if len(open_nodes) > DEEPEST:
                raise _UnreadableError(f"nested more than {DEEPEST} levels deep", place)
            continue
        elif isinstance(event, yaml.CollectionEndEvent):
            closed = open_nodes.pop()
            node = closed.close()
            if closed.anchor is not None:
                anchors[closed.anchor] = node
        elif isinstance(event, yaml.AliasEvent):
            node = _aliased(event.anchor, anchors, place)
            total += node.size - 1
        elif isinstance(event, yaml.DocumentStartEvent) and root is not None:
            raise _UnreadableError("a second document starts; one scene a file is expected", place)
        else:
            continue
        total += 1
        if total > MOST_VALUES:
            raise _UnreadableError(
                f"the file holds more than {MOST_VALUES} values, aliases counted as often as used",
                place,
            )
        if not open_nodes:
            root = node
            continue
        open_nodes[-1].add(node)
        if len(open_nodes) + node.height > DEEPEST:
            raise _UnreadableError(f"nested more than {DEEPEST} levels deep", place)
    if root is None or (root.value is None and not root.fault):
        raise _UnreadableError("the file is empty; a scene is expected")
    return root


def _aliased(anchor: str | None, anchors: dict[str, _Node | None], place: Location) -> _Node:
    if anchor is None or anchor not in anchors:
        raise _UnreadableError(
            f"not valid YAML: the alias *{anchor} has no anchor before it", place
        )
    node = anchors[anchor]
    if node is None:
        raise _UnreadableError(f"the alias *{anchor} stands inside what it names", place)
    return node


def _scalar(event: yaml.ScalarEvent, place: Location) -> _Node:
    """Text, number, boolean or None: as tagged, else by how a plain value is written."""
    text, tag = event.value, event.tag
    if tag == "!" or (tag is None and not event.implicit[0]):
        return _Node(place, text)
    if tag is not None:
        return _tagged(text, tag, place)
    if text in _NULLS:
        return _Node(place, None)
    if text in _BOOLEANS:
        return _Node(place, _BOOLEANS[text], "" if text.lower() in {"true", "false"} else text)
    first = text[0]
    if not (first.isdigit() or first in "+-."):
        return _Node(place, text)
    return _number(text, place) if _INT.match(text) or _FLOAT.match(text) else _Node(place, text)


def _number(text: str, place: Location) -> _Node:
    if len(text) > LONGEST_NUMBER:
        return _Node(place, fault=f"is a number of {len(text)} characters, which is too long")
    plain = text.replace("_", "")
    if _INT.match(text):
        return _Node(place, int(plain, 10 if _PLAIN_INT.match(text) else 0))
    # YAML writes .inf and .nan where Python writes inf and nan.
    return _Node(place, float(re.sub(r"\.(?=[in])", "", plain.lower())))


def _tagged(text: str, tag: str, place: Location) -> _Node:
    kind = tag.removeprefix(_TAG)
    if kind == "str":
        return _Node(place, text)
    if kind in {"int", "float"} and (_INT.match(text) or _FLOAT.match(text)):
        node = _number(text, place)
        if kind == "float" and isinstance(node.value, int):
            node.value = float(node.value)
        if kind == "float" or not isinstance(node.value, float):
            return node
    if kind == "bool" and text in _BOOLEANS:
        return _Node(place, _BOOLEANS[text])
    if kind == "null" and text in _NULLS:
        return _Node(place, None)
    if kind in {"int", "float", "bool", "null"}:
        return _Node(place, fault=f"{text!r} is no !!{kind}")
    return _Node(place, fault=f"the tag {tag!r} is not expected in a scene")


def _build(node: _Node, path: str, tree: Tree) -> Any:
    """The value of `node`, new containers for every alias; depth is bounded by `DEEPEST`."""
    tree.locations.setdefault(path, node.place)
    if node.fault:
        tree.faults.append((path, tree.locations[path], node.fault))
        return None
    if isinstance(node.value, tuple):
        return [_build(child, f"{path}[{k}]", tree) for k, child in enumerate(node.value)]
    if isinstance(node.value, list):
        return _mapping(node, path, tree)
    if node.written:
        tree.written[path] = node.written
    return node.value


def _mapping(node: _Node, path: str, tree: Tree) -> dict[str, Any]:
    result: dict[str, Any] = {}
    merged: list[_Node] = []
    for key_node, value_node in node.value:
        key = key_node.value
        if key == "<<":
            merged.append(value_node)
            continue
        inner = f"{path}.{key}" if path else str(key)
        if not isinstance(key, str):
            shown = key_node.written or ("a list or mapping" if _is_container(key) else repr(key))
            hint = "" if _is_container(key) else f"; in quotes it is: '{shown}'"
            text = f"has the key {shown}, which is no text{hint}"
            tree.faults.append((path, key_node.place, text))
        elif len(key) > LONGEST_KEY:
            text = f"has a key of {len(key)} characters; at most {LONGEST_KEY} are expected"
            tree.faults.append((path, key_node.place, text))
        elif key in result:
            line, column = tree.locations[inner]
            text = f"this key stands here twice, first in line {line}, column {column}"
            tree.faults.append((inner, key_node.place, text))
        else:
            tree.locations[inner] = key_node.place
            result[key] = _build(value_node, inner, tree)
    for value_node in merged:
        _merge(value_node, path, tree, result)
    return result


def _is_container(value: Any) -> bool:
    return isinstance(value, list | tuple)


def _merge(node: _Node, path: str, tree: Tree, result: dict[str, Any]) -> None:
    """The keys of ``<<: *base`` (or of a list of bases) that `result` does not have itself."""
    bases = node.value if isinstance(node.value, tuple) else (node,)
    for base in bases:
        if not isinstance(base.value, list):
            tree.faults.append((path, node.place, "'<<' merges mappings; another value is here"))
            continue
        # The keys already there are left out before building, so that their places stay.
        rest = [pair for pair in base.value if pair[0].value not in result]
        result |= _mapping(_Node(base.place, rest), path, tree)
