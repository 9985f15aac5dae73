"""Signals are held back where a system can, and go on as they did before where it cannot."""

from __future__ import annotations

import signal

import pytest

from stplan import signal_masks
from stplan.signal_masks import held, release


def _ask(after: list[str], *, within: bool = True) -> None:
    """Ask this process to stop, held back or not, and note that it went on."""
    with held(signal.SIGINT):
        signal.raise_signal(signal.SIGINT)
        after.append("went on")
        if not within:
            release(signal.SIGINT)
            after.append("went on still")


def test_a_signal_waits_until_all_is_done():
    after: list[str] = []
    with pytest.raises(KeyboardInterrupt):
        _ask(after)
    assert after == ["went on"]


def test_whoever_was_started_with_it_held_lets_it_through():
    after: list[str] = []
    with pytest.raises(KeyboardInterrupt):
        _ask(after, within=False)
    assert after == ["went on"]


def test_without_masks_it_comes_at_once(monkeypatch):
    monkeypatch.setattr(signal_masks, "_HAS_MASKS", False)
    after: list[str] = []
    with pytest.raises(KeyboardInterrupt):
        _ask(after)
    release(signal.SIGINT)
    assert after == []
