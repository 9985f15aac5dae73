"""What seeders share: the record of what it took to find curves."""

from __future__ import annotations

from dataclasses import dataclass, fields


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
