"""The page in a real browser: played, scrubbed, clicked, read."""

from __future__ import annotations

import io
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

from stplan.viewing.page import page_bytes
from stplan.viewing.run_view import open_run
from tests.viewing.runs import CURVES, EVENTS, HALL, hall_run, many_run, write_run

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
ADVICE = "no browser to test the page in: apt-get install chromium (as .ci/run does)"
# WebGL by the processor: there may be no graphics card.
ARGUMENTS = [
    "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-background-networking", "--disable-dev-shm-usage",
]  # fmt: skip


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    path = next(filter(None, map(shutil.which, BROWSERS)), None)
    if path is None:
        pytest.fail(ADVICE)
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=path, args=ARGUMENTS)
        yield started
        started.close()


@pytest.fixture
def opened(browser: Browser, tmp_path: Path) -> Iterator[Callable[[Path], Page]]:
    """Open the page of a run; at the end there must have been no error and no request."""
    faults: list[str] = []
    contexts = []

    def show(run: Path, other: Path | None = None) -> Page:
        file = tmp_path / "view.html"
        second = None if other is None else open_run(other)
        file.write_bytes(page_bytes(open_run(run), second))
        context = browser.new_context(
            viewport={"width": 1080, "height": 440}, color_scheme="light", offline=True
        )
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(60_000)
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda said: said.type == "error" and faults.append(said.text))
        page.on("request", lambda asked: asked.url != file.as_uri() and faults.append(asked.url))
        page.goto(file.as_uri())
        page.wait_for_function("() => document.querySelector('#plane canvas').width > 300")
        return page

    yield show
    for context in contexts:
        context.close()
    assert faults == []


def _time(page: Page) -> float:
    return float(page.locator("#timeline").get_attribute("aria-valuenow") or "nan")


def _scrub(page: Page, part: float) -> None:
    box = page.locator("#timeline").bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + part * box["width"], box["y"] + 10)


def _centre(page: Page, selector: str) -> tuple[float, float]:
    box = page.locator(selector).bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def _next_frames(page: Page) -> None:
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def _pixels(page: Page, selector: str) -> np.ndarray[Any, Any]:
    _next_frames(page)
    with Image.open(io.BytesIO(page.locator(selector).screenshot())) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def _wait_for_time_after(page: Page, time: float) -> None:
    page.wait_for_function(
        "time => Number(document.getElementById('timeline').ariaValueNow) > time", arg=time
    )


def _wait_for_text(page: Page, element: str, text: str) -> None:
    page.wait_for_function(
        "([id, text]) => document.getElementById(id).textContent === text", arg=[element, text]
    )


def _point_at_a_rod(page: Page) -> str:
    """Move over the 3D view until a rod is found; the name that is shown then."""
    x, y = _centre(page, "#rods")
    for step in range(-60, 61, 10):
        page.mouse.move(x + step, y + 20)
        _next_frames(page)
        if page.locator("#tip").is_visible():
            return page.locator("#tip").inner_text().split(" · ")[0]
    pytest.fail("no rod near the middle of the 3D view")


def test_a_small_scene(opened, tmp_path):
    page = opened(hall_run(tmp_path))
    assert page.title() == "hall · stplan"
    assert page.locator("#description").inner_text() == "two cross, one waits </script>"
    assert page.locator("#facts").inner_text().startswith("3 agents · all arrived after 9.00 s")
    assert page.locator(".missing").count() == 0, "the browser has no WebGL"
    assert page.locator("#time").inner_text() == "0.00 s"

    # Play and pause, by button and by key.
    page.locator("#play").click()
    assert page.locator("#play").get_attribute("aria-pressed") == "true"
    _wait_for_time_after(page, 0.05)
    page.keyboard.press(" ")
    assert page.locator("#play").get_attribute("aria-pressed") == "false"
    stopped = _time(page)
    map_before, rods_before = _pixels(page, "#plane"), _pixels(page, "#rods")
    assert _time(page) == stopped

    # Scrub to 4 s, when ann is in the middle of the map; both views follow.
    _scrub(page, 4.0 / 9.0)
    assert _time(page) == pytest.approx(4.0, abs=0.05)
    assert (np.abs(_pixels(page, "#plane") - map_before).max(axis=2) > 60).sum() > 200
    rods = _pixels(page, "#rods")
    assert (np.abs(rods - rods_before).max(axis=2) > 30).sum() > 200
    assert len(np.unique(rods.reshape(-1, 3), axis=0)) > 200, "nothing shaded in the 3D view"

    # Hover, click, and read what the panel says.
    page.mouse.move(*_centre(page, "#plane"))
    page.wait_for_selector("#tip:not([hidden])")
    assert page.locator("#tip").inner_text().endswith("s · 1.00 m/s")
    assert page.locator("#tip").inner_text().startswith("ann")
    page.mouse.click(*_centre(page, "#plane"))
    panel = page.locator("#panel")
    assert page.locator("#selected").inner_text() == "ann"
    _wait_for_text(page, "now", "1.00 m/s")
    assert page.locator("#near").inner_text().startswith("ben, ")
    assert "8.00 s, wanted 7.00 s" in panel.inner_text()
    assert "8.00 m" in panel.inner_text()

    # The tightest moment of her pair with ben is one click away.
    row = panel.locator(".moments button", has_text="ben")
    moment = float(row.get_attribute("data-time") or "nan")
    row.click()
    assert _time(page) == pytest.approx(moment, abs=1e-3)
    assert set(panel.locator(".agent").all_inner_texts()) == {"ann", "ben"}

    # A rod is as good to point at as a disc.
    page.keyboard.press("Escape")
    name = _point_at_a_rod(page)
    page.mouse.down()
    page.mouse.up()
    assert page.locator("#selected").inner_text() == name

    # All again; who waits, and for whom.
    page.keyboard.press("Escape")
    wait = panel.locator(".moments button", has_text="ben for ann")
    assert "1.5 to 5.0 s" in wait.inner_text()
    wait.click()
    assert _time(page) == pytest.approx(1.5)
    assert page.locator("#selected").inner_text() == "ben"

    # Keys along the time, and at its ends.
    page.keyboard.press("End")
    assert _time(page) == 9.0
    page.keyboard.press("ArrowLeft")
    assert _time(page) == pytest.approx(9.0 - 0.09)
    page.keyboard.press("Home")
    assert _time(page) == 0.0

    # Light and dark.
    light = _pixels(page, "body").mean()
    page.locator("#theme").click()
    assert _pixels(page, "body").mean() < 0.5 * light
    assert _pixels(page, "#rods")[5:40, 5:40].mean() < 60


def test_two_runs_in_step(opened, tmp_path):
    """ben sets off two seconds later in the second run, which is drawn as rings."""
    (tmp_path / "second").mkdir()
    later = write_run(
        tmp_path / "second",
        HALL.replace("{id: ben,", "{id: ben, start_time: 2.0,"),
        [CURVES[0], CURVES[1] + [0.0, 0.0, 2.0], CURVES[2]],
    )
    page = opened(hall_run(tmp_path), later)
    assert "rings: hall, after 9.00 s" in page.locator("#facts").inner_text()
    rows = page.locator("#differences button")
    assert rows.count() == 3
    assert rows.first.inner_text().startswith("ben, 2.00 s later")
    # The row leads to the moment at which they are furthest apart, and to ben alone.
    moment = float(rows.first.get_attribute("data-time") or "nan")
    rows.first.click()
    assert _time(page) == pytest.approx(moment, abs=1e-3)
    assert page.locator("#selected").inner_text() == "ben"
    page.keyboard.press("Escape")
    # By box and by key, the rings come and go.
    box = page.get_by_label("hall, as rings")
    with_rings = _pixels(page, "#plane")
    box.uncheck()
    without = _pixels(page, "#plane")
    assert (np.abs(with_rings - without).max(axis=2) > 30).sum() > 100
    box.blur()
    page.keyboard.press("o")
    assert box.is_checked()
    assert np.array_equal(_pixels(page, "#plane"), with_rings)


def test_a_hundred_agents(opened, tmp_path):
    page = opened(many_run(tmp_path, 100))
    assert page.locator(".agent").count() == 100
    assert page.locator(".moments button").count() < 60
    page.keyboard.press(" ")
    _wait_for_time_after(page, 0.5)
    page.keyboard.press(" ")
    _scrub(page, 0.5)
    assert _time(page) == pytest.approx(14.0, abs=0.2)
    page.locator("[data-agent=a42]").click()
    assert page.locator("#selected").inner_text() == "a42"
    _wait_for_text(page, "now", "2.31 m/s")
    # All its pairs are there once they are asked for.
    page.locator(".more").click()
    assert page.locator(".moments button").count() == 99
    assert len(np.unique(_pixels(page, "#rods").reshape(-1, 3), axis=0)) > 100


def test_events_are_marked_and_reached_by_mouse_and_keys(opened, tmp_path):
    page = opened(write_run(tmp_path, HALL + EVENTS, CURVES))
    marks = page.locator("#marks button")
    assert marks.count() == 2
    assert marks.nth(0).get_attribute("aria-label") == "1.00 s: the <b> door closes"
    bar, mark = page.locator("#timeline").bounding_box(), marks.nth(0).bounding_box()
    assert mark["x"] + mark["width"] / 2 == pytest.approx(bar["x"] + bar["width"] / 9.0, abs=1.5)

    # By mouse, by keys for the next and the one before, by Tab and Enter, and by its row.
    marks.nth(1).click()
    assert _time(page) == pytest.approx(6.0)
    page.keyboard.press("Shift+E")
    assert _time(page) == pytest.approx(1.0)
    page.keyboard.press("Shift+E")
    assert _time(page) == pytest.approx(1.0)
    page.keyboard.press("e")
    assert _time(page) == pytest.approx(6.0)
    page.locator("#timeline").focus()
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    assert _time(page) == pytest.approx(1.0)
    rows = page.locator("#events li")
    rows.nth(1).locator("button").click()
    assert _time(page) == pytest.approx(6.0)

    # Who stops whom stands with the event that it follows.
    assert rows.nth(0).inner_text().startswith("the <b> door closes")
    assert rows.nth(0).locator(".stops").inner_text() == "ann stops ben"
    assert rows.nth(1).locator(".stops").count() == 0

    # The bar is still dragged where there are no marks.
    _scrub(page, 0.5)
    assert _time(page) == pytest.approx(4.5, abs=0.05)


def test_whom_an_event_stops_waits_for_nobody(opened, tmp_path):
    delay = "events: [{at: 1.4, agent: ben, delay: 3.6}]\n"
    page = opened(write_run(tmp_path, HALL + delay, CURVES))
    assert page.locator("#events li").inner_text().startswith("ben stands still for 3.6 s")
    assert page.locator("#events .stops").count() == 0


def test_a_run_without_events_has_no_marks(opened, tmp_path):
    page = opened(hall_run(tmp_path))
    assert page.locator("#marks button").count() == 0
    assert page.locator("#events").count() == 0
