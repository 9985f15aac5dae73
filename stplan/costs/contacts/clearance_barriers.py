"""Barriers of many clearances at once: value, and the coefficients that chain rules need.

Two models of "far enough apart" share everything else:

- contacts: the sum of barriers of every contact, sum_k K_k b(D_k - R_k);
- smooth minimum: a barrier of the log-sum-exp minimum of a group of contacts (the paper's d),
  d = m - log(sum_k exp(-alpha (D_k - m))) / alpha with m the least D_k, so that nothing overflows.
  With softmax weights w_k it has the gradient sum_k w_k grad D_k and the Hessian
  sum_k w_k hess D_k - alpha (sum_k w_k g_k g_k^T - grad d grad d^T).

In both, the gradient is sum_k slope_k grad D_k. The part of the Hessian that has rank one in every
contact is sum_k curvature_k g_k g_k^T; the smooth minimum adds `coupling` grad d grad d^T.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import kernel
from stplan.costs.contacts.barrier import barrier


@dataclass
class Coefficients:
    """What a list of contacts contributes at one iterate.

    Attributes:
        value: the sum, inf where a clearance is not positive.
        least: smallest clearance in m (of the smooth minimum where that is the model).
        slope: (C,) factor of grad D_k.
        curvature: (C,) factor of g_k g_k^T in the exact Hessian.
        majorizer: (C,) factor of g_k g_k^T in the positive semidefinite stand-in.
        coupling: (G,) factor of grad d grad d^T in the exact Hessian, 0 for contacts.
    """

    value: float
    least: float
    slope: FloatArray
    curvature: FloatArray
    majorizer: FloatArray
    coupling: FloatArray


def contact_barriers(
    distance: FloatArray, radius: FloatArray, weight: FloatArray, reach: FloatArray
) -> Coefficients:
    """Sum of barriers over contacts; all arguments (C,), metres but for `weight`."""
    slope = np.zeros(len(distance))
    curvature = np.zeros(len(distance))
    value, least = _contact_barriers(distance, radius, weight, reach, slope, curvature)
    return Coefficients(value, least, slope, curvature, curvature, np.zeros(0))


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
        least = min(least, clearance)
        if clearance <= 0.0 or clearance >= reach[k]:
            continue
        value, first, second = barrier(clearance, reach[k])
        total += weight[k] * value
        slope[k] = weight[k] * first
        curvature[k] = weight[k] * second
    if least <= 0.0:
        total = np.inf
    return total, least


def smooth_minimum_barriers(
    distance: FloatArray,
    starts: IntArray,
    alpha: FloatArray,
    radius: FloatArray,
    weight: FloatArray,
    reach: FloatArray,
) -> Coefficients:
    """Sum over groups of the barrier of the smooth minimum distance.

    Group g owns contacts ``starts[g]:starts[g + 1]``; `alpha` (1/m), `radius`, `weight` and
    `reach` are (G,).
    """
    slope = np.zeros(len(distance))
    curvature = np.zeros(len(distance))
    majorizer = np.zeros(len(distance))
    coupling = np.zeros(len(alpha))
    value, least = _smooth_minimum_barriers(
        distance, starts, alpha, radius, weight, reach, slope, curvature, majorizer, coupling
    )
    return Coefficients(value, least, slope, curvature, majorizer, coupling)


@kernel
def _smooth_minimum_barriers(
    distance: FloatArray,
    starts: IntArray,
    alpha: FloatArray,
    radius: FloatArray,
    weight: FloatArray,
    reach: FloatArray,
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
        least = min(least, clearance)
        if clearance <= 0.0 or clearance >= reach[g]:
            continue
        value, first, second = barrier(clearance, reach[g])
        total += weight[g] * value
        coupling[g] = weight[g] * (second + alpha[g] * first)
        for k in range(low, high):
            share = np.exp(-alpha[g] * (distance[k] - minimum)) / summed
            slope[k] = weight[g] * first * share
            curvature[k] = -weight[g] * alpha[g] * first * share
            majorizer[k] = weight[g] * share * (second - alpha[g] * first * (1.0 - share))
    if least <= 0.0:
        total = np.inf
    return total, least


@kernel
def smooth_minimum(distance: FloatArray, alpha: float) -> float:
    """-log(sum exp(-alpha D)) / alpha in m, shifted by the least D; never above min(D)."""
    minimum = np.min(distance)
    return float(minimum - np.log(np.sum(np.exp(-alpha * (distance - minimum)))) / alpha)


def choose_alpha(
    distance: FloatArray, starts: IntArray, radius: FloatArray, alpha_0: float
) -> FloatArray:
    """Sharpness of every group, (G,) in 1/m: `alpha_0` raised until the model is usable.

    The paper's heuristic raises alpha until the smooth distance is positive; the barrier needs
    d > R, so here the underestimate log(sum)/alpha may be half the true clearance at most.
    """
    alpha = np.full(len(radius), alpha_0)
    for g in range(len(radius)):
        members = distance[starts[g] : starts[g + 1]]
        if not len(members):
            continue
        minimum = members.min()
        while minimum > radius[g] and (
            minimum - smooth_minimum(members, alpha[g]) > 0.5 * (minimum - radius[g])
        ):
            alpha[g] *= 1.3
    return alpha
