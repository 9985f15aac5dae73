"""The one place that decides how numerical kernels are compiled.

numba compiles on first use and keeps the machine code on disk beside the sources (or in the
user's cache folder where the installation is read-only), so only the first run pays. No fast-math,
and no threads within a kernel: the same input gives the same bytes.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

from numba.core import event

from stplan.dispatchers import EntryDispatcher, LinkedCompiler, LinkedDispatcher

Function = TypeVar("Function", bound=Callable[..., Any])
# Thresholds of the garbage collector meanwhile: compiling makes millions of objects, few in cycles.
COMPILING = (200_000, 50, 100)
OPTIONS = {"nopython": True, "error_model": "numpy", "no_cfunc_wrapper": True}


def kernel(function: Function) -> Function:
    """Compile `function`, which Python calls, to machine code on its first call, cached on disk."""
    dispatcher = EntryDispatcher(function, targetoptions=OPTIONS | {"nogil": True})
    dispatcher.enable_caching()
    return cast(Function, dispatcher)


def inner(function: Function) -> Function:
    """Compile `function`, which kernels call; a call from Python runs it as it is written."""
    return _linked(function)


def inlined(function: Function) -> Function:
    """Like `inner`, but always made part of its callers: for what is small or called once."""
    return _linked(function, forceinline=True)


def _linked(function: Function, **options: Any) -> Function:
    options = OPTIONS | {"no_cpython_wrapper": True} | options
    return cast(
        Function, LinkedDispatcher(function, targetoptions=options, pipeline_class=LinkedCompiler)
    )


def compiled_before(function: Callable[..., Any]) -> bool:
    """Whether the machine code of a kernel's module is on disk already."""
    folder = Path(cast(Any, function).stats.cache_path)
    return any(folder.glob(f"{function.__module__.rpartition('.')[2]}.*.nbi"))


class _CompileTime(event.Listener):
    """Processor seconds that compilation has taken."""

    def __init__(self) -> None:
        self._depth = 0
        self._began = 0.0
        self._thresholds = gc.get_threshold()
        self.seconds = 0.0

    def on_start(self, event: Any) -> None:
        """A kernel begins to compile, perhaps for another one that does."""
        del event
        if self._depth == 0:
            self._began = time.thread_time()
            self._thresholds = gc.get_threshold()
            gc.set_threshold(*COMPILING)
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """It is done."""
        del event
        self._depth -= 1
        if self._depth == 0:
            self.seconds += time.thread_time() - self._began
            gc.set_threshold(*self._thresholds)


_compile_time = _CompileTime()
cast(Any, event).register("numba:compile", _compile_time)


def working_time() -> float:
    """The clock of time limits: this thread's processor seconds, but for those spent compiling.

    A busy machine and a first run find what an idle one and a later run find.
    """
    return time.thread_time() - _compile_time.seconds
