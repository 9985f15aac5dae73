"""How the verdicts of two runs differ: status, certificate, what is demanded, clearances."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from stplan.files.recorded import RecordedReport


@dataclass(frozen=True)
class Change:
    """Something that reads otherwise in the second report; None where it is missing there.

    Attributes:
        subject: what changed, as in ``status`` or ``clearance of sam and ann``.
        first, second: the two values; clearances in m.
    """

    subject: str
    first: bool | float | str | None
    second: bool | float | str | None

    def sentence(self) -> str:
        """In words."""
        return f"{self.subject}: {_shown(self.first)} -> {_shown(self.second)}"

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def _shown(value: object) -> str:
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g} m" if isinstance(value, float) else str(value)


def compare_verdicts(
    a: RecordedReport, b: RecordedReport, moved: Mapping[str, float], atol: float, rtol: float
) -> tuple[Change, ...]:
    """What changed from `a` to `b`.

    Clearances follow the trajectories, whose differences are judged by themselves. So a clearance
    counts only where it changed by more than ``atol + rtol * size`` beyond what its agents moved
    at one instant (`moved`, m by agent): then distances or walls of the scene are others.
    """
    changes = []
    if a.status != b.status:
        changes.append(Change("status", a.status, b.status))
    if a.holds != b.holds:
        changes.append(Change("certificate holds", a.holds, b.holds))
    for who in dict.fromkeys((*a.clearances, *b.clearances)):
        first = a.clearance(who, b.clearances.get(who))
        second = b.clearance(who, a.clearances.get(who))
        subject = f"clearance of {' and '.join(who)}" + (" to the walls" if len(who) == 1 else "")
        if first is None or second is None:
            changes.append(Change(subject, first, second))
            continue
        allowed = atol + rtol * max(abs(first), abs(second))
        # An agent without an instant in common differs already.
        allowed += sum(moved.get(name, float("inf")) for name in who)
        if abs(first - second) > allowed:
            changes.append(Change(subject, first, second))
    return tuple(changes)
