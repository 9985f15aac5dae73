"""A function becomes a command: its switches, its console, its exit status."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Annotated

import pytest
import typer

from stplan.cli.command import command, group
from stplan.cli.console import Console
from stplan.errors import SceneError, SeedingError, SolverError


@pytest.fixture
def app() -> typer.Typer:
    commands = group()

    @command(commands)
    def count(
        console: Console,
        words: Annotated[list[str], typer.Argument(help="What to count.")],
        *,
        at_most: Annotated[int, typer.Option(help="No more than these.")] = 9,
    ) -> int:
        """Count words."""
        if len(words) > at_most:
            raise SeedingError("too many")
        console.result(f"{len(words)} words")
        console.result_json({"exit_status": 0, "words": words})
        return 0

    @command(commands, "plain", without=("quiet", "as_json"))
    def other(console: Console) -> int:
        """Nothing."""
        console.result("verbose" if console.verbose else "plain")
        return 1

    return commands


@pytest.fixture
def call(app, capsys):
    def run(*arguments: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as left:
            app(args=list(arguments))
        return (int(left.value.code or 0), *capsys.readouterr())

    return run


def test_arguments_and_switches_reach_the_function(call):
    assert call("count", "a", "b") == (0, "2 words\n", "")
    assert call("count", "a", "b", "--quiet") == (0, "", "")
    status, out, _ = call("count", "a", "b", "--json")
    assert (status, json.loads(out)["words"]) == (0, ["a", "b"])


# With the page that says more.
TOO_MANY = f"too many\nmore on this: {SeedingError.page}\n"


def test_the_pages_that_errors_name_exist():
    root = Path(__file__).parents[2]
    keys = [
        "name",
        "map",
        "agents",
        "defaults",
        "places",
        "groups",
        "pairs",
        "events",
        "seeding",
        "solver",
        "preset",
    ]
    faults = [SceneError(f"a.yaml:3:4: {key}.more: is wrong") for key in keys]
    faults += [
        SceneError("a.yaml:3:4: no YAML"),
        SceneError("--set agents.sam: KEY=VALUE is expected"),
    ]
    pages = [error.page for error in (SeedingError, SolverError, *faults)]
    assert len(set(pages)) == 2 + len(faults) - 1
    for page, _, anchor in (page.partition("#") for page in pages):
        headings = re.findall(r"(?m)^#+ (.*)$", (root / page).read_text(encoding="utf-8"))
        assert not anchor or anchor in {
            re.sub(r"[^\w -]", "", heading).lower().replace(" ", "-") for heading in headings
        }


def test_what_says_all_there_is_names_no_page():
    assert SceneError("no.yaml: no such scene file").page == ""


def test_an_exception_is_its_exit_status_and_a_message(call):
    assert call("count", "a", "b", "--at-most", "1") == (3, "", TOO_MANY)
    status, out, err = call("count", "a", "b", "--at-most", "1", "--json")
    assert (status, json.loads(out), err) == (
        3, {"exit_status": 3, "messages": ["too many"]}, TOO_MANY,
    )  # fmt: skip


def test_a_command_may_have_fewer_switches_and_another_name(call):
    assert call("plain", "-v") == (1, "verbose\n", "")
    assert call("plain", "--json")[0] == 2
    assert "--quiet" not in call("plain", "--help")[1]
