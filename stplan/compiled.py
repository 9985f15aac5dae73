"""The one place that decides how numerical kernels are compiled.

numba compiles on first use and keeps the machine code on disk beside the sources (or in the
user's cache folder where the installation is read-only), so only the first run pays. No fast-math
and no threads: the same input gives the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(function: Function) -> Function:
    """Compile `function` to machine code on first call, cached on disk."""
    return cast(Function, numba.njit(cache=True, error_model="numpy")(function))


def inlined(function: Function) -> Function:
    """Like `kernel`, inlined into the kernels that call it (small geometric primitives)."""
    return cast(Function, numba.njit(cache=True, error_model="numpy", inline="always")(function))


def compiled_before(function: Callable[..., Any]) -> bool:
    """Whether the machine code of a kernel's module is on disk already."""
    folder = Path(cast(Any, function).stats.cache_path)
    return any(folder.glob(f"{function.__module__.rpartition('.')[2]}.*.nbi"))
