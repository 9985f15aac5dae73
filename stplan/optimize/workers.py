"""Parts optimised at the same time, by processes forked off this one where there are several.

A forked process has the whole problem without being sent it, and machine code without loading it. It is told
which part to optimise, finds everybody's knots in shared memory, and sends back curves. What comes of a part
depends on nothing else, so it is the same whoever does it. The part of a process that dies is done here.
"""

from __future__ import annotations

import mmap
import multiprocessing
import signal
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Protocol

import numpy as np

from stplan.optimize.parts import DividedProblem, Part, PartResult
from stplan.signal_masks import held, release
from stplan.threads import threads

# Seconds after which a request to stop is noticed at the latest.
_TICK = 0.2

Told = Callable[[int], None]


class Workers(Protocol):
    """Whoever optimises parts."""

    def optimise(self, parts: Sequence[Part], told: Told) -> list[PartResult | None]:
        """Every part from where everybody is now; None where one cannot be moved, or none was begun.

        `told` is called with how many are done.
        """
        ...


# Whoever optimises the parts of a problem, for as long as they are needed.
WorkersFor = Callable[[DividedProblem], AbstractContextManager[Workers]]


def on_this_machine(count: int) -> WorkersFor:
    """`count` processes, as far as the system can fork; a single one is this process."""
    return partial(_workers, count=count)


@contextmanager
def _workers(problem: DividedProblem, count: int) -> Iterator[Workers]:
    if count == 1 or "fork" not in multiprocessing.get_all_start_methods():
        yield _Alone(problem)
        return
    pool = _Pool(problem, count)
    try:
        yield pool
    finally:
        pool.kill()


THIS_PROCESS = on_this_machine(1)


def largest_first(problem: DividedProblem, parts: Sequence[Part]) -> list[int]:
    """The numbers of `parts`, those with most knots first, so that none of them is left over at the end."""
    segments = problem.formulation.layout.num_segments
    return sorted(range(len(parts)), key=lambda k: (-int(segments[parts[k].agents].sum()), k))


class _Alone:
    def __init__(self, problem: DividedProblem) -> None:
        self._problem = problem

    def optimise(self, parts: Sequence[Part], told: Told) -> list[PartResult | None]:
        results: list[PartResult | None] = [None] * len(parts)
        for number, part in enumerate(parts):
            if self._problem.stop():
                break
            results[number] = self._problem.optimised(part)
            told(number + 1)
        return results


@dataclass
class _Worker:
    process: BaseProcess
    connection: Connection
    part: int | None = None


class _Pool:
    def __init__(self, problem: DividedProblem, count: int) -> None:
        self._problem, self._count = problem, count
        self._knots = mmap.mmap(-1, problem.knots.nbytes)
        self._stopped = mmap.mmap(-1, 1)
        self._workers: list[_Worker] = []
        # How often everybody's knots have been put into shared memory.
        self._round = 0

    def optimise(self, parts: Sequence[Part], told: Told) -> list[PartResult | None]:
        if len(parts) == 1:
            return _Alone(self._problem).optimise(parts, told)
        self._knots[:] = self._problem.knots.tobytes()
        self._round += 1
        while len(self._workers) < min(self._count, len(parts)):
            self._workers.append(self._forked())
        waiting = largest_first(self._problem, parts)
        results: list[PartResult | None] = [None] * len(parts)
        done = 0
        while waiting or any(worker.part is not None for worker in self._workers):
            if self._problem.stop():
                self._stopped[0] = 1
                waiting = []
            if not self._workers:
                for part in waiting:
                    results[part] = self._problem.optimised(parts[part])
                break
            self._hand_out(parts, waiting)
            for part, result in self._heard(parts):
                results[part] = result
                done += 1
                told(done)
        return results

    def kill(self) -> None:
        """End all workers, whatever they are at."""
        for worker in self._workers:
            worker.process.kill()
            worker.process.join()
            worker.connection.close()
        self._workers.clear()

    def _hand_out(self, parts: Sequence[Part], waiting: list[int]) -> None:
        for worker in self._workers:
            if worker.part is None and waiting:
                worker.part = waiting.pop(0)
                # One that is dead by now is noticed by what it fails to answer.
                with suppress(OSError):
                    worker.connection.send((self._round, parts[worker.part]))

    def _heard(self, parts: Sequence[Part]) -> list[tuple[int, PartResult | None]]:
        """What has been done in the meantime."""
        busy = {worker.connection: worker for worker in self._workers if worker.part is not None}
        heard: list[tuple[int, PartResult | None]] = []
        for connection in wait(list(busy), _TICK):
            worker = next(one for one in self._workers if one.connection is connection)
            part, worker.part = worker.part, None
            if part is None:
                continue
            try:
                said = worker.connection.recv()
            except (EOFError, OSError):
                self._workers.remove(worker)
                worker.connection.close()
                worker.process.join()
                said = self._problem.optimised(parts[part])
            if isinstance(said, BaseException):
                raise said
            heard.append((part, said))
        return heard

    def _forked(self) -> _Worker:
        context = multiprocessing.get_context("fork")
        ours, theirs = context.Pipe()
        others = [ours, *(worker.connection for worker in self._workers)]
        process = context.Process(target=self._serve, args=(theirs, others), daemon=True)
        try:
            with held(signal.SIGINT, signal.SIGTERM), warnings.catch_warnings():
                # Threads of libraries that know how to be forked.
                warnings.simplefilter("ignore", DeprecationWarning)
                process.start()
        finally:
            theirs.close()
        return _Worker(process, ours)

    def _serve(self, connection: Connection, others: Sequence[Connection]) -> None:
        """The worker: optimises the parts that come out of the pipe until it is closed."""
        # Ctrl-C at a terminal reaches every process of its group; this one is asked to stop instead.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        release(signal.SIGINT, signal.SIGTERM)
        for other in others:
            other.close()
        problem, shape, known = self._problem, self._problem.knots.shape, 0
        problem.stop = lambda: self._stopped[0] == 1
        # Threads are not forked, and every core has a process.
        with threads(1), suppress(EOFError, OSError):
            while True:
                number, part = connection.recv()
                if number != known:
                    problem.knots = np.frombuffer(self._knots[:]).reshape(shape)
                    known = number
                try:
                    said: object = problem.optimised(part)
                except Exception as error:
                    said = error
                connection.send(said)
