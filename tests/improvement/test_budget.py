"""Budgets as they are written."""

import pytest

from stplan.errors import UsageError
from stplan.improvement.budget import ImprovementBudget


def test_moves_and_seconds_are_told_apart():
    assert ImprovementBudget.parse("200") == ImprovementBudget(moves=200)
    assert ImprovementBudget.parse("1.5s") == ImprovementBudget(seconds=1.5)
    for text in ("200", "30s", "0.5s"):
        assert str(ImprovementBudget.parse(text)) == text


@pytest.mark.parametrize("text", ["", "s", "0", "-3", "1.5", "nans", "infs", "-2s", "ten", "30 m"])
def test_anything_else_is_refused(text):
    with pytest.raises(UsageError, match="no budget"):
        ImprovementBudget.parse(text)
