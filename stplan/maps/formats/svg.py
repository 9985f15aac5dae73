"""Vector drawings (``.svg``): what is light is floor and what is dark is not, as painted; or groups by name.

Without names the page is floor, dark fills and dark strokes (as wide as drawn) block it, and a light fill
opens what it is painted over. With `floor` or `layers` the colours do not count: shapes whose id, class or
label, or that of a group around them, is named are floor, or block. A unit of the drawing is a metre unless
`scale` says otherwise.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.maps.files import FileContent
from stplan.maps.formats.drawing import (
    Beside,
    Drawing,
    FileOptions,
    ForeignFormat,
    FormatError,
    repaired,
)
from stplan.maps.formats.svg_shapes import colour_of, length_of, outlines, transform_of
from stplan.maps.formats.xml_tree import Element, read_xml

# Elements in all, those that are used elsewhere counted as often as used.
MOST_DRAWN = 50_000
# How light a colour is at least to be floor, 0 to 1.
_LIGHT = 0.5
# Chords may be from curves so far, a share of the page.
_SAG = 1e-4
_SHAPES = ("path", "rect", "circle", "ellipse", "line", "polyline", "polygon")
_HIDDEN = ("defs", "symbol", "clipPath", "mask", "marker", "pattern", "metadata", "style", "title", "desc",
           "namedview", "linearGradient", "radialGradient", "filter", "script")  # fmt: skip
_INHERITED = ("fill", "stroke", "stroke-width", "fill-rule", "visibility", "opacity")


@dataclass(frozen=True)
class _Context:
    """What a shape has from the groups around it."""

    matrix: FloatArray
    style: Mapping[str, str]
    names: tuple[str, ...] = ()
    depth: int = 0


def read_svg(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """The drawing, y upwards from the lower edge of its page."""
    del beside
    root = read_xml(file.content)
    if root.tag != "svg":
        raise FormatError(f"is no SVG drawing: it begins with <{root.tag}>", root.line)
    x, y, width, height = _page(root)
    sag = _SAG * max(width, height)
    start = np.array([[1.0, 0.0, -x], [0.0, -1.0, y + height], [0.0, 0.0, 1.0]])
    painter = _Painter(options, sag)
    walker = _Walker(root)
    for element, context in walker.drawn(start):
        painter.paint(element, context)
    page = shapely.box(0, 0, width, height) if width and height else None
    left = [f"{count} <{tag}>" for tag, count in sorted(walker.left.items())]
    return painter.drawing(page, (f"{', '.join(left)} were left out",) if left else ())


def _page(root: Element) -> tuple[float, float, float, float]:
    box = re.split(r"[\s,]+", root.attributes.get("viewBox", "").strip())
    if len(box) == 4:
        x, y, width, height = (length_of(word, "viewBox", root.line) for word in box)
        return x, y, width, height
    sizes = [
        length_of(root.attributes.get(key, "0"), key, root.line) for key in ("width", "height")
    ]
    return 0.0, 0.0, sizes[0], sizes[1]


class _Walker:
    """Goes through everything that is drawn, in the order of painting."""

    def __init__(self, root: Element) -> None:
        self.root = root
        self.by_id = {
            one.attributes["id"]: one for one in _everything(root) if "id" in one.attributes
        }
        self.rules = _rules(root)
        self.left: dict[str, int] = {}
        self.count = 0

    def drawn(self, matrix: FloatArray) -> Iterator[tuple[Element, _Context]]:
        """Shapes with all that they inherit."""
        yield from self._visit(self.root, _Context(matrix, {}), self.root)

    def _visit(
        self, element: Element, context: _Context, top: Element
    ) -> Iterator[tuple[Element, _Context]]:
        self.count += 1
        if self.count > MOST_DRAWN:
            raise FormatError(
                f"draws more than {MOST_DRAWN} elements, those that are used counted as often as used",
                element.line,
            )
        if context.depth > 60:
            raise FormatError("uses elements inside one another without end", element.line)
        style = {**context.style, **self._own_style(element)}
        if style.get("display") == "none":
            return
        names = [element.attributes.get(key, "") for key in ("id", "label")]
        names += element.attributes.get("class", "").split()
        inner = _Context(
            context.matrix @ transform_of(element.attributes.get("transform", ""), element.line),
            {key: style[key] for key in _INHERITED if key in style},
            context.names + tuple(name.lower() for name in names if name),
            context.depth + 1,
        )
        if element.tag in _SHAPES:
            yield element, replace(inner, style=style)
        elif element.tag == "use":
            yield from self._used(element, inner, top)
        elif element.tag in ("g", "a", "svg", "switch", "symbol"):
            for child in element.children:
                if child.tag not in _HIDDEN:
                    yield from self._visit(child, inner, top)
        else:
            self.left[element.tag] = self.left.get(element.tag, 0) + 1

    def _used(
        self, element: Element, context: _Context, top: Element
    ) -> Iterator[tuple[Element, _Context]]:
        name = element.attributes.get("href", "").removeprefix("#")
        target = self.by_id.get(name)
        if target is None:
            raise FormatError(f"uses {name[:40]!r}, which is not there", element.line)
        shift = np.eye(3)
        shift[:2, 2] = [element.number("x", 0.0), element.number("y", 0.0)]
        yield from self._visit(target, replace(context, matrix=context.matrix @ shift), top)

    def _own_style(self, element: Element) -> dict[str, str]:
        style = {
            key: value
            for key, value in element.attributes.items()
            if key in (*_INHERITED, "display")
        }
        for selector in (element.tag, *("." + one for one in element.attributes.get("class", "").split()),
                         "#" + element.attributes.get("id", "")):  # fmt: skip
            style |= self.rules.get(selector, {})
        return style | _declarations(element.attributes.get("style", ""))


def _everything(root: Element) -> Iterator[Element]:
    stack = [root]
    while stack:
        element = stack.pop()
        yield element
        stack += element.children


def _rules(root: Element) -> dict[str, dict[str, str]]:
    """Simple selectors (a tag, a class, an id) of style sheets inside the drawing."""
    found: dict[str, dict[str, str]] = {}
    for sheet in root.all("style"):
        for selectors, body in re.findall(r"([^{}]+)\{([^{}]*)\}", sheet.text):
            for selector in selectors.split(","):
                found.setdefault(selector.strip(), {}).update(_declarations(body))
    return found


def _declarations(text: str) -> dict[str, str]:
    pairs = (part.partition(":") for part in text.split(";") if ":" in part)
    return {key.strip(): value.strip() for key, _, value in pairs}


class _Painter:
    """Sorts shapes into floors, blocked areas and walls."""

    def __init__(self, options: FileOptions, sag: float) -> None:
        self.floor = {name.lower() for name in options.floor}
        self.chosen = {name.lower() for name in options.layers}
        self.sag = sag
        self.floors: list[Any] = []
        self.blocked: list[Any] = []
        self.walls: list[FloatArray] = []
        # As painted: (whether it is floor, area), in turn.
        self.painted: list[tuple[bool, Any]] = []
        self.names: dict[str, None] = {}

    def paint(self, element: Element, context: _Context) -> None:
        """Add a shape."""
        style = context.style
        if style.get("visibility") == "hidden":
            return
        self.names.update(dict.fromkeys(context.names))
        lines, curved = outlines(element, context.matrix, self.sag)
        fill = _filled(lines, style.get("fill-rule") == "evenodd")
        if self.floor or self.chosen:
            self._by_name(context.names, lines, fill, style, curved=curved)
            return
        light = colour_of(style.get("fill", "black"))
        if light is not None and not fill.is_empty and element.tag != "line":
            is_floor = light >= _LIGHT
            grown = -self.sag if is_floor else self.sag
            self.painted.append((is_floor, shapely.buffer(fill, grown) if curved else fill))
        light = colour_of(style.get("stroke", "none"))
        if light is not None and light < _LIGHT:
            scale = float(np.sqrt(abs(np.linalg.det(context.matrix[:2, :2]))))
            width = length_of(style.get("stroke-width", "1"), "stroke-width", element.line) * scale
            reach = width / 2 + (self.sag if curved else 0.0)
            for line in lines:
                if len(line) > 1 and reach > 0:
                    self.painted.append(
                        (
                            False,
                            shapely.buffer(shapely.linestrings(line), reach, join_style="mitre"),
                        )
                    )

    def _by_name(
        self,
        names: tuple[str, ...],
        lines: list[FloatArray],
        fill: Any,
        style: Mapping[str, str],
        *,
        curved: bool,
    ) -> None:
        if self.floor.intersection(names):
            self.floors.append(shapely.buffer(fill, -self.sag) if curved else fill)
        elif not self.chosen or self.chosen.intersection(names):
            if colour_of(style.get("fill", "black")) is not None and not fill.is_empty:
                self.blocked.append(shapely.buffer(fill, self.sag) if curved else fill)
            elif curved:
                self.blocked += [
                    shapely.buffer(shapely.linestrings(line), self.sag)
                    for line in lines
                    if len(line) > 1
                ]
            else:
                self.walls += [line for line in lines if len(line) > 1]

    def drawing(self, page: Any, notes: tuple[str, ...]) -> Drawing:
        """What was painted on the page, None where it has no size."""
        if self.floor or self.chosen:
            floors, mended = repaired(self.floors, "floors")
            if self.floor and not floors:
                raise FormatError(f"has no shape named {', '.join(sorted(self.floor))}")
            blocked, more = repaired(self.blocked, "shapes", blocked=True)
            return Drawing(
                floors=floors, blocked=blocked, walls=tuple(self.walls), names=tuple(self.names),
                notes=notes, mended=mended + more,
            )  # fmt: skip
        if not self.painted:
            raise FormatError("draws nothing")
        area = page or shapely.box(
            *shapely.total_bounds(np.array([shape for _, shape in self.painted], dtype=object))
        )
        for is_floor, shapes in _in_turn(self.painted):
            area = (
                shapely.union(area, shapely.intersection(shapes, page or shapes))
                if is_floor
                else shapely.difference(area, shapes)
            )
        floors, mended = repaired(list(shapely.get_parts(area)), "floors")
        if not floors:
            raise FormatError(
                "leaves no floor: everything is painted dark (map.floor names what is floor)"
            )
        return Drawing(floors=floors, names=tuple(self.names), notes=notes, mended=mended)


def _in_turn(painted: list[tuple[bool, Any]]) -> Iterator[tuple[bool, Any]]:
    """Runs of the same kind, united."""
    run: list[Any] = []
    for k, (is_floor, shape) in enumerate(painted):
        run.append(shape)
        if k + 1 == len(painted) or painted[k + 1][0] != is_floor:
            yield is_floor, shapely.union_all(np.array(run, dtype=object))
            run = []


def _filled(lines: list[FloatArray], even_odd: bool) -> Any:
    """The area that outlines enclose: inner ones that turn the other way, or all with even-odd, are holes."""
    rings = [shapely.Polygon(line) for line in lines if len(line) > 2]
    if not rings:
        return shapely.Polygon()
    area = shapely.make_valid(rings[0], method="structure", keep_collapsed=False)
    first = shapely.LinearRing(rings[0].exterior).is_ccw
    for ring in rings[1:]:
        shape = shapely.make_valid(ring, method="structure", keep_collapsed=False)
        if even_odd:
            area = shapely.symmetric_difference(area, shape)
        elif shapely.LinearRing(ring.exterior).is_ccw == first:
            area = shapely.union(area, shape)
        else:
            area = shapely.difference(area, shape)
    return area


SVG = ForeignFormat("SVG drawing", (".svg",), read_svg, frozenset({"layers", "floor"}))
