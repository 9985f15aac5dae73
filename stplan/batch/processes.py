"""Runs in processes of this machine.

Every worker has a pipe of its own and shares no lock, so that one killed at any moment takes down
nothing but the run it was at, and that one is known. Workers live over many runs: they pay once for
starting and for loading machine code.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from types import FrameType

from stplan.batch.events import Event, Finished, Progress, Started, Stop
from stplan.batch.outcome import Outcome, RunState
from stplan.batch.runs import Run
from stplan.batch.worker import ONE_THREAD, execute
from stplan.errors import UsageError
from stplan.signal_masks import held, release
from stplan.stopping import StopRequest

# Seconds a worker has to give back its best so far, once its time is over or it is interrupted.
GRACE = 10.0
# Seconds after which a request to stop is noticed at the latest.
_TICK = 0.2


@dataclass
class _Worker:
    process: SpawnProcess
    connection: Connection
    run: Run | None = None
    started: float = 0.0
    killed_for: str = ""


def run_in_processes(
    runs: Sequence[Run], *, jobs: int, timeout: float | None, retries: int, stop: Stop
) -> Generator[Event, None, None]:
    """Execute `runs`, `jobs` at a time, and tell what happens; closing the iterator kills the rest.

    Args:
        timeout: seconds for a run; one that has not given in GRACE seconds later is killed.
        retries: how often a run is begun again whose worker died.
        stop: once asked, nothing more is begun; asked twice, the rest is killed at once.
    """
    pool = _Pool(jobs, timeout, retries, stop, deque(runs))
    try:
        yield from pool.events()
    finally:
        pool.kill()


class _Pool:
    def __init__(
        self, jobs: int, timeout: float | None, retries: int, stop: Stop, waiting: deque[Run]
    ) -> None:
        self._jobs = jobs
        self._timeout = timeout
        self._retries = retries
        self._stop = stop
        self._waiting = waiting
        self._workers: list[_Worker] = []
        self._attempts: dict[str, int] = {}
        self._stopping: float | None = None

    def events(self) -> Iterator[Event]:
        while True:
            if self._stop.asked:
                self._ask_to_stop()
            # The workers are busy again before anyone takes the time to write what they gave.
            yield from self._hand_out()
            if not any(worker.run for worker in self._workers):
                return
            happened = self._listen()
            yield from self._hand_out()
            yield from happened

    def kill(self) -> None:
        """End all workers, whatever they are at."""
        for worker in self._workers:
            worker.process.kill()
            worker.process.join()
            worker.connection.close()
        self._workers.clear()

    def _hand_out(self) -> list[Event]:
        begun: list[Event] = []
        while self._waiting and not self._stop.asked:
            worker = next((worker for worker in self._workers if worker.run is None), None)
            if worker is None:
                if len(self._workers) >= self._jobs:
                    break
                worker = self._start()
            run = self._waiting.popleft()
            worker.run, worker.started = run, time.monotonic()
            begun.append(Started(run.name))
            try:
                worker.connection.send(run)
            except OSError:
                begun.append(self._lost(worker, run))
        return begun

    def _start(self) -> _Worker:
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs, self._timeout), daemon=True)
        try:
            # A Ctrl-C waits until the newborn can ignore it.
            with held(signal.SIGINT):
                process.start()
        except OSError as error:
            raise UsageError(f"cannot start a worker process: {error.strerror or error}") from error
        finally:
            theirs.close()
        worker = _Worker(process, ours)
        self._workers.append(worker)
        return worker

    def _listen(self) -> list[Event]:
        """What the workers say; a silence ends after a moment."""
        happened: list[Event] = []
        ready = wait([worker.connection for worker in self._workers], _TICK)
        for worker in [worker for worker in self._workers if worker.connection in ready]:
            run = worker.run
            try:
                said = worker.connection.recv()
            except (EOFError, OSError):
                if run is None:
                    self._bury(worker)
                else:
                    happened.append(self._lost(worker, run))
                continue
            if run is None:
                continue
            if isinstance(said, Outcome):
                happened.append(Finished(run.name, said))
                worker.run = None
            else:
                happened.append(Progress(run.name, said))
        self._kill_the_late()
        return happened

    def _kill_the_late(self) -> None:
        now = time.monotonic()
        for worker in self._workers:
            if worker.run is None or worker.killed_for:
                continue
            if self._stopping is not None and now > self._stopping:
                worker.killed_for = "interrupted"
            elif self._timeout is not None and now > worker.started + self._timeout + GRACE:
                worker.killed_for = "timeout"
            if worker.killed_for:
                worker.process.kill()

    def _ask_to_stop(self) -> None:
        if self._stopping is None:
            self._stopping = time.monotonic() + GRACE
            self._waiting.clear()
            for worker in self._workers:
                if worker.run is not None:
                    worker.process.terminate()
        if self._stop.at_once:
            self._stopping = 0.0

    def _lost(self, worker: _Worker, run: Run) -> Event:
        seconds = time.monotonic() - worker.started
        how = self._bury(worker)
        if worker.killed_for == "timeout":
            message = f"killed {seconds:.0f} s after it began (--timeout {self._timeout:g})"
            return Finished(run.name, Outcome(RunState.TIMEOUT, (message,), {}, seconds))
        if self._stopping is not None:
            message = "interrupted before there was a result"
            return Finished(run.name, Outcome(RunState.INTERRUPTED, (message,), {}, seconds))
        attempts = self._attempts[run.name] = self._attempts.get(run.name, 0) + 1
        if attempts <= self._retries:
            self._waiting.appendleft(run)
            return Progress(run.name, f"its worker {how}; begun again")
        times = f", {attempts} times in all" if attempts > 1 else ""
        return Finished(
            run.name, Outcome(RunState.DIED, (f"its worker {how}{times}",), {}, seconds)
        )

    def _bury(self, worker: _Worker) -> str:
        """Forget a dead worker; how it died, in words."""
        self._workers.remove(worker)
        worker.connection.close()
        worker.process.join(GRACE)
        if worker.process.exitcode is None:  # It closed its pipe and lives on.
            worker.process.kill()
            worker.process.join()
        return death(worker.process.exitcode or 0)


def death(exit_code: int) -> str:
    """How a process ended, in words."""
    if exit_code >= 0:
        return f"ended with exit status {exit_code}"
    try:
        name = signal.Signals(-exit_code).name
    except ValueError:
        name = f"signal {-exit_code}"
    memory = ", as systems do when memory runs out" if name == "SIGKILL" else ""
    return f"was killed by {name}{memory}"


def _serve(connection: Connection, timeout: float | None) -> None:
    """The worker: plans the runs that come out of the pipe until it is closed."""
    # Ctrl-C at a terminal reaches every process of its group; the batch decides what ends.
    if hasattr(os, "setpgrp"):
        os.setpgrp()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    release(signal.SIGINT)
    os.environ.update(ONE_THREAD)
    threading.Thread(target=_die_with_the_batch, daemon=True).start()
    ended = False
    stop: StopRequest | None = None  # To the run at work.

    def end(number: int, frame: FrameType | None) -> None:
        nonlocal ended
        del number, frame
        ended = True
        if stop is not None:
            stop.make()

    # A process of its own, which the batch asks to stop by SIGTERM.
    signal.signal(signal.SIGTERM, end)
    with suppress(EOFError, OSError):
        while True:
            run = connection.recv()
            if ended:
                return
            stop = StopRequest()
            outcome = execute(run, timeout, connection.send, stop)
            stop = None
            connection.send(outcome)


def _die_with_the_batch() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)
