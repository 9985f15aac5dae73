"""How the runs of a batch stand, and the figures that are told of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from stplan.batch.outcome import RunState
from stplan.batch.runs import Run
from stplan.files.recorded import RecordedReport, RecordedTimes


@dataclass(frozen=True)
class Result:
    """How a run stands at the end of the batch.

    Attributes:
        folder: where its files are, if it has any.
        state: whether it is certified, and if not, why.
        messages: what a user should know of it.
        report, times: what its files say; nothing where none were written.
        seconds: wall time of planning it, now or when it was found done; None if unknown.
        fresh: planned now, and not found done.
    """

    run: Run
    folder: Path
    state: RunState
    messages: tuple[str, ...] = ()
    report: RecordedReport = field(default_factory=RecordedReport, repr=False)
    times: RecordedTimes = field(default_factory=RecordedTimes, repr=False)
    seconds: float | None = None
    fresh: bool = True

    @property
    def exit_status(self) -> int:
        """What `stplan solve` would say of this run."""
        return self.state.exit_status

    @property
    def sentence(self) -> str:
        """In one line: the state and the figures that matter most."""
        report = self.report
        parts: list[str] = [self.state]
        if report.smallest_clearance is not None:
            parts.append(f"clearance {report.smallest_clearance:.4g} m")
        if report.latest_arrival is not None:
            parts.append(f"latest arrival {report.latest_arrival:.2f} s")
        if self.seconds is not None and self.fresh:
            parts.append(f"took {self.seconds:.2f} s")
        if not self.fresh:
            parts.append("done before")
        return f"{self.run.name}: {', '.join(parts)}"

    @property
    def complaints(self) -> list[str]:
        """What is wrong; nothing where the run is certified or was not begun."""
        if self.exit_status == 0 or self.state is RunState.NOT_RUN:
            return []
        # Messages about a scene begin with their place already.
        prefix = "" if self.run.refusal else f"{self.run.name}: "
        return [prefix + message for message in self.messages]


@dataclass(frozen=True)
class Batch:
    """All results, in the order of the runs, and whether the batch was interrupted."""

    results: tuple[Result, ...]
    interrupted: bool = False

    @property
    def exit_statuses(self) -> list[int]:
        """Of all runs that have one; runs that were not begun have none but the interruption's."""
        begun = [
            result.exit_status for result in self.results if result.state is not RunState.NOT_RUN
        ]
        return begun + [130] * self.interrupted

    @property
    def counts(self) -> dict[str, int]:
        """How many runs are in each state, those that occur."""
        states = [result.state for result in self.results]
        return {state: states.count(state) for state in RunState if state in states}

    @property
    def sentence(self) -> str:
        """The counts in words."""
        before = sum(not result.fresh for result in self.results)
        counts = ", ".join(f"{number} {state}" for state, number in self.counts.items())
        return f"{len(self.results)} runs: {counts}" + (
            f" ({before} done before)" if before else ""
        )
