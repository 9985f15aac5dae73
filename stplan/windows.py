"""What Windows tells of memory: it has neither `resource` nor tables to read."""

from __future__ import annotations

import ctypes
from typing import Any

# A handle that stands for the process that asks.
_THIS_PROCESS = ctypes.c_void_p(-1)
_LONG = ctypes.c_uint32
_SIZE = ctypes.c_size_t
_HUGE = ctypes.c_ulonglong


class ProcessCounters(ctypes.Structure):
    """PROCESS_MEMORY_COUNTERS, as the system lays it out."""

    _fields_ = (
        ("cb", _LONG),
        ("PageFaultCount", _LONG),
        ("PeakWorkingSetSize", _SIZE),
        ("WorkingSetSize", _SIZE),
        ("QuotaPeakPagedPoolUsage", _SIZE),
        ("QuotaPagedPoolUsage", _SIZE),
        ("QuotaPeakNonPagedPoolUsage", _SIZE),
        ("QuotaNonPagedPoolUsage", _SIZE),
        ("PagefileUsage", _SIZE),
        ("PeakPagefileUsage", _SIZE),
    )


class MemoryStatus(ctypes.Structure):
    """MEMORYSTATUSEX, as the system lays it out."""

    _fields_ = (
        ("dwLength", _LONG),
        ("dwMemoryLoad", _LONG),
        ("ullTotalPhys", _HUGE),
        ("ullAvailPhys", _HUGE),
        ("ullTotalPageFile", _HUGE),
        ("ullAvailPageFile", _HUGE),
        ("ullTotalVirtual", _HUGE),
        ("ullAvailVirtual", _HUGE),
        ("ullAvailExtendedVirtual", _HUGE),
    )


def _kernel() -> Any:
    """The library of the system, None on others."""
    return getattr(getattr(ctypes, "windll", None), "kernel32", None)


def peak_memory() -> int:
    """The most resident memory this process has had, in bytes; 0 where nobody tells."""
    kernel, counters = _kernel(), ProcessCounters()
    counters.cb = ctypes.sizeof(counters)
    if kernel is None or not kernel.K32GetProcessMemoryInfo(
        _THIS_PROCESS, ctypes.byref(counters), counters.cb
    ):
        return 0
    return int(counters.PeakWorkingSetSize)


def physical_memory() -> tuple[float, float]:
    """Bytes that there are, and that are free; infinite where nobody tells."""
    kernel, status = _kernel(), MemoryStatus()
    status.dwLength = ctypes.sizeof(status)
    if kernel is None or not kernel.GlobalMemoryStatusEx(ctypes.byref(status)):
        return float("inf"), float("inf")
    return float(status.ullTotalPhys), float(status.ullAvailPhys)
