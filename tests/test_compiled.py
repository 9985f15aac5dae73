"""How kernels are compiled: who may call what, and when machine code on disk is good."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest
from numba.core.errors import TypingError

import stplan
from stplan.callbacks import COMPILING
from stplan.compiled import inlined, inner, kernel
from stplan.dispatchers import source_stamp
from stplan.geometry.sorting import sorted_pairs


@inlined
def _twice(value: float) -> float:
    return 2.0 * value


@inner
def _total(values: np.ndarray) -> float:
    total = 0.0
    for k in range(len(values)):
        total += _twice(values[k])
    return total


@kernel
def doubled(values: np.ndarray) -> float:
    """Twice the sum."""
    return _total(values)


@kernel
def doubled_twice(values: np.ndarray) -> float:
    """Calls what only Python may call."""
    return 2.0 * doubled(values)


def test_kernels_call_what_is_linked_or_inlined() -> None:
    assert doubled(np.array([1.0, 2.5])) == 7.0


def test_a_call_from_python_runs_linked_functions_as_written() -> None:
    # A list would be refused by compiled code.
    assert _total([1.0, 2.5]) == 7.0
    assert _twice(3.0) == 6.0


def test_kernels_do_not_call_kernels() -> None:
    with pytest.raises(TypingError, match="doubled is called from Python only"):
        doubled_twice(np.array([1.0]))


def test_the_stamp_covers_the_sources_of_all_that_is_called() -> None:
    assert len(source_stamp(doubled.py_func)) == 1  # type: ignore[attr-defined]
    assert len(source_stamp(with_a_call_elsewhere.py_func)) == 3  # type: ignore[attr-defined]


@kernel
def with_a_call_elsewhere(rows: np.ndarray) -> int:
    """Calls what another module defines, which calls something there and in a third."""
    return len(sorted_pairs(rows, 3))


def test_before_a_kernel_is_compiled_it_is_said(tmp_path: Path) -> None:
    called = []
    file = tmp_path / "module_to_compile.py"
    file.write_text(
        "from stplan.compiled import kernel\n\n@kernel\ndef third(x):\n    return x / 3.0\n"
    )
    spec = spec_from_file_location("module_to_compile", file)
    assert spec is not None
    module = module_from_spec(spec)
    token = COMPILING.set(lambda: called.append(1))
    try:
        spec.loader.exec_module(module)
        assert module.third(6.0) == module.third(3.0) + 1.0
    finally:
        COMPILING.reset(token)
    assert called == [1]


LINKED = """
from stplan.compiled import inner

@inner
def shifted(value):
    return value + {shift}
"""
ENTRY = """
from linked import shifted
from stplan.compiled import kernel

@kernel
def answer(value):
    return shifted(value)

print(answer(2.0), sum(answer.stats.cache_hits.values()))
"""


def test_machine_code_on_disk_is_good_until_a_linked_file_changes(tmp_path: Path) -> None:
    (tmp_path / "entry.py").write_text(ENTRY)
    root = Path(stplan.__file__).parents[1]
    environment = os.environ | {
        "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
        "PYTHONPATH": os.pathsep.join([str(tmp_path), str(root)]),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    answers = []
    for shift in (1.0, 1.0, 5.0, 5.0):
        (tmp_path / "linked.py").write_text(LINKED.format(shift=shift))
        done = subprocess.run(
            [sys.executable, "-c", "import entry"],
            env=environment, check=True, capture_output=True, text=True,
        )  # fmt: skip
        answers.append(done.stdout.split())
    assert answers == [["3.0", "0"], ["3.0", "1"], ["7.0", "0"], ["7.0", "1"]]
