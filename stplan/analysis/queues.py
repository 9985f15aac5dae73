"""What agents pay at least that pass a narrow gate one after another.

Let n agents pass a gate at the instants tau_1 < ... < tau_n, each at any one of its passages. When another
one passes, the centre of agent i is at least s_i from where it passes itself (`least_asides`). So between the
passages e before and f after its own it covers at least 2 s_i, before f at least its way to the gate and
s_i more, from e on at least s_i and its way on from the gate. By Cauchy and Schwarz it pays at least

    C_i(e, f) = k / 2 min x^2 / (e - t_0) + m^2 / (f - e) + z^2 / (T - f)   subject to
    m >= 2 s,   x + m >= before + s,   m + z >= s + after,   x + m + z >= whole;

the first and the last agent, too, with instants at which they have s_i to go to the gate, or came so far,
for e and f. Every instant lies between the e and f of at most two agents. So for any price lambda(t) >= 0

    sum of costs >= sum_i min_{e < f} [C_i(e, f) + 1/2 int_e^f lambda] - int lambda,

whoever goes first. Prices are sought that make the right hand side large; it is a bound for any of them.
Multipliers of the constraints bound C_i from below by a function that is linear in e and f, so that minima
over cells of a grid of instants are found without a gap.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from stplan.analysis.gates import HAIR, Gate
from stplan.arrays import BoolArray, FloatArray, IntArray

# Cells of the grid of instants: fewer where many agents would have more pairs of cells than so many.
CELLS, FEWEST_CELLS, MOST_PAIRS = 96, 24, 120_000
# Sweeps over the multipliers of one cell, and steps of the prices.
SWEEPS, STEPS = 30, 100
# Which parts of a way (before e, between e and f, after f) the four constraints are about.
PARTS = ((1,), (0, 1), (1, 2), (0, 1, 2))
# Durations at least, s: multipliers of shorter ones would be without bounds.
SHORTEST = 1e-9
# Where in their cells (shares) functions may touch C_i: the one that is highest on all of both cells counts.
TOUCH = ((0.5, 0.5), (0.0, 1.0))
# Minima are softened by shares of what one pays alone, less and less; prices move by so many of them.
SOFTEST, HARDEST, STRIDE = 0.1, 0.0003, 2.0


@dataclass(frozen=True)
class Passers:
    """Agents that pass a gate, as arrays (n,): what they pay is stiffness * length^2 / duration.

    Attributes:
        stiffness: kg.
        begin, end: when they start and have arrived at the latest, s.
        aside: s_i, m.
        before, after, whole: lower bounds of their ways, m.
    """

    stiffness: FloatArray
    begin: FloatArray
    end: FloatArray
    aside: FloatArray
    before: FloatArray
    after: FloatArray
    whole: FloatArray

    def only(self, kept: BoolArray) -> Passers:
        """The same for the agents that are `kept` (n,)."""
        return Passers(*(getattr(self, field.name)[kept] for field in fields(self)))

    @property
    def alone(self) -> FloatArray:
        """(n,) what each pays at least if it is alone."""
        return self.stiffness * self.whole**2 / (self.end - self.begin)


def hurried(passers: Passers, length: FloatArray, duration: FloatArray) -> FloatArray:
    """(n, P) J s, what all pay that cover `length` (n, 1) in `duration` (n, P) at one end of their way."""
    whole, span = passers.whole[:, None], (passers.end - passers.begin)[:, None]
    share = np.clip(duration / span, SHORTEST, 1.0 - SHORTEST)
    near = np.maximum(length, whole * share)
    work = near**2 / share + np.maximum(whole - near, 0.0) ** 2 / (1.0 - share)
    return passers.stiffness[:, None] * work / span


def least_asides(gate: Gate, radii: FloatArray, distance: FloatArray) -> FloatArray:
    """(n,) how far from `gate` each agent is at least when another one passes it, m; 0 where that is unknown.

    With the nearer end of the gate at y = 0 and the passing agent at y_i on it, the other one at p keeps r_j
    from that end and R from (0, y_i). Nearest to its own part of the gate, y >= r_j, it is beside it, at
    sqrt(R^2 - (y - y_i)^2), or before its end, where both discs touch p.

    Args:
        radii: (n,) m.
        distance: (n, n) R, m.
    """
    mine, others = radii[:, None], radii[None, :]
    furthest = gate.width - others
    spread = np.maximum(gate.width - mine - others, 0.0)
    beside = np.sqrt(np.maximum(distance**2 - spread**2, 0.0))
    height = (mine**2 + furthest**2 - distance**2) / (2.0 * furthest)
    before = np.sqrt(np.maximum(2.0 * mine * (mine - height), 0.0))
    asides = np.where(distance > spread, np.minimum(beside, before), 0.0)
    np.fill_diagonal(asides, np.inf)
    nearest = asides.min(axis=1) - 2.0 * HAIR * radii
    return np.clip(nearest, 0.0, np.minimum(gate.before, gate.after))


def queue_bound(passers: Passers) -> float:
    """What `passers`, all of which keep clear of each other, pay at least together, J s."""
    cells = int(np.clip(np.sqrt(MOST_PAIRS / len(passers.whole)), FEWEST_CELLS, CELLS))
    pieces = _Pieces.of(passers, cells)
    prices = np.zeros(cells)
    best = pieces.bound(prices)
    # A share of what all pay alone, spread over the cells: the size of prices.
    mean = float(passers.alone.sum()) / cells / pieces.width
    momentum = prices
    for step in range(STEPS):
        softness = SOFTEST * (HARDEST / SOFTEST) ** (step / STEPS)
        slope = pieces.slope(momentum, softness * float(passers.alone.mean()))
        moved = np.maximum(momentum + STRIDE * softness * mean * slope, 0.0)
        momentum = np.maximum(moved + step / (step + 3.0) * (moved - prices), 0.0)
        prices = moved
        best = max(best, pieces.bound(prices))
    return best


@dataclass(frozen=True)
class _Pieces:
    """Functions below C_i on pairs of cells (c, d), c <= d, that e and f lie in: each linear in e and f.

    Attributes:
        width: of a cell, s.
        first, last: (P,) c and d.
        at: (n, P, 2) where in the cells, in widths from their begins, functions touch C_i.
        value: (n, P) there, J s; inf where e and f cannot be.
        slopes: (n, P, 2) by e and by f, J.
        least: (n, P) of C_i on all of both cells, J s.
        whole: (n, P) whether the agent is there all the time of both cells.
    """

    width: float
    first: IntArray
    last: IntArray
    at: FloatArray
    value: FloatArray
    slopes: FloatArray
    least: FloatArray
    whole: BoolArray

    @staticmethod
    def of(passers: Passers, cells: int) -> _Pieces:
        """On `cells` cells of the time from the first start to the last arrival."""
        edges = np.linspace(float(passers.begin.min()), float(passers.end.max()), cells + 1)
        width = float(edges[1] - edges[0])
        first, last = np.triu_indices(cells)
        begin, end = passers.begin[:, None], passers.end[:, None]
        lows = [np.clip(edges[cell], begin, end) for cell in (first, last)]
        highs = [np.clip(edges[cell + 1], begin, end) for cell in (first, last)]
        lowest = np.full((len(begin), len(first)), -np.inf)
        value, slopes, at = lowest, np.zeros((*lowest.shape, 2)), np.zeros((*lowest.shape, 2))
        for spot in TOUCH:
            touch = [
                low + share * (high - low)
                for share, low, high in zip(spot, lows, highs, strict=True)
            ]
            there, tilts = _least(passers, *touch)
            low = there + sum(
                np.minimum(tilt * (begun - own), tilt * (ended - own))
                for tilt, begun, ended, own in zip(tilts, lows, highs, touch, strict=True)
            )
            better = low > lowest
            lowest, value = np.where(better, low, lowest), np.where(better, there, value)
            slopes = np.where(better[..., None], np.stack(tilts, axis=-1), slopes)
            at = np.where(better[..., None], spot, at)
        impossible = (highs[1] <= begin) | (lows[0] >= end)
        before, after = passers.before + passers.aside, passers.aside + passers.after
        for length, duration in ((before, highs[1] - begin), (after, end - lows[0])):
            lowest = np.maximum(lowest, hurried(passers, length[:, None], duration))
        least = np.where(impossible, np.inf, lowest)
        value = np.where(impossible, np.inf, value)
        whole = (lows[0] == edges[first]) & (highs[1] == edges[last + 1])
        return _Pieces(width, first, last, at, value, slopes, least, whole)

    def bound(self, prices: FloatArray) -> float:
        """The right hand side for `prices` (c,), J."""
        spent = np.append(0.0, self.width * np.cumsum(prices))
        inner = np.maximum(spent[self.last] - spent[self.first + 1], 0.0)
        lowest = self.least + 0.5 * inner
        turns = np.stack([-prices[self.first], prices[self.last]], axis=-1)
        tilts = self.slopes + 0.5 * turns
        falls = self.width * np.minimum(-self.at * tilts, (1.0 - self.at) * tilts).sum(axis=-1)
        sharp = np.where(self.whole, self._priced(prices) + falls, -np.inf)
        return float(np.maximum(lowest, sharp).min(axis=1).sum() - self.width * prices.sum())

    def slope(self, prices: FloatArray, softness: float) -> FloatArray:
        """(c,) by how much it grows with prices, minima softened by so much (J s); in widths of a cell."""
        priced = self._priced(prices)
        shares = np.exp((priced.min(axis=1, keepdims=True) - priced) / softness)
        shares /= shares.sum(axis=1, keepdims=True)
        mass = shares.sum(axis=0)
        cells = len(prices)
        begun = np.bincount(self.first, mass, cells)
        ended = np.bincount(self.last, mass, cells)
        covered = np.cumsum(begun) - np.cumsum(ended) + 0.5 * (ended - begun)
        return 0.5 * covered - 1.0

    def _priced(self, prices: FloatArray) -> FloatArray:
        """(n, P) costs and prices where functions touch."""
        spent = np.append(0.0, self.width * np.cumsum(prices))
        begun = spent[self.first] + self.at[..., 0] * self.width * prices[self.first]
        ended = spent[self.last] + self.at[..., 1] * self.width * prices[self.last]
        return self.value + 0.5 * (ended - begun)


def _least(
    passers: Passers, first: FloatArray, last: FloatArray
) -> tuple[FloatArray, list[FloatArray]]:
    """C_i (n, P) at e = `first` and f = `last` (n, P), from multipliers, and its slopes by e and by f.

    The multipliers of the constraints are improved one by one; those of any sweep give a bound.
    """
    spans = [
        first - passers.begin[:, None],
        np.maximum(last - first, SHORTEST),
        passers.end[:, None] - last,
    ]
    before, after = passers.before + passers.aside, passers.aside + passers.after
    asked = [own[:, None] for own in (2.0 * passers.aside, before, after, passers.whole)]
    # Sums of the multipliers of all constraints that a part of the way is in.
    rates = [np.zeros_like(first) for _ in spans]
    value = np.zeros_like(first)
    multipliers = [np.zeros_like(first) for _ in asked]
    # What is asked of the whole way comes first.
    for _ in range(SWEEPS):
        for i in reversed(range(len(asked))):
            own = PARTS[i]
            span = sum(spans[part] for part in own)
            covered = sum(rates[part] * spans[part] for part in own)
            step = (2.0 * asked[i] - covered) / np.maximum(span, SHORTEST)
            step = np.maximum(step, -multipliers[i])
            multipliers[i] = multipliers[i] + step
            for part in own:
                rates[part] = rates[part] + step
    for multiplier, length in zip(multipliers, asked, strict=True):
        value = value + multiplier * length
    for rate, span in zip(rates, spans, strict=True):
        value = value - 0.25 * rate**2 * span
    stiffness = passers.stiffness[:, None]
    x, m, z = rates
    slopes = [0.25 * stiffness * (m**2 - x**2), 0.25 * stiffness * (z**2 - m**2)]
    return stiffness * value, slopes
