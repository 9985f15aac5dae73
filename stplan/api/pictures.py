"""Plans drawn into figures of one's own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stplan.errors import UsageError
from stplan.optional import require
from stplan.planned import Plan

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot(result: Plan, axes: Axes | None = None, *, part: str = "map", seed: bool = False) -> Any:
    """Draw a plan into matplotlib `axes`, or into new ones; the axes are returned.

    Args:
        part: ``map``, ``clearance``, ``speed`` or ``arrivals``; ``rods`` in axes made with
            ``projection="3d"``.
        seed: on the map, the initial curves as well.

    Raises:
        UsageError: there is no such part, or no matplotlib (``pip install 'stplan[view]'``).
    """
    require("matplotlib", "stplan.plot")
    from stplan.viewing.figure import AXES_PARTS, draw_part, new_axes
    from stplan.viewing.run_view import view_plan

    if part not in AXES_PARTS:
        raise UsageError(f"{part!r} is none of {', '.join(AXES_PARTS)}")
    if axes is None:
        axes = new_axes(part)
    draw_part(axes, view_plan(result), part, seed=seed)
    return axes
