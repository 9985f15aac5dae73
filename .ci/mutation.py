"""Change the certificate's code in small ways and see whether its tests notice: `make mutation`.

Each mutant swaps one operator, bound, constant or truth value of a module of `stplan/certify`, and runs
`tests/certify` on a copy of the package, the tests of that module first. A mutant that no test notices is
listed; it either lacks a test or means the same, as those do that `EQUIVALENT` leaves out. One whose tests
never end counts as noticed, and is listed, too. `--sample N` takes N of all, the same ones for the same
`--rng-seed`. What is compiled is compiled anew for every mutant: machine code on disk is good for the sources
it was made of only.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
ROOM = Path("stplan/certify")
# Tests never end that take so many times longer than they should, and so many seconds: compiling takes long.
PATIENCE, LEAST_PATIENCE = 20, 300.0
SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
NAMES = {
    "min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum", "any": "all", "all": "any",
    "argmin": "argmax", "argmax": "argmin",
}  # fmt: skip
# Lines (or of a line one kind of change, or those in a part of it) whose changes mean the same, and why;
# `make mutation` ends where one of them is no longer there.
EQUIVALENT: dict[tuple[str, ...], str] = {
    ("near_pairs.py", "MOST_SLABS = 1000"): "how finely time is cut: speed alone",
    ("near_pairs.py", "MOST_CELLS = 16"): "how finely the plane is cut: speed alone",
    ("near_pairs.py", "SHORTEST = 1e-9"): "where cuts lie: speed alone",
    (
        "near_pairs.py",
        "_SPREAD_X, _SPREAD_Y, _SPREAD = 73856093, 19349663, 83492791",
    ): "in which buckets cells come: speed alone",
    (
        "near_pairs.py",
        "table = np.full(1024, -1, dtype=np.int64)",
    ): "how large it begins: speed alone",
    ("near_pairs.py", "if 2 * used >= len(table):"): "how full it gets: speed alone",
    ("near_pairs.py", "codes = np.sort(codes[codes >= 0])"): "no pair has the code 0, of (0, 0)",
    ("near_pairs.py", "size *= 2.0"): "how fast cells grow: speed alone",
    (
        "near_pairs.py",
        "count = int(np.clip(np.ceil(progress[-1] / (2.0 * halves.mean())), 1, MOST_SLABS))",
    ): "how many slabs of time there are: speed alone",
    (
        "near_pairs.py",
        "cuts = np.interp(np.linspace(0.0, progress[-1], count + 1)[1:-1], progress, times[order])",
    ): "where they are cut: speed alone",
    (
        "pairs.py",
        "FIRST_REACH, FURTHER = 0.5, 4.0",
    ): "what is said of unlisted pairs is proven for any",
    ("pairs.py", "reach *= FURTHER"): "the same",
    ("box_tree.py", "_STEPS = 2**16 - 1"): "which segments share a leaf: speed alone",
    (
        "box_tree.py",
        "pairs = level.reshape(-1, 2, 4)",
    ): "numpy takes every negative length for the rest",
    (
        "wall_clearance.py",
        "moves = np.append(True, (np.diff(points, axis=0) != 0).any(axis=1))",
    ): "knots that repeat are left out for speed",
    (
        "box_tree.py",
        "leaves = 1 << max(count - 1, 0).bit_length()",
    ): "more leaves than needed are empty: speed alone",
    ("wall_clearance.py", "swap = far < near"): "which child is looked at first: speed alone",
    ("wall_clearance.py", "if gap < best:"): "which of places that are equally near is named",
    ("wall_clearance.py", "along = 0.0"): "on a segment without length every point is the same",
    (
        "wall_clearance.py",
        "inside = free_space.contains(np.array([curve[0, :2] for curve in curves]))",
    ): "any knot of a path that keeps away tells; of a knot x and y are looked at",
    ("wall_clearance.py", "edge = -1"): "the first edge is nearer than infinity",
    ("wall_clearance.py", "segment = -1"): "the same",
    ("wall_clearance.py", "stack = np.empty(64, dtype=np.int64)"): "no tree is so deep",
    (
        "history.py",
        'until = np.append(times[1:], times[-1]) if what == "speed" else times',
    ): "the speed after the last knot is 0, whatever its limit",
    ("history.py", "SAME_TIME = 1e-9"): "a tolerance between rounding and anything that matters",
    (
        "history.py",
        "for k in np.flatnonzero(np.abs(times - stop) <= SAME_TIME * (times[-1] - times[0]))",
    ): "the same",
    (
        "near_pairs.py",
        "step = lines.knots[first + 1] - lines.knots[first]",
    ): "where time is cut: speed alone",
    (
        "near_pairs.py",
        "for q in range(p + 1, begins[bucket + 1]):",
        "1 -> 2",
        "bucket + 1",
    ): "what lies in other cells is left out anyhow",
    (
        "near_pairs.py",
        "size += max(boxes[i, 2] - boxes[i, 0], boxes[i, 3] - boxes[i, 1]) / len(boxes)",
    ): "how large cells are: speed alone",
    (
        "box_tree.py",
        "extent = max(float((middles.max(axis=0) - low).max()), 2.0**-500)",
    ): "which segments share a leaf: speed alone",
    (
        "box_tree.py",
        "for shift, mask in ((8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):",
    ): "the same",
    (
        "wall_clearance.py",
        "edges = np.ascontiguousarray(frame.local(walls.reshape(-1, 2)).reshape(-1, 4))",
        "1 -> 2",
        "-1",
    ): "numpy takes every negative length for the rest",
    (
        "motion.py",
        "if arrives + visit.dwell <= min(end, leave) + late:",
        "LtE -> Lt",
    ): "there is a tolerance on one side",
    (
        "meetings.py",
        "return np.column_stack([np.interp(times, curve[:, 2], curve[:, x]) for x in range(2)])",
        "2 -> 3",
        "range(2)",
    ): "time as a third coordinate is the same for both",
    (
        "history.py",
        "when = np.append(0.5 * (times[1:] + times[:-1]), times[-1])",
        "1 -> 2",
        "times[-1])",
    ): "after the last knot the speed is 0, and never the greatest",
    (
        "local_frame.py",
        "largest = float(np.abs([low, high]).max())",
        "max -> min",
    ): "coordinates that differ do so by their spacing at least",
    ("wall_clearance.py", "if along <= 0.0:", "LtE -> Lt"): "at an end both ways give that end",
    ("wall_clearance.py", "if along >= 1.0:", "GtE -> Gt"): "the same",
    (
        "history.py",
        "if curve is None or curve[0, 2] >= world.end:",
        "GtE -> Gt",
    ): "who comes as a world ends is left out below",
    (
        "history.py",
        'if agent.after_arrival == "vanish" or begin >= world.end:',
        "GtE -> Gt",
    ): "what begins before a world begins before its end",
    (
        "history.py",
        "until = min(world.end, max(world.scene.final_time, begin + 1.0))",
        "Add -> Sub",
    ): "how long whoever stands is looked at after all have arrived",
    ("pairs.py", "reach = FIRST_REACH * 2.0 * float(halves.max())"): "the same",
    ("pairs.py", "if (found.distance - needs <= reach).any() or reach > furthest:"): "the same",
    ("pairs.py", "if demanded <= LISTED:", "LtE -> Lt"): "either way is judged the same",
    (
        "places.py",
        "inside = bool((above & (crossing > point[0])).sum() % 2)",
        "Gt -> GtE",
    ): "on an edge the distance is 0 either way",
    (
        "play.py",
        "if when is not None and when < leaves - time_tolerance(curve):",
        "Sub -> Add",
    ): "a tolerance between rounding and anything that matters",
    (
        "play.py",
        "times = times[(times >= max(curve[0, 2], other[0, 2])) & (times <= last)]",
        "max -> min",
    ): "all are there from the same time on, and clipped after their ends",
    (
        "ends.py",
        "if gap > place_tolerance(agent, curve) or curve[-1, 2] != given[-1, 2]:",
        "Gt -> GtE",
    ): "there is a tolerance on one side",
    (
        "meetings.py",
        "return self.distance <= self.within * (1.0 + ROUNDING)",
        "LtE -> Lt",
    ): "there is a tolerance on one side",
    (
        "meetings.py",
        'return MeetingSpot(who, within, float("inf"), float(begin), (0.0, 0.0))',
        "0.0 -> 0.5",
    ): "who never meets does so nowhere",
    (
        "motion.py",
        "rounding = 4.0 * float(np.spacing(np.abs(curve[:, 2]).max()))",
        "4.0 -> 6.0",
    ): "how many roundings count",
    (
        "motion.py",
        "safe = np.where(moves, squared, 1.0)",
        "1.0 -> 1.5",
    ): "what stands for lengths of nothing is not used",
    (
        "motion.py",
        "for k in np.flatnonzero(np.where(moves, (across >= 0) & (first <= last), near)):",
        "GtE -> Gt",
    ): "just touching the tolerance is rounding",
    (
        "local_frame.py",
        "unit = max(2.0 ** np.ceil(np.log2(max(float((high - low).max()), 2.0**-500))),",
        "500 -> 501",
    ): "no scene is so small",
    (
        "near_pairs.py",
        "members = np.empty((total, 3), dtype=np.int64)",
        "3 -> 4",
    ): "room that is not used",
    (
        "near_pairs.py",
        "total += (cells[i, 2] - cells[i, 0] + 1.0) * (cells[i, 3] - cells[i, 1] + 1.0)",
        "1.0 -> 1.5",
    ): "when cells grow: speed alone",
}


def means_the_same(name: str, line: str, what: str, column: int) -> tuple[str, ...] | None:
    """The key of `EQUIVALENT` that a change at a column of a line falls under."""
    for key in EQUIVALENT:
        file, text, kind, part = (*key, *("", "")[len(key) - 2 :])
        if (file, text) == (name, line) and kind in ("", what):
            spots = [found.span() for found in re.finditer(re.escape(part), line)]
            if not part or any(first <= column < last for first, last in spots):
                return key
    return None


def read(path: Path) -> str:
    """The text of a module, by its path from the root."""
    return (ROOT / path).read_text(encoding="utf-8")


def mutations(tree: ast.Module) -> Iterator[tuple[ast.AST, str]]:
    """Places in a module that can be changed, and what the change is."""
    skipped = {
        id(inner)
        for node in ast.walk(tree)
        for part in (
            getattr(node, "annotation", None),
            getattr(node, "returns", None),
            # It asks for lengths that are equal anyhow.
            node.value if isinstance(node, ast.keyword) and node.arg == "strict" else None,
        )
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


def tests_pass(copied: Path, module: Path, text: str, limit: float | None) -> bool | None:
    """Whether the tests of the room pass with a module replaced by `text`; None after `limit` seconds."""
    kept = (copied / module).read_text(encoding="utf-8")
    (copied / module).write_text(text, encoding="utf-8")
    own = Path("tests/certify") / f"test_{module.name}"
    tests = [str(own)] if (copied / own).is_file() else []
    try:
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *tests, "tests/certify"],
            cwd=copied, env=os.environ | {"PYTHONPATH": str(copied)}, capture_output=True,
            check=False, timeout=limit,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return None
    finally:
        (copied / module).write_text(kept, encoding="utf-8")
    return done.returncode == 0


def main() -> None:
    """Try all mutants, or a sample, and say which survive."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sample", type=int, metavar="N")
    parser.add_argument("--rng-seed", type=int, metavar="N", default=0)
    arguments = parser.parse_args()
    wanted = arguments.sample
    cases = []
    seen = set()
    for path in sorted((ROOT / ROOM).glob("*.py")):
        text = read(path)
        lines = [line.partition("  #")[0].strip() for line in text.splitlines()]
        for number, (node, what) in enumerate(mutations(ast.parse(text))):
            place = node.lineno  # type: ignore[attr-defined]
            line = lines[place - 1]
            indent = len(text.splitlines()[place - 1]) - len(text.splitlines()[place - 1].lstrip())
            key = means_the_same(path.name, line, what, node.col_offset - indent)  # type: ignore[attr-defined]
            if key is not None:
                seen.add(key)
            else:
                cases.append((path.relative_to(ROOT), number, place, what))
    if gone := sorted(EQUIVALENT.keys() - seen):
        sys.exit(f"there is no such line any more: {gone}")
    if wanted is not None:
        cases = random.Random(arguments.rng_seed).sample(cases, min(wanted, len(cases)))
    alive = 0
    with tempfile.TemporaryDirectory(prefix="stplan-mutants-") as name:
        copied = Path(name)
        for folder in ("stplan", "tests", "scenes", "docs"):
            shutil.copytree(ROOT / folder, copied / folder)
        shutil.copy2(ROOT / "pyproject.toml", copied)
        first = cases[0][0]
        began = time.monotonic()
        # Rewritten as mutants are, so that it is compiled anew, too.
        if not tests_pass(copied, first, ast.unparse(ast.parse(read(first))), None):
            sys.exit("tests/certify does not pass as it is")
        limit = max(LEAST_PATIENCE, PATIENCE * (time.monotonic() - began))
        for tried, (path, number, line, what) in enumerate(cases, start=1):
            tree = ast.parse(read(path))
            mutate(list(mutations(tree))[number][0])
            passed = tests_pass(copied, path, ast.unparse(tree), limit)
            if passed is not False:
                alive += passed is True
                end = "survives" if passed else "does not end"
                print(f"{end}: {path}:{line}: {what} ({tried} of {len(cases)} tried)", flush=True)
    killed = len(cases) - alive
    print(f"{killed} of {len(cases)} mutants killed: {100 * killed / len(cases):.0f} %")


if __name__ == "__main__":
    main()
