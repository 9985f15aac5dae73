"""The site of the documentation: built without a warning, whole, and without an error in a browser."""

from __future__ import annotations

import functools
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest
import typer.main
from playwright.sync_api import sync_playwright

import stplan
from stplan.cli.app import app
from tests.viewing.test_page_in_browser import ADVICE, ARGUMENTS, BROWSERS

ROOT = Path(__file__).parents[2]
OPENED = [
    "index", "site/tutorials/crowds", "site/reference/commands", "site/reference/api", "site/gallery",
]  # fmt: skip


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-c", "docs/site", "-d",
         str(folder / "doctrees"), "docs", str(folder / "html")],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return folder / "html"


class _Links(HTMLParser):
    """What a page refers to, and what can be referred to in it."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.names: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {key: value for key, value in attrs if value}
        self.names.update(given[key] for key in ("id", "name") if key in given)
        found = [given[key] for key in ("href", "src") if key in given]
        self.links += found
        if tag != "a":
            self.loaded += found


@functools.cache
def _links(page: Path) -> _Links:
    found = _Links()
    found.feed(page.read_text(encoding="utf-8"))
    return found


def _pages(site: Path) -> Iterator[Path]:
    return (page for page in site.rglob("*.html") if "runs" not in page.parts)


def test_every_link_within_leads_somewhere(site):
    broken = []
    for page in _pages(site):
        for link in _links(page).links:
            if re.match(r"[a-z]+:", link):
                continue
            path, _, name = link.partition("#")
            target = (page.parent / unquote(path.partition("?")[0])).resolve() if path else page
            if not target.exists() or (
                name and target.suffix == ".html" and unquote(name) not in _links(target).names
            ):
                broken.append(f"{page.relative_to(site)}: {link}")
    assert broken == []


def test_nothing_is_loaded_from_elsewhere(site):
    pages = list(_pages(site))
    assert len(pages) > 20
    assert [
        (p, one) for p in pages for one in _links(p).loaded if re.match("https?:|//", one)
    ] == []


def test_every_command_key_and_function_is_in_the_reference(site):
    group = typer.main.get_command(app)
    commands = (site / "site/reference/commands.html").read_text(encoding="utf-8")
    assert [one for one in group.commands if f">stplan {one}" not in commands] == []
    scene = (site / "site/reference/scene.html").read_text(encoding="utf-8")
    for key in ("agents", "max_acceleration", "barrier_range", "grouping"):
        assert f">{key}</span>" in scene
    names = _links(site / "site/reference/api.html").names
    assert [
        n for n in stplan.__all__ if n[0] != "_" and n != "errors" and f"stplan.{n}" not in names
    ] == []


def test_pages_open_in_a_browser_without_an_error(site):
    path = next(filter(None, map(shutil.which, BROWSERS)), None)
    if path is None:
        pytest.fail(ADVICE)
    faults: list[str] = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=ARGUMENTS)
        context = browser.new_context(offline=True)
        for name in OPENED:
            page = context.new_page()
            page.set_default_timeout(60_000)
            page.on("pageerror", lambda error: faults.append(str(error)))
            page.on("console", lambda said: said.type == "error" and faults.append(said.text))
            page.on("requestfailed", lambda asked: faults.append(asked.url))
            page.goto((site / f"{name}.html").as_uri())
            assert page.locator("h1").first.inner_text()
            if name == "site/gallery":
                frame = page.frame_locator("iframe").first
                assert frame.locator("#facts").inner_text().startswith("5 agents")
            page.close()
        browser.close()
    assert faults == []
