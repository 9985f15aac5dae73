"""The command that looks at the installation: doctor."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stplan.cli.command import command, group
from stplan.cli.console import Console

if TYPE_CHECKING:
    from stplan.installation.kernels import KernelCache
    from stplan.installation.parts import InstalledParts
    from stplan.installation.trials import SelfTest

app = group()

_BAR = 30


@command(app)
def doctor(
    console: Console,
    *,
    compile_ahead: Annotated[
        bool, typer.Option("--compile", help="Compile all kernels now, so that no plan waits.")
    ] = False,
) -> int:
    """Look whether everything is in order here, and plan two agents to prove it.

    Versions, the machine code of kernels, optional packages, a browser for `stplan view`. Kernels are
    compiled when they are first needed and kept; --compile does it now, for example while a container is
    built. Exit status 0 where the two agents are planned and certified, 4 otherwise.

    \b
    Examples:
      stplan doctor
      stplan doctor --compile
      stplan doctor --json
    """
    from stplan.installation.kernels import kernel_cache
    from stplan.installation.parts import installed_parts
    from stplan.installation.trials import self_test

    left = _compile(console) if compile_ahead else None
    parts, tested = installed_parts(), self_test()
    cache = kernel_cache()
    status = 0 if tested.certified else 4
    console.result(*_lines(parts, cache, tested))
    content: dict[str, Any] = {
        "exit_status": status,
        **asdict(parts),
        "kernels": asdict(cache),
        "self_test": asdict(tested),
    }
    console.result_json(content if left is None else content | {"left_for_later": list(left)})
    return status


def _compile(console: Console) -> tuple[str, ...]:
    """Compile the kernels with a bar on a terminal, else with a line every so often."""
    from stplan.installation.trials import compile_kernels

    console.expects_compiling = True
    with console.live_line() as live:
        left = compile_kernels(_bar(live) if live else _steps(console))
    if left:
        console.progress(f"left for when they are needed: {', '.join(left)}")
    return left


def _bar(draw: Callable[[Callable[[], str]], None]) -> Callable[[int, int], None]:
    def progress(done: int, total: int) -> None:
        full = _BAR * done // total
        draw(lambda: f"compiling [{'#' * full}{'.' * (_BAR - full)}] {done} of {total} kernels")

    return progress


def _steps(console: Console) -> Callable[[int, int], None]:
    said = -1

    def progress(done: int, total: int) -> None:
        nonlocal said
        if 4 * done // total > said:
            said = 4 * done // total
            console.progress(f"compiling: {done} of {total} kernels")

    return progress


def _lines(parts: InstalledParts, cache: KernelCache, tested: SelfTest) -> list[str]:
    """What is found, a line a matter."""
    libraries = {
        k: v for k, v in parts.versions.items() if k not in ("stplan", "python", "platform")
    }
    lines = [
        f"stplan {parts.versions['stplan']}, Python {parts.versions['python']}, "
        f"{parts.versions['platform']}",
        "libraries: " + ", ".join(f"{name} {version}" for name, version in libraries.items()),
        f"kernels: {cache.compiled} of {cache.kernels} compiled, in {_common(cache.folders)}"
        + ("" if cache.writable else "; it cannot be written, name another by NUMBA_CACHE_DIR"),
    ]
    for extra in parts.extras:
        advice = f"; pip install 'stplan[{extra.name}]'"
        what = f"lacks {', '.join(extra.missing)}{advice}" if extra.missing else "installed"
        lines.append(f"extra {extra.name}: {what}")
    lines.append(f"browser: {parts.browser or 'none found; stplan view needs one to be looked at'}")
    verdict = "passed" if tested.certified else "FAILED"
    lines.append(f"self-test: {verdict} in {tested.seconds:.1f} s; {tested.sentence}")
    return lines


def _common(folders: tuple[str, ...]) -> str:
    return folders[0] if len(folders) == 1 else os.path.commonpath(folders)
