"""What there is to say of costs: how far a plan can be from the best one, and who pays the difference."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.analysis.cost_bound import CostBound
from stplan.arrays import Point
from stplan.explain.explanation import Fact, Section
from stplan.wording import at, names

# Those are named who pay this share of the difference together, and no more than so many.
NAMED_SHARE, MOST_NAMED = 0.8, 10
# Plans nearer to the least cost than this share leave nothing to explain.
NEGLIGIBLE = 1e-3


@dataclass(frozen=True)
class Payment:
    """What one agent pays, at least, and its share of what all pay beyond their least; J s."""

    agent: str
    cost: float
    least: float
    share: float


@dataclass(frozen=True)
class Conflict:
    """Who is in each other's way, where, and pays how much more at least; J s and m."""

    kind: str
    agents: tuple[str, ...]
    extra: float
    place: Point
    width: float | None


def cost_section(bound: CostBound) -> Section:
    """How far the plan can be from the best one, and who pays the difference, the dearest first."""
    title = "Costs"
    if bound.excess is None:
        return Section("costs", title, "Nobody has to pay anything.")
    lead = (
        f"All agents together pay {bound.cost:.4g} J s, and at least {bound.total:.4g} on any plan"
    )
    if bound.excess < NEGLIGIBLE:
        return Section("costs", title, f"{lead}: there is nothing to gain.")
    facts = [*map(_conflict_fact, conflicts(bound)), *map(_fact, payments(bound))]
    lead += f", so this one is at most {100.0 * bound.excess:.3g} % above the best; who pays the difference:"
    return Section("costs", title, lead, facts)


def conflicts(bound: CostBound) -> list[Conflict]:
    """Who cannot but wait for each other or evade each other, those whom it costs most first."""
    groups = sorted(bound.together, key=lambda group: -group.extra)
    return [
        Conflict(
            group.kind,
            tuple(bound.agents[a] for a in group.agents.tolist()),
            group.extra,
            group.place,
            group.width,
        )
        for group in groups
    ]


def payments(bound: CostBound) -> list[Payment]:
    """Who pays most of what all pay beyond their least."""
    beyond = np.maximum(bound.costs - bound.least, 0.0)
    shares = beyond / max(float(beyond.sum()), 1e-300)
    order = np.argsort(-shares, kind="stable")
    enough = int(np.searchsorted(np.cumsum(shares[order]), NAMED_SHARE)) + 1
    return [
        Payment(bound.agents[a], float(bound.costs[a]), float(bound.least[a]), float(shares[a]))
        for a in order[: min(enough, MOST_NAMED)].tolist()
    ]


def _conflict_fact(conflict: Conflict) -> Fact:
    where = at(conflict.place)
    what = {
        "gate": f"pass {conflict.width or 0.0:.4g} m at {where} one after another",
        "lane": f"are opposed in a lane of {conflict.width or 0.0:.4g} m around {where}",
        "crossing": f"cross each other's ways around {where}",
        "meeting": "have to meet",
    }[conflict.kind]
    return Fact(
        f"{names(conflict.agents)} {what}, for which they pay at least {conflict.extra:.3g} more on any plan",
        conflict,
    )


def _fact(payment: Payment) -> Fact:
    more = payment.cost - payment.least
    return Fact(
        f"{payment.agent} pays {payment.cost:.4g}, {more:.3g} more than alone "
        f"({payment.share:.0%} of the difference)",
        payment,
    )
