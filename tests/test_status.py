"""One word, one sentence and one exit status for every outcome."""

from __future__ import annotations

import json

from stplan.status import Status


def test_a_status_is_its_word_in_reports_and_comparisons() -> None:
    assert json.dumps({"status": Status.CONVERGED}) == '{"status": "converged"}'
    assert Status("limit") is Status.LIMIT
    assert Status.FAILED == "failed"
    assert f"{Status.BROKEN}" == "broken"


def test_only_what_is_well_or_can_go_on_exits_with_nought() -> None:
    assert {status.value: status.exit_status for status in Status} == {
        "seeded": 0, "converged": 0, "played": 0, "limit": 0, "interrupted": 130, "failed": 4, "broken": 4,
        "fragile": 4,
    }  # fmt: skip


def test_whatever_is_not_well_says_what_it_means() -> None:
    well = {status for status in Status if not status.advice}
    assert well == {Status.SEEDED, Status.CONVERGED, Status.PLAYED}
