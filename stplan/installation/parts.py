"""What the program is made of on this machine: versions, optional packages, a browser."""

from __future__ import annotations

import platform
import re
import shutil
from dataclasses import dataclass
from importlib import metadata

from stplan.report import versions

# What users may add; the others are for those who develop.
EXTRAS = ("view", "maps", "export", "measure", "data", "bim", "dask")
BROWSERS = (
    "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "firefox", "msedge",
    "safari",
)  # fmt: skip


@dataclass(frozen=True)
class Extra:
    """An optional part.

    Attributes:
        name: as in ``pip install 'stplan[NAME]'``.
        packages: what it asks for.
        missing: those of them that are not installed.
    """

    name: str
    packages: tuple[str, ...]
    missing: tuple[str, ...]


@dataclass(frozen=True)
class InstalledParts:
    """Versions by name, optional parts, and the path of a browser where one is found."""

    versions: dict[str, str]
    extras: tuple[Extra, ...]
    browser: str | None


def installed_parts() -> InstalledParts:
    """What is installed in this environment."""
    return InstalledParts(program_versions(), installed_extras(), find_browser())


def program_versions() -> dict[str, str]:
    """Versions of the program, of Python, the system, and of what results depend on."""
    found = versions()
    place = {"python": platform.python_version(), "platform": platform.platform()}
    return {"stplan": found["stplan"], **place, **found}


def installed_extras() -> tuple[Extra, ...]:
    """The optional parts that the installed package declares."""
    asked: dict[str, list[str]] = {name: [] for name in EXTRAS}
    for requirement in metadata.requires("stplan") or []:
        extra = re.search(r"extra\s*==\s*['\"]([\w-]+)['\"]", requirement)
        package = re.match(r"[\w.-]+", requirement)
        if extra and package and extra[1] in asked:
            asked[extra[1]].append(package[0])
    return tuple(
        Extra(name, tuple(packages), tuple(p for p in packages if not _is_installed(p)))
        for name, packages in asked.items()
        if packages
    )


def _is_installed(package: str) -> bool:
    try:
        metadata.version(package)
    except metadata.PackageNotFoundError:
        return False
    return True


def find_browser() -> str | None:
    """Where a browser is that could open the page of `stplan view`."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)
