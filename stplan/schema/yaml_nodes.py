"""Untrusted YAML text -> nodes with their places.

The text is read event by event: bounds are met before memory is spent on what breaks them, and
without recursion over the text, which the compiled composer does not survive on deep nesting. Plain
scalars are kept as the values they are, in lists beside their places: maps hold many thousand numbers.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import yaml

LARGEST_FILE = 16 * 1024 * 1024
MOST_VALUES = 1_000_000
DEEPEST = 40
# Digits of the longest number; more cannot change a float, and conversion is quadratic in them.
LONGEST_NUMBER = 400

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
# How nearly all numbers are written; any other way is looked at afterwards.
_DECIMAL = re.compile(r"[-+]?[0-9]{1,20}\.[0-9]{1,20}\Z")
_BOOLEANS = {
    word: value
    for value, words in ((True, ("true", "yes", "on")), (False, ("false", "no", "off")))
    for lower in words
    for word in (lower, lower.capitalize(), lower.upper())
}
_NULLS = {"", "~", "null", "Null", "NULL"}


class Scalar:
    """A scalar that is more than its value: `written` in a way of its own, or at fault."""

    __slots__ = ("fault", "value", "written")

    def __init__(self, value: Any = None, written: str = "", fault: str = "") -> None:
        self.value, self.written, self.fault = value, written, fault


class Collection:
    """A list, or a mapping whose `children` alternate between keys and values.

    Attributes:
        place: where it begins.
        children: collections, scalars, and plain values.
        places: where each of them stands; of an alias, where what it names stands.
        size, height: of all below it, aliases counted as often as used.
        fault: what is wrong with its tag.
    """

    __slots__ = ("children", "fault", "height", "is_mapping", "place", "places", "size")

    def __init__(self, place: Location, is_mapping: bool, tag: str | None) -> None:
        self.place, self.is_mapping = place, is_mapping
        self.children: list[Any] = []
        self.places: list[Location] = []
        self.size = self.height = 1
        plain = (None, "!", f"{_TAG}map" if is_mapping else f"{_TAG}seq")
        self.fault = "" if tag in plain else f"the tag {tag!r} is not expected in a scene"


class UnreadableError(Exception):
    """The text cannot be read any further."""

    def __init__(self, text: str, place: Location = (1, 1)) -> None:
        super().__init__(text)
        self.text, self.place = text, place


def read_nodes(text: str) -> tuple[Any, Location]:
    """The only document of `text`, and where it begins.

    Raises:
        UnreadableError: the text is no YAML this reader accepts.
    """
    if len(text) > LARGEST_FILE:
        raise UnreadableError(f"the file is larger than {LARGEST_FILE // 2**20} MiB")
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


def _unreadable(error: Exception, text: str) -> UnreadableError:
    """The parser's complaint as ours, with the place it names."""
    if isinstance(error, yaml.MarkedYAMLError):
        mark = error.problem_mark or error.context_mark
        place = (1, 1) if mark is None else (mark.line + 1, mark.column + 1)
        if "maximum nesting depth" in (error.problem or ""):
            # Newer scanners look far ahead and meet a bound of their own before ours.
            return UnreadableError(f"nested more than {DEEPEST} levels deep", place)
        return UnreadableError(f"not valid YAML: {error.problem or error.context}", place)
    if isinstance(error, yaml.reader.ReaderError | UnicodeEncodeError):
        # Not every parser counts characters here, so the culprit is looked for.
        for number, line in enumerate(text.split("\n"), 1):
            for column, character in enumerate(line, 1):
                if yaml.reader.Reader.NON_PRINTABLE.match(character):
                    shown = f"the character U+{ord(character):04X} is not allowed in YAML"
                    return UnreadableError(f"not valid YAML: {shown}", (number, column))
    reason = str(error).partition("\n")[0] or type(error).__name__
    return UnreadableError(f"not valid YAML: {reason}")


class _Reader:
    """What is open, what has anchors, and how many values there have been."""

    def __init__(self) -> None:
        self.open: list[tuple[Collection, str | None]] = []
        self.anchors: dict[str, tuple[Any, Location] | None] = {}
        self.root: tuple[Any, Location] | None = None
        self.total = 0
        # Plain scalars by how they are written: coordinates repeat.
        self.known: dict[str, Any] = {}

    def scalar(self, event: yaml.ScalarEvent, place: Location) -> None:
        """The next value is a scalar."""
        text = event.value
        if event.implicit[0] and event.tag is None:
            if text in self.known:
                value = self.known[text]
            else:
                value = self.known[text] = _plain(text)
        else:
            value = text if event.tag in (None, "!") else _tagged(text, event.tag)
        if event.anchor is not None:
            self.anchors[event.anchor] = value, place
        self.add(value, place, 1, 1)

    def begin(self, event: yaml.CollectionStartEvent, place: Location, is_mapping: bool) -> None:
        """A collection begins."""
        if event.anchor is not None:
            self.anchors[event.anchor] = None
        self.open.append((Collection(place, is_mapping, event.tag), event.anchor))
        if len(self.open) > DEEPEST:
            raise UnreadableError(f"nested more than {DEEPEST} levels deep", place)

    def end(self, place: Location) -> None:
        """The innermost collection ends, at `place`."""
        node, anchor = self.open.pop()
        if anchor is not None:
            self.anchors[anchor] = node, node.place
        self.add(node, node.place, node.size, node.height, place)

    def alias(self, anchor: str | None, place: Location) -> None:
        """The next value stands elsewhere already."""
        if anchor is None or anchor not in self.anchors:
            text = f"not valid YAML: the alias *{anchor} has no anchor before it"
            raise UnreadableError(text, place)
        named = self.anchors[anchor]
        if named is None:
            raise UnreadableError(f"the alias *{anchor} stands inside what it names", place)
        node, there = named
        many = isinstance(node, Collection)
        size, height = (node.size, node.height) if many else (1, 1)
        self.total += size - 1
        self.add(node, there, size, height, place)

    def add(
        self, value: Any, place: Location, size: int, height: int, met: Location | None = None
    ) -> None:
        """A value is complete: it belongs to the innermost open collection. It was `met` there."""
        self.total += 1
        if self.total > MOST_VALUES:
            raise UnreadableError(
                f"the file holds more than {MOST_VALUES} values, aliases counted as often as used",
                met or place,
            )
        if not self.open:
            self.root = value, place
            return
        parent = self.open[-1][0]
        parent.children.append(value)
        parent.places.append(place)
        parent.size += size
        if height >= parent.height:
            parent.height = height + 1
            if len(self.open) + height > DEEPEST:
                raise UnreadableError(f"nested more than {DEEPEST} levels deep", met or place)


def _document(events: Iterator[yaml.Event]) -> tuple[Any, Location]:
    """The first document; everything that could explode is refused on the way."""
    reader = _Reader()
    for event in events:
        mark = event.start_mark
        place = (1, 1) if mark is None else (mark.line + 1, mark.column + 1)
        if isinstance(event, yaml.ScalarEvent):
            reader.scalar(event, place)
        elif isinstance(event, yaml.CollectionStartEvent):
            reader.begin(event, place, isinstance(event, yaml.MappingStartEvent))
        elif isinstance(event, yaml.CollectionEndEvent):
            reader.end(place)
        elif isinstance(event, yaml.AliasEvent):
            reader.alias(event.anchor, place)
        elif isinstance(event, yaml.DocumentStartEvent) and reader.root is not None:
            raise UnreadableError("a second document starts; one scene a file is expected", place)
    if reader.root is None or reader.root[0] is None:
        raise UnreadableError("the file is empty; a scene is expected")
    return reader.root


def _plain(text: str) -> Any:
    """Text, number, boolean or None, by how it is written."""
    if _DECIMAL.match(text):
        return float(text)
    if text in _NULLS:
        return None
    if text in _BOOLEANS:
        plain = text.lower() in {"true", "false"}
        return _BOOLEANS[text] if plain else Scalar(_BOOLEANS[text], text)
    if not (text[0].isdigit() or text[0] in "+-."):
        return text
    return _number(text) if _INT.match(text) or _FLOAT.match(text) else text


def _number(text: str) -> Any:
    if len(text) > LONGEST_NUMBER:
        return Scalar(fault=f"is a number of {len(text)} characters, which is too long")
    plain = text.replace("_", "")
    if _INT.match(text):
        return int(plain, 10 if _PLAIN_INT.match(text) else 0)
    # YAML writes .inf and .nan where Python writes inf and nan.
    return float(plain.replace(".", "") if plain[-1] in "fFnN" else plain)


def _tagged(text: str, tag: str) -> Any:
    kind = tag.removeprefix(_TAG)
    if kind == "str":
        return text
    if kind in {"int", "float"} and (_INT.match(text) or _FLOAT.match(text)):
        number = _number(text)
        if kind == "float" and isinstance(number, int):
            number = float(number)
        if kind == "float" or not isinstance(number, float):
            return number
    if kind == "bool" and text in _BOOLEANS:
        return _BOOLEANS[text]
    if kind == "null" and text in _NULLS:
        return None
    if kind in {"int", "float", "bool", "null"}:
        return Scalar(fault=f"{text!r} is no !!{kind}")
    return Scalar(fault=f"the tag {tag!r} is not expected in a scene")
