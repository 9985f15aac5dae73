"""What signals do to a command, by real signals to this process."""

from __future__ import annotations

import os
import signal
import threading

import pytest

from stplan.cli.signals import answered_by


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_answered_within_and_as_before_afterwards(number):
    before = signal.getsignal(number)
    times: list[str] = []
    with answered_by(lambda: times.append("asked")):
        os.kill(os.getpid(), number)
        os.kill(os.getpid(), number)
    assert times == ["asked", "asked"]
    assert signal.getsignal(number) is before


def test_in_another_thread_handlers_are_left_alone():
    found = []

    def work() -> None:
        before = signal.getsignal(signal.SIGINT)
        with answered_by(lambda: None):
            found.append(signal.getsignal(signal.SIGINT) is before)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found == [True]
