"""Who is around the agents of a problem without being part of it: their rods are there and do not move."""

from __future__ import annotations

from dataclasses import dataclass

from stplan.arrays import FloatArray
from stplan.problem.rods import FixedRods
from stplan.scene.interactions import Interactions


@dataclass(frozen=True)
class Surroundings:
    """B agents around the A agents of a problem.

    Attributes:
        rods: theirs.
        interactions: (A + B, A + B) of the problem's agents, then theirs, who have nothing to do with
            each other.
        wish: (A + B, A + B) m, clearance wished for beyond the distance; None where nobody wishes for any.
        clearance_weights: (B,) of such wishes.
    """

    rods: FixedRods
    interactions: Interactions
    wish: FloatArray | None
    clearance_weights: FloatArray
