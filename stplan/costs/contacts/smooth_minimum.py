"""The smooth minimum of distances, d = -log(sum exp(-alpha D)) / alpha, and the choice of its alpha."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from stplan.arrays import FloatArray
from stplan.compiled import kernel
from stplan.costs.contacts.contact_set import ContactList

# exp(-36) is below the rounding of a sum of order one.
NEGLIGIBLE = 36.0
# alpha is raised by this factor at a time, or by this part of alpha_0.
SHARPER, STEP = 1.3, 0.1

AlphaRule = Literal["half-clearance", "stepped"]


@kernel
def smooth_minimum(distance: FloatArray, alpha: float) -> float:
    """-log(sum exp(-alpha D)) / alpha in m, shifted by the least D; never above min(D)."""
    minimum = np.min(distance)
    return float(minimum - np.log(np.sum(np.exp(-alpha * (distance - minimum)))) / alpha)


@dataclass(frozen=True)
class SmoothMinimum:
    """How rods' distances become one smooth distance.

    Attributes:
        alpha_0: least sharpness, 1/m.
        rule: how alpha is raised. "half-clearance" (by `SHARPER` a time, until the underestimate
            log(sum) / alpha is at most half the true clearance), or "stepped", the paper's: by a tenth of
            alpha_0 a time, until the smooth distance exceeds R, without which there is no logarithm.
        cutoff: contacts that weigh less than this part of the heaviest one of their group have no part in
            the sparse Hessian (the paper's sparsifying cutoff).
    """

    alpha_0: float
    rule: AlphaRule = "half-clearance"
    cutoff: float = 0.0

    @property
    def curved(self) -> float:
        """Contacts further than this over alpha beyond the nearest have no part in the sparse Hessian."""
        return min(NEGLIGIBLE, -math.log(self.cutoff)) if self.cutoff > 0.0 else NEGLIGIBLE

    def alpha(self, distance: FloatArray, radius: float) -> float:
        """Sharpness (1/m) of a group with distances (n,) m that has to keep `radius`, m.

        Where something touches no sharpness helps: `alpha_0`.
        """
        alpha, minimum = self.alpha_0, float(distance.min())
        steps = 0
        while minimum > radius:
            smooth = smooth_minimum(distance, alpha)
            if self.rule == "stepped":
                if smooth > radius:
                    break
                steps += 1
                alpha = self.alpha_0 * (1.0 + STEP * steps)
            else:
                if minimum - smooth <= 0.5 * (minimum - radius):
                    break
                alpha *= SHARPER
        return alpha

    def sharpened(
        self, kept: FloatArray, contacts: ContactList, distance: FloatArray, radius: FloatArray
    ) -> FloatArray:
        """`kept` sharpness by key (1/m), chosen where it is nan and the group has contacts.

        Args:
            distance: (C,) m, of all contacts that weigh.
            radius: by key, m.
        """
        result = kept.copy()
        for g in np.flatnonzero(np.isnan(kept[contacts.keys])).tolist():
            key = contacts.keys[g]
            members = distance[contacts.starts[g] : contacts.starts[g + 1]]
            result[key] = self.alpha(members, float(radius[key]))
        return result


def weighing_reach(
    num_contacts: FloatArray, alpha: FloatArray, negligible: float = NEGLIGIBLE
) -> FloatArray:
    """How much further than where its barrier begins a contact still weighs in a smooth minimum, m.

    The minimum of n distances is underestimated by up to log(n) / alpha, and contacts weigh up to
    `negligible` / alpha beyond the nearest.
    """
    reach: FloatArray = (np.log(np.maximum(num_contacts, 1.0)) + negligible) / alpha
    return reach
