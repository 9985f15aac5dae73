"""The benchmark on grid maps that are given."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stplan.cli.bench import FOLDER, Output, app, benchmarks, finish
from stplan.cli.command import command
from stplan.cli.console import Console
from stplan.errors import UsageError

__all__ = ["app", "movingai"]


@command(benchmarks, without=("as_json",))
def movingai(
    console: Console,
    maps: Annotated[list[Path], typer.Argument(metavar="MAP...", help="Grid maps (.map).")],
    *,
    output: Output = FOLDER,
    agents: Annotated[str, typer.Option(metavar="N,M", help="How many.")] = "10,30,100",
    radii: Annotated[
        str, typer.Option(metavar="R,S", help="Radii of the agents, in cells.")
    ] = "0.3,0.45",
    seed: Annotated[int, typer.Option(min=0, help="Of starts and goals.")] = 0,
    rival: Annotated[
        bool, typer.Option(help="Search with LaCAM of pymapf too, where installed.")
    ] = True,
) -> int:
    """Plan agents on grid maps of the MovingAI benchmarks.

    Starts and goals are middles of free cells at random. Writes movingai.csv and movingai.md: time, how far
    the plan can be from the best one, and what the certificate says of it and of that of a solver for grids.

    \b
    Examples:
      stplan bench movingai docs/samples/rooms.map --agents 3 --radii 0.3 --no-rival
      stplan bench movingai arena.map den520d.map -o outputs/bench
    """
    from stplan.bench import movingai as measurement
    from stplan.bench import movingai_table

    counts = [int(count) for count in _numbers("--agents", agents)]
    shares = _numbers("--radii", radii)
    outcomes = measurement.measure(
        maps, counts, shares, seed, rival=rival, progress=console.progress
    )
    return finish(console, output, movingai_table.files(outcomes))


def _numbers(option: str, text: str) -> list[float]:
    try:
        found = [float(word) for word in text.split(",")]
    except ValueError:
        found = []
    if not found or min(found) <= 0 or (option == "--agents" and any(n != int(n) for n in found)):
        raise UsageError(f"{option} is {text!r}; expected numbers above 0, separated by commas")
    return found
