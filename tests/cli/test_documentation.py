"""Commands and examples in README.md and docs/ are what the program understands."""

from __future__ import annotations

import re
import shlex
import subprocess
from pathlib import Path

import pytest
import typer.main
import yaml

from stplan.cli.app import app

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
_SHELL_ENDS = re.compile(r"\s(?:[|>&;]|2>).*$")
# Quick, and without need of results of other commands.
FOLLOWED = {"tutorial.md", "crowds.md", "animation.md", "fleets.md"}
_CHEAP = ("validate", "schema", "--help", "--version", "import", "new")


def _blocks(languages: set[str]) -> list[tuple[Path, str]]:
    return [
        (page, text)
        for page in PAGES
        for language, text in _BLOCK.findall(page.read_text(encoding="utf-8"))
        if language in languages
    ]


def _commands(program: str) -> list[tuple[str, list[str]]]:
    found = []
    for page, text in _blocks({"bash", "console", "sh"}):
        for line in text.replace("\\\n", " ").splitlines():
            command = _SHELL_ENDS.sub("", line.strip().removeprefix("$ "))
            words = shlex.split(command, comments=True)
            if words and words[0] == program:
                found.append((f"{page.name}: {command}", words[1:]))
    return found


STPLAN = _commands("stplan")


def test_there_is_something_to_check():
    assert {words[0] for _, words in STPLAN} >= {"solve", "seed", "check", "diff", "validate"}
    assert any(words == ["demo"] for _, words in _commands("make"))


@pytest.mark.parametrize("words", [pytest.param(words, id=name) for name, words in STPLAN])
def test_command_is_understood(words):
    group = typer.main.get_command(app)
    if words[0].startswith("-"):
        assert words[0] in {"--help", "-h", "--version", "--install-completion"}
        return
    with group.make_context("stplan", list(words)) as context:
        command = group.get_command(context, words[0])
        assert command is not None, f"there is no command {words[0]}"
        # Raises where an option is unknown or a value cannot be converted.
        command.make_context(words[0], list(words[1:]), parent=context).close()


@pytest.mark.parametrize("words", [pytest.param(words, id=name) for name, words in STPLAN])
def test_scenes_named_are_there(words):
    named = [word for word in words if word.startswith("scenes/")]
    missing = [word for word in named if not list(ROOT.glob(word))]
    assert not missing


@pytest.mark.parametrize(
    "words",
    [
        pytest.param(words, id=name)
        for name, words in STPLAN
        # Tutorials are followed as wholes by tests of their own.
        if (words[0] in _CHEAP or (words[0] == "check" and name.startswith("formats.md")))
        and name.partition(":")[0] not in FOLLOWED
    ],
)
def test_cheap_command_runs(run, monkeypatch, words):
    monkeypatch.chdir(ROOT)
    expanded = [
        path
        for word in words
        for path in (sorted(map(str, ROOT.glob(word))) if "*" in word else [word])
    ]
    result = run(*expanded)
    assert result.status == 0, result.err


@pytest.mark.parametrize(
    "text",
    [
        pytest.param(text, id=page.name)
        for page, text in _blocks({"python"})
        if page.name not in FOLLOWED
    ],
)
def test_python_example_runs(monkeypatch, tmp_path, capsys, text):
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    monkeypatch.chdir(tmp_path)
    exec(compile(text, "example", "exec"), {"__name__": "__example__"})
    assert capsys.readouterr().err == ""


def test_make_without_a_target_lists_those_that_the_readme_names():
    listed = subprocess.run(
        ["make", "--no-print-directory"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    for _, words in _commands("make"):
        assert f"make {words[0]} " in listed


def test_the_workflow_for_ci_does_what_it_says(run, monkeypatch, tmp_path):
    (text,) = [text for _, text in _blocks({"yaml"}) if text.startswith("name: trajectories")]
    steps = yaml.safe_load(text)["jobs"]["trajectories"]["steps"]
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    monkeypatch.chdir(tmp_path)
    commands = [step["run"] for step in steps if step.get("run", "").startswith("stplan")]
    assert [shlex.split(command)[1] for command in commands] == ["validate", "solve", "diff"]

    def expanded(word: str) -> list[str]:
        # Two scenes stand for all of them.
        return sorted(map(str, Path().glob(word)))[-2:] if "*" in word else [word]

    def follow(command: str):
        words = shlex.split(_SHELL_ENDS.sub("", command))[1:]
        return run(*(path for word in words for path in expanded(word)))

    assert follow(commands[0]).status == 0
    assert follow(commands[1].replace("-o runs", "-o golden")).status == 0
    assert follow(commands[1]).status == 0
    result = follow(commands[2])
    assert (result.status, result.out.splitlines()[0]) == (
        0, "### stplan diff: 2 of 2 common runs equal",
    )  # fmt: skip
    golden = next(Path("golden").glob("*/trajectories.npz"))
    golden.unlink()
    table = golden.with_suffix(".csv")
    table.write_text(re.sub(r"(?m)^(\w+,1,)[^,]+", r"\g<1>7.5", table.read_text()))
    result = follow(commands[2])
    assert result.status == 1
    assert "1 of 2 common runs equal" in result.out


def test_the_words_about_a_scene_are_those_of_the_page(run, monkeypatch):
    monkeypatch.chdir(ROOT)
    page = (ROOT / "docs" / "explain.md").read_text(encoding="utf-8")
    (command, said), *_ = re.findall(r"```bash\nstplan (.*?)\n```\n\n```text\n(.*?)```", page, re.S)
    assert run(*shlex.split(command)).out == said
