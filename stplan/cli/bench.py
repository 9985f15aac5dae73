"""The commands that measure the planner.

Every benchmark writes NAME.csv, NAME.md (what it prints) and, where there is something to see, NAME.png.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from stplan.cli.command import command, group
from stplan.cli.console import Console

Output = Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Results go to DIR.")]
Full = Annotated[bool, typer.Option("--full", help="All sizes, scenes and draws: for the record.")]
Scenes = Annotated[Path, typer.Option(metavar="DIR", help="Where the scenes are.")]
Only = Annotated[str, typer.Option(metavar="A,B", help="Only scenes with these names.")]
TimeLimit = Annotated[float | None, typer.Option(min=0.1, help="Seconds a run may take.")]

FOLDER, SCENES = Path("outputs/bench"), Path("scenes")
NO_JSON = ("as_json",)

benchmarks = group(
    name="bench", help="Measure the planner on generated scenes.", no_args_is_help=True
)
app = group()
app.add_typer(benchmarks)


@benchmarks.callback()
def _benchmarks() -> None:
    """Measure the planner on generated scenes.

    Each writes a table (.csv, .md) and most a figure (.png). Small by default; all together
    take less than five minutes.
    """


@command(benchmarks, "all", without=NO_JSON)
def everything(
    console: Console,
    *,
    output: Output = FOLDER,
    full: Full = False,
    keep: Annotated[
        bool, typer.Option("--record", help="Append to the history, and compare with what was.")
    ] = False,
    history: Annotated[Path, typer.Option(metavar="FILE", help="The history, a CSV.")] = Path(
        "docs/bench-history.csv"
    ),
) -> int:
    """Run every benchmark, and describe the machine.

    With --record what was measured is appended to a history, by commit and machine, in units of a loop that
    never changes and was timed beside it; and every case is compared with its last record, so that the
    noise of machines divides out.

    \b
    Examples:
      stplan bench all
      stplan bench all --full -o outputs/bench
      stplan bench all --record
    """
    from stplan.bench.convergence import shipped_scenes
    from stplan.bench.history import read_history, record
    from stplan.bench.machine import description
    from stplan.bench.plots import require_matplotlib
    from stplan.bench.rival import require_casadi
    from stplan.bench.scaling import SWEEPS

    # What is missing is said before anything is measured.
    require_matplotlib()
    require_casadi()
    if keep:
        read_history(history)
    shipped_scenes([], full=full)
    finish(console, output, {"machine.md": description().encode()})
    startup(console, output=output, full=full)
    figures(console, output=output, full=full)
    for name in SWEEPS:
        _sweep(console, name, output=output, full=full)
    rival(console, output=output, full=full)
    seeding(console, output=output, full=full)
    convergence(console, output=output, full=full)
    if keep:
        text = record(output, history, progress=console.progress)
        finish(console, output, {"history.md": text.encode()})
    return 0


@command(benchmarks, without=NO_JSON)
def startup(
    console: Console,
    *,
    output: Output = FOLDER,
    scene: Annotated[
        Path, typer.Option(metavar="SCENE", help="The scene to be validated and solved.")
    ] = Path("scenes/three-agents/symmetric.yaml"),
    full: Full = False,
) -> int:
    """Whole commands beside what loading numpy, scipy.sparse and numba takes.

    Help, validation and solution of a small scene, and its first solution, for which the kernels
    have to be compiled; in turns with the yardstick, in processes of their own.

    \b
    Examples:
      stplan bench startup
      stplan bench startup --scene scenes/tight/door.yaml --full
    """
    from stplan.bench import startup

    timed = startup.measure(
        scene,
        rounds=startup.FULL_ROUNDS if full else startup.ROUNDS,
        first_rounds=startup.FULL_FIRST_ROUNDS if full else startup.FIRST_ROUNDS,
        progress=console.progress,
    )
    return finish(console, output, startup.files(timed))


@command(benchmarks, without=NO_JSON)
def comparison(
    console: Console,
    *,
    output: Output = FOLDER,
    scenes: Annotated[
        Path, typer.Option(metavar="DIR", help="Where the scenes of the comparison are.")
    ] = Path("scenes/comparison"),
    only: Annotated[str, typer.Option(metavar="A,B", help="Only these scenes.")] = "",
) -> int:
    """Set the planner beside its rivals, as fast as agents can go.

    Writes comparison.csv and comparison.md: makespans, accelerations and clearances of this
    planner and of those that are installed of RVO2, JuPedSim, OMPL and CasADi
    (pip install 'stplan[rivals]'); `room` is a crowd behind a door, beside JuPedSim alone.

    \b
    Examples:
      stplan bench comparison
      stplan bench comparison --only gap,lane -o outputs/bench
    """
    from stplan.bench import comparison, comparison_table, evacuation

    names = names_in(only)
    outcomes = []
    if not names or set(names) != {evacuation.NAME}:
        chosen = [name for name in names if name != evacuation.NAME]
        outcomes += comparison.compare_planners(scenes, chosen, progress=console.progress)
    if not names or evacuation.NAME in names:
        outcomes += evacuation.outcomes(progress=console.progress)
    contents = {
        "comparison.csv": comparison_table.csv_text(outcomes).encode(),
        "comparison.md": comparison_table.markdown_text(outcomes).encode(),
    }
    return finish(console, output, contents)


@command(benchmarks, without=NO_JSON)
def figures(
    console: Console,
    *,
    output: Output = FOLDER,
    only: Annotated[
        str, typer.Option(metavar="A,B", help="Only these figures or kinds of them.")
    ] = "",
    full: Full = False,
) -> int:
    """Whole plans beside what is asked of them.

    Time, cost, clearance and memory of planning generated scenes, beside what is asked of them.

    \b
    Examples:
      stplan bench figures
      stplan bench figures --only circle-35,flows
      stplan bench figures --full -o outputs/bench
    """
    from stplan.bench import figures, figures_table

    chosen = figures.chosen_cases(names_in(only), full=full)
    measured = figures.measure(chosen, progress=console.progress)
    return finish(console, output, figures_table.files(chosen, measured))


@command(benchmarks, without=NO_JSON)
def agents(console: Console, *, output: Output = FOLDER, full: Full = False) -> int:
    """Time of an iteration over agents.

    Flows of random agents cross, at constant density.

    \b
    Example:
      stplan bench agents --full
    """
    return _sweep(console, "agents", output=output, full=full)


@command(benchmarks, without=NO_JSON)
def knots(console: Console, *, output: Output = FOLDER, full: Full = False) -> int:
    """Time of an iteration over knots per agent.

    \b
    Example:
      stplan bench knots --full
    """
    return _sweep(console, "knots", output=output, full=full)


@command(benchmarks, without=NO_JSON)
def walls(console: Console, *, output: Output = FOLDER, full: Full = False) -> int:
    """Time of an iteration over edges of walls.

    Three agents in a maze between hedges that are drawn more and more finely.

    \b
    Example:
      stplan bench walls --full
    """
    return _sweep(console, "walls", output=output, full=full)


@command(benchmarks, without=NO_JSON)
def convergence(
    console: Console,
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
) -> int:
    """Variants of the optimiser on whole scenes.

    Iterations and time to 1 % and 0.1 % of the best cost, clearance, failures.

    \b
    Examples:
      stplan bench convergence
      stplan bench convergence scenes/tight/door.yaml --variants default,exact
    """
    from stplan.bench import convergence, convergence_table
    from stplan.bench.plots import require_matplotlib

    require_matplotlib()
    outcomes = convergence.measure(
        convergence.shipped_scenes(scenes or [], full=full),
        time_limit or (convergence.FULL_SECONDS if full else convergence.SMALL_SECONDS),
        convergence.chosen_variants(names_in(variants)),
        progress=console.progress,
    )
    return finish(console, output, convergence_table.files(outcomes))


@command(benchmarks, without=NO_JSON)
def rival(
    console: Console, *, output: Output = FOLDER, time_limit: TimeLimit = None, full: Full = False
) -> int:
    """Against CasADi and Ipopt on a common time grid.

    The rival's distances are enlarged until its result is clear at every instant.

    \b
    Example:
      stplan bench rival --full
    """
    from stplan.bench import rival, rival_table
    from stplan.bench.plots import require_matplotlib

    require_matplotlib()
    rival.require_casadi()
    duels = rival.measure(
        rival.SIZES if full else rival.SMALL_SIZES,
        rival.FULL_DRAWS if full else 1,
        time_limit or (rival.FULL_SECONDS if full else rival.SMALL_SECONDS),
        progress=console.progress,
    )
    return finish(console, output, rival_table.files(duels))


@command(benchmarks, without=NO_JSON)
def batch(
    console: Console,
    *,
    output: Output = FOLDER,
    runs: Annotated[int, typer.Option(min=2, help="Runs a batch.")] = 100,
) -> int:
    """Measure what a batch costs beyond planning, with one job and with two.

    \b
    Example:
      stplan bench batch
    """
    from stplan.bench import batches

    measured = batches.measure(runs, (1, 2), progress=console.progress)
    return finish(console, output, batches.files(measured))


@command(benchmarks, without=NO_JSON)
def seeding(
    console: Console,
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
) -> int:
    """How often and how fast seeds are found.

    Writes seeding.csv, a row a draw, and seeding.md, a row a family.

    \b
    Examples:
      stplan bench seeding
      stplan bench seeding --families door,circle --draws 5
      stplan bench seeding --full -o outputs/bench
    """
    from stplan.bench import seeding, seeding_table

    measurements = seeding.measure(
        seeding.chosen_families(names_in(families), full=full),
        draws or (seeding.FULL_DRAWS if full else seeding.SMALL_DRAWS),
        time_limit or (seeding.FULL_LIMIT if full else seeding.SMALL_LIMIT),
        progress=console.progress,
    )
    return finish(console, output, seeding_table.files(measurements))


def _sweep(console: Console, name: str, *, output: Path, full: bool) -> int:
    """Measure how the time of an iteration grows in one direction."""
    from stplan.bench import scaling, scaling_table
    from stplan.bench.plots import require_matplotlib

    require_matplotlib()
    sweep = scaling.SWEEPS[name]
    points = scaling.measure(sweep, full=full, progress=console.progress)
    return finish(console, output, scaling_table.files(sweep, points))


def finish(console: Console, output: Path, contents: Mapping[str, bytes]) -> int:
    """Write the files of a benchmark and print its table."""
    from stplan.files.atomic import write_set

    files = write_set(output, contents)
    console.progress(f"wrote {', '.join(map(str, files))}")
    for name, content in contents.items():
        if name.endswith(".md"):
            console.result(content.decode().rstrip())
    return 0


def names_in(text: str) -> list[str]:
    """The names in `A,B`."""
    return [name.strip() for name in text.split(",") if name.strip()]
