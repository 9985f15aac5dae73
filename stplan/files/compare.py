"""Where two sets of trajectories differ, and by how much."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.world_lines import WorldLines


@dataclass(frozen=True)
class Spot:
    """A greatest difference: how much (m or s), at which knot (None: between knots), when (s)."""

    amount: float
    knot: int | None
    time: float


@dataclass(frozen=True)
class AgentDifference:
    """How one agent's curves differ.

    Attributes:
        agent: its id.
        num_knots: in the first and in the second file.
        position: worst distance of knots of one number (m); None where the counts differ.
        time: worst difference of their times (s); None where the counts differ.
        simultaneous: worst distance at one instant (m), exact over all instants common to both;
            None where there are none or a curve runs back in time.
        equal: same number of knots, all within the tolerances.
    """

    agent: str
    num_knots: tuple[int, int]
    position: Spot | None
    time: Spot | None
    simultaneous: Spot | None
    equal: bool

    def sentence(self) -> str:
        """In words, worst first."""
        if self.position is None or self.time is None:
            parts = [f"{self.num_knots[0]} knots against {self.num_knots[1]}"]
        else:
            parts = [
                f"position {self.position.amount:.3g} m at knot {self.position.knot} "
                f"(t = {self.position.time:.6g} s)",
                f"time {self.time.amount:.3g} s at knot {self.time.knot} "
                f"(t = {self.time.time:.6g} s)",
            ]
        if self.simultaneous is None:
            parts.append("no instant in common")
        else:
            spot = self.simultaneous
            parts.append(f"at one instant up to {spot.amount:.3g} m (t = {spot.time:.6g} s)")
        return f"{self.agent}: " + ", ".join(parts)


@dataclass(frozen=True)
class Difference:
    """How two sets of trajectories differ; the first is what was expected.

    Attributes:
        missing: agents of the first only.
        added: agents of the second only.
        reordered: whether the common agents stand in another order.
        agents: the common agents, in the first's order.
    """

    missing: tuple[str, ...]
    added: tuple[str, ...]
    reordered: bool
    agents: tuple[AgentDifference, ...]

    @property
    def equal(self) -> bool:
        """Same agents, same order, same number of knots, all within the tolerances."""
        whole = not (self.missing or self.added or self.reordered)
        return whole and all(agent.equal for agent in self.agents)

    def as_dict(self) -> dict[str, Any]:
        """For JSON: lengths in m, times in s."""
        return {"equal": self.equal, **asdict(self)}

    def lines(self) -> list[str]:
        """A sentence for everything that differs, the worst agent first; one if nothing does."""
        if self.equal:
            return [f"equal: {len(self.agents)} agents"]
        sentences = [f"{name}: only in the first" for name in self.missing]
        sentences += [f"{name}: only in the second" for name in self.added]
        if self.reordered:
            sentences.append("the agents stand in another order")
        different = [agent for agent in self.agents if not agent.equal]
        different.sort(key=_severity, reverse=True)
        return sentences + [agent.sentence() for agent in different]


def compare_trajectories(
    a: WorldLines, b: WorldLines, atol: float = 1e-9, rtol: float = 0.0
) -> Difference:
    """Compare `b` with `a`, agent by agent (matched by id).

    Two knots agree when their distance, and the difference of their times, are at most
    ``atol + rtol * size``, size being the greater distance to the origin or the greater time.
    """
    index = {name: number for number, name in enumerate(b.agent_ids)}
    common = [name for name in a.agent_ids if name in index]
    known = set(a.agent_ids)
    return Difference(
        missing=tuple(name for name in a.agent_ids if name not in index),
        added=tuple(name for name in b.agent_ids if name not in known),
        reordered=common != [name for name in b.agent_ids if name in known],
        agents=tuple(
            _compare_curves(name, curve, b.curve(index[name]), atol, rtol)
            for name, curve in zip(a.agent_ids, a.curves(), strict=True)
            if name in index
        ),
    )


def _compare_curves(
    agent: str, a: FloatArray, b: FloatArray, atol: float, rtol: float
) -> AgentDifference:
    position = time = None
    equal = False
    if len(a) == len(b):
        far = np.hypot(a[:, 0] - b[:, 0], a[:, 1] - b[:, 1])
        late = np.abs(a[:, 2] - b[:, 2])
        size = np.maximum(np.hypot(a[:, 0], a[:, 1]), np.hypot(b[:, 0], b[:, 1]))
        instant = np.maximum(np.abs(a[:, 2]), np.abs(b[:, 2]))
        equal = bool((far <= atol + rtol * size).all() and (late <= atol + rtol * instant).all())
        position, time = _worst_knot(far, a), _worst_knot(late, a)
    return AgentDifference(agent, (len(a), len(b)), position, time, _simultaneous(a, b), equal)


def _worst_knot(amounts: FloatArray, curve: FloatArray) -> Spot:
    knot = int(np.argmax(amounts))
    return Spot(float(amounts[knot]), knot, float(curve[knot, 2]))


def _simultaneous(a: FloatArray, b: FloatArray) -> Spot | None:
    """The difference is linear between two merged knot times, so it peaks at one of them."""
    if (np.diff(a[:, 2]) <= 0).any() or (np.diff(b[:, 2]) <= 0).any():
        return None
    first, last = max(a[0, 2], b[0, 2]), min(a[-1, 2], b[-1, 2])
    if first > last:
        return None
    times = np.unique(np.concatenate([a[:, 2], b[:, 2], [first, last]]))
    times = times[(times >= first) & (times <= last)]
    apart = [
        np.interp(times, a[:, 2], a[:, axis]) - np.interp(times, b[:, 2], b[:, axis])
        for axis in range(2)
    ]
    far = np.hypot(*apart)
    worst = int(np.argmax(far))
    return Spot(float(far[worst]), None, float(times[worst]))


def _severity(agent: AgentDifference) -> tuple[bool, float]:
    amounts = [spot.amount for spot in (agent.position, agent.time, agent.simultaneous) if spot]
    return agent.position is None, max(amounts, default=0.0)
