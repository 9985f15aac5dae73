"""Plan every shipped scene and draw it: `make gallery` (or `python docs/make_gallery.py [NAME...]`).

Writes docs/gallery/ (a picture a scene and a page that shows them) and the picture and the movie of README,
all by the commands that users have. With names only those scenes' pictures are drawn again.
"""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PIL import Image

ROOT = Path(__file__).parent.parent
SCENES = ROOT / "scenes"
RUNS = ROOT / "outputs" / "gallery"
GALLERY = ROOT / "docs" / "gallery"
PICTURES = ROOT / "docs" / "pictures"
FORMATS = GALLERY / "formats"
# Enough for line drawings, and a third of the bytes.
COLOURS = 240
# The scenes of README.
PICTURE, MOVIE = "bottleneck", "warehouse"
# The scene of docs/seeding.md that shows the paper's initial curves behind its plan.
INITIAL = SCENES / "roomba" / "roomba.yaml"


@dataclass(frozen=True)
class Entry:
    """A scene in the gallery; `report` is None where it could not be planned, `problem` says why."""

    scene: Path
    name: str
    report: dict[str, Any] | None
    problem: str

    @property
    def text(self) -> str:
        """The lines that head the scene file and say what it shows."""
        said = []
        for line in self.scene.read_text(encoding="utf-8").splitlines():
            if not line.startswith("#"):
                break
            said.append(line.lstrip("# ").strip())
        return " ".join(said)


def stplan(*arguments: object) -> subprocess.CompletedProcess[str]:
    """Run a command of this clone; its progress goes to stderr as it comes."""
    command = [sys.executable, "-m", "stplan", *map(str, arguments)]
    return subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=False)


def planned(scene: Path) -> Entry:
    """Plan a scene and draw it into the gallery."""
    answer = json.loads(stplan("solve", scene, "-o", RUNS, "--json").stdout)
    (record,) = answer["scenes"]
    if "report" not in record:
        return Entry(scene, scene.stem, None, "; ".join(record["messages"]))
    name = record["name"]
    target = GALLERY / f"{name}.png"
    drawn = stplan("plot", RUNS / name, "--show", "map,rods", "--dpi", 90, "-o", target)
    if drawn.returncode:
        raise SystemExit(drawn.returncode)
    reduce(target)
    return Entry(scene, name, record["report"], record["advice"])


def reduce(picture: Path) -> None:
    """Make a picture small: few colours, packed as well as possible."""
    image = Image.open(io.BytesIO(picture.read_bytes())).convert("RGB")
    image.quantize(COLOURS, dither=Image.Dither.NONE).save(picture, optimize=True)


def facts(entry: Entry) -> str:
    """What a reader wants to know beside the picture."""
    if entry.report is None:
        return f"**No plan:** {entry.problem}"
    certificate, metrics = entry.report["certificate"], entry.report["metrics"]
    tightest = certificate["smallest_clearance"]
    where = "nothing interacts"
    if tightest is not None:
        *who, clearance, time, _, _ = tightest
        who = f"{who[0]} and {who[1]}" if len(who) == 2 else f"{who[0]} and a wall"
        where = f"smallest clearance {1000 * clearance:.3g} mm ({who}, {time:.4g} s)"
    count = len(metrics["agents"])
    return f"{count} agents, all arrived after {metrics['latest_arrival']:.4g} s; {where}."


def page(entries: list[Entry]) -> str:
    """The gallery as Markdown, a chapter a folder of scenes."""
    lines = [
        "# Gallery",
        "",
        "Every scene in `scenes/`, planned and drawn by `make gallery`: swept paths at true scale, discs at",
        "equal times, and the rods of all agents in space and time.",
    ]
    folder = None
    for entry in entries:
        if entry.scene.parent != folder:
            folder = entry.scene.parent
            lines += ["", f"## {folder.relative_to(SCENES).as_posix()}"]
        source = entry.scene.relative_to(ROOT).as_posix()
        lines += ["", f"### [{entry.name}](../../{source})", "", entry.text, ""]
        if entry.report is not None:
            lines += [f"![{entry.name}]({entry.name}.png)", ""]
        lines.append(facts(entry))
    return "\n".join(lines) + "\n"


def readme_pictures() -> None:
    """The picture and the movie at the top of README."""
    PICTURES.mkdir(exist_ok=True)
    picture = PICTURES / f"{PICTURE}.png"
    stplan("plot", RUNS / PICTURE, "--seed", "--dpi", 100, "-o", picture).check_returncode()
    reduce(picture)
    movie = PICTURES / f"{MOVIE}.webp"
    stplan("animate", RUNS / MOVIE, "--size", 640, "--fps", 15, "-o", movie).check_returncode()


def initial_picture() -> None:
    """Raw initial curves against the plan that begins with them, by the paper's recipe."""
    runs = RUNS / "paper"
    stplan("solve", INITIAL, "--set", "preset=paper", "-o", runs).check_returncode()
    picture = PICTURES / "initial.png"
    shown = ("--seed", "--show", "map", "--dpi", 100, "-o", picture)
    stplan("plot", runs / INITIAL.stem, *shown).check_returncode()
    reduce(picture)


def format_pictures() -> None:
    """A picture for every command of docs/formats.md that imports a sample."""
    FORMATS.mkdir(exist_ok=True)
    page = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
    for line in re.findall(
        r"^stplan (import docs/samples/.*--agents 10|import .*setup.json)$", page, re.M
    ):
        words = line.split()
        name = Path(words[1]).name.partition(".")[0] + "-" + words[1].rpartition(".")[2]
        scene = RUNS / "formats" / f"{name}.yaml"
        scene.parent.mkdir(parents=True, exist_ok=True)
        stplan(*words, "-o", scene).check_returncode()
        answer = json.loads(stplan("solve", scene, "-o", RUNS / "formats", "--json").stdout)
        target = FORMATS / f"{name}.png"
        folder = answer["scenes"][0]["folder"]
        stplan("plot", folder, "--show", "map", "--dpi", 60, "-o", target).check_returncode()
        reduce(target)


def main(names: list[str]) -> int:
    """Make the whole gallery, draw some scenes again, only the formats of others, or the initial curves."""
    scenes = sorted(SCENES.rglob("*.yaml"))
    if names == ["formats"]:
        format_pictures()
        return 0
    if names == ["initial"]:
        initial_picture()
        return 0
    if names:
        for scene in scenes:
            if scene.stem in names:
                planned(scene)
        return 0
    for old in GALLERY.glob("*.png"):
        old.unlink()
    entries = [planned(scene) for scene in scenes]
    GALLERY.mkdir(exist_ok=True)
    (GALLERY / "README.md").write_text(page(entries), encoding="utf-8")
    readme_pictures()
    initial_picture()
    format_pictures()
    failed = [entry for entry in entries if entry.report is None]
    for entry in failed:
        print(f"{entry.scene}: {entry.problem}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
