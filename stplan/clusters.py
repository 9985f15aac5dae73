"""Connections to Dask clusters, an optional package."""

from __future__ import annotations

import gc
import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from stplan.errors import UsageError

if TYPE_CHECKING:
    from distributed import Client

LOCAL = "local"
# How long a scheduler may take to answer.
PATIENCE = "10s"
# Seconds after which a request to stop, or the loss of the scheduler, is noticed at the latest.
TICK = 0.5
# What workers of this machine do with memory that is not needed for a moment: they keep it, as any process
# does. Dask has it given back at once, and asked for again, which would take a fifth of a worker's time.
KEEPING = {"MALLOC_TRIM_THRESHOLD_": 128 << 20, "MALLOC_MMAP_THRESHOLD_": 32 << 20}
# MUMPS, the linear solver, keeps state of its own: one at a time in a process of a worker.
ALONE = threading.Lock()


@contextmanager
def connected(address: str, jobs: int) -> Iterator[Client]:
    """A client of the cluster at `address`, or of one of `jobs` processes on this machine if that is "local".

    Raises:
        UsageError: there is no Dask, or no scheduler at the address.
    """
    try:
        import dask
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise UsageError("--dask needs Dask: pip install 'stplan[dask]'") from error
    if address == LOCAL:
        # One thread a worker; a killed one is told by the outcome, not by pages of log.
        with (
            dask.config.set(
                {
                    f"distributed.nanny.pre-spawn-environ.{name}": amount
                    for name, amount in KEEPING.items()
                }
            ),
            LocalCluster(
                n_workers=jobs, threads_per_worker=1, dashboard_address=None,
                silence_logs=logging.CRITICAL,
            ) as cluster,
            Client(cluster) as client,
        ):  # fmt: skip
            yield client
        return
    # A client that failed to connect before is finalised now: while another one starts, its finaliser
    # would wait for ever for a lock that this thread holds.
    gc.collect()
    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise UsageError(f"--dask {address}: no Dask scheduler answers there") from error
    with client:
        yield client
