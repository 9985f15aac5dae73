"""Runs on a Dask cluster: its scheduler decides where, its workers may die and come back.

Scenes travel as text, results as bytes; only the files of map meshes must be in reach of the
workers, under the same path.
"""

from __future__ import annotations

import queue
from collections.abc import Generator, Iterator, Sequence
from typing import TYPE_CHECKING

from stplan.batch.events import GO_ON, Event, Finished, Progress, Started, Stop
from stplan.batch.outcome import Outcome, RunState
from stplan.batch.runs import Run
from stplan.batch.worker import execute
from stplan.callbacks import unheard
from stplan.clusters import ALONE, TICK, connected
from stplan.errors import UsageError

if TYPE_CHECKING:
    from distributed import Client, Future


def run_on_cluster(
    runs: Sequence[Run],
    address: str,
    *,
    jobs: int,
    timeout: float | None,
    retries: int,
    stop: Stop,
) -> Generator[Event, None, None]:
    """Execute `runs` on the cluster at `address`, and tell what happens; like `run_in_processes`.

    Args:
        address: of a Dask scheduler, or "local" for a cluster of `jobs` processes on this machine.
        timeout: seconds after which the optimisation of a run ends with its best so far.
        retries: how often a run is begun again of which the cluster lost the workers.

    Raises:
        UsageError: there is no Dask, or no scheduler at the address, or it was lost.
    """
    if not runs:
        return
    with connected(address, jobs) as client:
        yield from _Submission(client, runs, timeout, retries, stop).events()


class _Submission:
    def __init__(
        self,
        client: Client,
        runs: Sequence[Run],
        timeout: float | None,
        retries: int,
        stop: Stop,
    ) -> None:
        self._client = client
        self._timeout = timeout
        self._retries = retries
        self._stop = stop
        self._runs = {run.name: run for run in runs}
        self._attempts: dict[str, int] = {}
        self._futures: dict[str, Future[Outcome]] = {}
        self._over: queue.SimpleQueue[str] = queue.SimpleQueue()

    def events(self) -> Iterator[Event]:
        for run in self._runs.values():
            self._submit(run)
            yield Started(run.name)
        while self._futures and not self._stop.asked:
            if self._client.status != "running":
                raise UsageError(f"the Dask scheduler is gone; {GO_ON}")
            try:
                name = self._over.get(timeout=TICK)
            except queue.Empty:
                continue
            yield self._outcome(name)
        self._client.cancel(list(self._futures.values()))

    def _submit(self, run: Run) -> None:
        future = self._client.submit(execute_alone, run, self._timeout, pure=False)
        self._futures[run.name] = future
        future.add_done_callback(lambda future: self._over.put(run.name))

    def _outcome(self, name: str) -> Event:
        from distributed import CancelledError, KilledWorker

        future = self._futures.pop(name)
        try:
            outcome = future.result()
        except (KilledWorker, CancelledError):
            attempts = self._attempts[name] = self._attempts.get(name, 0) + 1
            if attempts <= self._retries:
                self._submit(self._runs[name])
                return Progress(name, "the cluster lost its workers; begun again")
            outcome = Outcome(
                RunState.DIED, ("the cluster lost the workers that were planning it",)
            )
        except Exception as error:  # what a worker raises that lacks this program, or has another
            what = " ".join(f"{type(error).__name__}: {error}".split())
            outcome = Outcome(RunState.ERROR, (f"a worker of the cluster cannot plan: {what}",))
        return Finished(name, outcome)


def execute_alone(run: Run, timeout: float | None) -> Outcome:
    """`execute`, one at a time in a process."""
    with ALONE:
        return execute(run, timeout, unheard)
