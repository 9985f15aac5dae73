"""XML of unknown origin -> a tree with lines; what could explode is refused while it is read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

from stplan.maps.formats.drawing import FormatError, finite

LARGEST_TEXT = 32 * 1024 * 1024
MOST_ELEMENTS = 500_000
DEEPEST = 200


@dataclass
class Element:
    """An element: its name without a namespace, attributes, children, and the line where it begins."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def all(self, tag: str) -> Iterator[Element]:
        """Every element of this name below, in the order of the file."""
        for child in self.children:
            if child.tag == tag:
                yield child
            yield from child.all(tag)

    def first(self, tag: str) -> Element | None:
        """The first of this name below."""
        return next(self.all(tag), None)

    def number(self, name: str, default: float | None = None) -> float:
        """A numeric attribute; raises FormatError where it is missing or no finite number."""
        value = self.attributes.get(name)
        if value is None:
            if default is None:
                raise FormatError(f"<{self.tag}> lacks {name}", self.line)
            return default
        return finite(value, f"{name} of <{self.tag}>", self.line)


def read_xml(content: bytes) -> Element:
    """The root of a text.

    Raises:
        FormatError: it is no XML, declares entities made of others or of files, or is larger than is read.
    """
    if len(content) > LARGEST_TEXT:
        raise FormatError(f"is larger than {LARGEST_TEXT // 2**20} MiB")
    parser = expat.ParserCreate()
    parser.buffer_text = True
    references = content.count(b"&")
    open_elements: list[Element] = []
    roots: list[Element] = []
    total = 0

    def begin(tag: str, attributes: dict[str, str]) -> None:
        nonlocal total
        total += 1
        line = parser.CurrentLineNumber
        if total > MOST_ELEMENTS:
            raise FormatError(f"has more than {MOST_ELEMENTS} elements", line)
        if len(open_elements) >= DEEPEST:
            raise FormatError(f"is nested more than {DEEPEST} levels deep", line)
        plain = {name.rpartition(":")[2]: value for name, value in attributes.items()}
        element = Element(tag.rpartition(":")[2], plain, line)
        (open_elements[-1].children if open_elements else roots).append(element)
        open_elements.append(element)

    def end(tag: str) -> None:
        del tag
        open_elements.pop()

    def characters(text: str) -> None:
        if open_elements:
            open_elements[-1].text += text

    def declares(name: str, parameter: bool, value: str | None, *origin: object) -> None:
        del name, origin
        # Some drawing programs abbreviate namespaces so; what grows or comes from elsewhere is refused.
        harmless = value is not None and not parameter and not set("&%<") & set(value)
        if not harmless or len(value or "") * references > LARGEST_TEXT:
            raise FormatError("declares entities, which are not read", parser.CurrentLineNumber)

    parser.StartElementHandler = begin
    parser.EndElementHandler = end
    parser.CharacterDataHandler = characters
    parser.EntityDeclHandler = declares
    try:
        parser.Parse(content, True)
    except expat.ExpatError as error:
        reason = expat.errors.messages.get(error.code, "no reason given")
        raise FormatError(f"is no valid XML: {reason}", error.lineno) from error
    except (ValueError, LookupError) as error:
        raise FormatError("is in an encoding that cannot be read", 1) from error
    return roots[0]
