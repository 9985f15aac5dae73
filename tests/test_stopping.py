"""When a request to stop is polite, when it interrupts, and that nothing does within `held`."""

from __future__ import annotations

import pytest

from stplan.stopping import StopRequest


def test_work_that_does_not_ask_is_interrupted():
    stop = StopRequest()
    with pytest.raises(KeyboardInterrupt):
        stop.make()
    assert stop.made


def test_work_that_asks_is_told_and_the_second_time_interrupted():
    stop = StopRequest()
    assert not stop()
    stop.make()
    assert stop()
    with pytest.raises(KeyboardInterrupt):
        stop.make()


def test_nothing_is_interrupted_where_requests_are_held():
    stop = StopRequest()
    with stop.held():
        stop.make()
        stop.make()
    assert stop.made
    with pytest.raises(KeyboardInterrupt):
        stop.make()
