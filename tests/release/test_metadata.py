"""What a release is made of: one version everywhere, readable files, workflows that do what is there."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import tomllib
from pathlib import Path

import pytest
import typer.main
import yaml
from setuptools_scm import get_version

from stplan.cli.app import app

ROOT = Path(__file__).parents[2]
CONTENT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT, SCM = CONTENT["project"], CONTENT["tool"]["setuptools_scm"]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
FILES = [*WORKFLOWS, *sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"))]


def _yaml(path: Path):
    return yaml.safe_load(path.read_text(encoding="utf-8"))


def test_the_last_release_is_the_same_everywhere():
    # The version itself is that of a tag.
    assert "version" in PROJECT["dynamic"]
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    released = re.findall(r"(?m)^## \[(\d[^\]]*)\]", changes)[0]
    assert SCM["fallback_version"] == released
    assert _yaml(ROOT / "CITATION.cff")["version"] == released
    zenodo = json.loads((ROOT / ".zenodo.json").read_text(encoding="utf-8"))
    assert zenodo["version"] == released
    recipe = _yaml(ROOT / ".ci" / "conda" / "recipe.yaml")
    assert recipe["context"]["version"] == released


def test_a_version_is_found_with_and_without_history(tmp_path):
    def version(folder: Path) -> str:
        return get_version(root=folder, **SCM)

    assert version(tmp_path) == SCM["fallback_version"]
    settings = ["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false"]
    for words in (
        ["init", "-q"], ["commit", "-q", "--allow-empty", "-m", "first"], ["tag", "v1.2.3"],
    ):  # fmt: skip
        subprocess.run(["git", *settings, *words], cwd=tmp_path, check=True)
    assert version(tmp_path) == "1.2.3"
    subprocess.run(
        ["git", *settings, "commit", "-q", "--allow-empty", "-m", "next"], cwd=tmp_path, check=True
    )
    assert version(tmp_path) == "1.2.4.dev1"


def test_the_recipe_asks_for_what_the_package_asks_for():
    recipe = _yaml(ROOT / ".ci" / "conda" / "recipe.yaml")
    asked = {tuple(line.split()) for line in recipe["requirements"]["run"]} - {("python", ">=3.11")}
    wanted = {tuple(re.split(r"(?=[>=])", line, maxsplit=1)) for line in PROJECT["dependencies"]}
    # From conda-forge Ipopt's interface comes under its own name.
    assert {name for name, *_ in asked ^ wanted} == {"cyipopt", "cyipopt-wheels"}


def test_the_citation_has_what_its_format_requires():
    citation = _yaml(ROOT / "CITATION.cff")
    assert {"cff-version", "message", "title", "authors"} <= set(citation)
    assert citation["license"] == PROJECT["license"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_files_that_the_forge_reads_can_be_read(path):
    assert isinstance(_yaml(path), dict)


def test_systems_and_versions_are_those_that_are_claimed():
    matrix = _yaml(ROOT / ".github/workflows/check.yml")["jobs"]["test"]["strategy"]["matrix"]
    claimed = {one.rpartition(" ")[2] for one in PROJECT["classifiers"] if "Python :: 3." in one}
    assert set(matrix["python"]) == claimed
    assert {name.partition("-")[0] for name in matrix["os"]} == {"ubuntu", "macos", "windows"}


def test_parts_of_the_suite_cover_all_of_it_once():
    matrix = _yaml(ROOT / ".github/workflows/check.yml")["jobs"]["test"]["strategy"]["matrix"]
    parts = {one["part"]: one["tests"].split() for one in matrix["include"]}
    assert set(parts) == set(matrix["part"])
    rest = parts.pop("rest")
    named = [folder for part in parts.values() for folder in part]
    assert len(named) == len(set(named))
    assert all((ROOT / folder).is_dir() for folder in named)
    assert rest == ["tests", *(f"--ignore={folder}" for folder in rest_order(rest, named))]


def rest_order(rest: list[str], named: list[str]) -> list[str]:
    """The named folders, in the order in which they are left out."""
    order = [word.partition("=")[2] for word in rest[1:]]
    assert set(order) == set(named)
    return order


def test_commands_of_workflows_are_understood():
    group = typer.main.get_command(app)
    targets = re.findall(r"(?m)^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"))
    seen = set()
    for path in WORKFLOWS:
        for job in _yaml(path)["jobs"].values():
            for step in job["steps"]:
                program, *words = shlex.split(step.get("run", "true"), comments=True)
                seen.add(program)
                if program == "stplan":
                    with group.make_context("stplan", list(words)) as context:
                        command = group.get_command(context, words[0])
                        assert command is not None
                        command.make_context(words[0], words[1:], parent=context).close()
                if program == "make":
                    assert set(words) <= set(targets)
                if words and words[0].endswith(".py"):
                    assert (ROOT / words[0]).is_file()
    assert {"stplan", "make", "python"} <= seen


def test_what_contributors_are_told_exists():
    for path in (ROOT / ".github").glob("*.md"):
        for link in re.findall(r"\]\(([^)#]+)", path.read_text(encoding="utf-8")):
            assert (path.parent / link).exists(), (path.name, link)
