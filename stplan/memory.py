"""How much memory there is, how much was used, and whether a scene can fit at all.

What a plan needs grows with the knots (the contact list and the matrix made of it) and with the
pairs of agents (their settings and ranges). Both are known before anything is computed, and
the least a knot and a pair can need is known from measurement: a scene that needs more than there is
would be stopped by the system in the middle of its work, so it is refused at once.
"""

from __future__ import annotations

import importlib
import sys
import time
from pathlib import Path
from types import ModuleType

from stplan import windows
from stplan.errors import SceneError

try:
    resource: ModuleType | None = importlib.import_module("resource")
except ImportError:
    # Windows.
    resource = None

MIB = 2**20
# Bytes of the program and its compiled kernels; of a knot, which has its place in Ipopt's matrix while its
# block is optimised and in the curves all the time; of a pair of agents: its settings and its range.
PROGRAM = 160 * MIB
A_KNOT = 2000
A_PAIR = 80


def least_need(agents: int, knots: int) -> int:
    """Bytes that a plan of `agents` with `knots` in all needs at least."""
    return PROGRAM + A_KNOT * knots + A_PAIR * (agents * (agents - 1) // 2)


def require_memory(name: str, agents: int, knots: int) -> None:
    """Refuse a scene that cannot fit.

    Raises:
        SceneError: it needs more memory than there is.
    """
    need, there = least_need(agents, knots), available()
    if need > there:
        raise SceneError(
            f"{name}: needs at least {_amount(need)} of memory, and {_amount(there)} are available: "
            f"{agents} agents make {agents * (agents - 1) // 2} pairs, and {knots} knots"
        )


def _amount(size: float) -> str:
    return f"{size / 2**30:.1f} GiB"


def peak() -> int:
    """The most resident memory this process has had, in bytes."""
    if resource is None:
        return windows.peak_memory()
    most: int = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else 1024 * most


def total_peak() -> int:
    """The same of this process and the largest of its children that have ended, where the system says so."""
    if resource is None:
        return peak()
    most: int = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    return peak() + (most if sys.platform == "darwin" else 1024 * most)


def processor_time() -> float:
    """Of this process and its children that have ended, s; of this one where the system says no more."""
    if resource is None:
        return time.process_time()
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + float(children.ru_utime + children.ru_stime)


def available() -> float:
    """Bytes this process may have: what the system, its container and its own limit leave."""
    if resource is None:
        return windows.physical_memory()[1]
    own, _ = resource.getrlimit(resource.RLIMIT_AS)
    own_limit = float("inf") if own == resource.RLIM_INFINITY else float(own)
    return min(
        own_limit, _system(Path("/proc/meminfo")), _container(Path("/sys/fs/cgroup/memory.max"))
    )


def _system(table: Path) -> float:
    """MemAvailable of the table that Linux keeps, infinite where there is none."""
    if not table.exists():
        return float("inf")
    rows = (line.partition(":") for line in table.read_text(encoding="ascii").splitlines())
    amounts = {key: amount.split()[0] for key, _, amount in rows}
    return 1024.0 * float(amounts.get("MemAvailable", "inf"))


def _container(limit: Path) -> float:
    """The limit of the control group this process is in, infinite where it has none."""
    text = limit.read_text(encoding="ascii").strip() if limit.exists() else "max"
    return float("inf") if text == "max" else float(text)
