"""Who arrives later than preferred."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stplan.explain.explanation import Section
from stplan.explain.waiting import Wait
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene

# Late means by more than this share of the time the agent wanted to take.
LATE = 0.01


@dataclass(frozen=True)
class Late:
    """An agent that arrives after its preferred time (s); `waited` is what its waits cost it."""

    agent: str
    arrival: float
    preferred: float
    waited: float

    def sentence(self) -> str:
        """In words."""
        late = self.arrival - self.preferred
        waited = f"; waiting cost it {self.waited:.2f} s" if self.waited > 0 else ""
        return (
            f"{self.agent} arrives at t = {self.arrival:.2f} s, {late:.2f} s later than "
            f"the {self.preferred:g} s it prefers{waited}"
        )


def lateness(scene: Scene, lines: WorldLines, waits: Sequence[Wait]) -> Section:
    """Late agents, the latest first; `lines` in scene order."""
    title = "Arrivals"
    timed = [
        (a, agent.preferred_time)
        for a, agent in enumerate(scene.agents)
        if agent.preferred_time is not None and agent.path is None
    ]
    if not timed:
        return Section("late", title, "No agent has a preferred time.")
    late = []
    for a, preferred in timed:
        agent, arrival = scene.agents[a], float(lines.curve(a)[-1, 2])
        if arrival - preferred > LATE * (preferred - agent.start_time):
            waited = sum(wait.lost for wait in waits if wait.agent == agent.id)
            late.append(Late(agent.id, arrival, preferred, waited))
    if not late:
        return Section("late", title, f"All {len(timed)} agents with a preferred time keep it.")
    late.sort(key=lambda entry: entry.preferred - entry.arrival)
    lead = f"{len(late)} of {len(timed)} agents with a preferred time are late:"
    return Section("late", title, lead, late)
