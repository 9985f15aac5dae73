"""What seeders share: budgets, records, margins."""

from __future__ import annotations

import math

from stplan.compiled import working_time
from stplan.seeding.margins import margin_ladder
from stplan.seeding.seeder import Budget, SeedAttempt, SeedRecord


def test_a_budget_is_spent_after_its_deadline_only() -> None:
    assert not Budget().spent()
    assert Budget(deadline=-math.inf).spent()
    assert not Budget(deadline=working_time() + 1e6).spent()


def test_a_record_holds_what_was_counted() -> None:
    assert SeedRecord().as_dict() == {}
    assert list(SeedRecord(margin=1.05, tries=0, starts=3, start=2).as_dict().items()) == [
        ("margin", 1.05), ("tries", 0), ("starts", 3), ("start", 2),
    ]  # fmt: skip


def test_an_attempt_counts_its_tries() -> None:
    assert SeedAttempt("nobody").tries == 0
    counted = SeedAttempt("search", record=SeedRecord(margin=1.02)).counting(7)
    assert (counted.tries, counted.record.margin) == (7, 1.02)
    assert not counted.clear


def test_margins_fall_from_the_one_asked_for() -> None:
    assert margin_ladder(1.05) == (1.05, 1.02, 1.005, 1.001)
    assert margin_ladder(1.01) == (1.01, 1.005, 1.001)
    assert margin_ladder(1.0) == (1.0,)
