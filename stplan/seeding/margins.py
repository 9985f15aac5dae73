"""Margins: times the distances and radii that curves keep while they are sought."""

from __future__ import annotations

# Tried where the margin asked for leaves no way.
SMALLER_MARGINS = (1.02, 1.005, 1.001)


def margin_ladder(margin: float) -> tuple[float, ...]:
    """`margin`, then ever smaller ones."""
    return (margin, *(smaller for smaller in SMALLER_MARGINS if smaller < margin))
