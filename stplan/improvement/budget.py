"""How long plans are improved: a number of moves, which is repeatable, or of seconds, which is not."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stplan.errors import UsageError
from stplan.scene.model import Scene


@dataclass(frozen=True)
class ImprovementBudget:
    """What an improvement may use.

    Attributes:
        moves: tried at most.
        seconds: of processor time after which no move is begun.
        effort: iterations of optimisations, proposals counted as some, after which no move is begun.
    """

    moves: float = math.inf
    seconds: float = math.inf
    effort: float = math.inf

    @staticmethod
    def parse(text: str) -> ImprovementBudget:
        """`200` are moves, `30s` seconds.

        Raises:
            UsageError: it is neither.
        """
        number = text.removesuffix("s")
        try:
            amount = float(number) if number != text else int(text)
        except ValueError:
            amount = math.nan
        if not (math.isfinite(amount) and amount > 0):
            raise UsageError(
                f"{text!r} is no budget; expected a number of moves such as 200, or of seconds such as 30s"
            )
        return (
            ImprovementBudget(moves=amount) if number == text else ImprovementBudget(seconds=amount)
        )

    def __str__(self) -> str:
        """As `parse` reads it."""
        return f"{self.moves:g}" if math.isfinite(self.moves) else f"{self.seconds:g}s"


def require_energy(scene: Scene) -> None:
    """Improvement compares costs of plans, and of nothing else.

    Raises:
        UsageError: these are not what is to be least in `scene`, or the plan has delays to forgive.
    """
    if scene.robust.delay:
        raise UsageError(
            f"{scene.name} has robust.delay; what is improved could forgive less, so it stays"
        )
    if scene.overlap == "ease":
        raise UsageError(f"{scene.name} has overlap: ease; what is eased apart is past improvement")
    if scene.minimise != "energy":
        raise UsageError(
            f"{scene.name} minimises {scene.minimise}; only plans that minimise energy are improved"
        )
