"""The tightest spot of a pair of agents, or of an agent and the walls."""

from __future__ import annotations

from dataclasses import dataclass

from stplan.amounts import amount, place


@dataclass(frozen=True)
class Tightest:
    """A smallest clearance: of whom, how much (m), when (s) and where (m)."""

    who: tuple[str, ...]
    clearance: float
    time: float
    place: tuple[float, float]

    def __str__(self) -> str:
        """In words."""
        return (
            f"{' and '.join(self.who)}: {amount(self.clearance)} m at t = {amount(self.time)} s, "
            f"{place(*self.place)}"
        )


@dataclass(frozen=True)
class Unlisted:
    """Pairs that are not listed one by one: how many, and what clearance (m) all of them exceed."""

    pairs: int
    clearance: float
