"""One name a thing: a reader who meets a type, or a module, has met all of its name."""

from __future__ import annotations

import ast
from collections import Counter
from pathlib import Path

import stplan

PACKAGE = Path(stplan.__file__).parent
MODULES = sorted(PACKAGE.rglob("*.py"))


def public_types() -> Counter[str]:
    """How often each public class is defined at the top of a module."""
    found: Counter[str] = Counter()
    for path in MODULES:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        found.update(node.name for node in tree.body if isinstance(node, ast.ClassDef))
    return Counter({name: times for name, times in found.items() if not name.startswith("_")})


def test_no_two_types_share_a_name():
    types = public_types()
    assert len(types) > 100
    assert [name for name, times in types.items() if times > 1] == []


def test_no_module_is_called_after_nothing():
    names = {path.stem for path in MODULES}
    assert not names & {"utils", "util", "helpers", "misc", "common", "tools"}


def test_modules_are_short_enough_to_be_one_idea():
    long = [path.name for path in MODULES if path.read_text(encoding="utf-8").count("\n") > 400]
    assert long == []
