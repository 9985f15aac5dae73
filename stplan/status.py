"""How a plan ended: one word for reports, a sentence for users, an exit status for commands."""

from __future__ import annotations

from enum import StrEnum


class Status(StrEnum):
    """The numerical outcome of a plan, or of one run of a solver.

    Attributes:
        advice: what it means for the user, empty where all is well.
        exit_status: the command's.
    """

    advice: str
    exit_status: int

    def __new__(cls, word: str, exit_status: int = 0, advice: str = "") -> Status:
        """A status that equals its `word`, as reports hold it."""
        status = str.__new__(cls, word)
        status._value_ = word
        status.exit_status = exit_status
        status.advice = advice
        return status

    SEEDED = "seeded"
    CONVERGED = "converged"
    PLAYED = "played"
    LIMIT = (
        "limit",
        0,
        "the last outer iteration used all its iterations and was still improving; "
        "raise solver.max_iterations to go on",
    )
    INTERRUPTED = "interrupted", 130, "interrupted: these are the best feasible trajectories so far"
    FAILED = (
        "failed",
        4,
        "the optimiser could not improve the seed; the trajectories are the best feasible ones",
    )
    FRAGILE = (
        "fragile",
        4,
        "no plan was found that survives the delay asked for; the report says which one is survived",
    )
    BROKEN = (
        "broken",
        4,
        "the optimised curves do not hold their certificate, so the seed is given instead",
    )
