"""Colours of agents: told apart on light and on dark ground, for any number of them."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray

# Neighbours in scene order get hues a golden angle apart, so that any few in a row are well spread;
# the lightness changes with a period of three, because hues come close again after eight steps.
_FIRST_HUE = 255.0
_GOLDEN_ANGLE = 180.0 * (3.0 - np.sqrt(5.0))
_LIGHTNESS = np.array([0.60, 0.73, 0.54])
_CHROMA = np.array([0.17, 0.155, 0.12])


def agent_colours(count: int) -> FloatArray:
    """(A, 3) sRGB from 0 to 1."""
    index = np.arange(count)
    hue = np.radians(_FIRST_HUE + _GOLDEN_ANGLE * index)
    chroma = _CHROMA[index % 3]
    return _srgb_from_oklab(
        np.column_stack([_LIGHTNESS[index % 3], chroma * np.cos(hue), chroma * np.sin(hue)])
    )


def hex_colours(count: int) -> list[str]:
    """The same as ``#rrggbb``."""
    levels = np.rint(255 * agent_colours(count)).astype(int)
    return [f"#{red:02x}{green:02x}{blue:02x}" for red, green, blue in levels.tolist()]


def _srgb_from_oklab(colours: FloatArray) -> FloatArray:
    """(N, 3) Oklab, a space in which equal steps look equal, to sRGB cut to its gamut."""
    to_cones = np.array(
        [
            [1.0, 0.3963377774, 0.2158037573],
            [1.0, -0.1055613458, -0.0638541728],
            [1.0, -0.0894841775, -1.2914855480],
        ]
    )
    to_linear = np.array(
        [
            [4.0767416621, -3.3077115913, 0.2309699292],
            [-1.2684380046, 2.6097574011, -0.3413193965],
            [-0.0041960863, -0.7034186147, 1.7076147010],
        ]
    )
    linear = np.clip((colours @ to_cones.T) ** 3 @ to_linear.T, 0.0, 1.0)
    curved = 1.055 * linear ** (1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, curved)
