"""What a nonlinear program asks of every term that it sums."""

from __future__ import annotations

from abc import abstractmethod
from enum import Flag, auto
from typing import ClassVar, Protocol, Self

import numpy as np

from stplan.arrays import FloatArray, IntArray

# Rows and columns of entries of a lower triangle.
Structure = tuple[IntArray, IntArray]


class Capability(Flag):
    """What a term is to those who sum it.

    PRICE: what plans are compared by, without barriers and regularity.
    RESTORING: it takes part in feasibility restoration.
    CLEARANCE: a barrier of clearances in m: steps keep a share of the least one, and are damped where
        it refuses them.
    LIMIT: it limits motion: a barrier, or a penalty where feasibility is restored.
    LIVE: it knows who is near whom, and that is renewed as the iterate moves.
    """

    NONE = 0
    PRICE = auto()
    RESTORING = auto()
    CLEARANCE = auto()
    LIMIT = auto()
    LIVE = auto()


class Term(Protocol):
    """One summand of the objective over all agents: a pure function of the knots.

    Knots are (M, 3) arrays of x, y [m], t [s]; variable 3 i + x is axis x of knot i. A value of inf
    says that the term is undefined there (a rod inside another, time running back).
    """

    name: ClassVar[str]
    capabilities: ClassVar[Capability]

    @abstractmethod
    def value(self, knots: FloatArray) -> float:
        """The cost, inf outside its domain."""

    @abstractmethod
    def gradient(self, knots: FloatArray) -> FloatArray:
        """(M, 3) derivative of `value`."""

    @abstractmethod
    def hessian_structure(self) -> Structure:
        """Rows and columns (row >= column) of what `hessian` gives; fixed for life."""

    @abstractmethod
    def hessian(self, knots: FloatArray) -> FloatArray:
        """Exact second derivatives in the order of `hessian_structure`; repeated entries add."""

    @abstractmethod
    def gauss_newton_structure(self) -> Structure:
        """Rows and columns (row >= column) of what `gauss_newton_hessian` gives; fixed for life."""

    @abstractmethod
    def gauss_newton_hessian(self, knots: FloatArray) -> FloatArray:
        """What the optimiser uses by default, in the order of `gauss_newton_structure`.

        Every term says what it is: the exact Hessian, or which part of it.
        """

    def renewed(self, knots: FloatArray) -> Self:
        """The same function, prepared for being asked around `knots`."""
        del knots
        return self

    def touches(self, knots: FloatArray) -> bool:
        """Whether the value at `knots` is known to be inf before the term is prepared for them."""
        del knots
        return False

    def is_stale(self, knots: FloatArray) -> bool:
        """Whether the structure has no room for an interaction that is felt at `knots`."""
        del knots
        return False

    def least_clearance(self, knots: FloatArray) -> float:
        """Smallest clearance in m that a barrier feels, inf where none is felt."""
        del knots
        return np.inf

    def unbounded_weight(self, knots: FloatArray) -> float:
        """Summed weight of the logarithms of lengths at `knots`: they alone depend on the unit of length."""
        del knots
        return 0.0

    def leaves_slack(self, start: FloatArray, end: FloatArray, share: float) -> bool:
        """Whether at knots `end` no limit leaves less than a `share` of what it leaves at `start`."""
        del start, end, share
        return True

    def allows_step(self, start: FloatArray, end: FloatArray) -> bool:
        """Whether nothing is crossed on the straight way from feasible knots `start` to `end`."""
        del start, end
        return True

    @property
    def sharpness(self) -> FloatArray | None:
        """Sharpness of smooth minima (1/m) for the next program's term of this kind, None without any."""
        return None
