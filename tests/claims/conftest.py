"""Claims of the paper as figures: every one is asserted, and `--figures FILE` writes them as a table."""

from __future__ import annotations

import inspect
from dataclasses import dataclass
from pathlib import Path

import pytest

HEAD = """# The paper's claims, as figures

Every row is a claim of the paper, what is measured on plans of the scenes in `scenes/`, what came out and
what is asked. The tests in `tests/claims/` make these figures and assert them; `make claims` plans every
scene again and writes this page.

| scene | claim | measured | figure | asked |
| --- | --- | --- | ---: | --- |
"""
_ROWS = pytest.StashKey[list[tuple[str, ...]]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--figures", metavar="FILE", help="write the figures of the claims into FILE")


def pytest_configure(config: pytest.Config) -> None:
    config.stash[_ROWS] = []


@dataclass(frozen=True)
class Claim:
    """Asserts figures of one test; `sentence` is what its docstring says first."""

    sentence: str
    rows: list[tuple[str, ...]]

    def __call__(
        self,
        scene: str,
        measured: str,
        figure: float,
        *,
        at_least: float | None = None,
        at_most: float | None = None,
    ) -> None:
        """Assert that a figure lies within its bounds, and keep it for the table."""
        bounds = [f"at least {at_least:g}"] if at_least is not None else []
        bounds += [f"at most {at_most:g}"] if at_most is not None else []
        self.rows.append((scene, self.sentence, measured, f"{figure:.4g}", ", ".join(bounds)))
        assert bounds, "a figure needs a bound"
        assert at_least is None or figure >= at_least, f"{measured}: {figure}"
        assert at_most is None or figure <= at_most, f"{measured}: {figure}"


@pytest.fixture
def claim(request: pytest.FixtureRequest) -> Claim:
    sentence = inspect.getdoc(request.function) or ""
    first = " ".join(sentence.split("\n\n")[0].split()).rstrip(".")
    return Claim(first, request.config.stash[_ROWS])


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    target = session.config.getoption("figures", None)
    if target and exitstatus == 0:
        rows = [f"| {' | '.join(row)} |" for row in session.config.stash[_ROWS]]
        Path(target).write_text(HEAD + "\n".join(rows) + "\n", encoding="utf-8")
