"""Change the certificate's code in small ways and see whether its tests notice: `make mutation`.

Each mutant swaps one operator, bound, constant or truth value of a module of `stplan/certify`, and runs
`tests/certify` on a copy of the package. A mutant that no test notices is listed; it either lacks a test or
means the same. `--sample N` takes N of all, the same ones every time.
"""

from __future__ import annotations

import argparse
import ast
import copy
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
ROOM = Path("stplan/certify")
LIMIT = 300
SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
NAMES = {
    "min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum", "any": "all", "all": "any",
    "argmin": "argmax", "argmax": "argmin",
}  # fmt: skip


def mutations(tree: ast.Module) -> Iterator[tuple[ast.AST, str]]:
    """Places in a module that can be changed, and what the change is."""
    skipped = {
        id(inner)
        for node in ast.walk(tree)
        for part in (getattr(node, "annotation", None), getattr(node, "returns", None))
        if part is not None
        for inner in ast.walk(part)
    }
    for node in ast.walk(tree):
        if id(node) in skipped:
            continue
        operator = getattr(node, "op", None) or (getattr(node, "ops", None) or [None])[0]
        if type(operator) in SWAPS:
            yield node, f"{type(operator).__name__} -> {SWAPS[type(operator)].__name__}"
        elif isinstance(node, ast.Attribute) and node.attr in NAMES:
            yield node, f"{node.attr} -> {NAMES[node.attr]}"
        elif (
            isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in NAMES
        ):
            yield node, f"{node.func.id} -> {NAMES[node.func.id]}"
        elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
            yield node, f"{node.value} -> {not node.value}"
        elif isinstance(node, ast.Constant) and isinstance(node.value, int | float):
            yield node, f"{node.value} -> {_other(node.value)}"


def _other(value: float) -> float:
    return value + 1 if isinstance(value, int) else 1.5 * value + 0.5 * (value == 0)


def mutate(node: ast.AST) -> None:
    """Change a node in place, as `mutations` says."""
    if isinstance(node, ast.Compare):
        node.ops[0] = SWAPS[type(node.ops[0])]()  # type: ignore[assignment]
    elif isinstance(node, ast.Attribute):
        node.attr = NAMES[node.attr]
    elif isinstance(node, ast.Call):
        node.func = ast.Name(NAMES[node.func.id], ast.Load())  # type: ignore[attr-defined]
    elif isinstance(node, ast.Constant):
        value = node.value
        node.value = not value if isinstance(value, bool) else _other(value)  # type: ignore[arg-type]
    else:
        node.op = SWAPS[type(node.op)]()  # type: ignore[attr-defined]


def survives(copied: Path, module: Path, text: str) -> bool:
    """Whether the tests of the room pass with a module replaced by `text`."""
    kept = (copied / module).read_text(encoding="utf-8")
    (copied / module).write_text(text, encoding="utf-8")
    try:
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "tests/certify"],
            cwd=copied, env=os.environ | {"PYTHONPATH": str(copied)}, capture_output=True,
            check=False, timeout=LIMIT,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return False
    finally:
        (copied / module).write_text(kept, encoding="utf-8")
    return done.returncode == 0


def main() -> None:
    """Try all mutants, or a sample, and say which survive."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sample", type=int, metavar="N")
    wanted = parser.parse_args().sample
    cases = []
    for path in sorted((ROOT / ROOM).glob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        cases += [
            (path.relative_to(ROOT), number, node.lineno, what)  # type: ignore[attr-defined]
            for number, (node, what) in enumerate(mutations(tree))
        ]
    if wanted is not None:
        cases = random.Random(0).sample(cases, min(wanted, len(cases)))
    alive = 0
    with tempfile.TemporaryDirectory(prefix="stplan-mutants-") as name:
        copied = Path(name)
        for folder in ("stplan", "tests", "scenes", "docs"):
            shutil.copytree(ROOT / folder, copied / folder)
        shutil.copy2(ROOT / "pyproject.toml", copied)
        for path, number, line, what in cases:
            tree = copy.deepcopy(ast.parse((ROOT / path).read_text(encoding="utf-8")))
            mutate(list(mutations(tree))[number][0])
            if survives(copied, path, ast.unparse(tree)):
                alive += 1
                print(f"survives: {path}:{line}: {what}", flush=True)
    killed = len(cases) - alive
    print(f"{killed} of {len(cases)} mutants killed: {100 * killed / len(cases):.0f} %")


if __name__ == "__main__":
    main()
