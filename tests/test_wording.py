"""Lengths, places and lists as one says them."""

from __future__ import annotations

import pytest

from stplan.wording import at, count, metres, names


@pytest.mark.parametrize(
    ("length", "words"),
    [
        (0.0004, "0.4 mm"),
        (0.0004501, "0.45 mm"),
        (-0.02, "-20 mm"),
        (0.09996, "100 mm"),
        (0.233333, "0.233 m"),
        (0.996, "0.996 m"),
        (1.25, "1.25 m"),
        (1.5, "1.5 m"),
    ],
)
def test_lengths_in_words(length, words):
    assert metres(length) == words


def test_lists_counts_and_places():
    assert names(["a"]) == "a"
    assert names(["a", "b", "c"]) == "a, b and c"
    assert names(list("abcdefg")) == "a, b, c, d and 3 more"
    assert (count(1, "agent"), count(2, "agent")) == ("1 agent", "2 agents")
    assert at((-0.001, 2.126)) == "(0, 2.13)"
