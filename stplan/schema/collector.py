"""The garbage collector while large files are read."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def collector_paused() -> Iterator[None]:
    """Leave cycles alone meanwhile, for what makes many objects that stay.

    The collector would go through all of them again and again, which took half of the time that
    large maps are read in. What is no longer referred to is freed as ever.
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()
