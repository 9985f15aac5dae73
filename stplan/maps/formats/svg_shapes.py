"""Shapes, transforms, lengths and colours of SVG, within bounds."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np

from stplan.arrays import FloatArray
from stplan.maps.formats.curves import bezier
from stplan.maps.formats.drawing import FormatError, finite
from stplan.maps.formats.xml_tree import Element

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_TOKEN = re.compile(rf"([MmLlHhVvCcSsQqTtAaZz])|({_NUMBER})")
_FLAG = re.compile(r"[\s,]*()([01])")
_COUNTS = {"m": 2, "l": 2, "h": 1, "v": 1, "c": 6, "s": 4, "q": 4, "t": 2, "a": 7, "z": 0}
_TRANSFORM = re.compile(r"(\w+)\s*\(([^)]*)\)")
# Colours by name that drawings use most; others count as dark.
_NAMES = {
    "white": 1.0, "snow": 0.98, "ivory": 0.99, "whitesmoke": 0.96, "lightgray": 0.83, "lightgrey": 0.83,
    "silver": 0.75, "gainsboro": 0.86, "yellow": 0.89, "lightyellow": 0.99, "beige": 0.95,
    "linen": 0.95, "cornsilk": 0.97, "lightblue": 0.81, "lightgreen": 0.8, "pink": 0.82, "cyan": 0.7,
}  # fmt: skip
_ACROSS = ("x", "width", "cx", "rx", "x1", "x2")
_UPWARDS = ("y", "height", "cy", "ry", "y1", "y2")
_LENGTHS = (*_ACROSS, *_UPWARDS, "r")
# Names of units -> units of the drawing; a pixel of style sheets is one, an inch has 96.
_UNITS = {"": 1.0, "px": 1.0, "pt": 96 / 72, "pc": 16.0, "in": 96.0, "cm": 96 / 2.54, "mm": 96 / 25.4,
          "q": 96 / 101.6, "em": 16.0, "rem": 16.0, "ex": 8.0}  # fmt: skip
# How light a colour is at least to be floor, and how opaque.
LIGHT = 0.5
_OPAQUE = 0.5
_SIDES = 64
_MOST_TRANSFORMS, _LARGEST_SCALE = 1000, 1e9
# Corners of one path, curves and all.
MOST_PATH = 200_000
# Width and height of the page that percentages refer to.
Viewport = tuple[float, float]


def length_of(text: str, what: str, line: int, viewport: Viewport = (0.0, 0.0)) -> float:
    """A length in units of the drawing; those in percent are parts of the viewport."""
    match = re.match(rf"\s*({_NUMBER})\s*(%|[a-zA-Z]*)", text)
    if match is None:
        raise FormatError(f"{what} is {text[:40]!r}; a number is expected", line)
    number = finite(match[1], what, line)
    if match[2] == "%":
        across, upwards = viewport
        diagonal = math.hypot(across, upwards) / math.sqrt(2)
        whole = across if what in _ACROSS else upwards if what in _UPWARDS else diagonal
        return number / 100 * whole
    unit = _UNITS.get(match[2].lower())
    if unit is None:
        raise FormatError(f"{what} is {text[:40]!r}, of no known unit", line)
    return number * unit


def opacity_of(text: str) -> float:
    """0 to 1, a number or a percentage; what cannot be read is opaque."""
    match = re.match(rf"\s*({_NUMBER})\s*(%?)", text)
    if match is None:
        return 1.0
    return min(1.0, max(0.0, float(match[1]) / (100 if match[2] else 1)))


def colour_of(text: str, opacity: float = 1.0) -> float | None:
    """How light a paint is, 0 to 1; None is no paint at all. What is not known is dark.

    What is light and rather transparent is no paint either: something dark may be behind it.
    """
    light, opaque = _colour(text.strip().lower())
    opacity *= opaque
    if light is None or opacity == 0 or (light >= LIGHT and opacity < _OPAQUE):
        return None
    return light


def _colour(text: str) -> tuple[float | None, float]:
    """How light and how opaque a colour is."""
    if text in ("none", "transparent", ""):
        return None, 0.0
    if re.fullmatch(r"#([0-9a-f]{3,4}|[0-9a-f]{6}|[0-9a-f]{8})", text):
        digits = text[1:] if len(text) > 5 else "".join(digit * 2 for digit in text[1:])
        channels = [int(digits[k : k + 2], 16) / 255 for k in range(0, len(digits), 2)]
        return _lightness(*channels[:3]), (channels[3] if len(channels) == 4 else 1.0)
    match = re.match(
        r"rgba?\(\s*([\d.]+)(%?)[\s,]+([\d.]+)%?[\s,]+([\d.]+)%?(?:[\s,/]+([\d.]+%?))?\s*\)", text
    )
    if match and all(match[k].count(".") < 2 for k in (1, 3, 4)):
        whole = 100.0 if match[2] else 255.0
        red, green, blue = (float(match[k]) / whole for k in (1, 3, 4))
        return _lightness(red, green, blue), opacity_of(match[5] or "1")
    return _NAMES.get(text, 0.0), 1.0


def _lightness(red: float, green: float, blue: float) -> float:
    return 0.299 * red + 0.587 * green + 0.114 * blue


def transform_of(text: str, line: int) -> FloatArray:
    """(3, 3) matrix of a list of transforms."""
    matrix = np.eye(3)
    found = _TRANSFORM.findall(text)
    if len(found) > _MOST_TRANSFORMS:
        raise FormatError(f"has more than {_MOST_TRANSFORMS} transforms of one shape", line)
    for name, arguments in found:
        numbers = [finite(word, name, line) for word in re.findall(_NUMBER, arguments)]
        matrix = matrix @ _one_transform(name, numbers, line)
    return matrix


def _one_transform(name: str, numbers: list[float], line: int) -> FloatArray:
    matrix = np.eye(3)
    if name == "matrix" and len(numbers) == 6:
        matrix[:2] = np.array(numbers).reshape(3, 2).T
    elif name == "translate" and numbers:
        matrix[:2, 2] = [numbers[0], numbers[1] if len(numbers) > 1 else 0.0]
    elif name == "scale" and numbers:
        matrix[0, 0], matrix[1, 1] = numbers[0], numbers[1] if len(numbers) > 1 else numbers[0]
    elif name == "rotate" and numbers:
        angle = math.radians(numbers[0])
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        centre = np.array(numbers[1:3] if len(numbers) == 3 else [0.0, 0.0])
        matrix[:2, :2], matrix[:2, 2] = turn, centre - turn @ centre
    elif name in ("skewX", "skewY") and numbers:
        matrix[(0, 1) if name == "skewX" else (1, 0)] = math.tan(math.radians(numbers[0]))
    else:
        raise FormatError(f"has the transform {name[:40]!r} with {len(numbers)} numbers", line)
    return matrix


def window_of(element: Element, viewport: Viewport) -> tuple[FloatArray, Viewport]:
    """(3, 3) matrix of the inside of a drawing in a drawing, and the viewport there."""
    get = {
        key: length_of(element.attributes[key], key, element.line, viewport)
        for key in ("x", "y", "width", "height")
        if element.attributes.get(key, "auto") != "auto"
    }
    size = get.get("width", viewport[0]), get.get("height", viewport[1])
    matrix = np.eye(3)
    matrix[:2, 2] = get.get("x", 0.0), get.get("y", 0.0)
    box = re.findall(_NUMBER, element.attributes.get("viewBox", ""))
    if len(box) != 4:
        return matrix, size
    x, y, width, height = (finite(word, "viewBox", element.line) for word in box)
    if min(width, height, *size) <= 0:
        return matrix, size
    scale = np.array([size[0] / width, size[1] / height])
    if not scale.max() <= _LARGEST_SCALE:
        raise FormatError("has a viewBox that is absurdly small", element.line)
    fit = element.attributes.get("preserveAspectRatio", "xMidYMid").split() or ["xMidYMid"]
    if fit[0] != "none":
        scale[:] = scale.max() if fit[-1] == "slice" else scale.min()
    room = np.array(size) - scale * [width, height]
    share = [{"min": 0.0, "max": 1.0}.get(fit[0][k : k + 3].lower(), 0.5) for k in (1, 5)]
    inside = np.diag([*scale, 1.0])
    inside[:2, 2] = room * share - scale * [x, y]
    return matrix @ inside, (width, height)


def outlines(
    element: Element, matrix: FloatArray, sag: float, viewport: Viewport = (0.0, 0.0)
) -> tuple[list[FloatArray], bool]:
    """The polylines (n, 2) of a shape after its transform, and whether any of it is curved.

    Raises:
        FormatError: its numbers cannot be read.
    """
    scale = max(float(np.linalg.norm(matrix[:2, :2], 2)), 1e-12)
    lines, curved = _lines(element, sag / scale, viewport)
    return [line @ matrix[:2, :2].T + matrix[:2, 2] for line in lines if len(line)], curved


def _lines(element: Element, sag: float, viewport: Viewport) -> tuple[list[FloatArray], bool]:
    tag = element.tag
    get = {
        key: length_of(value, key, element.line, viewport)
        for key, value in element.attributes.items()
        if key in _LENGTHS and value != "auto"
    }
    if tag == "rect":
        x, y, width, height = (get.get(key, 0.0) for key in ("x", "y", "width", "height"))
        rx = min(get.get("rx", get.get("ry", 0.0)), width / 2)
        ry = min(get.get("ry", get.get("rx", 0.0)), height / 2)
        if rx > 0 and ry > 0:
            return _rounded(sag, x, y, width, height, rx, ry)
        return [
            np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height], [x, y]])
        ], False
    if tag in ("circle", "ellipse"):
        radii = np.array([get.get("r", get.get("rx", 0.0)), get.get("r", get.get("ry", 0.0))])
        angles = np.linspace(0, 2 * np.pi, _SIDES + 1)
        # Around it, so that what is solid keeps its size.
        ring = np.column_stack([np.cos(angles), np.sin(angles)]) / math.cos(math.pi / _SIDES)
        return [ring * radii + [get.get("cx", 0.0), get.get("cy", 0.0)]], True
    if tag == "line":
        ends = [[get.get("x1", 0.0), get.get("y1", 0.0)], [get.get("x2", 0.0), get.get("y2", 0.0)]]
        return [np.array(ends)], False
    if tag in ("polyline", "polygon"):
        numbers = [
            finite(word, "points", element.line)
            for word in re.findall(_NUMBER, element.attributes.get("points", ""))
        ]
        points = np.array(numbers[: len(numbers) // 2 * 2]).reshape(-1, 2)
        return [np.vstack([points, points[:1]]) if tag == "polygon" else points], False
    return _path(element, sag)


def _rounded(
    sag: float, x: float, y: float, width: float, height: float, rx: float, ry: float
) -> tuple[list[FloatArray], bool]:
    """A rectangle with round corners."""
    pen = _Pen(sag)
    right, below = x + width, y + height
    pen.draw("M", [x + rx, y])
    for near, corner in (
        ((right - rx, y), (right, y + ry)), ((right, below - ry), (right - rx, below)),
        ((x + rx, below), (x, below - ry)), ((x, y + ry), (x + rx, y)),
    ):  # fmt: skip
        pen.draw("L", [*near])
        pen.draw("A", [rx, ry, 0, 0, 1, *corner])
    pen.draw("Z", [])
    return pen.finished()


def _path(element: Element, sag: float) -> tuple[list[FloatArray], bool]:
    """The polylines of path data."""
    pen = _Pen(sag)
    for command, numbers in _commands(element):
        need = _COUNTS[command.lower()]
        if (need and (not numbers or len(numbers) % need)) or (not need and numbers):
            raise FormatError(
                f"has a path with {len(numbers)} numbers after {command}", element.line
            )
        drawn = command
        for k in range(0, max(len(numbers), 1), max(need, 1)):
            pen.draw(drawn, numbers[k : k + need])
            if pen.count > MOST_PATH:
                raise FormatError(f"has a path of more than {MOST_PATH} corners", element.line)
            drawn = {"M": "L", "m": "l"}.get(drawn, drawn)
    return pen.finished()


def _commands(element: Element) -> Iterator[tuple[str, list[float]]]:
    """The letters of path data, each with the numbers after it."""
    data = element.attributes.get("d", "")
    command, position = "", 0
    numbers: list[float] = []
    while True:
        # The two flags of an arc are single digits that nothing need part from what follows.
        flag = command in ("A", "a") and len(numbers) % 7 in (3, 4)
        token = (_FLAG.match(data, position) if flag else None) or _TOKEN.search(data, position)
        if token is None:
            break
        position = token.end()
        if token[1]:
            if command:
                yield command, numbers
            command, numbers = token[1], []
        elif command:
            numbers.append(finite(token[2], "d", element.line))
        else:
            raise FormatError("has a path that begins with a number", element.line)
    if command:
        yield command, numbers


class _Pen:
    """Draws path data."""

    def __init__(self, sag: float) -> None:
        self.sag = sag
        self.lines: list[FloatArray] = []
        self.line: list[FloatArray] = []
        self.at = np.zeros(2)
        self.begin = np.zeros(2)
        self.control: tuple[str, FloatArray] = ("", np.zeros(2))
        self.curved = False
        self.count = 0

    def finished(self) -> tuple[list[FloatArray], bool]:
        """All lines, and whether any is curved."""
        self._lift()
        return self.lines, self.curved

    def draw(self, command: str, values: list[float]) -> None:
        """One command with its numbers."""
        kind = command.lower()
        base = self.at if command.islower() else np.zeros(2)
        before, self.control = self.control, ("", self.at)
        if kind == "z":
            self._to(self.begin)
            self._lift()
            self.at = self.begin
        elif kind == "h":
            self._to(np.array([values[0] + base[0], self.at[1]]))
        elif kind == "v":
            self._to(np.array([self.at[0], values[0] + base[1]]))
        elif kind == "a":
            self._arc(values, np.array(values[5:]) + base)
        else:
            points = np.array(values).reshape(-1, 2) + base
            if kind == "m":
                self._lift()
                self.at = self.begin = points[0]
            elif kind == "l":
                self._to(points[0])
            else:
                if kind in "st":
                    same = before[0] == {"s": "c", "t": "q"}[kind]
                    mirrored = 2 * self.at - before[1] if same else self.at
                    points = np.vstack([mirrored, points])
                self._curve(points, "c" if kind in "cs" else "q")

    def _curve(self, points: FloatArray, kind: str) -> None:
        self.curved = True
        for place in bezier(np.vstack([self.at, points]), self.sag)[1:]:
            self._to(place)
        self.control = (kind, points[-2])

    def _arc(self, values: list[float], end: FloatArray) -> None:
        """An elliptical arc, by its centre as the standard derives it."""
        rx, ry, tilt = abs(values[0]), abs(values[1]), math.radians(values[2])
        if rx == 0 or ry == 0 or (end == self.at).all():
            self._to(end)
            return
        self.curved = True
        turn = np.array([[math.cos(tilt), math.sin(tilt)], [-math.sin(tilt), math.cos(tilt)]])
        half = turn @ (self.at - end) / 2 / [rx, ry]
        size = float(half @ half)
        if size > 1:
            rx, ry, half, size = (
                rx * math.sqrt(size),
                ry * math.sqrt(size),
                half / math.sqrt(size),
                1.0,
            )
        sign = -1.0 if bool(values[3]) == bool(values[4]) else 1.0
        centre = sign * math.sqrt(max(0.0, 1.0 / size - 1.0)) * np.array([half[1], -half[0]])
        first, last = half - centre, -half - centre
        start = math.atan2(first[1], first[0])
        sweep = math.atan2(last[1], last[0]) - start
        if values[4] and sweep < 0:
            sweep += 2 * math.pi
        elif not values[4] and sweep > 0:
            sweep -= 2 * math.pi
        step = 2 * math.acos(max(0.0, 1 - min(1.0, self.sag / max(rx, ry))))
        count = int(min(256, max(2, math.ceil(abs(sweep) / max(step, 1e-3)))))
        angles = start + sweep * np.arange(1, count + 1) / count
        circle = np.column_stack([np.cos(angles), np.sin(angles)])
        places = (circle + centre) * [rx, ry] @ turn + (self.at + end) / 2
        for place in [*places[:-1], end]:
            self._to(place)

    def _to(self, place: FloatArray) -> None:
        if not self.line:
            self.line.append(self.at)
        self.line.append(place)
        self.at = place
        self.count += 1

    def _lift(self) -> None:
        if self.line:
            self.lines.append(np.array(self.line))
        self.line = []
