"""Potentials of many clearances at once: value, and the coefficients that chain rules need.

Two models of "far enough apart" share everything else:

- contacts: the sum of barriers of every contact, sum_k w_k K_k b(D_k - R_k), with weights w_k that keep
  it from growing with the number of segments (`shares.segment_shares`);
- smooth minimum: a barrier of the log-sum-exp minimum of a group of contacts (the paper's d),
  d = m - log(sum_k exp(-alpha (D_k - m))) / alpha with m the least D_k, so that nothing overflows.
  With softmax weights w_k it has the gradient sum_k w_k grad D_k and the Hessian
  sum_k w_k hess D_k - alpha (sum_k w_k g_k g_k^T - grad d grad d^T).

In both, the gradient is sum_k slope_k grad D_k. The part of the Hessian that has rank one in every
contact is sum_k curvature_k g_k g_k^T; the smooth minimum adds `coupling` grad d grad d^T.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import kernel
from stplan.costs.contacts.barrier import barrier
from stplan.costs.contacts.contact_set import ContactList


@dataclass(frozen=True)
class Coefficients:
    """What a list of contacts contributes at one iterate.

    Attributes:
        value: the sum, inf where a clearance is not positive.
        least: smallest clearance that is felt, m (of the smooth minimum where that is the model); inf
            where none is.
        slope: (C,) factor of grad D_k.
        curvature: (C,) factor of g_k g_k^T in the exact Hessian.
        majorizer: (C,) factor of g_k g_k^T in the positive semidefinite stand-in.
        coupling: (G,) factor of grad d grad d^T in the exact Hessian, 0 for contacts.
        unbounded: summed weight of logarithms without a range: in a unit of length L times as large the
            value is greater by this times log L.
    """

    value: float
    least: float
    slope: FloatArray
    curvature: FloatArray
    majorizer: FloatArray
    coupling: FloatArray
    unbounded: float = 0.0


class Potential(Protocol):
    """How the distances of a list of contacts become a cost."""

    def coefficients(self, distance: FloatArray, contacts: ContactList) -> Coefficients:
        """Value and chain-rule coefficients of the distances (C,) in m."""
        ...


class ByKey(Protocol):
    """Values by key: an array, or what stands for one that all pairs of many agents would make too large."""

    def __getitem__(self, keys: IntArray) -> FloatArray:
        """Of these keys."""
        ...


@dataclass(frozen=True)
class _Barriers:
    """Of every contact of a list (C,); `unbounded` as in `Coefficients`."""

    radius: FloatArray
    weight: FloatArray
    reach: FloatArray
    unbounded: float


@dataclass(frozen=True)
class ContactBarriers:
    """A barrier for every contact; all attributes by key of its group.

    Attributes:
        radius: R, m.
        weight: factor of the barrier, mu included.
        reach: clearance at which repulsion starts, m, inf for the unbounded logarithm.
        shares: (P,) weight of a contact's curve by its second position, 1 for what is no curve; None
            where all are 1.
    """

    radius: ByKey
    weight: ByKey
    reach: ByKey
    shares: FloatArray | None = None
    _latest: list[tuple[ContactList, _Barriers]] = field(
        default_factory=list, init=False, repr=False, compare=False
    )

    def coefficients(self, distance: FloatArray, contacts: ContactList) -> Coefficients:
        """The sum over contacts."""
        if not self._latest or self._latest[0][0] is not contacts:
            self._latest[:] = [(contacts, self._barriers(contacts))]
        barriers = self._latest[0][1]
        slope = np.zeros(len(distance))
        curvature = np.zeros(len(distance))
        value, least = _contact_barriers(
            distance, barriers.radius, barriers.weight, barriers.reach, slope, curvature
        )
        return Coefficients(
            value, least, slope, curvature, curvature, np.zeros(0), barriers.unbounded
        )

    def _barriers(self, contacts: ContactList) -> _Barriers:
        keys, members = contacts.keys, contacts.members
        weight = self.weight[keys][members]
        if self.shares is not None:
            weight = (
                weight * self.shares[contacts.points[:, 1]] * self.shares[contacts.points[:, 3]]
            )
        reach = self.reach[keys][members]
        unbounded = float(weight[np.isinf(reach)].sum())
        return _Barriers(self.radius[keys][members], weight, reach, unbounded)


@dataclass(frozen=True)
class SmoothMinimumBarriers:
    """A barrier for the smooth minimum distance of every group; all attributes by its key.

    Attributes:
        radius, weight, reach: as for `ContactBarriers`.
        sharpness: alpha, 1/m.
        cutoff: contacts that weigh less than this part of their group's heaviest one have no part in the
            semidefinite stand-in.
    """

    radius: ByKey
    weight: ByKey
    reach: ByKey
    sharpness: FloatArray
    cutoff: float = 0.0

    def coefficients(self, distance: FloatArray, contacts: ContactList) -> Coefficients:
        """The sum over groups."""
        keys = contacts.keys
        slope = np.zeros(len(distance))
        curvature = np.zeros(len(distance))
        majorizer = np.zeros(len(distance))
        coupling = np.zeros(len(keys))
        value, least = _smooth_minimum_barriers(
            distance, contacts.starts, self.sharpness[keys], self.radius[keys], self.weight[keys],
            self.reach[keys], self.cutoff, slope, curvature, majorizer, coupling,
        )  # fmt: skip
        felt = (np.diff(contacts.starts) > 0) & np.isinf(self.reach[keys])
        unbounded = float(self.weight[keys][felt].sum())
        return Coefficients(value, least, slope, curvature, majorizer, coupling, unbounded)


@dataclass(frozen=True)
class QuadraticPull:
    """weight (d - R)^2 of the smooth minimum distance d of every group.

    With D = d - R, value K D^2, slope 2 K D and second derivative 2 K; the rank-one terms follow as for
    barriers.

    Attributes:
        radius: R by key, m.
        weight: K by key.
        sharpness: alpha of all, 1/m.
    """

    radius: FloatArray
    weight: FloatArray
    sharpness: float

    def coefficients(self, distance: FloatArray, contacts: ContactList) -> Coefficients:
        """The sum over groups."""
        if not len(distance):
            nothing = np.zeros(0)
            return Coefficients(0.0, np.inf, nothing, nothing, nothing, nothing)
        starts, members, keys = contacts.starts[:-1], contacts.members, contacts.keys
        weight = self.weight[keys]
        least = np.minimum.reduceat(distance, starts)
        share = np.exp(-self.sharpness * (distance - least[members]))
        summed = np.add.reduceat(share, starts)
        share /= summed[members]
        smooth = least - np.log(summed) / self.sharpness
        gap = smooth - self.radius[keys]
        slope = (2 * weight * gap)[members] * share
        return Coefficients(
            value=float((weight * gap**2).sum()),
            least=np.inf,
            slope=slope,
            curvature=-self.sharpness * slope,
            majorizer=(2 * weight)[members] * share,
            coupling=2 * weight * (1 + gap * self.sharpness),
        )


@kernel
def _contact_barriers(
    distance: FloatArray,
    radius: FloatArray,
    weight: FloatArray,
    reach: FloatArray,
    slope: FloatArray,
    curvature: FloatArray,
) -> tuple[float, float]:
    total = 0.0
    least = np.inf
    for k in range(len(distance)):
        clearance = distance[k] - radius[k]
        if clearance >= reach[k]:
            continue
        least = min(least, clearance)
        if clearance <= 0.0:
            continue
        value, first, second = barrier(clearance, reach[k])
        total += weight[k] * value
        slope[k] = weight[k] * first
        curvature[k] = weight[k] * second
    if least <= 0.0:
        total = np.inf
    return total, least


@kernel
def _smooth_minimum_barriers(
    distance: FloatArray,
    starts: IntArray,
    alpha: FloatArray,
    radius: FloatArray,
    weight: FloatArray,
    reach: FloatArray,
    cutoff: float,
    slope: FloatArray,
    curvature: FloatArray,
    majorizer: FloatArray,
    coupling: FloatArray,
) -> tuple[float, float]:
    total = 0.0
    least = np.inf
    for g in range(len(alpha)):
        low = starts[g]
        high = starts[g + 1]
        if high == low:
            continue
        minimum = np.min(distance[low:high])
        summed = 0.0
        for k in range(low, high):
            summed += np.exp(-alpha[g] * (distance[k] - minimum))
        clearance = minimum - np.log(summed) / alpha[g] - radius[g]
        if clearance >= reach[g]:
            continue
        least = min(least, clearance)
        if clearance <= 0.0:
            continue
        value, first, second = barrier(clearance, reach[g])
        total += weight[g] * value
        coupling[g] = weight[g] * (second + alpha[g] * first)
        for k in range(low, high):
            share = np.exp(-alpha[g] * (distance[k] - minimum)) / summed
            slope[k] = weight[g] * first * share
            curvature[k] = -weight[g] * alpha[g] * first * share
            if share * summed >= cutoff:
                majorizer[k] = weight[g] * share * (second - alpha[g] * first * (1.0 - share))
    if least <= 0.0:
        total = np.inf
    return total, least
