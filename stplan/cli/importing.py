"""The commands that make scenes: import, of other programs' files, and new."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stplan.cli.command import command, group
from stplan.cli.console import Console, write
from stplan.errors import UsageError

if TYPE_CHECKING:
    from stplan.imports.draft import SceneDraft
    from stplan.maps.formats.drawing import FileOptions

app = group()

Target = Annotated[
    Path | None,
    typer.Option("--output", "-o", metavar="SCENE", help="The scene to write.  [default: stdout]"),
]
Agents = Annotated[
    int | None,
    typer.Option("--agents", "-n", min=1, max=10_000, metavar="N", help="How many agents."),
]
Seed = Annotated[
    int, typer.Option("--seed", min=0, metavar="S", help="Of what is drawn at random.")
]
Radius = Annotated[float | None, typer.Option(metavar="R", help="Radius of everybody, m.")]
Scale = Annotated[float | None, typer.Option(help="Metres a unit of the file.")]
Origin = Annotated[
    str | None, typer.Option(metavar="X,Y", help="Where the file's (0, 0) comes to lie, m.")
]
Flip = Annotated[
    str, typer.Option(metavar="x|y|both", help="Axes along which the map is mirrored.")
]
Simplify = Annotated[
    float | None, typer.Option(metavar="M", help="How far corners may be cut off the floor, m.")
]
Weld = Annotated[
    float | None, typer.Option(metavar="M", help="Close gaps between walls up to this, m.")
]
Thickness = Annotated[float | None, typer.Option(metavar="M", help="Of walls drawn as lines, m.")]
Layers = Annotated[str, typer.Option(metavar="A,B", help="Layers or groups that block the way.")]
Floor = Annotated[str, typer.Option(metavar="A,B", help="Layers or groups that are floor.")]
Threshold = Annotated[
    float | None, typer.Option(min=0.0, max=1.0, help="How light free pixels are at least.")
]
Level = Annotated[str | None, typer.Option(metavar="NAME", help="The storey of a building.")]
Doors = Annotated[str, typer.Option(metavar="open|closed", help="The doors of a building.")]


@command(app, "import", without=("verbose", "as_json"))
def import_files(
    console: Console,
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="A map, and files with agents for it.")
    ],
    *,
    output: Target = None,
    agents: Agents = None,
    seed: Seed = 0,
    radius: Radius = None,
    horizon: Annotated[float | None, typer.Option(metavar="T", help="Latest arrival, s.")] = None,
    sources: Annotated[
        str, typer.Option("--from", metavar="A,B", help="Regions in which agents start.")
    ] = "",
    goals: Annotated[
        str, typer.Option("--to", metavar="A,B", help="Regions in which they end.")
    ] = "",
    scale: Scale = None,
    origin: Origin = None,
    flip: Flip = "",
    simplify: Simplify = None,
    weld: Weld = None,
    thickness: Thickness = None,
    layers: Layers = "",
    floor: Floor = "",
    threshold: Threshold = None,
    level: Level = None,
    doors: Doors = "open",
) -> int:
    """Make a scene of other programs' files.

    Maps of robots, crowds, fleets and drawings, with the agents where the format has any; docs/formats.md
    lists the formats. The scene names the map, so that a new version of it is read the next time. What was
    left out, mended or chosen is said. --agents without agents in the files places some at random.

    \b
    Examples:
      stplan import maze.map maze.scen --agents 20 -o maze.yaml
      stplan import depot.yaml --agents 30 --radius 0.25 -o depot-scene.yaml
      stplan import rimea09.scenario --agents 40 --from source-10 --to target-1 | stplan solve -
    """
    for name, value in (("--radius", radius), ("--horizon", horizon)):
        _check_positive(name, value)
    options = _file_options(
        scale, origin, flip, simplify, weld, thickness, layers, floor, threshold, level, doors
    )
    from stplan.imports.files import draft_of_files
    from stplan.imports.people import CrowdOptions

    crowd = CrowdOptions(agents, seed, radius, horizon, _names(sources), _names(goals))
    draft, notes = draft_of_files(
        files, options, crowd, _folder(output), _comment(f"import {_listed(files)}", seed)
    )
    return _finish(console, draft, notes, output)


@command(app, without=("verbose", "as_json"))
def new(
    console: Console,
    template: Annotated[
        str, typer.Argument(metavar="[TEMPLATE]", help="corridor, room, warehouse or from-map.")
    ] = "",
    file: Annotated[
        Path | None,
        typer.Argument(metavar="[FILE]", help="The map of from-map.", show_default=False),
    ] = None,
    *,
    map_file: Annotated[
        Path | None,
        typer.Option("--map", metavar="FILE", help="Short for from-map FILE.", show_default=False),
    ] = None,
    output: Target = None,
    agents: Agents = None,
    seed: Seed = 0,
    radius: Radius = None,
    scale: Scale = None,
    origin: Origin = None,
    flip: Flip = "",
    simplify: Simplify = None,
    weld: Weld = None,
    thickness: Thickness = None,
    layers: Layers = "",
    floor: Floor = "",
    threshold: Threshold = None,
    level: Level = None,
    doors: Doors = "open",
) -> int:
    """Write a first scene, with comments.

    From a template, or around a map, with agents at random places where they fit (ten unless --agents says
    how many). It goes to stdout, or to a file with -o; paths in it are relative to where it will be.

    \b
    Examples:
      stplan new corridor > scene.yaml
      stplan new room --agents 12 --seed 1 -o scene.yaml
      stplan new --map office.dxf --agents 30 | stplan solve -
    """
    from stplan.imports.templates import TEMPLATES, draft_of_template

    _check_positive("--radius", radius)
    if template == "from-map" or map_file is not None:
        source = map_file or file
        if source is None or (map_file is not None and template):
            raise UsageError("expected stplan new from-map FILE, or stplan new --map FILE")
        options = _file_options(
            scale, origin, flip, simplify, weld, thickness, layers, floor, threshold, level, doors
        )
        from stplan.imports.files import draft_of_files
        from stplan.imports.people import CrowdOptions

        crowd = CrowdOptions(agents or 10, seed, radius, own=False)
        draft, notes = draft_of_files(
            [source], options, crowd, _folder(output), _comment(f"new --map {source.name}", seed)
        )
        return _finish(console, draft, notes, output)
    if template not in TEMPLATES or file is not None:
        known = ", ".join(TEMPLATES)
        raise UsageError(f"{template or 'no template'}: expected {known}, or from-map FILE")
    draft = draft_of_template(
        template,
        _folder(output),
        _comment(f"new {template}", seed),
        agents=agents,
        rng_seed=seed,
        radius=radius,
    )
    return _finish(console, draft, [], output)


def _finish(console: Console, draft: SceneDraft, notes: Sequence[str], output: Path | None) -> int:
    for note in notes:
        console.progress(f"note: {note}")
    text = draft.text()
    if output is None:
        write(sys.stdout, text)
        return 0
    from stplan.files.atomic import write_atomically

    write_atomically(output, text.encode())
    console.result(f"{output}: {draft.name} with {len(draft.agents)} agents")
    return 0


def _file_options(
    scale: float | None,
    origin: str | None,
    flip: str,
    simplify: float | None,
    weld: float | None,
    thickness: float | None,
    layers: str,
    floor: str,
    threshold: float | None,
    level: str | None,
    doors: str,
) -> FileOptions:
    from stplan.maps.formats.drawing import FileOptions

    for name, value in (("--scale", scale), ("--thickness", thickness)):
        _check_positive(name, value)
    for name, value in (("--simplify", simplify), ("--weld", weld)):
        if value is not None and not (math.isfinite(value) and value >= 0):
            raise UsageError(f"{name} is {value}; expected a finite number, at least 0")
    if flip not in ("", "x", "y", "both"):
        raise UsageError(f"--flip is {flip!r}; expected x, y or both")
    if doors not in ("open", "closed"):
        raise UsageError(f"--doors is {doors!r}; expected open or closed")
    return FileOptions(
        scale, _place(origin), flip, simplify, weld, thickness, _names(layers), _names(floor),
        threshold, level, doors == "open",
    )  # fmt: skip


def _place(text: str | None) -> tuple[float, float]:
    if text is None:
        return 0.0, 0.0
    try:
        x, y = (float(word) for word in text.split(","))
    except ValueError:
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        raise UsageError(f"--origin is {text!r}; expected two numbers as X,Y")
    return x, y


def _check_positive(name: str, value: float | None) -> None:
    if value is not None and not (math.isfinite(value) and value > 0):
        raise UsageError(f"{name} is {value}; expected a number above 0")


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())


def _listed(files: Sequence[Path]) -> str:
    return " ".join(file.name for file in files)


def _folder(output: Path | None) -> Path:
    return Path() if output is None else output.parent


def _comment(command: str, seed: int) -> str:
    """How the scene was made."""
    return f"Made by stplan {command}; what is drawn at random is so with --seed {seed}"
