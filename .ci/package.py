"""Build the package, look at it as an index does, and try its wheel where nothing else is."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

ROOT = Path(__file__).parents[1]
DIST = ROOT / "dist"
# What somebody does who has nothing but the wheel.
TRIED = (
    "doctor",
    "new room -o room.yaml",
    "validate room.yaml",
    "solve room.yaml --set solver.effort=quick",
    "check outputs/room",
    "explain outputs/room",
    "view outputs/room",
    "export outputs/room",
    "batch room.yaml -o results --set solver.effort=quick --sweep seeding.rng_seed=0,1",
    "new --map room.wkt --agents 4 -o office.yaml",
    "import room.wkt -o imported.yaml --agents 2",
)


def run(*command: str | Path, folder: Path = ROOT, **settings: str) -> None:
    """Run a command and end where it fails."""
    print("+", *command, flush=True)
    environment = {
        key: value for key, value in os.environ.items() if key != "PYTHONPATH"
    } | settings
    subprocess.run([str(word) for word in command], cwd=folder, env=environment, check=True)


def main() -> None:
    """Build, check, install, try."""
    shutil.rmtree(DIST, ignore_errors=True)
    run(sys.executable, "-m", "build", "--outdir", DIST)
    run(sys.executable, "-m", "twine", "check", "--strict", *sorted(DIST.iterdir()))
    (wheel,) = DIST.glob("*.whl")
    with tempfile.TemporaryDirectory(prefix="stplan-wheel-") as name:
        folder = Path(name)
        venv.create(folder / "venv", with_pip=True)
        programs = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
        run(
            programs / "python",
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
            wheel,
        )
        place = folder / "place"
        place.mkdir()
        (place / "room.wkt").write_text("POLYGON ((0 0, 12 0, 12 8, 0 8, 0 0))\n")
        for command in TRIED:
            run(programs / "stplan", *command.split(), folder=place)
    print(f"{wheel.name} is whole")


if __name__ == "__main__":
    main()
