"""A finished run of a shipped engine, with everything rendered, and pages opened without a network."""

import pytest

from crankfem.jobs.pipeline import run_engine

pytest.importorskip(
    "playwright.sync_api", reason="pages are looked at in a browser with crankfem[browser]"
)


@pytest.fixture(scope="session")
def report(tmp_path_factory):
    """The report of the six-cylinder engine."""
    return run_engine("6chn25-34", tmp_path_factory.mktemp("run") / "six").report


@pytest.fixture
def open_page(browser):
    """Open a file with the network off; what it asked for and complained of is kept."""
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
