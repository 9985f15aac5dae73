"""The trial scenes need every kernel, so that compiling ahead leaves none for the first plan."""

from __future__ import annotations

from stplan.installation.kernels import all_kernels, kernel_cache
from stplan.installation.trials import compile_kernels, self_test


def test_every_kernel_is_compiled_ahead():
    told: list[tuple[int, int]] = []
    assert compile_kernels(lambda done, total: told.append((done, total))) == ()
    count = len(all_kernels())
    assert told[-1] == (count, count)
    assert told == sorted(told)
    cache = kernel_cache()
    assert cache.compiled == cache.kernels == count


def test_the_self_test_is_planned_and_certified():
    found = self_test()
    assert found.certified
    assert "certificate holds" in found.sentence
