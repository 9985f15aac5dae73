"""What `import stplan` offers: documented, typed, complete, and its examples true."""

from __future__ import annotations

import doctest
import inspect
from importlib import import_module
from pathlib import Path

import pytest

import stplan

FUNCTIONS = sorted(name for name in stplan.__all__ if inspect.isroutine(getattr(stplan, name)))
HOMES = sorted({getattr(stplan, name).__module__ for name in FUNCTIONS})


def test_names_are_what_their_homes_hold():
    assert set(stplan._HOMES) == set(stplan.__all__) - {"__version__", "errors"}
    for name, home in stplan._HOMES.items():
        assert getattr(stplan, name) is getattr(import_module(home), name)


@pytest.mark.parametrize("name", sorted(set(stplan.__all__) - {"__version__"}))
def test_everything_public_is_documented(name):
    assert (inspect.getdoc(getattr(stplan, name)) or "").strip()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_everything_public_is_typed(name):
    signature = inspect.signature(getattr(stplan, name))
    missing = [p.name for p in signature.parameters.values() if p.annotation is p.empty]
    assert missing == []
    assert signature.return_annotation is not signature.empty


def test_the_package_says_that_it_is_typed():
    assert (Path(stplan.__file__).parent / "py.typed").is_file()


@pytest.mark.parametrize("home", HOMES)
def test_examples_in_docstrings_are_true(home):
    failed, _ = doctest.testmod(import_module(home))
    assert failed == 0


def test_there_are_examples():
    finder = doctest.DocTestFinder()
    examples = [
        each
        for home in HOMES
        for test in finder.find(import_module(home))
        for each in test.examples
    ]
    assert len(examples) >= 15


def test_the_page_names_everything_public():
    page = (Path(__file__).parents[1] / "docs" / "python.md").read_text(encoding="utf-8")
    missing = [name for name in stplan.__all__ if f"`{name}" not in page and f".{name}" not in page]
    assert missing == []
