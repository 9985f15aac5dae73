"""The drawing of the house is the one that import-linter holds."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")


def rooms(line: str) -> list[str]:
    """The rooms of a layer."""
    return re.findall(r"\w+", line)


def test_the_page_draws_the_layers_that_are_enforced() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    layers = settings["tool"]["importlinter"]["contracts"][0]["layers"]
    drawn = PAGE.split("```\n")[1].splitlines()
    # The rest of a line, after two spaces, is what the rooms are for.
    assert [rooms(re.split(r"\s{2,}", line)[0]) for line in drawn] == [
        rooms(layer) for layer in layers if layer != "__main__"
    ]


def test_every_folder_has_its_row() -> None:
    folders = {path.parent.name for path in (ROOT / "stplan").glob("*/__init__.py")}
    rows = set(re.findall(r"^\| `(\w+)/` \|", PAGE, re.MULTILINE))
    assert folders == rows


def test_the_functions_of_the_stages_exist() -> None:
    from importlib import import_module

    table = PAGE.split("| stage | function |")[1].split("\n\n")[0]
    stages = re.findall(r"^\| \w+ \| `([\w.]+)` \| ", table, re.MULTILINE)
    assert len(stages) == 8
    for stage in stages:
        module, _, name = stage.rpartition(".")
        assert callable(getattr(import_module(f"stplan.{module}"), name))
