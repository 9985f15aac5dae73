"""Who arrives how much later than it could: of plans whose arrivals were to be early."""

from __future__ import annotations

import numpy as np

from stplan.analysis.arrival_gap import ArrivalGap
from stplan.explain.explanation import Fact, Section

# Agents that are named, the most delayed first; and the shortest delay (s) that is worth a word.
MOST_NAMED, SHORTEST = 5, 0.01


def arrival_section(gap: ArrivalGap) -> Section:
    """How fast the plan is, and whom the others delay most."""
    delay = gap.arrivals - gap.bound.earliest
    facts = [
        Fact(
            f"{gap.bound.agents[a]} arrives at {gap.arrivals[a]:.2f} s, {delay[a]:.2f} s later than alone"
        )
        for a in np.argsort(-delay, kind="stable")[:MOST_NAMED].tolist()
        if delay[a] >= SHORTEST
    ]
    lead = gap.sentence[0].upper() + gap.sentence[1:]
    return Section("arrivals", "Arrivals", f"{lead}:" if facts else f"{lead}.", facts)
