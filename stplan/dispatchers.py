"""numba's dispatchers, made to compile and to load no more than kernels need.

numba lets every compiled function be called from everywhere. Here a function is called either from
Python (`EntryDispatcher`) or from other compiled ones (`LinkedDispatcher`). So what is linked needs no
optimisation and no machine code of its own, only that of the entry which it becomes a part of; and what is
loaded from disk is machine code alone, without the intermediate code that linking it would take.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, cast

import llvmlite.binding as llvm
from numba.core import caching, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.dispatcher import Dispatcher
from numba.core.errors import TypingError
from numba.core.registry import CPUDispatcher
from numba.core.runtime.nrt import rtsys

from stplan.callbacks import COMPILING


class EntryDispatcher(CPUDispatcher):
    """A compiled function that Python calls, cached on disk."""

    def enable_caching(self) -> None:
        """Keep machine code on disk."""
        self._cache = _KernelCache(self.py_func)

    def num_on_disk(self) -> int:
        """For how many types of arguments there is machine code on disk, good for this processor."""
        return self._cache.num_entries(cast(Any, self.targetctx).codegen())

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Refuse to be called from compiled code."""
        raise TypingError(f"{self.py_func.__qualname__} is called from Python only")


class LinkedDispatcher(CPUDispatcher):
    """A compiled function that other compiled ones call; a call from Python runs it as it is written."""

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return self.py_func(*arguments, **named)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """numba's own, for the types of constants: not compiled once more for every value."""
        plain = {name: types.unliteral(kind) for name, kind in kws.items()}
        return super().get_call_template([types.unliteral(kind) for kind in args], plain)

    def add_overload(self, cres: Any) -> None:
        """Register what was compiled under a name of its own, as there is nothing to call."""
        cres = cres._replace(entry_point=object())
        cres.target_context.insert_user_function(cres.entry_point, cres.fndesc, [cres.library])
        self.overloads[tuple(cres.signature.args)] = cres


class LinkedCompiler(CompilerBase):
    """Compiles to intermediate code only."""

    def __init__(self, typingctx: Any, targetctx: Any, library: Any, *rest: Any) -> None:
        if library is None:
            library = _LinkedLibrary(targetctx.codegen(), "linked")
        super().__init__(typingctx, targetctx, library, *rest)
        self.state.flags.no_compile = True

    def define_pipelines(self) -> list[Any]:
        """numba's own."""
        return [DefaultPassBuilder.define_nopython_pipeline(self.state)]


class _LinkedLibrary(JITCodeLibrary):
    """Code that becomes part of other libraries."""

    def finalize(self) -> None:
        """Link what it calls, and leave the rest to whatever it is linked into."""
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalize_dynamic_globals()
        self._finalized = True


class _KernelCache(caching.FunctionCache):
    """numba's cache on disk, good for the source of a kernel and of all that it calls.

    numba looks at the kernel's own file only, so machine code would outlive a change of what is linked
    into it. And before it loads anything it imports all that compiling takes, most of the time that
    loading would take; machine code itself needs no more than the runtime.
    """

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled function for a signature, None where it has to be compiled."""
        rtsys.initialize(target_context)
        found = self._load_overload(sig, target_context)
        if found is None:
            COMPILING.get()()
        return found

    def _load_overload(self, sig: Any, target_context: Any) -> Any:
        self._stamp()
        return super()._load_overload(sig, target_context)

    def _save_overload(self, sig: Any, data: Any) -> None:
        self._stamp()
        super()._save_overload(sig, data)

    def num_entries(self, codegen: Any) -> int:
        """How many signatures the index holds for the processor of `codegen`."""
        self._stamp()
        target = codegen.magic_tuple()
        return sum(key[1] == target for key in self._cache_file._load_index())

    def _stamp(self) -> None:
        """Tell what the sources are, once all they refer to has been imported."""
        if not isinstance(self._cache_file, _StampedFile):
            self._cache_file = _StampedFile(
                self.cache_path, self._impl.filename_base, source_stamp(self._py_func)
            )

    class _impl_class(caching.CompileResultCacheImpl):  # noqa: N801
        """What is kept of a compiled function."""

        def reduce(self, cres: Any) -> Any:
            """All but the intermediate code, of which only the names are asked for."""
            (name, kind, (machine_code, _)), *rest = cres._reduce()
            names = (cres.fndesc.llvm_func_name, cres.fndesc.llvm_cpython_wrapper_name)
            stub = "".join(f'define void @"{name}"() {{ ret void }}\n' for name in names)
            bitcode = llvm.parse_assembly(stub).as_bitcode()
            return (name, kind, (machine_code, bitcode)), *rest


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
