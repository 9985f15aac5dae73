"""Pages made of the program itself: the scene format of its schema, every command, pages of runs.

A page of `GENERATED` says where: its line `<!-- generated -->` gives way to what is made here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click
import typer.main
from sphinx.application import Sphinx

import stplan
from stplan.bench.history import read_history, trends
from stplan.cli.app import app as program
from stplan.scene import load_scene, scene_schema
from stplan.viewing.page import page_bytes
from stplan.viewing.run_view import view_plan

MARK = "<!-- generated -->"
ROOT = Path(__file__).parents[2]
# Planned while the site is built, and embedded in its gallery.
EMBEDDED = {
    "bottleneck": ROOT / "scenes" / "bottleneck" / "bottleneck.yaml",
    "circle-8": ROOT / "scenes" / "circle" / "circle-8.yaml",
    "pocket-swap": ROOT / "scenes" / "tight" / "pocket-swap.yaml",
}


def scene_reference() -> str:
    """Every mapping of the scene format with its keys."""
    schema = scene_schema()
    mappings = {
        name: part
        for name, part in sorted(schema["$defs"].items())
        if part.get("type") == "object" and part.get("properties")
    }
    lines: list[str] = []
    for name, part in {"A scene": schema, **mappings}.items():
        lines += [f"## {_spoken(name)}", "", part.get("description", ""), ""]
        lines += ["| key | takes | default | is |", "| --- | --- | --- | --- |"]
        required = part.get("required", [])
        for key, value in part["properties"].items():
            default = (
                "required"
                if key in required
                else _code(value["default"])
                if "default" in value
                else ""
            )
            lines.append(
                f"| `{key}` | {_takes(value)} | {default} | {_cell(value.get('description', ''))} |"
            )
        lines.append("")
    return "\n".join(lines)


def _spoken(name: str) -> str:
    """`CrowdStartFile` as `Crowd start`."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name.removesuffix("File"))
    return words.capitalize() if " " in words else words


def _takes(value: dict[str, Any]) -> str:
    if "$ref" in value:
        name = _spoken(value["$ref"].rpartition("/")[2])
        return f"[{name}](#{name.lower().replace(' ', '-')})"
    for choice in ("anyOf", "oneOf"):
        if choice in value:
            parts = [_takes(one) for one in value[choice] if one.get("type") != "null"]
            return " or ".join(dict.fromkeys(parts))
    if "const" in value:
        return _code(value["const"])
    if "enum" in value:
        return ", ".join(map(_code, value["enum"]))
    if value.get("type") == "array":
        return f"list of {_takes(value['items'])}" if value.get("items") else "list"
    limits = {
        "minimum": "at least", "exclusiveMinimum": "above", "maximum": "at most", "exclusiveMaximum": "below",
    }  # fmt: skip
    bounds = [f"{word} {value[key]:g}" for key, word in limits.items() if key in value]
    kind = {"object": "mapping", "string": "text", "boolean": "true or false"}.get(
        value.get("type", ""), value.get("type", "anything")
    )
    return " ".join([kind, ", ".join(bounds)]).strip()


def _code(value: Any) -> str:
    if isinstance(value, dict | list | str) and not value:
        return ""
    if isinstance(value, dict):
        return "see there"
    return f"`{str(value).lower() if isinstance(value, bool) else value}`"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def command_reference() -> str:
    """Every command: its help and its options."""
    lines: list[str] = []
    for path, command in _commands(typer.main.get_command(program), ("stplan",)):
        text = re.sub(r"\x08\n?", "", command.help or "")
        context = click.Context(command, info_name=" ".join(path))
        usage = " ".join([*path, *command.collect_usage_pieces(context)])
        lines += [f"## {' '.join(path)}", "", "```text", usage, "```", ""]
        lines += ["```text", text.strip(), "```", ""]
        options = [one for one in command.params if isinstance(one, click.Option)]
        lines += ["| option | does |", "| --- | --- |"]
        lines += [
            f"| {', '.join(f'`{name}`' for name in one.opts)} | {_cell(one.help or '')} |"
            for one in options
        ]
        lines.append("")
    return "\n".join(lines)


def _commands(group: Any, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any]]:
    for name, command in group.commands.items():
        if hasattr(command, "commands"):
            yield from _commands(command, (*path, name))
        else:
            yield (*path, name), command


def python_reference() -> str:
    """Everything public, from its docstring."""
    lines: list[str] = []
    for name in stplan.__all__:
        if name.startswith("__"):
            continue
        kind = "function" if callable(getattr(stplan, name)) else "module"
        if isinstance(getattr(stplan, name), type):
            kind = "class"
        home = "stplan.errors" if kind == "module" else f"stplan.{name}"
        lines += [f"## {name}", "", "```{eval-rst}", f".. auto{kind}:: {home}"]
        if kind != "function":
            lines += ["   :members:", "   :no-index:" if kind == "module" else ""]
        lines += ["```", ""]
    return "\n".join(lines)


def trend_tables() -> str:
    """What benchmarks took, record by record."""
    history = read_history(ROOT / "docs" / "bench-history.csv")
    return trends(history) if history else "Nothing has been recorded yet."


GENERATED: dict[str, Callable[[], str]] = {
    "site/reference/scene": scene_reference,
    "site/reference/commands": command_reference,
    "site/reference/api": python_reference,
    "site/trends": trend_tables,
}


def fill_in(app: Sphinx, name: str, source: list[str]) -> None:
    """Put what is generated into its page."""
    del app
    if name in GENERATED:
        source[0] = source[0].replace(MARK, GENERATED[name]())
    # Tables of contents have no place for a heading that links to a file.
    source[0] = re.sub(r"(?m)^(#+) \[(.*)\]\(.*\)$", r"\1 \2", source[0])


def write_runs(app: Sphinx, error: Exception | None) -> None:
    """Plan the scenes of the gallery and write their interactive pages beside it."""
    if error is not None:
        return
    folder = Path(app.outdir) / "site" / "runs"
    folder.mkdir(parents=True, exist_ok=True)
    for name, scene in EMBEDDED.items():
        (folder / f"{name}.html").write_bytes(page_bytes(view_plan(stplan.plan(load_scene(scene)))))


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("source-read", fill_in)
    app.connect("build-finished", write_runs)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
