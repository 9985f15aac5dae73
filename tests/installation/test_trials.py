"""The trial scenes need every kernel, so that compiling ahead leaves none for the first plan."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import stplan
from stplan.installation.kernels import ROOMS, all_kernels, kernel_cache
from stplan.installation.trials import compile_kernels, self_test


def test_all_kernels_are_known_and_need_no_optional_package():
    package = Path(stplan.__file__).parent
    rooms = {
        path.relative_to(package).parts[0]
        for path in package.rglob("*.py")
        if "\n@kernel\n" in path.read_text(encoding="utf-8")
    }
    assert rooms == set(ROOMS)
    program = (
        "import sys; from stplan.installation.kernels import all_kernels; all_kernels();"
        "sys.exit(bool({'matplotlib', 'PIL', 'pandas', 'h5py', 'distributed'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


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
