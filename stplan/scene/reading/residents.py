"""Who starts in which place of a file, and who may end there: agents that `pairs` mean by their places."""

from __future__ import annotations

from collections.abc import Sequence

from stplan.scene.format.agents import AgentFile
from stplan.scene.format.moving_goals import MovingGoalFile
from stplan.scene.format.places import GoalPlaceFile, PlacedAgentsFile, StartPlaceFile
from stplan.scene.reading.faults import Hints
from stplan.scene.reading.patterns import Listed
from stplan.scene.reading.places import Places
from stplan.schema.mapping import Fault


class Residents:
    """The agents of the places of a file, by the names that their starts and goals call them by."""

    def __init__(self, listed: Sequence[Listed], places: Places) -> None:
        self._places = places
        self._starting: dict[str, list[int]] = {}
        self._ending: dict[str, list[int]] = {}
        for a, one in enumerate(listed):
            if one.agent is None:
                continue
            for name in _start_names(one.agent):
                self._starting.setdefault(name, []).append(a)
            for name in dict.fromkeys(_goal_names(one.agent)):
                self._ending.setdefault(name, []).append(a)

    def of(
        self, side: PlacedAgentsFile, path: str, all_known: bool, faults: list[Fault], hints: Hints
    ) -> tuple[int, ...]:
        """Indices of the agents that a side of a pair means, empty with new faults.

        Args:
            all_known: whether every agent could be read, so that a place of nobody is a fault.
        """
        if side.start is None and side.goal is None:
            faults.append((path, "has neither start nor goal; the name of a place is expected"))
            return ()
        found: list[list[int]] = []
        for key, name, agents, verb in (
            ("start", side.start, self._starting, "starts"),
            ("goal", side.goal, self._ending, "ends"),
        ):
            if name is None:
                continue
            known = self._places.named(name, f"{path}.{key}", faults, hints) is not None
            if known and all_known and name not in agents:
                text = f"is '{name}', where no agent {verb}; a place of agents is expected"
                faults.append((f"{path}.{key}", text))
            found.append(agents.get(name, []))
        both = set(found[0]).intersection(*found[1:])
        if not both and all_known and all(found):
            faults.append((path, "is no agent: nobody starts and ends so"))
        return tuple(sorted(both))


def _start_names(agent: AgentFile) -> list[str]:
    if isinstance(agent.start, StartPlaceFile) and agent.start.place is not None:
        return [agent.start.place]
    return []


def _goal_names(agent: AgentFile) -> list[str]:
    if isinstance(agent.goal, MovingGoalFile):
        return list(agent.goal.places or [])
    if not isinstance(agent.goal, GoalPlaceFile):
        return []
    if agent.goal.place is not None:
        return [agent.goal.place]
    return list(agent.goal.any or [])
