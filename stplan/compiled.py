"""The one place that decides how numerical kernels are compiled.

numba compiles on first use and keeps the machine code on disk beside the sources (or in the
user's cache folder where the installation is read-only), so only the first run pays. No fast-math
and no threads: the same input gives the same bytes.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import caching, event
from numba.core.dispatcher import Dispatcher
from numba.core.registry import CPUDispatcher
from numba.core.runtime.nrt import rtsys

Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(function: Function) -> Function:
    """Compile `function` to machine code on first call, cached on disk."""
    dispatcher = _njit(no_cfunc_wrapper=True)(function)
    dispatcher._cache = _KernelCache(function)
    return cast(Function, dispatcher)


def inner(function: Function) -> Function:
    """Like `kernel`, for what only kernels call: it lacks what a call from Python would need."""
    dispatcher = _njit(no_cfunc_wrapper=True, no_cpython_wrapper=True)(function)
    dispatcher._cache = _KernelCache(function)
    return cast(Function, _from_kernels_only(dispatcher))


def inlined(function: Function) -> Function:
    """Like `inner`, but part of every kernel that calls it (small primitives, or called once)."""
    return cast(Function, _from_kernels_only(_njit(inline="always")(function)))


def _njit(**options: Any) -> Any:
    return cast(Any, numba.njit)(error_model="numpy", **options)


class _FromKernelsOnly(CPUDispatcher):
    """A compiled function that a call from Python does not compile: it runs as it is written."""

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return self.py_func(*arguments, **named)


def _from_kernels_only(dispatcher: Any) -> Any:
    dispatcher.__class__ = _FromKernelsOnly
    return dispatcher


class _KernelCache(caching.FunctionCache):
    """numba's cache on disk, good for the source of a kernel and of all that it calls.

    numba looks at the kernel's own file only, so machine code would outlive a change of what is linked
    into it. And before it loads anything it imports all that compiling takes, most of the time that
    loading would take; machine code itself needs no more than the runtime.
    """

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled function for a signature, None where it has to be compiled."""
        rtsys.initialize(target_context)
        return self._load_overload(sig, target_context)

    def _load_overload(self, sig: Any, target_context: Any) -> Any:
        self._stamp()
        return super()._load_overload(sig, target_context)

    def _save_overload(self, sig: Any, data: Any) -> None:
        self._stamp()
        super()._save_overload(sig, data)

    def _stamp(self) -> None:
        """Tell what the sources are, once all they refer to has been imported."""
        stamped = self._cache_file
        if not isinstance(stamped, _StampedFile):
            self._cache_file = _StampedFile(
                self.cache_path, self._impl.filename_base, source_stamp(self._py_func)
            )


class _StampedFile(caching.IndexDataCacheFile):
    """What is on disk for one kernel."""

    def _load_index(self) -> Any:
        try:
            return super()._load_index()
        except (AttributeError, ImportError):
            # Left by another version of the package, of argument types that are gone.
            return {}


def source_stamp(function: Callable[..., Any]) -> tuple[str, ...]:
    """Digests of the files that a function and all compiled functions it calls come from."""
    todo, files, seen = [function], set(), set()
    while todo:
        code, names = todo[-1].__code__, todo.pop().__globals__
        files.add(code.co_filename)
        for name in code.co_names:
            called = names.get(name)
            if isinstance(called, Dispatcher) and called not in seen:
                seen.add(called)
                todo.append(called.py_func)
    return tuple(_digest(path) for path in sorted(files))


@cache
def _digest(path: str) -> str:
    return sha256(Path(path).read_bytes()).hexdigest()


def compiled_before(function: Callable[..., Any]) -> bool:
    """Whether the machine code of a kernel's module is on disk already."""
    folder = Path(cast(Any, function).stats.cache_path)
    return any(folder.glob(f"{function.__module__.rpartition('.')[2]}.*.nbi"))


class _CompileTime(event.Listener):
    """Processor seconds that compilation has taken."""

    def __init__(self) -> None:
        self._depth = 0
        self._began = 0.0
        self.seconds = 0.0

    def on_start(self, event: Any) -> None:
        """A kernel begins to compile, perhaps for another one that does."""
        del event
        if self._depth == 0:
            self._began = time.thread_time()
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """It is done."""
        del event
        self._depth -= 1
        if self._depth == 0:
            self.seconds += time.thread_time() - self._began


_compile_time = _CompileTime()
cast(Any, event).register("numba:compile", _compile_time)


def working_time() -> float:
    """The clock of time limits: this thread's processor seconds, but for those spent compiling.

    A busy machine and a first run find what an idle one and a later run find.
    """
    return time.thread_time() - _compile_time.seconds
