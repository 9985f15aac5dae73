"""What agents pay at least for getting out of each other's way, wherever they do it.

Let agents of stiffness k_i (K^K m) move over the same time D, and eta_i be how far each is off an even pace
on the straight line; it is 0 at both ends. Then each pays k_i / 2 int |eta_i'|^2 more than on the line, and

    sum_i k_i |eta_i'|^2 >= sum_{i < j} k_i k_j / M |eta_i' - eta_j'|^2,   M = sum_i k_i,

by the parallel axis theorem. The motion of j as i sees it has to go round a disc of radius R. Where both are
there all the time it is no shorter than the shortest way L round that, and l is the straight one:

    1/2 int |eta_i' - eta_j'|^2 >= (L^2 - l^2) / (2 D).

Where one vanishes when it arrives, one instant t is looked at: if both are still there, they are R apart,
where straight they would be d(t), so that the integral is at least (R - d)^2 D / (t (D - t)). If agent i has
gone before, it has hurried, and pays k_i l_i^2 / 2 (1 / t - 1 / D) more. So its pairs count up to that only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray

# Instants at which agents that vanish are looked at, as shares of their time.
INSTANTS = np.linspace(0.02, 0.98, 49)
# More agents than this are not grouped.
MOST = 400


@dataclass(frozen=True)
class Movers:
    """Agents that move over the same time, as arrays (n,).

    Attributes:
        starts, goals: (n, 2) m.
        stiffness: K^K m, kg.
        vanishes: whether it is gone after its arrival.
        distance: (n, n) how far pairs keep apart, m; 0 where they need not.
        duration: D, s.
    """

    starts: FloatArray
    goals: FloatArray
    stiffness: FloatArray
    vanishes: BoolArray
    distance: FloatArray
    duration: float

    @property
    def straight(self) -> FloatArray:
        """(n,) what each pays on its straight line, J s."""
        return 0.5 * self.stiffness * ((self.goals - self.starts) ** 2).sum(axis=1) / self.duration


def evading_groups(movers: Movers) -> list[tuple[IntArray, float]]:
    """Disjoint groups, and what each pays at least beyond what all its members pay on straight lines, J s.

    Groups are merged as long as that adds up to more.
    """
    if not 2 <= len(movers.stiffness) <= MOST:
        return []
    added, instants = _pair_costs(movers)
    weight = movers.stiffness[:, None] * movers.stiffness[None, :] * added
    groups = [[a] for a in range(len(weight))]
    within, masses, between = np.zeros(len(weight)), movers.stiffness.copy(), weight.copy()
    while True:
        worth = within / masses
        gain = (within[:, None] + within[None, :] + between) / (masses[:, None] + masses[None, :])
        gain = np.where(between > 0.0, gain - worth[:, None] - worth[None, :], 0.0)
        np.fill_diagonal(gain, 0.0)
        a, b = sorted(np.unravel_index(int(gain.argmax()), gain.shape))
        if gain[a, b] <= 1e-12 * max(float(worth.sum()), 1e-300):
            break
        groups[a] += groups[b]
        groups[b] = []
        within[a] += within[b] + between[a, b]
        masses[a] += masses[b]
        between[a] += between[b]
        between[:, a] = between[a]
        between[a, a] = between[b] = between[:, b] = 0.0
        within[b] = 0.0
    found = [np.array(sorted(group)) for group in groups if len(group) > 1]
    return [(group, _worth(movers, group, weight, instants)) for group in found]


def _worth(movers: Movers, group: IntArray, weight: FloatArray, instants: FloatArray) -> float:
    """What a group adds, those who vanish being worth no more than it costs them to hurry."""
    shares = weight[np.ix_(group, group)] / movers.stiffness[group].sum()
    hurried = movers.straight[group] * (1.0 / instants[np.ix_(group, group)].max(axis=1) - 1.0)
    over = np.where(movers.vanishes[group], np.maximum(shares.sum(axis=1) - hurried, 0.0), 0.0)
    return float(0.5 * shares.sum() - over.sum())


def _pair_costs(movers: Movers) -> tuple[FloatArray, FloatArray]:
    """(n, n) least costs per stiffness that evading adds to relative motion; shares of time they are from."""
    begin = movers.starts[None, :] - movers.starts[:, None]
    end = movers.goals[None, :] - movers.goals[:, None]
    radius, duration = movers.distance, movers.duration
    straight = np.sqrt(((end - begin) ** 2).sum(axis=-1))
    longer = np.maximum(_way_round(begin, end, radius) ** 2 - straight**2, 0.0)
    fixed = ~(movers.vanishes[:, None] | movers.vanishes[None, :])
    added = np.where(fixed, longer / (2.0 * duration), 0.0)
    instants = np.zeros_like(added)
    for share in INSTANTS:
        gap = np.sqrt(((begin + share * (end - begin)) ** 2).sum(axis=-1))
        own = 0.5 * np.maximum(radius - gap, 0.0) ** 2 / (duration * share * (1.0 - share))
        better = (own > added) & ~fixed
        added, instants = np.where(better, own, added), np.where(better, share, instants)
    np.fill_diagonal(added, 0.0)
    return added, np.maximum(instants, INSTANTS[0])


def _way_round(begin: FloatArray, end: FloatArray, radius: FloatArray) -> FloatArray:
    """(n, n) lengths of the shortest ways from `begin` to `end` (n, n, 2) around discs about the origin."""
    near, far = np.sqrt((begin**2).sum(axis=-1)), np.sqrt((end**2).sum(axis=-1))
    step = end - begin
    length = np.sqrt((step**2).sum(axis=-1))
    share = np.clip(-(begin * step).sum(axis=-1) / np.maximum(length**2, 1e-300), 0.0, 1.0)
    gap = np.sqrt(((begin + share[..., None] * step) ** 2).sum(axis=-1))
    inside = (gap < radius) & (near > radius) & (far > radius)
    r, a, b = (
        np.where(inside, own, default) for own, default in ((radius, 1.0), (near, 2.0), (far, 2.0))
    )
    angle = np.abs(
        np.arctan2(
            begin[..., 0] * end[..., 1] - begin[..., 1] * end[..., 0], (begin * end).sum(axis=-1)
        )
    )
    arc = np.maximum(angle - np.arccos(r / a) - np.arccos(r / b), 0.0)
    return np.where(inside, np.sqrt(a**2 - r**2) + np.sqrt(b**2 - r**2) + r * arc, length)
