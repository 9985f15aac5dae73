"""The errors a user can meet, and the exit status each stands for.

A numerical outcome (stopped early, could not improve) is no error but a status of the plan.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from stplan.reasons import Reason
from stplan.wording import in_words

FORMAT = "docs/scene-format.md"
# A message of a scene is headed by FILE:LINE:COLUMN, where it has a place, and by the path of a key.
_PLACED = re.compile(r".*?:\d+:\d+: (?:(\w+)[.\[:])?")
# Sections of the page on the format, by the key that a path begins with.
_SECTIONS = {
    "map": "map", "agents": "agents", "defaults": "agents", "places": "places", "groups": "groups",
    "pairs": "pairs", "events": "events", "seeding": "seeding", "solver": "solver",
    "preset": "the-papers-recipe",
}  # fmt: skip
# So many violations of initial curves are listed.
MOST_VIOLATIONS = 5
BROKEN_SEED = "no initial curves were found that hold their certificate"


class StplanError(Exception):
    """Base of every error this package raises on purpose.

    Attributes:
        exit_status: the command's.
        page: where the documentation says what helps, empty where the message says all there is.
    """

    exit_status: int = 5
    page: str = ""


class SceneError(StplanError):
    """The scene, its map or the command line is wrong. One message a line, each with its place."""

    exit_status = 2

    def __init__(self, messages: str | list[str]) -> None:
        self.messages = [messages] if isinstance(messages, str) else list(messages)
        super().__init__("\n".join(self.messages))
        self.page = scene_page(self.messages[0] if self.messages else "")


def scene_page(message: str) -> str:
    """Where the scene format is explained that a message is about: its section on the path's first key.

    Empty for messages without a place in a scene, which say all there is.
    """
    if message.startswith("--set "):
        return f"{FORMAT}#overrides"
    found = _PLACED.match(message)
    if not found:
        return ""
    section = _SECTIONS.get(found[1], "top-level") if found[1] else "what-is-refused"
    return f"{FORMAT}#{section}"


class UsageError(StplanError):
    """A command was called with arguments that cannot be served (a missing file, a bad option)."""

    exit_status = 2


class SeedingError(StplanError):
    """No initial curves were found: `reasons` say why, and `str` puts them into words.

    Where there is no reason to name, a plain message stands instead.
    """

    exit_status = 3
    page = "docs/troubleshooting.md#no-initial-curves-exit-status-3"

    def __init__(self, reasons: Sequence[Reason] | str) -> None:
        super().__init__(reasons)
        self.reasons = () if isinstance(reasons, str) else tuple(reasons)

    def __str__(self) -> str:
        """A headline, and a line a reason."""
        return in_words(self.reasons) if self.reasons else super().__str__()


class BrokenSeedError(SeedingError):
    """Clear initial curves were found, but none that keep all that the scene asks.

    Attributes:
        violations: what the best of them miss, a sentence each.
    """

    def __init__(self, violations: Sequence[str]) -> None:
        self.violations = tuple(violations)
        shown = [*violations[:MOST_VIOLATIONS]]
        more = len(violations) - len(shown)
        shown += [f"and {more} more"] if more else []
        super().__init__(f"{BROKEN_SEED}; of the best ones:\n  " + "\n  ".join(shown))


class SolverError(StplanError):
    """The optimiser is missing something it was asked for (a linear solver, an option)."""

    exit_status = 2
    page = "docs/dependencies.md"


class DerivativeError(StplanError):
    """A cost of one's own has wrong derivatives: a line for everything that does not fit."""

    exit_status = 2

    def __init__(self, faults: Sequence[str]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(faults))


class OutOfMemoryError(StplanError):
    """The system, or a limit set for this process (``ulimit -v``), gives no more memory."""

    exit_status = 4

    def __init__(self) -> None:
        super().__init__(
            "out of memory: nothing was written; raise the limit of this process, or plan fewer "
            "agents, knots or vertices"
        )


class StoppedError(StplanError):
    """The work was asked to stop before it had a result."""

    exit_status = 130

    def __init__(self) -> None:
        super().__init__("interrupted before there was a result; nothing was written")


def as_stplan_error(error: BaseException) -> StplanError | None:
    """`error` as one of this package's, or None where it is a bug."""
    if isinstance(error, StplanError):
        return error
    if isinstance(error, KeyboardInterrupt):
        return StoppedError()
    return OutOfMemoryError() if isinstance(error, MemoryError) else None
