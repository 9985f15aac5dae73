"""The machine measurements were taken on, as far as it concerns their readers."""

from __future__ import annotations

import os
import platform
from datetime import date
from pathlib import Path

from stplan import windows
from stplan.report import versions


def description() -> str:
    """Markdown: date, processor, memory, system and versions; no names of hosts or users."""
    packages = ", ".join(f"{name} {version}" for name, version in versions().items())
    return (
        f"Measured on {date.today().isoformat()}: {os.cpu_count()} cores of {processor()}, "
        f"{_memory_gib():.0f} GiB of memory, {platform.system()}, "
        f"Python {platform.python_version()}; {packages}.\n"
    )


def processor() -> str:
    """The processor's name, as the system tells it."""
    table = Path("/proc/cpuinfo")
    if table.exists():
        for line in table.read_text(encoding="utf-8").splitlines():
            key, _, value = line.partition(":")
            if key.strip() == "model name":
                return value.strip()
    return platform.processor() or platform.machine()


def _memory_gib() -> float:
    if not hasattr(os, "sysconf"):
        return windows.physical_memory()[0] / 2**30
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
