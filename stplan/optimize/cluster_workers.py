"""Parts of one problem optimised at the same time on a Dask cluster.

The problem travels to the workers once, everybody's knots once for every group of parts, and curves travel
back. The scheduler gives the part of a worker that dies to another one; what the cluster loses altogether is
sent once more, then done here. What comes of a part is the same whoever does it.
"""

from __future__ import annotations

import copy
import queue
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib.metadata import version
from typing import TYPE_CHECKING

from stplan.arrays import FloatArray
from stplan.clusters import ALONE, TICK
from stplan.errors import UsageError
from stplan.optimize.parts import DividedProblem, Part, PartResult
from stplan.optimize.workers import Told, Workers, WorkersFor, largest_first

if TYPE_CHECKING:
    from distributed import Client, Future

# A part is given to the cluster so often before it is done here.
ATTEMPTS = 2


def on_cluster(client: Client) -> WorkersFor:
    """Workers of the cluster that `client` is connected to."""
    return partial(_cluster_workers, client=client)


@contextmanager
def _cluster_workers(problem: DividedProblem, client: Client) -> Iterator[Workers]:
    yield _ClusterWorkers(problem, client)


class _ClusterWorkers:
    def __init__(self, problem: DividedProblem, client: Client) -> None:
        self._problem, self._client = problem, client
        self._sent: Future[DividedProblem] | None = None

    def optimise(self, parts: Sequence[Part], told: Told) -> list[PartResult | None]:
        results: dict[int, PartResult | None] = {}
        waiting = largest_first(self._problem, parts)
        for _ in range(ATTEMPTS):
            if waiting and self._client.status == "running":
                for number, result in self._handed_out(parts, waiting):
                    results[number] = result
                    told(len(results))
                waiting = [number for number in waiting if number not in results]
                if self._problem.stop():
                    break
        for number in waiting:
            if self._problem.stop():
                break
            results[number] = self._problem.optimised(parts[number])
            told(len(results))
        return [results.get(number) for number in range(len(parts))]

    def _handed_out(
        self, parts: Sequence[Part], waiting: Sequence[int]
    ) -> Iterator[tuple[int, PartResult | None]]:
        """What the cluster makes of parts, as it comes; without those that it loses."""
        client = self._client
        try:
            if self._sent is None or self._sent.status != "finished":
                self._sent = client.scatter(self._problem, broadcast=True, hash=False)
            knots = client.scatter(self._problem.knots.copy(), broadcast=True, hash=False)
        except OSError:  # No worker is there, or all are going.
            return
        over: queue.SimpleQueue[int] = queue.SimpleQueue()
        futures: dict[int, Future[PartResult | None]] = {}
        for place, number in enumerate(waiting):
            futures[number] = client.submit(
                _optimised, version("stplan"), self._sent, knots, parts[number],
                pure=False, priority=-place,
            )  # fmt: skip
            futures[number].add_done_callback(_putting(over, number))
        while futures and client.status == "running" and not self._problem.stop():
            try:
                number = over.get(timeout=TICK)
            except queue.Empty:
                continue
            lost, result = _result(futures.pop(number))
            if not lost:
                yield number, result
        client.cancel(list(futures.values()))


def _putting(over: queue.SimpleQueue[int], number: int) -> Callable[[object], None]:
    return lambda _: over.put(number)


def _result(future: Future[PartResult | None]) -> tuple[bool, PartResult | None]:
    """Whether the cluster lost it, and the result.

    Raises:
        UsageError: workers cannot do what they are asked for, as they lack this program, say.
        StplanError: what a part raised.
    """
    from distributed import CancelledError, KilledWorker

    try:
        return False, future.result()
    except (KilledWorker, CancelledError):
        return True, None
    except (ImportError, AttributeError) as error:
        what = " ".join(f"{type(error).__name__}: {error}".split())
        raise UsageError(f"a worker of the cluster cannot plan: {what}") from error


def _optimised(
    wanted: str, problem: DividedProblem, knots: FloatArray, part: Part
) -> PartResult | None:
    """The worker: a part, from where everybody is now."""
    if version("stplan") != wanted:
        raise UsageError(
            f"a worker of the cluster has stplan {version('stplan')}, this is {wanted}; "
            "the same version gives the same bytes"
        )
    with ALONE:
        own = copy.copy(problem)
        own.knots = knots
        return own.optimised(part)
