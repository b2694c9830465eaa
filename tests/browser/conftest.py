"""A finished run of a shipped engine, with everything rendered, and a browser without a network."""

import shutil

import pytest

from crankfem.jobs.pipeline import run_engine

playwright = pytest.importorskip(
    "playwright.sync_api", reason="pages are looked at in a browser with crankfem[browser]"
)
CHROMIUM = shutil.which("chromium")
# Graphics are calculated by the processor: test machines have no screen.
FLAGS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)


@pytest.fixture(scope="session")
def report(tmp_path_factory):
    """The report of the six-cylinder engine."""
    return run_engine("6chn25-34", tmp_path_factory.mktemp("run") / "six").report


@pytest.fixture(scope="session")
def browser():
    if CHROMIUM is None:
        pytest.skip("there is no chromium")
    with playwright.sync_playwright() as started:
        opened = started.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        yield opened
        opened.close()


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
