"""What the benchmarks' commands do, given a console: each returns its exit status.

Every benchmark writes NAME.csv, NAME.md (what it prints) and, where there is something to see, NAME.png.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from stplan.cli.console import Console


def _finish(console: Console, output: Path, contents: Mapping[str, bytes]) -> int:
    """Write the files of a benchmark and print its table."""
    from stplan.files.atomic import write_set

    files = write_set(output, contents)
    console.progress(f"wrote {', '.join(map(str, files))}")
    for name, content in contents.items():
        if name.endswith(".md"):
            console.result(content.decode().rstrip())
    return 0


def bench_batch(console: Console, output: Path, runs: int) -> int:
    """Measure what a batch costs beyond planning, with one job and with two."""
    from stplan.bench import batches

    measured = batches.measure(runs, (1, 2), progress=console.progress)
    return _finish(console, output, batches.files(measured))


def bench_seeding(
    console: Console,
    output: Path,
    draws: int | None,
    families: Sequence[str],
    time_limit: float | None,
    *,
    full: bool,
) -> int:
    """Measure the seeder on generated families of scenes."""
    from stplan.bench import seeding, seeding_table

    chosen = seeding.chosen_families(families, full=full)
    measurements = seeding.measure(
        chosen,
        draws or (seeding.FULL_DRAWS if full else seeding.SMALL_DRAWS),
        time_limit or (seeding.FULL_LIMIT if full else seeding.SMALL_LIMIT),
        progress=console.progress,
    )
    return _finish(console, output, seeding_table.files(measurements))


def bench_figures(console: Console, output: Path, only: Sequence[str], *, full: bool) -> int:
    """Measure the figures the planner is held to."""
    from stplan.bench import figures, figures_table

    chosen = figures.chosen_cases(only, full=full)
    measured = figures.measure(chosen, progress=console.progress)
    return _finish(console, output, figures_table.files(chosen, measured))


def bench_sweep(console: Console, output: Path, name: str, *, full: bool) -> int:
    """Measure how the time of an iteration grows in one direction."""
    from stplan.bench import scaling, scaling_table
    from stplan.bench.plots import require_matplotlib

    require_matplotlib()
    sweep = scaling.SWEEPS[name]
    points = scaling.measure(sweep, full=full, progress=console.progress)
    return _finish(console, output, scaling_table.files(sweep, points))


def bench_convergence(
    console: Console,
    output: Path,
    scenes: Sequence[Path],
    variants: Sequence[str],
    time_limit: float | None,
    *,
    full: bool,
) -> int:
    """Measure how fast the variants of the optimiser come near the best cost."""
    from stplan.bench import convergence, convergence_table
    from stplan.bench.plots import require_matplotlib

    require_matplotlib()
    outcomes = convergence.measure(
        convergence.shipped_scenes(scenes, full=full),
        time_limit or (convergence.FULL_SECONDS if full else convergence.SMALL_SECONDS),
        convergence.chosen_variants(variants),
        progress=console.progress,
    )
    return _finish(console, output, convergence_table.files(outcomes))


def bench_rival(console: Console, output: Path, time_limit: float | None, *, full: bool) -> int:
    """Plan the same fields with ours and with CasADi and Ipopt."""
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
    return _finish(console, output, rival_table.files(duels))


def bench_all(console: Console, output: Path, *, full: bool) -> int:
    """Every benchmark in turn, and the description of the machine."""
    from stplan.bench.convergence import shipped_scenes
    from stplan.bench.machine import description
    from stplan.bench.plots import require_matplotlib
    from stplan.bench.rival import require_casadi
    from stplan.bench.scaling import SWEEPS

    # What is missing is said before anything is measured.
    require_matplotlib()
    require_casadi()
    shipped_scenes([], full=full)
    _finish(console, output, {"machine.md": description().encode()})
    bench_figures(console, output, [], full=full)
    for name in SWEEPS:
        bench_sweep(console, output, name, full=full)
    bench_rival(console, output, None, full=full)
    bench_seeding(console, output, None, [], None, full=full)
    return bench_convergence(console, output, [], [], None, full=full)


def bench_comparison(console: Console, output: Path, scenes: Path, only: Sequence[str]) -> int:
    """Set the planner beside its rivals."""
    from stplan.bench import comparison
    from stplan.bench.comparison_table import csv_text, markdown_text
    from stplan.files.atomic import write_set

    names = [name.strip() for name in only if name.strip()]
    outcomes = comparison.compare_planners(scenes, names, progress=console.progress)
    text = markdown_text(outcomes)
    contents = {"comparison.csv": csv_text(outcomes).encode(), "comparison.md": text.encode()}
    files = write_set(output, contents)
    console.progress(f"wrote {' and '.join(map(str, files))}")
    console.result(text.rstrip())
    return 0
