"""Tasks: points that robots are sent to, one after another, with something to do there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from stplan.arrays import Point

# Plans reach so far ahead, s.
WINDOW = 10.0


@dataclass(frozen=True)
class RobotTask:
    """One task.

    Attributes:
        agent: id of whose it is; None for whoever is free.
        at: where it is done, m.
        service: how long whoever does it stands there, s.
        path: where it stands in the file.
    """

    agent: str | None
    at: Point
    service: float
    path: str = ""

    def meaning(self) -> dict[str, Any]:
        """What it means, as it is hashed."""
        return {"agent": self.agent, "at": list(self.at), "service": self.service}
