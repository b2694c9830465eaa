"""A finished run of a shipped engine, with everything rendered, and pages opened without a network."""

import contextlib
import time
from functools import cache

import pytest

from crankfem.jobs.pipeline import run_engine
from stand_ins import made_once

pytest.importorskip(
    "playwright.sync_api", reason="pages are looked at in a browser with crankfem[browser]"
)


# Plots that are not there, or not yet complete.
NOT_DRAWN = "div.interactive[hidden], div.interactive.waiting"
# Seconds for all plots of a report, without a graphics card and on a busy machine.
LONGEST_DRAWING = 120.0


@pytest.fixture(scope="session")
def report(tmp_path_factory):
    """The report of the six-cylinder engine."""
    folder = made_once(tmp_path_factory, "seen-run", lambda made: run_engine("6chn25-34", made))
    return folder / "report.html"


@contextlib.contextmanager
def pages_of(browser):
    """Open files with the network off; what each page asked for and complained of is kept."""
    contexts = []

    def opened(path, width=1200, height=800):
        context = browser.new_context(viewport={"width": width, "height": height}, offline=True)
        contexts.append(context)
        page = context.new_page()
        page.asked, page.complaints = [], []
        page.on("request", lambda request: page.asked.append(request.url))
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.on(
            "console",
            lambda told: page.complaints.append(told.text) if told.type == "error" else None,
        )
        page.goto(path.as_uri())
        return page

    yield opened
    for context in contexts:
        context.close()


@pytest.fixture
def open_page(browser):
    """Open a file in a page of the test's own."""
    with pages_of(browser) as opened:
        yield opened


def scroll_through(page):
    """Unfold the page and let every part come into sight until all plots are drawn, or for too long."""
    page.evaluate("document.querySelectorAll('details').forEach(part => { part.open = true; })")
    deadline = time.monotonic() + LONGEST_DRAWING
    while True:
        for place in range(0, page.evaluate("document.documentElement.scrollHeight"), 500):
            page.evaluate(f"window.scrollTo(0, {place})")
            page.wait_for_timeout(50)
        if page.locator(NOT_DRAWN).count() == 0 or time.monotonic() > deadline:
            break
    page.evaluate("window.scrollTo(0, 0)")


@pytest.fixture(scope="session")
def drawn_page(browser):
    """Open a file once for each width, with all plots drawn, for tests that only look at it."""
    with pages_of(browser) as opened:

        @cache
        def drawn(path, width):
            page = opened(path, width)
            scroll_through(page)
            return page

        yield drawn
