"""What every seeder is given and what it gives back.

A seeder belongs to one problem and works out once what random numbers do not change (roadmaps, shortest
ways), so that it can be asked again and again with other random numbers.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Protocol

from stplan.arrays import FloatArray
from stplan.callbacks import Progress, unheard
from stplan.compiled import working_time
from stplan.reasons import Reason


@dataclass(frozen=True)
class Budget:
    """What one attempt may use.

    Attributes:
        rng_seed: of all random numbers.
        deadline: `working_time` (s) after which nothing is begun any more.
        progress: is told a line now and then.
    """

    rng_seed: int = 0
    deadline: float = float("inf")
    progress: Progress = unheard

    def spent(self) -> bool:
        """Whether the deadline has passed."""
        return working_time() > self.deadline


@dataclass(frozen=True)
class SeedRecord:
    """Repeatable figures of a seed, for the report; None where there is nothing to count.

    Attributes:
        sweeps: of the relaxation.
        retensions: how often stuck bands were pulled tight again.
        margin: times R and r that search kept.
        tries: orders, nodes and neighbourhoods that search tried.
        starts: seeds found from different random numbers, of which this is the cheapest.
        start: which of them it is, from 1.
    """

    sweeps: int | None = None
    retensions: int | None = None
    margin: float | None = None
    tries: int | None = None
    starts: int | None = None
    start: int | None = None

    def as_dict(self) -> dict[str, float]:
        """What was counted, by name."""
        known = ((one.name, getattr(self, one.name)) for one in fields(self))
        return {name: value for name, value in known if value is not None}


@dataclass(frozen=True)
class SeedAttempt:
    """What came of one attempt.

    Attributes:
        found_by: the method, and what part of it.
        curves: one (n, 3) curve an agent, the best there were; empty where there were none at all.
        clear: whether they are proven clear.
        record: what it took.
        touching: pairs of agents a < b that touch in the best curves.
        reasons: why they are not clear.
        jammed: whether it was given up because there is no room to part them all.
    """

    found_by: str
    curves: list[FloatArray] = field(default_factory=list)
    clear: bool = False
    record: SeedRecord = field(default_factory=SeedRecord)
    touching: tuple[tuple[int, int], ...] = ()
    reasons: tuple[Reason, ...] = ()
    jammed: bool = False

    @property
    def tries(self) -> int:
        """How much search tried."""
        return self.record.tries or 0

    def counting(self, tries: int) -> SeedAttempt:
        """The same with so many tries on its record."""
        return replace(self, record=replace(self.record, tries=tries))


class Seeder(Protocol):
    """A way to find clear initial curves of one problem."""

    def attempt(self, budget: Budget) -> SeedAttempt:
        """Clear curves, or why there are none."""
        ...
