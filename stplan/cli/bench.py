"""The command line of the benchmarks: arguments and help. What they do is `bench_commands`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stplan.cli.bench_commands import (
    bench_all,
    bench_batch,
    bench_comparison,
    bench_convergence,
    bench_figures,
    bench_rival,
    bench_seeding,
    bench_sweep,
)
from stplan.cli.options import Quiet, Verbose, serve

Output = Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Results go to DIR.")]
Full = Annotated[bool, typer.Option("--full", help="All sizes, scenes and draws: for the record.")]
TimeLimit = Annotated[float | None, typer.Option(min=0.1, help="Seconds a run may take.")]

FOLDER = Path("outputs/bench")


app = typer.Typer(
    name="bench",
    help="Measure the planner on generated scenes.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.callback()
def _benchmarks() -> None:
    """Measure the planner on generated scenes.

    Each writes a table (.csv, .md) and most a figure (.png). Small by default; all together
    take less than five minutes.
    """


@app.command("all")
def everything(
    *, output: Output = FOLDER, full: Full = False, quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:  # fmt: skip
    """Run every benchmark, and describe the machine.

    \b
    Examples:
      stplan bench all
      stplan bench all --full -o outputs/bench
    """
    serve(quiet, verbose, False, lambda console: bench_all(console, output, full=full))


@app.command()
def comparison(
    *,
    output: Output = FOLDER,
    scenes: Annotated[
        Path, typer.Option(metavar="DIR", help="Where the scenes of the comparison are.")
    ] = Path("scenes/comparison"),
    only: Annotated[str, typer.Option(metavar="A,B", help="Only these scenes.")] = "",
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Set the planner beside its rivals, as fast as agents can go.

    Writes comparison.csv and comparison.md: makespans, accelerations and clearances of this
    planner and of those that are installed of RVO2, JuPedSim, OMPL and CasADi
    (pip install 'stplan[rivals]').

    \b
    Examples:
      stplan bench comparison
      stplan bench comparison --only gap,lane -o outputs/bench
    """
    serve(
        quiet, verbose, False,
        lambda console: bench_comparison(console, output, scenes, only.split(",")),
    )  # fmt: skip


@app.command()
def figures(
    *,
    output: Output = FOLDER,
    only: Annotated[
        str, typer.Option(metavar="A,B", help="Only these figures or kinds of them.")
    ] = "",
    full: Full = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Whole plans beside what is asked of them.

    Time, cost, clearance and memory of planning generated scenes, beside what is asked of them.

    \b
    Examples:
      stplan bench figures
      stplan bench figures --only circle-35,flows
      stplan bench figures --full -o outputs/bench
    """
    serve(
        quiet, verbose, False,
        lambda console: bench_figures(console, output, only.split(","), full=full),
    )  # fmt: skip


@app.command()
def agents(
    *, output: Output = FOLDER, full: Full = False, quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:  # fmt: skip
    """Time of an iteration over agents.

    Flows of random agents cross, at constant density.

    \b
    Example:
      stplan bench agents --full
    """
    serve(
        quiet, verbose, False,
        lambda console: bench_sweep(console, output, "agents", full=full),
    )  # fmt: skip


@app.command()
def knots(
    *, output: Output = FOLDER, full: Full = False, quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:  # fmt: skip
    """Time of an iteration over knots per agent.

    \b
    Example:
      stplan bench knots --full
    """
    serve(
        quiet, verbose, False,
        lambda console: bench_sweep(console, output, "knots", full=full),
    )  # fmt: skip


@app.command()
def walls(
    *, output: Output = FOLDER, full: Full = False, quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:  # fmt: skip
    """Time of an iteration over edges of walls.

    Three agents in a maze between hedges that are drawn more and more finely.

    \b
    Example:
      stplan bench walls --full
    """
    serve(
        quiet, verbose, False,
        lambda console: bench_sweep(console, output, "walls", full=full),
    )  # fmt: skip


@app.command()
def convergence(
    scenes: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[SCENE]...",
            help="Scene files.  [default: a few of scenes/*/*.yaml; all with --full]",
        ),
    ] = None,
    *,
    output: Output = FOLDER,
    variants: Annotated[
        str, typer.Option(metavar="A,B", help="Only these variants of the optimiser.")
    ] = "",
    time_limit: TimeLimit = None,
    full: Full = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Variants of the optimiser on whole scenes.

    Iterations and time to 1 % and 0.1 % of the best cost, clearance, failures.

    \b
    Examples:
      stplan bench convergence
      stplan bench convergence scenes/tight/door.yaml --variants default,exact
    """
    serve(
        quiet, verbose, False,
        lambda console: bench_convergence(
            console, output, scenes or [], variants.split(","), time_limit, full=full
        ),
    )  # fmt: skip


@app.command()
def rival(
    *, output: Output = FOLDER, time_limit: TimeLimit = None, full: Full = False,
    quiet: Quiet = False, verbose: Verbose = False,
) -> None:  # fmt: skip
    """Against CasADi and Ipopt on a common time grid.

    The rival's distances are enlarged until its result is clear at every instant.

    \b
    Example:
      stplan bench rival --full
    """
    serve(
        quiet, verbose, False,
        lambda console: bench_rival(console, output, time_limit, full=full),
    )  # fmt: skip


@app.command()
def batch(
    *,
    output: Output = FOLDER,
    runs: Annotated[int, typer.Option(min=2, help="Runs a batch.")] = 100,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Measure what a batch costs beyond planning, with one job and with two.

    \b
    Example:
      stplan bench batch
    """
    serve(quiet, verbose, False, lambda console: bench_batch(console, output, runs))


@app.command()
def seeding(
    *,
    output: Output = FOLDER,
    draws: Annotated[
        int | None,
        typer.Option(min=1, help="Scenes a family.  [default: 3; 20 with --full]"),
    ] = None,
    families: Annotated[
        str, typer.Option(metavar="A,B", help="Only these families or kinds of them.")
    ] = "",
    time_limit: Annotated[
        float | None,
        typer.Option(
            min=0.1, help="Seconds for the search of one seed.  [default: 5; 60 with --full]"
        ),
    ] = None,
    full: Full = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """How often and how fast seeds are found.

    Writes seeding.csv, a row a draw, and seeding.md, a row a family.

    \b
    Examples:
      stplan bench seeding
      stplan bench seeding --families door,circle --draws 5
      stplan bench seeding --full -o outputs/bench
    """
    serve(
        quiet, verbose, False,
        lambda console: bench_seeding(
            console, output, draws, families.split(","), time_limit, full=full
        ),
    )  # fmt: skip
