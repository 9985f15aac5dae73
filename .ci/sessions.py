"""Three new users, each with nothing but the wheel and the site: `make sessions`.

A session begins on the first page of the built site, follows the link that stands beside who the user is,
and does what that page says from top to bottom: installs what it names, saves the files it shows, runs its
commands in a shell of an empty environment and its Python there. A command whose page says so
(`# exit status 1`) has to end so, all others with 0. In the end the user has what it came for.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import venv
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

ROOT = Path(__file__).parents[1]
SAVE = re.compile(r"\bas (\S+\.\w+)\W*$")
STATUS = re.compile(r"#.*exit status (\d+)")


@dataclass(frozen=True)
class Step:
    """A block of a page: its language, its text, and as what the page says to save it, if it does."""

    language: str
    text: str
    file: str | None


class Page(HTMLParser):
    """What a reader sees of a page: its links by row of tables, and its blocks with what is said before."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.steps: list[Step] = []
        self.rows: list[tuple[str, list[str]]] = []
        self._said = self._block = self._language = ""
        self._depth = {"p": 0, "pre": 0, "tr": 0}
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag == "div" and (found := re.match(r"highlight-(\w+)", given.get("class") or "")):
            self._language = found[1]
        if tag == "tr":
            self.rows.append(("", []))
        if tag == "a" and self._depth["tr"]:
            self.rows[-1][1].append(unquote(given.get("href") or ""))
        if tag in self._depth:
            self._depth[tag] += 1
            self._said = "" if tag == "p" else self._said

    def handle_endtag(self, tag: str) -> None:
        if tag not in self._depth:
            return
        self._depth[tag] -= 1
        if tag == "pre":
            saved = SAVE.search(self._said.strip())
            self.steps.append(Step(self._language, self._block, saved and saved[1]))
            self._block = self._said = ""

    def handle_data(self, data: str) -> None:
        if self._depth["tr"]:
            said, links = self.rows[-1]
            self.rows[-1] = (said + data, links)
        if self._depth["p"]:
            self._said += data
        if self._depth["pre"]:
            self._block += data


def page_for(site: Path, user: str) -> Path:
    """Where the first page sends a kind of user."""
    (link,) = (links[0] for said, links in Page(site / "index.html").rows if user in said)
    return site / link


def commands(text: str) -> Iterator[tuple[str, int]]:
    """The commands of a block, each with the exit status that the page announces."""
    for line in text.replace("\\\n", " ").splitlines():
        if line.strip():
            announced = STATUS.search(line)
            yield line, int(announced[1]) if announced else 0


class Session:
    """An empty folder and an environment of its own, which has the wheel and nothing else.

    Args:
        folder: for both.
        wheel: what is installed; found, too, by `pip install 'stplan[extra]'`.
    """

    def __init__(self, folder: Path, wheel: Path) -> None:
        venv.create(folder / "venv", with_pip=True)
        programs = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
        self.place = folder / "place"
        self.place.mkdir()
        self._settings = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")} | {
            "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}",
            "PIP_FIND_LINKS": str(wheel.parent),
            "PIP_DISABLE_PIP_VERSION_CHECK": "1",
            "PIP_QUIET": "1",
            "MPLBACKEND": "agg",
        }
        self.run(f"pip install '{wheel}'", 0)

    def follow(self, page: Path) -> None:
        """Do what a page says."""
        for step in Page(page).steps:
            if step.file is not None:
                (self.place / step.file).write_text(step.text, encoding="utf-8")
            elif step.language == "python":
                self._end_as(["python", "-W", "error", "-c", step.text], "python", 0)
            elif step.language == "bash":
                for command, status in commands(step.text):
                    self.run(command, status)

    def run(self, command: str, status: int) -> None:
        """Run a line in a shell; it has to end with `status`."""
        self._end_as(["bash", "-c", command], command, status)

    def _end_as(self, words: list[str], name: str, status: int) -> None:
        print("$", name, flush=True)
        done = subprocess.run(
            words, cwd=self.place, env=self._settings, stdin=subprocess.DEVNULL, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
        )  # fmt: skip
        if done.returncode != status:
            sys.exit(f"{done.stdout}\nends with {done.returncode}, not with {status}: {name}")


def _rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def measured(place: Path) -> bool:
    """Whether a researcher has flows at two doors, a study, and samples that hold."""
    crossed = [
        int(_rows(place / folder / "hall/measure/crossings-line-1.csv")[-1]["crossed"])
        for folder in ("outputs", "wide")
    ]
    return (
        crossed == [10, 10]
        and len(_rows(place / "study/batch.csv")) == 2
        and (place / "both.html").stat().st_size > 100_000
    )


def filmed(place: Path) -> bool:
    """Whether an animator has a movie, a scene that moves, and Sam on the mark in time."""
    glb = (place / "street.glb").read_bytes()
    frames = [row for row in _rows(place / "street.csv") if row["agent"] == "sam"]
    there = {
        int(row["frame"])
        for row in frames
        if abs(float(row["x"]) - 9.5) + abs(float(row["y"]) - 3.2) < 0.01
    }
    return (
        glb[:4] == b"glTF"
        and b'"animations"' in glb
        and 20 <= len(there) <= 60
        and (place / "street.mp4").read_bytes()[4:8] == b"ftyp"
        and (place / "takes.webp").read_bytes()[8:12] == b"WEBP"
        and (place / "street.usda").read_text(encoding="utf-8").startswith("#usda")
    )


def mended(place: Path) -> bool:
    """Whether an engineer has a plan that stands a delay, one that was mended, and orders for it."""
    order = json.loads((place / "order.json").read_text(encoding="utf-8"))
    report = json.loads((place / "mended/depot/report.json").read_text(encoding="utf-8"))
    past = {
        folder: [
            row for row in _rows(place / folder / "depot/trajectories.csv") if float(row["t"]) < 12
        ]
        for folder in ("outputs", "mended")
    }
    return (
        bool(order["passings"])
        and not order["touching"]
        and report["certificate"]["holds"]
        and past["outputs"] == past["mended"]
        and len(json.loads((place / "orders.json").read_text(encoding="utf-8"))) > 0
    )


USERS: dict[str, Callable[[Path], bool]] = {
    "crowd researcher": measured,
    "animator": filmed,
    "fleet engineer": mended,
}


def main() -> None:
    """Build the wheel and the site, leave the sources, and let everybody come."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("users", nargs="*", metavar="USER", help="who comes; everybody unless told")
    wanted = parser.parse_args().users or list(USERS)
    with tempfile.TemporaryDirectory(prefix="stplan-sessions-") as name:
        folder = Path(name)
        build = [sys.executable, "-m", "build", "--wheel", "--outdir", folder / "dist"]
        sphinx = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-c", "docs/site"]
        subprocess.run(build, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
        subprocess.run([*sphinx, "docs", folder / "site"], cwd=ROOT, check=True)
        (wheel,) = (folder / "dist").glob("*.whl")
        for user in wanted:
            page = page_for(folder / "site", user)
            print(f"\n{user}: {page.relative_to(folder)}", flush=True)
            session = Session(folder / user.replace(" ", "-"), wheel)
            session.follow(page)
            if not USERS[user](session.place):
                sys.exit(f"the {user} has not what the page promises, in {session.place}")
            shutil.rmtree(session.place.parent)
    print(f"\n{len(wanted)} of {len(wanted)} users have what they came for")


if __name__ == "__main__":
    main()
