"""Differences as Markdown, for the summary of a CI job or a comment on a change."""

from __future__ import annotations

import re

from stplan.files.compare import AgentDifference, Difference, Spot
from stplan.files.compare_runs import RunDifference, RunsDifference

_HEAD = (
    "| run | agents | position, m | time, s | at one instant, m | certificate |",
    "| --- | --- | --- | --- | --- | --- |",
)
# A comment nobody would read to the end helps nobody.
MOST_SENTENCES = 20


def markdown_lines(difference: RunDifference | RunsDifference) -> list[str]:
    """A heading, a table with the worst differences of every run, and what differs in words."""
    if isinstance(difference, RunDifference):
        runs: tuple[RunDifference, ...] = (difference,)
        verdict = "equal" if difference.equal else "different"
    else:
        runs, verdict = difference.runs, difference.summary
    lines = [f"### stplan diff: {verdict}", "", *_HEAD, *(_row(run) for run in runs)]
    if isinstance(difference, RunsDifference):
        lines += [_only(run, "only in the first") for run in difference.missing]
        lines += [_only(run, "only in the second") for run in difference.added]
    for run in runs:
        if not run.equal:
            lines += ["", f"**{_plain(run.run) or 'What differs'}**", ""]
            sentences = run.lines()
            lines += [f"- {_plain(sentence)}" for sentence in sentences[:MOST_SENTENCES]]
            left = len(sentences) - MOST_SENTENCES
            lines += [f"- and {left} more"] if left > 0 else []
    return lines


def _row(run: RunDifference) -> str:
    certificate = "not compared"
    if run.certificate is not None:
        certificate = "changed" if run.certificate else "unchanged"
    agents = run.trajectories.agents
    cells = [
        _plain(run.run) or "1",
        _agents(run.trajectories),
        *(
            _worst([(agent, getattr(agent, name)) for agent in agents])
            for name in ("position", "time", "simultaneous")
        ),
        certificate,
    ]
    return f"| {' | '.join(cells)} |"


def _only(run: str, where: str) -> str:
    return f"| {_plain(run)} | {where} | | | | |"


def _agents(difference: Difference) -> str:
    parts = [str(len(difference.agents))]
    parts += [f"{len(difference.missing)} missing"] if difference.missing else []
    parts += [f"{len(difference.added)} added"] if difference.added else []
    return ", ".join(parts)


def _worst(spots: list[tuple[AgentDifference, Spot | None]]) -> str:
    """The greatest of some differences, and whose; agents without are those of other knots."""
    known = [(spot.amount, agent.agent, spot) for agent, spot in spots if spot is not None]
    if not known:
        return "-"
    amount, agent, spot = max(known, key=lambda entry: entry[0])
    return f"{amount:.3g}" + (f" ({_plain(agent)}, t = {spot.time:.4g} s)" if amount > 0 else "")


def _plain(text: str) -> str:
    """`text` without a meaning in Markdown or HTML."""
    return re.sub(r"([\\`*_\[\]<>|#])", r"\\\1", " ".join(text.split()))
