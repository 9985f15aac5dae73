"""Pictures of floors: occupancy maps of robots (``.yaml`` beside a picture) and plain pictures.

A pixel is free or not; the outline follows its edges exactly and is then simplified inwards, by one
pixel's side unless asked otherwise, so that stairs of pixels become slopes and the floor never gains.
"""

from __future__ import annotations

import io
import math
import warnings
from typing import Any

import numpy as np
import shapely

from stplan.arrays import BoolArray, FloatArray
from stplan.maps.files import FileContent
from stplan.maps.formats.cells import cell_polygons, check_cells
from stplan.maps.formats.drawing import (
    Beside,
    Drawing,
    FileOptions,
    ForeignFormat,
    FormatError,
    finite,
)
from stplan.maps.formats.yaml_file import read_yaml_mapping
from stplan.optional import require

SUFFIXES = (
    ".pgm",
    ".png",
    ".bmp",
    ".gif",
    ".jpg",
    ".jpeg",
    ".tif",
    ".tiff",
    ".webp",
    ".ppm",
    ".pbm",
)
# How light a pixel of a plain picture is at least where it is free.
LIGHT = 0.5
# Of occupancy maps, the defaults of the map server.
_FREE_BELOW = 0.25
# The grey, of 255, of cells that nobody has seen.
_UNKNOWN = 205
_NOTHING = "has no free pixel: none is light enough"


def read_picture(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """What is light is floor, a unit a pixel, y upwards from the lower edge."""
    del beside
    threshold = LIGHT if options.threshold is None else options.threshold
    floors = _floors(_lightness(file) >= threshold)
    return Drawing(floors=floors, tolerance=1.0)


def read_occupancy(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """A map as the ROS map server has it, in m: what is not surely free is blocked."""
    tree = read_yaml_mapping(file)
    (name,) = _mentioned(file)
    resolution = finite(tree.get("resolution"), "resolution")
    if resolution <= 0:
        raise FormatError(f"resolution is {resolution:g}; more than 0 is expected")
    picture = beside(name)
    free = _free_pixels(picture, tree, options)
    x, y, angle = _origin(tree.get("origin", [0.0, 0.0, 0.0]))
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])

    def place(points: FloatArray) -> FloatArray:
        return (points * resolution) @ turn.T + [x, y]

    floors = tuple(shapely.transform(floor, place) for floor in _floors(free))
    return Drawing(floors=floors, tolerance=resolution)


def _mentioned(file: FileContent) -> tuple[str, ...]:
    name = read_yaml_mapping(file).get("image")
    if not isinstance(name, str):
        raise FormatError("names no image")
    if not name.lower().endswith(SUFFIXES):
        raise FormatError(f"names the image {name[:100]!r}, no known kind of picture")
    return (name,)


def _free_pixels(picture: FileContent, tree: dict[str, Any], options: FileOptions) -> BoolArray:
    negate = _flag(tree.get("negate", 0))
    # What is transparent is not known to be free.
    light = _lightness(picture, "white" if negate else "black")
    occupied = light if negate else 1.0 - light
    if options.threshold is not None:
        return occupied <= 1.0 - options.threshold
    mode = tree.get("mode", "trinary")
    if mode == "raw":
        # Pixels are probabilities in percent, above 100 unknown.
        percent = np.rint(light * 255)
        return percent <= 100 * finite(tree.get("free_thresh", _FREE_BELOW), "free_thresh")
    if mode not in ("trinary", "scale"):
        raise FormatError(f"mode is {str(mode)[:40]!r}; trinary, scale or raw is expected")
    free = occupied < finite(tree.get("free_thresh", _FREE_BELOW), "free_thresh")
    # Map servers write this grey for unknown cells, and thresholds above it do not change that.
    return free & (np.rint(light * 255) != _UNKNOWN)


def _flag(value: Any) -> bool:
    if isinstance(value, str) or finite(
        int(value) if isinstance(value, bool) else value, "negate"
    ) not in (0, 1):
        raise FormatError(f"negate is {str(value)[:40]!r}; 0 or 1 is expected")
    return bool(value)


def _origin(value: Any) -> tuple[float, float, float]:
    if not isinstance(value, list) or len(value) not in (2, 3):
        raise FormatError("origin is no [x, y, angle]")
    x, y, *angle = (finite(one, "origin") for one in value)
    return x, y, angle[0] if angle else 0.0


def _floors(free: BoolArray) -> tuple[Any, ...]:
    if not free.any():
        raise FormatError(_NOTHING)
    return cell_polygons(free)


def _lightness(file: FileContent, behind: str = "white") -> FloatArray:
    """(H, W) 0 black to 1 white, in front of a colour where the picture is transparent.

    Raises:
        FormatError: it is no picture, or larger than is read.
    """
    image_module = require("PIL.Image", f"{file.path.name}, a picture,", "maps")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            image = image_module.open(io.BytesIO(file.content))
            # Known before any pixel is unpacked.
            check_cells(*image.size)
            if image.mode in ("RGBA", "LA", "PA") or "transparency" in image.info:
                image = image.convert("RGBA")
                paper = image_module.new("RGBA", image.size, behind)
                image = image_module.alpha_composite(paper, image)
            if image.mode.startswith(("I", "F")):
                values = np.asarray(image, dtype=np.float64)
                # Whole numbers have 16 bits, whatever of these the picture uses; others say nothing.
                deep = image.mode.startswith("I") or values.max() > 255
                return values / (65535.0 if deep else 255.0)
            return np.asarray(image.convert("L"), dtype=np.float64) / 255.0
    except (FormatError, MemoryError):
        raise
    except Exception as error:  # a hostile picture may raise anything at all inside the reader
        raise FormatError("cannot be read: it is damaged, cut short or no picture") from error


PICTURE = ForeignFormat("picture", SUFFIXES, read_picture, frozenset({"threshold"}))
OCCUPANCY = ForeignFormat(
    "occupancy map", (".yaml", ".yml"), read_occupancy, frozenset({"threshold"}),
    lambda content: b"image" in content and b"resolution" in content,
    _mentioned,
)  # fmt: skip
