"""The commands that measure whole plans of the shipped scenes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stplan.cli.bench import (
    FOLDER,
    NO_JSON,
    SCENES,
    Full,
    Only,
    Output,
    Scenes,
    TimeLimit,
    benchmarks,
    finish,
    names_in,
)
from stplan.cli.bench_scale import app
from stplan.cli.command import command
from stplan.cli.console import Console

__all__ = ["app", "features", "metric", "paper", "quality", "replan", "repulsion"]


@command(benchmarks, without=NO_JSON)
def quality(
    console: Console,
    *,
    output: Output = FOLDER,
    scenes: Scenes = SCENES,
    only: Only = "",
    moves: Annotated[
        int | None,
        typer.Option(min=1, help="Moves of improvement.  [default: 20; 200 with --full]"),
    ] = None,
    ledger: Annotated[Path, typer.Option(metavar="FILE", help="The least costs known.")] = Path(
        "docs/ledger.csv"
    ),
    record: Annotated[
        bool, typer.Option("--record", help="Write what is cheaper into the ledger.")
    ] = False,
    draws: Annotated[
        int,
        typer.Option(
            min=0,
            help="Plan so many random draws of every tight family instead, by every method.",
        ),
    ] = 0,
    full: Full = False,
) -> int:
    """How near plans are to the best ones known.

    Scenes are planned by default and improved by a number of moves; both costs stand beside the
    least one known, which a ledger keeps with the command that reached it. A ledger only improves.
    With --draws it is random scenes of families, whose best one known is the cheapest by any method.

    \b
    Examples:
      stplan bench quality
      stplan bench quality --only cabin,door --moves 500 --record
      stplan bench quality --draws 20 --only door
    """
    from stplan.bench import draws as draws_bench
    from stplan.bench import draws_table, quality, quality_table
    from stplan.bench import ledger as ledgers
    from stplan.bench.named_scenes import chosen_scenes
    from stplan.files.atomic import write_set

    moves = moves or (quality.FULL_MOVES if full else quality.SMALL_MOVES)
    if draws:
        families = draws_bench.chosen(names_in(only))
        trials = draws_bench.measure(families, draws, moves, progress=console.progress)
        return finish(console, output, draws_table.files(trials))
    files = chosen_scenes(
        scenes, names_in(only), small=quality.SMALL_SCENES, every=quality.FULL_SCENES, full=full
    )
    known = ledgers.read_ledger(ledger)
    measured = quality.measure(files, moves, progress=console.progress)
    if record:
        found = [entry for one in measured for entry in one.entries()]
        # Read anew: others may have written meanwhile, and it only improves.
        text = ledgers.ledger_text(ledgers.read_ledger(ledger), found)
        write_set(ledger.parent, {ledger.name: text.encode()})
    return finish(console, output, quality_table.files(known, measured))


@command(benchmarks, without=NO_JSON)
def paper(
    console: Console,
    *,
    output: Output = FOLDER,
    scenes: Scenes = SCENES,
    only: Only = "",
    time_limit: TimeLimit = None,
    full: Full = False,
) -> int:
    """The paper's scenes by the default and by the paper's recipe, and its plots of time.

    Costs, iterations and seconds of either stand side by side. An iteration is timed over agents, knots
    and wall edges, by the default, by the paper's recipe, and with barriers of every pair of segments.
    Each deviation of the default is taken back once, to see what it gains.

    \b
    Examples:
      stplan bench paper
      stplan bench paper --only circle,corn --time-limit 60
    """
    from stplan.bench import deviations, paper, paper_table
    from stplan.bench.named_scenes import chosen_scenes
    from stplan.bench.plots import require_matplotlib

    require_matplotlib()
    files = chosen_scenes(
        scenes, names_in(only), small=paper.SMALL_FIGURES, every=tuple(paper.FIGURES), full=full
    )
    seconds = time_limit or (paper.FULL_SECONDS if full else paper.SMALL_SECONDS)
    compared = paper.compare(files, seconds, progress=console.progress)
    timings = paper.time_iterations(full=full, progress=console.progress)
    few = chosen_scenes(
        scenes, [], small=deviations.SMALL_SCENES, every=deviations.FULL_SCENES, full=full
    )
    outcomes = deviations.measure(few, seconds, progress=console.progress)
    every = chosen_scenes(scenes, [], small=(), every=tuple(paper.FIGURES), full=True)
    snapping = deviations.snap_places(every)
    return finish(console, output, paper_table.files(compared, timings, outcomes, snapping))


@command(benchmarks, without=NO_JSON)
def features(console: Console, *, output: Output = FOLDER) -> int:
    """What this planner and its rivals can do, each feature shown by a figure.

    A small scene for every feature: unequal masses and sizes, tight places, smoothness, arrivals,
    meetings. Rivals that are not installed are left out. Writes features.csv and features.md.

    \b
    Examples:
      stplan bench features
      stplan bench features -o docs
    """
    from stplan.bench import features, features_table

    return finish(
        console, output, features_table.files(features.measure(progress=console.progress))
    )


@command(benchmarks, without=NO_JSON)
def repulsion(
    console: Console,
    *,
    output: Output = FOLDER,
    scenes: Scenes = SCENES,
    full: Full = False,
) -> int:
    """Repulsive curves beside our plans: how long, and how far apart, either gets.

    Rods of the least tangent-point energy, 2 to 20 % longer than straight ones, in the same time as our plan.

    \b
    Examples:
      stplan bench repulsion
      stplan bench repulsion --full
    """
    from stplan.bench import repulsion
    from stplan.bench.named_scenes import chosen_scenes

    files = chosen_scenes(
        scenes, [], small=repulsion.SMALL_SCENES, every=repulsion.FULL_SCENES, full=full
    )
    return finish(
        console, output, repulsion.files(repulsion.measure(files, progress=console.progress))
    )


@command(benchmarks, without=NO_JSON)
def replan(
    console: Console,
    *,
    output: Output = FOLDER,
    scene: Annotated[
        Path, typer.Option(metavar="SCENE", help="Whose plan is mended, besides that of a crowd.")
    ] = Path("scenes/tight/warehouse.yaml"),
    draws: Annotated[int, typer.Option(min=1, help="Events of every kind.")] = 20,
    afresh: Annotated[
        int, typer.Option(min=0, help="So many of them beside plans made afresh.")
    ] = 3,
    full: Full = False,
) -> int:
    """How quickly plans are mended when somebody is late, is sent elsewhere, or a door closes.

    Writes replanning.csv and replanning.md: processor times, how many mended plans are certified or refused,
    and their cost beside plans made afresh. With --full a crowd of a hundred too.

    \b
    Examples:
      stplan bench replan
      stplan bench replan --full --draws 100
    """
    from stplan.bench import replanning
    from stplan.scene import load_scene

    scenes = [load_scene(scene)] + ([replanning.crowd_scene()] if full else [])
    measured = replanning.measure(scenes, draws, afresh, progress=console.progress)
    return finish(console, output, replanning.files(measured))


@command(benchmarks, without=NO_JSON)
def metric(
    console: Console,
    *,
    output: Output = FOLDER,
    scenes: Scenes = SCENES,
    only: Only = "",
    full: Full = False,
) -> int:
    """What the metric's c does: shipped and generated scenes with several values of `time_scale`.

    Cost, whether a plan is found, iterations and seconds of 1, 2, 3 and auto stand side by side.

    \b
    Examples:
      stplan bench metric
      stplan bench metric --only gap,cabin
    """
    from stplan.bench import metric, metric_table

    chosen = metric.chosen(scenes, names_in(only), full=full)
    trials = metric.measure(chosen, progress=console.progress)
    return finish(console, output, metric_table.files(trials))
