"""Help: every command says what it does, with examples that are understood; the shell completes."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys

import click
import pytest
import typer.main

from stplan.cli.app import app

GROUP = typer.main.get_command(app)


def _commands(group=GROUP, path=("stplan",)):
    for name, command in sorted(group.commands.items()):
        if hasattr(command, "commands"):
            yield from _commands(command, (*path, name))
        else:
            yield (*path, name), command


COMMANDS = dict(_commands())


@pytest.mark.parametrize("path", COMMANDS, ids=" ".join)
def test_a_command_is_explained_with_examples(run, path):
    text = run(*path[1:], "--help").out
    summary, examples = text.split("\n\n")[1], re.split(r"\n  Examples?:\n", text)
    assert summary.strip().endswith(".")
    assert len(examples) == 2
    shown = [line for line in examples[1].split("\n\n")[0].splitlines() if line.strip()]
    assert shown
    for line in shown:
        words = shlex.split(re.sub(r"\s(?:[|>]|2>).*$", "", line))
        assert words[: len(path)] == list(path)
        # Raises where an option is unknown or a value cannot be converted.
        COMMANDS[path].make_context(path[-1], words[len(path) :]).close()


@pytest.mark.parametrize("path", COMMANDS, ids=" ".join)
def test_every_option_is_explained(path):
    for parameter in COMMANDS[path].params:
        if not isinstance(parameter, click.Argument):
            assert parameter.help, parameter.name


def test_the_program_is_explained(run):
    text = run("--help").out
    for heading in ("Examples:", "Files of a run", "Exit status:", "Commands:"):
        assert heading in text
    for status in (0, 1, 2, 3, 4, 5, 130):
        assert re.search(rf"^    {status} +\w", text, re.MULTILINE)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("stplan s", {"solve", "seed", "schema"}),
        ("stplan ex", {"explain", "export"}),
        ("stplan diff --fo", {"--format"}),
        ("stplan diff a b --format m", {"markdown"}),
    ],
)
def test_the_shell_completes(words, expected):
    environment = os.environ | {
        "_STPLAN_COMPLETE": "complete_bash",
        "COMP_WORDS": words,
        "COMP_CWORD": str(len(words.split()) - 1),
    }
    done = subprocess.run(
        [sys.executable, "-m", "stplan"],
        env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert set(done.stdout.split()) == expected, done.stderr
