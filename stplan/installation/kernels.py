"""The compiled kernels of the package: which there are, and whose machine code is on disk."""

from __future__ import annotations

import os
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

from stplan.dispatchers import EntryDispatcher

_PACKAGE = Path(__file__).parents[1]
# The rooms that have kernels; others may need packages that are not installed.
ROOMS = ("certify", "costs", "geometry", "nlp", "seeding")


@dataclass(frozen=True)
class KernelCache:
    """Machine code on disk.

    Attributes:
        kernels: how many there are.
        compiled: of how many of them there is machine code for this processor and these sources.
        folders: where it lies.
        writable: whether more can be kept there.
    """

    kernels: int
    compiled: int
    folders: tuple[str, ...]
    writable: bool


def all_kernels() -> dict[str, EntryDispatcher]:
    """Every kernel of the package, by its module and name; imports all modules that may have one."""
    found = {}
    for room in ROOMS:
        for module in walk_packages([str(_PACKAGE / room)], f"stplan.{room}."):
            for value in vars(import_module(module.name)).values():
                if isinstance(value, EntryDispatcher):
                    found[f"{value.py_func.__module__}.{value.py_func.__qualname__}"] = value
    return dict(sorted(found.items()))


def kernel_cache() -> KernelCache:
    """What is on disk now."""
    kernels = all_kernels()
    folders = sorted({str(each.stats.cache_path) for each in kernels.values()})
    return KernelCache(
        kernels=len(kernels),
        compiled=sum(each.num_on_disk() > 0 for each in kernels.values()),
        folders=tuple(folders),
        writable=all(_can_write(Path(folder)) for folder in folders),
    )


def _can_write(folder: Path) -> bool:
    """Whether files can be made in `folder`, or in what it would be made in."""
    while not folder.exists():
        folder = folder.parent
    return os.access(folder, os.W_OK)
