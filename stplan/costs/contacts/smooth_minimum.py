"""The smooth minimum of distances, d = -log(sum exp(-alpha D)) / alpha, and the choice of its alpha."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import kernel
from stplan.costs.contacts.contact_set import ContactList

# exp(-36) is below the rounding of a sum of order one.
NEGLIGIBLE = 36.0
# alpha is raised by this factor at a time.
SHARPER = 1.3


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
            alpha[g] *= SHARPER
    return alpha


def sharpened(
    kept: FloatArray,
    contacts: ContactList,
    distance: FloatArray,
    radius: FloatArray,
    alpha_0: float,
) -> FloatArray:
    """`kept` sharpness by key (1/m), chosen where it is nan and the group has contacts.

    Args:
        distance: (C,) m, of all contacts that weigh.
        radius: by key, m.
    """
    chosen = choose_alpha(distance, contacts.starts, radius[contacts.keys], alpha_0)
    new = np.isnan(kept[contacts.keys])
    result = kept.copy()
    result[contacts.keys[new]] = chosen[new]
    return result


def weighing_reach(num_contacts: FloatArray, alpha: FloatArray) -> FloatArray:
    """How much further than where its barrier begins a contact still weighs in a smooth minimum, m.

    The minimum of n distances is underestimated by up to log(n) / alpha, and contacts weigh up to
    `NEGLIGIBLE` / alpha beyond the nearest.
    """
    reach: FloatArray = (np.log(np.maximum(num_contacts, 1.0)) + NEGLIGIBLE) / alpha
    return reach
