"""What limits of speed, of acceleration and of a meeting's distance share: |w| <= limit.

w is a vector in the plane that depends on a few knots (a velocity, a change of it, a distance of two
agents). With f = |w|^2 / limit^2 a limit enters the objective in one of two ways:

    barrier   mu w b(1 - f), the barrier of `contacts.barrier`, undefined from f = 1 on, with a weight w that
              keeps the sum from growing with the number of knots;
    penalty   w (sqrt(f) - aim)^2 where sqrt(f) > aim, defined everywhere: it leads curves that break
              a limit to where the barrier can take over.

Derivatives: with J = dw and K_k = ddw_k,  df = 2 J^T w / limit^2,  ddf = 2 (J^T J + sum w_k K_k) / limit^2,
and those of phi(f) follow. phi' >= 0 and phi'' >= 0, so leaving out K gives a positive semidefinite
stand-in, which penalties use.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, cast

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import kernel
from stplan.costs.blocks import joined_structure, pack_blocks
from stplan.costs.contacts.barrier import barrier
from stplan.costs.contacts.shares import segment_shares
from stplan.costs.formulation import TermSetup
from stplan.nlp.term import Capability, Structure, Term
from stplan.problem.layout import KnotLayout

# Feasibility is restored where every limit is kept to this share.
CONTENT = 0.98


@dataclass(frozen=True)
class LimitBarrier:
    """mu b(1 - f), felt where 1 - f < `reach`."""

    mu: float
    reach: float = 0.25


@dataclass(frozen=True)
class LimitPenalty:
    """weight (sqrt(f) - aim)^2 where sqrt(f) > `aim`."""

    weight: float
    aim: float = 0.93


Profile = LimitBarrier | LimitPenalty


def limit_profile(setup: TermSetup) -> Profile:
    """How limits enter a program."""
    if setup.penalties is None:
        return LimitBarrier(setup.mu)
    return LimitPenalty(setup.penalties.limit)


@dataclass(frozen=True)
class Vectors:
    """w (N, 2), its first (N, 2, V) and second (N, 2, V, V) derivatives by a stencil's V variables."""

    value: FloatArray
    first: FloatArray
    second: FloatArray


class Limiting(Term, Protocol):
    """A term with `Capability.LIMIT`: it can say whether what it limits is kept."""

    def is_kept(self, knots: FloatArray) -> bool:
        """Whether everything is kept with a little to spare."""
        ...

    def state(self, knots: FloatArray) -> str:
        """How far it is kept, in words."""
        ...


def limits_among(terms: Sequence[Term]) -> list[Limiting]:
    """The terms that limit."""
    return [cast(Limiting, term) for term in terms if Capability.LIMIT in term.capabilities]


def limit_weights(layout: KnotLayout, weights: FloatArray | None) -> FloatArray:
    """(A,) of sums over an agent's segments, given `weights` (A,) of agents (None: all alike)."""
    shares = segment_shares(layout.num_segments)
    return shares if weights is None else weights * shares


class MotionLimit(Term):
    """Keeps N vectors below their limits.

    Args:
        stencils: (N, K) knots each vector depends on, increasing.
        limits: (N,) in the unit of the vectors.
        profile: how the limit enters.
        num_knots: M.
        weights: (N,) w, 1 by default.
    """

    capabilities = Capability.LIMIT | Capability.RESTORING

    def __init__(
        self,
        stencils: IntArray,
        limits: FloatArray,
        profile: Profile,
        num_knots: int,
        weights: FloatArray | None = None,
    ) -> None:
        self._stencils = stencils
        self._limits = limits
        self._profile = profile
        self._num_knots = num_knots
        self._weights = np.ones(len(limits)) if weights is None else weights

    @property
    def stencils(self) -> IntArray:
        """(N, K) knots that each vector depends on."""
        return self._stencils

    @abstractmethod
    def vectors(self, local: FloatArray) -> Vectors:
        """The vectors at `local` (N, K, 3), the knots of every stencil."""

    def _vectors(self, knots: FloatArray) -> Vectors:
        return self.vectors(knots[self._stencils])

    def shares(self, knots: FloatArray) -> FloatArray:
        """(N,) |w| over its limit."""
        return np.hypot(*self._vectors(knots).value.T) / self._limits

    def leaves_slack(self, start: FloatArray, end: FloatArray, share: float) -> bool:
        """Whether every 1 - f at `end` is at least a `share` of that at `start`; penalties always do."""
        if isinstance(self._profile, LimitPenalty):
            return True
        before, after = (1.0 - self.shares(knots) ** 2 for knots in (start, end))
        return bool((after >= share * before).all())

    def is_kept(self, knots: FloatArray) -> bool:
        """Whether every limit is kept with a little to spare."""
        return bool((self.shares(knots) <= CONTENT).all())

    def state(self, knots: FloatArray) -> str:
        """How far the limits are kept, in words."""
        return f"{self.name} {100 * float(self.shares(knots).max(initial=0.0)):.0f} %"

    def _profiled(self, squared: FloatArray) -> FloatArray:
        """(3, N) phi, phi', phi'' at f."""
        result = np.zeros((3, len(squared)))
        if isinstance(self._profile, LimitBarrier):
            _barriers(squared, self._profile.mu * self._weights, self._profile.reach, result)
            return result
        weight, aim = self._profile.weight * self._weights, self._profile.aim
        share = np.sqrt(squared)
        over = share > aim
        result[0, over] = weight[over] * (share[over] - aim) ** 2
        result[1, over] = weight[over] * (1.0 - aim / share[over])
        result[2, over] = 0.5 * weight[over] * aim / share[over] ** 3
        return result

    def value(self, knots: FloatArray) -> float:
        """The cost, inf where a barrier's limit is reached."""
        squared = self.shares(knots) ** 2
        if isinstance(self._profile, LimitBarrier) and (squared >= 1.0).any():
            return np.inf
        return float(self._profiled(squared)[0].sum())

    def gradient(self, knots: FloatArray) -> FloatArray:
        """(M, 3)."""
        vectors = self._vectors(knots)
        squared = (vectors.value**2).sum(axis=1) / self._limits**2
        slope = 2.0 * self._profiled(squared)[1] / self._limits**2
        own = slope[:, None] * np.einsum("nk,nkv->nv", vectors.value, vectors.first)
        result = np.zeros((self._num_knots, 3))
        np.add.at(result, self._stencils, own.reshape(*self._stencils.shape, 3))
        return result

    def hessian_structure(self) -> Structure:
        """Blocks among the knots of every stencil."""
        return joined_structure(
            [(self._stencils[:, i], self._stencils[:, j]) for i, j in self._pairs()]
        )

    def hessian(self, knots: FloatArray) -> FloatArray:
        """Exact second derivatives in the order of the structure."""
        return self._second(knots, exact=True, convex=False)

    def gauss_newton_structure(self) -> Structure:
        """That of the Hessian."""
        return self.hessian_structure()

    def gauss_newton_hessian(self, knots: FloatArray) -> FloatArray:
        """A positive semidefinite one: of barriers the convex part of the exact one, see `convex_part`.

        Without the curvature of the vectors steps along a limit are far longer than the Hessian holds true;
        with all of it the solver has to regularise everything else for it, and creeps.
        """
        return self._second(knots, exact=isinstance(self._profile, LimitBarrier), convex=True)

    def _pairs(self) -> list[tuple[int, int]]:
        count = self._stencils.shape[1]
        return [(i, j) for i in range(count) for j in range(i + 1)]

    def _second(self, knots: FloatArray, *, exact: bool, convex: bool) -> FloatArray:
        vectors = self._vectors(knots)
        scale = 2.0 / self._limits**2
        _, slope, curvature = self._profiled((vectors.value**2).sum(axis=1) / self._limits**2)
        by_f = scale[:, None] * np.einsum("nk,nkv->nv", vectors.value, vectors.first)
        bent = np.einsum("nkv,nkw->nvw", vectors.first, vectors.first)
        if exact:
            bent += np.einsum("nk,nkvw->nvw", vectors.value, vectors.second)
        whole = (slope * scale)[:, None, None] * bent
        whole += curvature[:, None, None] * by_f[:, :, None] * by_f[:, None, :]
        if exact and convex:
            felt = np.flatnonzero(slope > 0.0)
            whole[felt] = convex_part(whole[felt])
        return np.concatenate(
            [
                pack_blocks(whole[:, 3 * i : 3 * i + 3, 3 * j : 3 * j + 3], diagonal=i == j)
                for i, j in self._pairs()
            ]
        )


@kernel
def _barriers(squared: FloatArray, weights: FloatArray, reach: float, result: FloatArray) -> None:
    for k in range(len(squared)):
        value, first, second = barrier(1.0 - squared[k], reach)
        result[0, k] = weights[k] * value
        result[1, k] = -weights[k] * first
        result[2, k] = weights[k] * second


def convex_part(blocks: FloatArray) -> FloatArray:
    """Symmetric `blocks` (N, V, V) without their negative eigenvalues."""
    values, vectors = np.linalg.eigh(blocks)
    part: FloatArray = (vectors * np.maximum(values, 0.0)[:, None, :]) @ vectors.swapaxes(1, 2)
    return part


def by_knots(first: FloatArray, second: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Derivatives by segments (N, 2, 3 S) and (N, 2, 3 S, 3 S) -> by the S + 1 knots they join."""
    segments = first.shape[2] // 3
    ahead, behind = np.eye(segments, segments + 1, 1), np.eye(segments, segments + 1)
    difference = np.kron(ahead - behind, np.eye(3))
    return first @ difference, difference.T @ second @ difference


def power_vectors(step: FloatArray, duration: FloatArray, factor: float, power: int) -> Vectors:
    """w = factor dx / h^power of segments `step` dx (N, 2) in m and `duration` h (N,) in s.

    With p the power:  dw/d(dx) = factor / h^p,  dw/dh = -p w / h,
    ddw/(d(dx) dh) = -p factor / h^(p+1),  ddw/dh^2 = p (p + 1) w / h^2.
    """
    count = len(duration)
    first = np.zeros((count, 2, 3))
    second = np.zeros((count, 2, 3, 3))
    base = factor * duration**-power
    for k in range(2):
        first[:, k, k] = base
        first[:, k, 2] = -power * base * step[:, k] / duration
        second[:, k, k, 2] = second[:, k, 2, k] = -power * base / duration
        second[:, k, 2, 2] = power * (power + 1) * base * step[:, k] / duration**2
    return Vectors(base[:, None] * step, *by_knots(first, second))
