"""Why there are no initial curves, as data: found by the seeders, put into words by `stplan.wording`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Kind = Literal[
    "start",
    "goal",
    "not connected",
    "limits of time",
    "limit of acceleration",
    "no way",
    "roadmap",
    "mesh",
    "layers",
    "order",
    "blocked",
    "touching",
    "walls",
    "not clear",
    "time limit",
    "unprepared",
    "time scale",
    "method",
    "margin",
    "more time",
]


@dataclass(frozen=True)
class Reason:
    """One reason why there are no clear curves.

    Attributes:
        kind: what is wrong.
        agents: ids of those whom it concerns.
        proven: no such curves exist; else only this search found none.
        place: (x, y) in m, where there is one.
        times: first and last time in s, where there are any.
        figures: what else was measured, in SI units; `stplan.wording` knows them by kind.
    """

    kind: Kind
    agents: tuple[str, ...] = ()
    proven: bool = False
    place: tuple[float, float] | None = None
    times: tuple[float, float] | None = None
    figures: Mapping[str, float] = field(default_factory=dict)
