"""What a plan forgives, as proven, beside what was asked of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stplan.amounts import amount
from stplan.analysis.precedence import Endurance, endurance, longest_delay, precedence
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Robust, Scene


@dataclass(frozen=True)
class Robustness:
    """What a plan forgives.

    Attributes:
        asked: of it.
        endurance: what comes of the delay asked for; None where none was.
        proven: the longest stop of any one agent that is survived, s; inf where any is.
    """

    asked: Robust
    endurance: Endurance | None = None
    proven: float = np.inf

    @property
    def holds(self) -> bool:
        """Whether all that was asked is forgiven; room for errors of tracking is in the certificate."""
        return self.endurance is None or self.endurance.survives

    @property
    def sentences(self) -> list[str]:
        """In words."""
        said = []
        if self.asked.tracking:
            said.append(
                f"everybody may be {amount(self.asked.tracking)} m off, with all distances kept"
            )
        if self.endurance is not None and self.endurance.survives:
            said.append(_survived(self.endurance))
        elif self.endurance is not None:
            said += [
                f"survives a stop of {amount(self.proven)} s of the {amount(self.asked.delay)} s asked",
                *self.endurance.broken,
            ]
        return said

    def as_dict(self) -> dict[str, Any]:
        """For report.json; a proven delay of null is any."""
        content: dict[str, Any] = {"tracking": self.asked.tracking}
        if self.endurance is not None:
            proven = None if np.isinf(self.proven) else self.proven
            content |= {"proven_delay": proven, **self.endurance.as_dict()}
        return content


def robustness(scene: Scene, lines: WorldLines) -> Robustness:
    """What `lines`, in any order the certified curves of all agents of `scene`, forgive."""
    if not scene.robust.delay:
        return Robustness(scene.robust)
    order = precedence(scene, lines)
    return Robustness(scene.robust, endurance(order, scene.robust.delay), longest_delay(order))


def _survived(tried: Endurance) -> str:
    head = f"any one agent may stop for {amount(tried.delay)} s if all keep the order of passing"
    if not tried.late:
        return f"{head}; nobody else is late"
    who, by, whose = tried.late[0]
    return (
        f"{head}; {len(tried.late)} {'is' if len(tried.late) == 1 else 'are'} late then, "
        f"{who} most: {amount(by)} s where {whose} stops"
    )
