"""Untrusted YAML text -> a plain tree and the place of everything in it.

The meaning is that of `yaml.safe_load`, with these differences, all towards fewer surprises:

- refused: duplicate keys, keys that are no text, tags that are no plain data, a second document,
  aliases that contain themselves or repeat more values than `MOST_VALUES`, nesting past `DEEPEST`;
- ``1e-3`` is a number (YAML 1.1 wants ``1.0e-3``);
- ``010`` and ``1:30`` are text (YAML 1.1 reads 8 and 90), and so are dates.

Places are worked out when somebody asks: only messages do, and a map may have a million values.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any, NamedTuple

from stplan.errors import SceneError
from stplan.schema.yaml_nodes import (
    Collection,
    Location,
    Scalar,
    UnreadableError,
    read_nodes,
)

# Characters of the longest key; a path repeats the keys above it for every value below them.
LONGEST_KEY = 100


class Tree:
    """A parsed file.

    Attributes:
        value: dicts, lists, text, numbers, booleans and None.
    """

    def __init__(self, root: Any = None, place: Location = (1, 1)) -> None:
        self._root, self._place = root, place
        self._faulty = False
        self.value = self._built(root)

    @property
    def locations(self) -> Mapping[str, Location]:
        """(line, column), from 1, of every path; of a key's path, where its key stands."""
        return _Places(self)

    @property
    def written(self) -> dict[str, str]:
        """How booleans are written where that is neither ``true`` nor ``false``, by path."""
        return self.survey.written

    @property
    def faults(self) -> list[tuple[str, Location, str]]:
        """(path, place, sentence) of everything a reader can step over."""
        return self.survey.faults if self._faulty else []

    @cached_property
    def survey(self) -> _Survey:
        """Everything that is known by path."""
        survey = _Survey({}, {}, [])
        survey.visit(self._root, self._place, "")
        return survey

    def _built(self, node: Any) -> Any:
        """The value of `node`, new containers for every alias; depth is bounded by `DEEPEST`."""
        kind = type(node)
        if kind is Scalar:
            self._faulty |= bool(node.fault)
            return None if node.fault else node.value
        if kind is not Collection:
            return node
        if node.fault:
            self._faulty = True
            return None
        if not node.is_mapping:
            return [
                self._built(child) if type(child) in _NODES else child for child in node.children
            ]
        entries, faults = _entries(node)
        self._faulty |= bool(faults)
        return {key: self._built(child) for key, (_, child) in entries.items()}


_NODES = (Collection, Scalar)


class _Places(Mapping[str, Location]):
    """The places of a tree, looked up when asked for."""

    def __init__(self, tree: Tree) -> None:
        self._tree = tree

    def __getitem__(self, path: str) -> Location:
        return self._tree.survey.locations[path]

    def __iter__(self) -> Iterator[str]:
        return iter(self._tree.survey.locations)

    def __len__(self) -> int:
        return len(self._tree.survey.locations)


def read_tree(text: str, name: str, *, located: bool = True) -> Tree:
    """Parse YAML `text`; `name` heads every message, followed by the place if `located`.

    Raises:
        SceneError: the text is no YAML this reader accepts.
    """
    try:
        return Tree(*read_nodes(text))
    except UnreadableError as refusal:
        place = f":{refusal.place[0]}:{refusal.place[1]}" if located else ""
        raise SceneError(f"{name}{place}: {refusal.text}") from refusal


class _Survey(NamedTuple):
    """Places, spellings and faults by path, as `Tree` gives them."""

    locations: dict[str, Location]
    written: dict[str, str]
    faults: list[tuple[str, Location, str]]

    def visit(self, node: Any, place: Location, path: str) -> None:
        """Note what there is to know of `node` and of all below it."""
        self.locations.setdefault(path, place)
        if isinstance(node, _NODES) and node.fault:
            self.faults.append((path, self.locations[path], node.fault))
        elif isinstance(node, Scalar):
            self.written[path] = node.written
        elif isinstance(node, Collection) and not node.is_mapping:
            for k, (child, there) in enumerate(zip(node.children, node.places, strict=True)):
                self.visit(child, there, f"{path}[{k}]")
        elif isinstance(node, Collection):
            entries, faults = _entries(node)
            for key, (there, child) in entries.items():
                self.visit(child, there, _joined(path, key))
            for name, there, text in faults:
                self.faults.append((path if name is None else _joined(path, name), there, text))


def _joined(path: str, key: str) -> str:
    return f"{path}.{key}" if path else key


_Entries = dict[str, tuple[Location, Any]]
_Faults = list[tuple[str | None, Location, str]]


def _entries(node: Collection, taken: Mapping[str, Any] | None = None) -> tuple[_Entries, _Faults]:
    """Key -> (place of the key, value) of a mapping, and (key or None, place, sentence) of its faults.

    Keys that are `taken` already are passed over.
    """
    entries: _Entries = {}
    faults: _Faults = []
    merged: list[tuple[Any, Location]] = []
    for k in range(0, len(node.children), 2):
        key, child = node.children[k], node.children[k + 1]
        place = node.places[k]
        if key == "<<":
            merged.append((child, node.places[k + 1]))
        elif not isinstance(key, str):
            faults.append((None, place, _no_text(key)))
        elif taken is not None and key in taken:
            continue
        elif len(key) > LONGEST_KEY:
            text = f"has a key of {len(key)} characters; at most {LONGEST_KEY} are expected"
            faults.append((None, place, text))
        elif key in entries:
            line, column = entries[key][0]
            text = f"this key stands here twice, first in line {line}, column {column}"
            faults.append((key, place, text))
        else:
            entries[key] = place, child
    for child, place in merged:
        _merge(child, place, entries, faults)
    return entries, faults


def _no_text(key: Any) -> str:
    """What is wrong with a key that is no text."""
    if isinstance(key, Collection):
        return "has the key a list or mapping, which is no text"
    if isinstance(key, Scalar) and key.fault:
        return f"has a key that is no text: {key.fault}"
    shown = key.written if isinstance(key, Scalar) else repr(key)
    return f"has the key {shown}, which is no text; in quotes it is: '{shown}'"


def _merge(node: Any, place: Location, entries: _Entries, faults: _Faults) -> None:
    """Add the keys of ``<<: *base`` (or of a list of bases) that `entries` does not have itself."""
    many = isinstance(node, Collection) and not node.is_mapping
    bases = zip(node.children, node.places, strict=True) if many else [(node, place)]
    for base, _ in bases:
        if not isinstance(base, Collection) or not base.is_mapping:
            faults.append((None, place, "'<<' merges mappings; another value is here"))
            continue
        more, wrong = _entries(base, entries)
        entries.update(more)
        faults.extend(wrong)
