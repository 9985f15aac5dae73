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
from itertools import pairwise
from typing import Any

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.maps.files import FileContent
from stplan.maps.formats.crossings import lines_tangle
from stplan.maps.formats.drawing import (
    Beside,
    Drawing,
    FileOptions,
    ForeignFormat,
    FormatError,
    check_crossings,
    repaired,
)
from stplan.maps.formats.svg_shapes import (
    LIGHT,
    Viewport,
    colour_of,
    length_of,
    opacity_of,
    outlines,
    transform_of,
    window_of,
)
from stplan.maps.formats.xml_tree import Element, read_xml

# Elements in all, those that are used elsewhere counted as often as used.
MOST_DRAWN = 50_000
# Corners in all, and how often light is painted over dark and dark over light.
MOST_PAINTED, MOST_TURNS = 400_000, 2000
_FURTHEST = 1e15
# Outlines of one path, where those that turn the same way overlap.
MOST_OVERLAPPING = 300
# What overlaps by less, a share of all, does not.
_OVERLAP = 1e-9
# Chords may be from curves so far, a share of the page.
_SAG = 1e-4
_SHAPES = ("path", "rect", "circle", "ellipse", "line", "polyline", "polygon")
_HIDDEN = ("defs", "symbol", "clipPath", "mask", "marker", "pattern", "metadata", "style", "title", "desc",
           "namedview", "linearGradient", "radialGradient", "filter", "script")  # fmt: skip
_INHERITED = ("fill", "stroke", "stroke-width", "stroke-linecap", "fill-rule", "fill-opacity",
              "stroke-opacity", "visibility")  # fmt: skip
_OWN = ("display", "opacity")
# Of these, what is drawn is only a part.
_CUT = ("clip-path", "mask")
# Ends of strokes, as shapely names them.
_CAPS = {"round": "round", "square": "square"}


@dataclass(frozen=True)
class _Context:
    """What a shape has from the groups around it."""

    matrix: FloatArray
    style: Mapping[str, str]
    viewport: Viewport
    names: tuple[str, ...] = ()
    depth: int = 0
    opacity: float = 1.0


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
    for element, context in walker.drawn(start, (width, height)):
        painter.paint(element, context)
    page = shapely.box(0, 0, width, height) if width and height else None
    left = [f"{count} {what}" for what, count in sorted(walker.left.items())]
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
        # What was left out, and how often.
        self.left: dict[str, int] = {}
        for selector in self.rules:
            if not re.fullmatch(r"\*|[.#]?[\w-]+|@.*", selector, re.DOTALL):
                self._leave("selectors of more than one word in style sheets")
        self.count = 0

    def drawn(self, matrix: FloatArray, viewport: Viewport) -> Iterator[tuple[Element, _Context]]:
        """Shapes with all that they inherit."""
        yield from self._visit(self.root, _Context(matrix, {}, viewport), self.root)

    def _leave(self, what: str) -> None:
        self.left[what] = self.left.get(what, 0) + 1

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
        matrix = transform_of(element.attributes.get("transform", ""), element.line)
        viewport = context.viewport
        if element.tag in ("svg", "symbol") and element is not self.root:
            window, viewport = window_of(element, viewport)
            with np.errstate(all="ignore"):
                matrix = matrix @ window
        for key in _CUT:
            if style.get(key, "none") != "none":
                self._leave(f"{key} (what they cut off counts as drawn)")
        with np.errstate(all="ignore"):
            matrix = context.matrix @ matrix
        if not (np.abs(matrix) <= _FURTHEST).all():
            raise FormatError("has a transform that is absurdly large", element.line)
        inner = _Context(
            matrix,
            {key: style[key] for key in _INHERITED if key in style},
            viewport,
            context.names + tuple(name.lower() for name in names if name),
            context.depth + 1,
            context.opacity * opacity_of(style.get("opacity", "1")),
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
            self._leave(f"<{element.tag}>")

    def _used(
        self, element: Element, context: _Context, top: Element
    ) -> Iterator[tuple[Element, _Context]]:
        name = element.attributes.get("href", "").removeprefix("#")
        target = self.by_id.get(name)
        if target is None:
            raise FormatError(f"uses {name[:40]!r}, which is not there", element.line)
        shift = np.eye(3)
        shift[:2, 2] = [
            length_of(element.attributes.get(key, "0"), key, element.line, context.viewport)
            for key in ("x", "y")
        ]
        if target.tag in ("svg", "symbol"):
            sizes: dict[str, str] = {
                key: element.attributes[key]
                for key in ("width", "height")
                if key in element.attributes
            }
            target = replace(target, attributes={**target.attributes, **sizes})
        yield from self._visit(target, replace(context, matrix=context.matrix @ shift), top)

    def _own_style(self, element: Element) -> dict[str, str]:
        style = {
            key: value
            for key, value in element.attributes.items()
            if key in (*_INHERITED, *_OWN, *_CUT)
        }
        classes = ("." + one for one in element.attributes.get("class", "").split())
        for selector in ("*", element.tag, *classes, "#" + element.attributes.get("id", "")):  # fmt: skip
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
        for selectors, body in re.findall(r"([^{}]+)\{([^{}]*)\}", _without_comments(sheet.text)):
            for selector in selectors.split(","):
                found.setdefault(selector.strip(), {}).update(_declarations(body))
    return found


def _without_comments(text: str) -> str:
    head, *rest = text.split("/*")
    return head + "".join(part.partition("*/")[2] for part in rest)


def _declarations(text: str) -> dict[str, str]:
    pairs = (part.partition(":") for part in text.split(";") if ":" in part)
    return {key.strip(): value.replace("!important", "").strip() for key, _, value in pairs}


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
        self.corners = 0

    def paint(self, element: Element, context: _Context) -> None:
        """Add a shape."""
        style = context.style
        if style.get("visibility") == "hidden":
            return
        self.names.update(dict.fromkeys(context.names))
        lines, curved = outlines(element, context.matrix, self.sag, context.viewport)
        self.corners += sum(map(len, lines))
        if self.corners > MOST_PAINTED:
            raise FormatError(f"draws more than {MOST_PAINTED} corners", element.line)
        if lines_tangle(lines):
            raise FormatError("has a line that crosses itself far too often", element.line)
        fill = _filled(lines, style.get("fill-rule") == "evenodd")
        if self.floor or self.chosen:
            self._by_name(context.names, lines, fill, style, curved=curved)
            return
        light = self._light(context, "fill", "black")
        if light is not None and not fill.is_empty and element.tag != "line":
            is_floor = light >= LIGHT
            grown = -self.sag if is_floor else self.sag
            self.painted.append((is_floor, shapely.buffer(fill, grown) if curved else fill))
        light = self._light(context, "stroke", "none")
        if light is not None and light < LIGHT:
            scale = float(np.sqrt(abs(np.linalg.det(context.matrix[:2, :2]))))
            wide = length_of(
                style.get("stroke-width", "1"), "stroke-width", element.line, context.viewport
            )
            reach = wide * scale / 2 + (self.sag if curved else 0.0)
            caps = _CAPS.get(style.get("stroke-linecap", "butt"), "flat")
            self.painted += [
                (False, _stroke(line, reach, caps)) for line in lines if len(line) > 1 and reach > 0
            ]

    def _light(self, context: _Context, what: str, default: str) -> float | None:
        """How light the fill or stroke of a shape is, None where it has none."""
        opacity = opacity_of(context.style.get(f"{what}-opacity", "1")) * context.opacity
        return colour_of(context.style.get(what, default), opacity)

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
        check_crossings([shape for _, shape in self.painted])
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
    turns = sum(one[0] != other[0] for one, other in pairwise(painted))
    if turns > MOST_TURNS:
        raise FormatError(f"paints light and dark over each other more than {MOST_TURNS} times")
    run: list[Any] = []
    for k, (is_floor, shape) in enumerate(painted):
        run.append(shape)
        if k + 1 == len(painted) or painted[k + 1][0] != is_floor:
            yield is_floor, shapely.union_all(np.array(run, dtype=object))
            run = []


def _stroke(line: FloatArray, reach: float, caps: str) -> Any:
    """The area of a line; one that closes has no ends."""
    if len(line) > 3 and (line[0] == line[-1]).all():
        return shapely.buffer(shapely.linearrings(line), reach, join_style="mitre")
    return shapely.buffer(shapely.linestrings(line), reach, cap_style=caps, join_style="mitre")


def _filled(lines: list[FloatArray], even_odd: bool) -> Any:
    """The area that outlines enclose: what they wind around, of both ways not as often; or an odd number."""
    rings = [shapely.Polygon(line) for line in lines if len(line) > 2]
    turns = [1 if shapely.LinearRing(ring.exterior).is_ccw else -1 for ring in rings]
    shapes = shapely.make_valid(
        np.array(rings, dtype=object), method="structure", keep_collapsed=False
    )
    by_turn = [[one for one, turn in zip(shapes, turns, strict=True) if turn == k] for k in (1, -1)]
    whole = [shapely.union_all(np.array(some, dtype=object)) for some in by_turn]
    total = float(shapely.area(shapes).sum())
    if abs(total - sum(one.area for one in whole)) <= _OVERLAP * total:
        return shapely.symmetric_difference(*whole)
    if len(shapes) > MOST_OVERLAPPING:
        raise FormatError(f"has a path of more than {MOST_OVERLAPPING} outlines that overlap")
    # By how often their places are wound around.
    areas: dict[int, Any] = {}
    for shape, turn in zip(shapes, turns, strict=True):
        parts = [(turn, shapely.difference(shape, shapely.union_all([*areas.values()])))]
        for count, area in areas.items():
            parts.append((count, shapely.difference(area, shape)))
            parts.append((count + turn, shapely.intersection(area, shape)))
        areas = {}
        for count, area in parts:
            if count and not area.is_empty:
                areas[count] = shapely.union(areas.get(count, shapely.Polygon()), area)
    found = [area for count, area in areas.items() if not even_odd or count % 2]
    return shapely.union_all(np.array(found, dtype=object))


SVG = ForeignFormat("SVG drawing", (".svg",), read_svg, frozenset({"layers", "floor"}))
