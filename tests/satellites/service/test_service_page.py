"""The service's page as people meet it: turned, calculated, linked, dropped on; in Debian's Chromium."""

import re

import pytest

from comparing import close
from crankfem import STEEL, CrankThrow, Material, analyze_throw, axial_law, load_throw
from crankfem.client import Client
from crankfem.files.engine.new_file import engine_template
from regression.law.throw_law import axial_law_slopes
from satellites.service.serving import Served

pytest.importorskip("fastapi", reason="the service needs crankfem[serve]")
pytestmark = pytest.mark.further
# Levels of axe, from the worst.
SERIOUS = ("critical", "serious")
MOVES = 40
# A slider from one place to the next, until the new numbers and the drawing are there;
# benchmarks/load_service.py takes the time.
TURN = """async (place) => {
    const root = document.querySelector(".throw");
    const slider = root.querySelector("#a-web_thickness ~ input[type=range]");
    const before = root.dataset.updated;
    slider.value = place;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    while (root.dataset.updated === before) {
        await new Promise((next) => new MutationObserver(next).observe(
            root, { attributes: true, attributeFilter: ["data-updated"] }));
    }
}"""


@pytest.fixture(scope="module")
def served(tmp_path_factory, models):
    with Served(tmp_path_factory.mktemp("page"), "--models", str(models)) as started:
        yield started


@pytest.fixture
def open_service(browser, served):
    """Open the page; what it asked for and complained of is kept."""
    contexts = []

    def opened(width=1400, height=1000, link=""):
        context = browser.new_context(viewport={"width": width, "height": height})
        contexts.append(context)
        page = context.new_page()
        page.asked, page.bodies, page.complaints = [], [], []
        page.on("request", lambda request: page.asked.append(request.url))
        page.on("request", lambda request: page.bodies.append(request.post_data))
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.goto(f"{served.address}/{link}")
        page.wait_for_selector("body[data-ready]")
        return page

    yield opened
    for context in contexts:
        context.close()


def serious(page):
    """Return what axe finds that is serious."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    return [
        f"{v['impact']}: {v['help']}: {v['nodes'][0]['html'][:200]}"
        for v in axe.Axe().run(page).response["violations"]
        if v["impact"] in SERIOUS
    ]


def number(page, row, column):
    """Return a number of the table by the words of its row."""
    text = page.locator(f".numbers tr:has-text({row!r}) td").nth(column).inner_text()
    return float(re.match(r"[\d.]+", text)[0])


def test_what_is_turned_is_answered_at_once(open_service):
    page = open_service()
    before = page.locator(".side svg").evaluate("svg => svg.innerHTML")
    for place in range(MOVES):
        page.evaluate(TURN, 0.05 + 0.001 * place)
    assert float(page.locator("#a-web_thickness").input_value()) == close(89.0, 2e-3)
    assert page.locator(".side svg").evaluate("svg => svg.innerHTML") != before
    assert page.complaints == []


@pytest.mark.parametrize("width", [1280, 390])
def test_what_changes_e_n_is_told_on_request(open_service, throw, width):
    page = open_service(width=width)
    slopes = axial_law_slopes(CrankThrow(**throw))
    assert not any("slopes" in str(body) for body in page.bodies)
    page.click(".slopes summary")
    page.wait_for_selector("[data-slope]")
    assert sum("slopes" in str(body) for body in page.bodies) == 1

    def shown():
        rows = page.locator(".slopes tbody tr")
        texts = rows.locator("td:nth-child(2)").all_inner_texts()
        names = rows.evaluate_all("rows => rows.map((row) => row.dataset.slope)")
        values = [float(text.replace("\u2212", "-")) for text in texts]
        return dict(zip(names, values, strict=True))

    before = shown()
    assert before == close(slopes, abs=0.0051)
    assert list(before) == sorted(before, key=lambda name: -abs(slopes[name]))
    # Bars start in the middle: to the left where more of a dimension makes e_n less.
    ends = page.locator('[data-slope="crank_radius"] div, [data-slope="pin_diameter"] div')
    right, left = (ends.nth(place).bounding_box() for place in (0, 1))
    assert right["x"] == close(left["x"] + left["width"], abs=1.0)
    page.evaluate(TURN, 0.09)
    thick = axial_law_slopes(CrankThrow(**throw | {"web_thickness": 0.09}))
    assert shown() == close(thick, abs=0.0051)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert serious(page) == []
    page.fill("#a-web_width", "600")
    page.wait_for_selector('.slopes .remarks:has-text("allowed")')
    assert not page.locator(".slopes table").is_visible()
    assert page.complaints == []


def test_the_throw_is_calculated_and_turns(open_service, throw):
    page = open_service()
    page.click(".calculate")
    page.wait_for_selector(".solid.plot-drawn", timeout=60_000)
    known = 1e9 * analyze_throw(CrankThrow(**throw), STEEL).axial_compliance()
    assert number(page, "ends pinned", 2) == close(known, 1e-3)
    names = page.locator(".solid [role=group] button[aria-pressed]").all_inner_texts()
    assert names == ["solid", "mesh", "deformed by an axial force"]
    page.wait_for_selector(".step:not([disabled])", timeout=60_000)
    with page.expect_download() as download:
        page.click(".step")
    assert download.value.path().read_text().startswith("ISO-10303-21;")
    with page.expect_download() as download:
        page.click(".toml")
    assert 'crank_radius = "170 mm"' in download.value.path().read_text()
    assert page.complaints == []


def test_stresses_are_shown_when_they_are_wanted(open_service):
    page = open_service()
    page.check(".stress")
    page.click(".calculate")
    page.wait_for_selector('.solid button:has-text("stress")', timeout=120_000)


def test_what_is_wrong_stands_at_its_field(open_service):
    page = open_service()
    page.fill("#a-web_width", "100 kg")
    page.wait_for_selector('#a-web_width[aria-invalid="true"]')
    told = page.locator("#a-web_width-wrong").inner_text()
    assert told.startswith("given '100 kg'")
    page.fill("#a-web_width", "11 in")
    page.wait_for_selector('#a-web_width:not([aria-invalid="true"])')
    assert page.locator("#a-web_width-wrong").inner_text() == ""
    page.fill("#a-web_width", "10")
    page.wait_for_selector(".stale")
    assert page.locator(".wrong, .dimension p").filter(has_text="allowed").count() >= 1


def test_a_link_brings_the_throws_back(open_service):
    page = open_service()
    page.fill("#a-pin_length", "150")
    page.click("#compare")
    page.fill("#b-web_thickness", "80")
    page.select_option("#unit", "in")
    page.click("#link")
    page.wait_for_timeout(300)
    again = open_service(link=page.url.partition("/#")[2] and f"#{page.url.partition('#')[2]}")
    assert again.locator(".throw").count() == 2
    assert again.locator("#unit").input_value() == "in"
    assert float(again.locator("#a-pin_length").input_value()) == close(150.0 / 25.4, 1e-4)
    assert float(again.locator("#b-web_thickness").input_value()) == close(80.0 / 25.4, 1e-4)


def test_a_model_answers_in_place_of_the_law(open_service):
    page = open_service()
    page.select_option("#source", "six")
    page.wait_for_selector('th.by:has-text("six")')
    # The model's throws have webs of 285 mm, as the page's first one.
    assert number(page, "ends pinned", 0) == close(1.3, 1e-3)
    page.fill("#a-pin_length", "150")
    page.wait_for_selector('.remarks:has-text("pin_length")')


def test_a_job_is_canceled_and_found_again(open_service):
    page = open_service()
    page.fill("#a-fillet_radius", "3")
    page.check(".stress")
    page.click(".calculate")
    page.click(".cancel:visible")
    page.wait_for_selector('.progress:has-text("Canceled")', timeout=30_000)
    page.reload()
    page.wait_for_selector('#job-list li:has-text("canceled")')


def test_a_dropped_engine_file_is_checked_run_and_canceled(open_service, tmp_path):
    page = open_service()
    file = tmp_path / "mine.toml"
    text = engine_template("mine.toml", 3, 4)
    file.write_text(text.replace("\nbore =", "\nboer ="))
    page.set_input_files("#file", file)
    page.wait_for_selector("#checked table")
    assert "engine.boer" in page.locator("#checked th[scope=row]").all_inner_texts()
    file.write_text(text)
    page.set_input_files("#file", file)
    page.click('#checked button:has-text("Run")')
    page.wait_for_selector('#job-list li:has-text("mine (engine")')
    page.click('#job-list li:has-text("mine (engine") button:has-text("Cancel")')
    page.wait_for_selector('#job-list li:has-text("mine (engine"):has-text("canceled")')


@pytest.fixture
def followed(open_service):
    """A page with one job, whose events and list are the test's."""
    page = open_service()
    job = {
        "id": "a" * 16, "kind": "engine", "title": "mine", "created": 0.0, "state": "running",
        "step": "Meshing", "finished": 0, "total": None, "files": [], "notes": [], "problem": None,
    }  # fmt: skip
    page.listed, page.canceled = [job], []
    page.route("**/api/jobs", lambda route: route.fulfill(json={"jobs": page.listed}))
    page.route(
        "**/api/jobs/*/cancel", lambda route: (page.canceled.append(1), route.fulfill(json=job))
    )
    page.add_init_script(EVENTS)
    page.reload()
    page.wait_for_selector("#job-list button")
    page.change = lambda **values: page.evaluate("job => tell(job)", job | values)
    return page


EVENTS = """window.EventSource = class extends EventTarget {
    constructor() {
        super();
        window.tell = (job) => this.dispatchEvent(new MessageEvent("job", { data: JSON.stringify(job) }));
    }
    close() {}
};"""


def test_a_click_that_an_update_interrupts_cancels(followed):
    followed.locator("#job-list button").hover()
    followed.mouse.down()
    followed.change(step="Solving", finished=1, total=2)
    followed.change(step="Report", finished=2, total=2, files=["mine"], notes=["Told."])
    followed.mouse.up()
    assert "Report (2 of 2" in followed.locator("#job-list li").inner_text()
    assert followed.locator("#job-list progress").get_attribute("value") == "2"
    assert followed.canceled == [1]
    assert followed.evaluate("document.activeElement.textContent") == "Cancel"
    followed.change(state="canceled")
    assert followed.evaluate("document.activeElement.id").startswith("job-")
    assert followed.locator("#job-list button").all_inner_texts() == ["Remove"]


def test_a_list_that_comes_late_changes_no_job_that_has_ended(followed):
    followed.change(state="canceled")
    with followed.expect_response("**/api/jobs"):
        followed.evaluate("document.dispatchEvent(new Event('jobs-changed'))")
    followed.wait_for_timeout(100)
    assert followed.locator("#job-list li").inner_text().startswith("mine (engine")
    assert "canceled" in followed.locator("#job-list li").inner_text()


def test_a_refused_change_of_a_job_is_told(followed):
    refused = {"status": 409, "detail": "The job has ended already."}
    followed.unroute("**/api/jobs/*/cancel")
    followed.route("**/api/jobs/*/cancel", lambda route: route.fulfill(status=409, json=refused))
    followed.click("#job-list button")
    followed.wait_for_selector('#job-list li:has-text("has ended already")')


def test_a_page_that_follows_many_jobs_still_asks(open_service, served, throw):
    """A browser keeps six connections to a service."""
    client = Client(served.address)
    jobs = [client.analyze_throw(throw, accuracy=0.002) for _ in range(8)]
    try:
        page = open_service()
        for job in (jobs[-1], jobs[0]):
            page.click(f"#job-{job.id} button:has-text('Cancel')")
            page.wait_for_selector(f"#job-{job.id}:has-text('canceled')", timeout=20_000)
        page.evaluate(TURN, 0.09)
        # The next one runs, and is followed.
        page.wait_for_selector(f"#job-{jobs[1].id}:has-text('Meshing')", timeout=60_000)
        client.cancel(jobs[1])
        page.wait_for_selector(f"#job-{jobs[1].id}:has-text('canceled')", timeout=20_000)
        assert page.complaints == []
    finally:
        for job in client.jobs():
            if job.state in ("queued", "running"):
                client.cancel(job)


def test_a_dropped_engine_sets_the_sliders_and_shows_its_verdict(open_service, tmp_path):
    page = open_service()
    file = tmp_path / "mine.toml"
    text = engine_template("mine.toml", 3, 4)
    file.write_text(
        text.replace('web_width = { value = "285 mm"', 'web_width = { value = "290 mm"')
    )
    page.set_input_files("#file", file)
    page.click('#checked button:has-text("Run:")')
    page.wait_for_selector(
        '#job-list li:has-text("mine (engine"):has-text("done")', timeout=300_000
    )
    page.wait_for_selector(".deciding.plot-drawn")
    assert float(page.locator("#a-web_width").input_value()) == close(290.0, 1e-6)
    assert page.locator("#verdict .card").count() >= 4
    assert serious(page) == []
    page.set_viewport_size({"width": 390, "height": 844})
    page.wait_for_timeout(500)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.reload()
    page.click('#job-list li:has-text("mine (engine"):has-text("done") button:has-text("Verdict")')
    page.wait_for_selector(".deciding.plot-drawn")
    assert page.locator("#verdict h2").inner_text().startswith("mine: ")
    assert page.complaints == []


@pytest.mark.parametrize("width", [1400, 390])
def test_letters_stand_inside_the_drawing(open_service, width):
    page = open_service(width)
    page.click('summary:has-text("Counterweights")')
    page.check(".weights")
    page.wait_for_selector('[data-field="counterweight.outer_radius"]')
    for view in (".side", ".front"):
        sheet = page.locator(f"{view} svg").bounding_box()
        for letter in page.locator(f"{view} [data-field]").all():
            box = letter.bounding_box()
            for place, size in (("x", "width"), ("y", "height")):
                assert sheet[place] - 4 <= box[place]
                assert box[place] + box[size] <= sheet[place] + sheet[size] + 4


def test_letters_light_with_their_sliders_and_bring_one_to_them(open_service):
    page = open_service()
    page.focus("#a-web_width")
    lit = page.locator(".lit")
    assert [lit.count(), lit.first.get_attribute("data-field")] == [1, "web_width"]
    page.locator('.side [data-field="pin_length"]').click()
    assert page.evaluate("document.activeElement.id") == "a-pin_length"


def test_a_slider_ends_with_the_law_and_says_why(open_service):
    page = open_service()
    page.evaluate(TURN, 10.0)  # a slider stops at its end
    # 0.6 of the main journal's 220 mm.
    assert float(page.locator("#a-web_thickness").input_value()) == close(132.0, 1e-6)
    told = page.locator("#a-web_thickness-edge").inner_text()
    assert "web_thickness / main_journal_diameter = 0.6" in told
    assert page.locator(".numbers td").first.inner_text() != "\N{EN DASH}"


def test_the_material_of_a_dropped_file_counts_everywhere(open_service):
    iron = Material(youngs_modulus=1.65e11, poisson_ratio=0.27, density=7200.0)
    page = open_service()
    text = engine_template("mine.toml", 3, 4)
    for steel, cast in (("210 GPa", "165 GPa"), ("= 0.3,", "= 0.27,"), ("7850 kg", "7200 kg")):
        text = text.replace(steel, cast)
    page.evaluate(DROP, ["mine.toml", list(text.encode())])
    page.wait_for_selector('.numbers caption:has-text("165 GPa")')
    with page.expect_download() as download:
        page.click(".toml")
    saved = download.value.path()
    throw, material = load_throw(saved)
    assert material == iron
    known = axial_law(throw, youngs_modulus=165e9, poisson_ratio=0.27).pinned
    assert number(page, "ends pinned", 0) == close(1e9 * known, 1e-3)
    page.click(".calculate")
    page.wait_for_selector(".solid.plot-drawn", timeout=60_000)
    known = analyze_throw(throw, iron).axial_compliance()
    assert number(page, "ends pinned", 2) == close(1e9 * known, 1e-3)
    page.click("#compare")
    page.wait_for_selector('[aria-labelledby="title-b"] caption:has-text("165 GPa")')
    page.wait_for_function("location.hash.includes('material')")
    page.reload()
    page.wait_for_selector('[aria-labelledby="title-b"] caption:has-text("165 GPa")')
    assert page.complaints == []


def test_counterweights_are_added_and_taken_away(open_service):
    page = open_service()
    page.click('summary:has-text("Counterweights")')
    page.check(".weights")
    assert float(page.locator("#a-counterweight\\.outer_radius").input_value()) == close(
        255.0, 1e-6
    )
    with page.expect_download() as download:
        page.click(".toml")
    assert "[throw.counterweight]" in download.value.path().read_text()
    page.uncheck(".weights")
    with page.expect_download() as download:
        page.click(".toml")
    assert "counterweight" not in download.value.path().read_text()


@pytest.mark.parametrize(("width", "height"), [(390, 844), (1280, 800)])
def test_the_answer_stays_in_view_while_a_slider_moves(open_service, width, height):
    page = open_service(width, height)
    page.locator("#a-fillet_radius").scroll_into_view_if_needed()
    page.evaluate(TURN, 0.09)
    told = page.locator(".brief").inner_text()
    assert "axial" in told
    box = page.locator(".brief").bounding_box()
    assert 0.0 <= box["y"] < height - box["height"]
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    assert page.evaluate(f"!!document.elementFromPoint({x}, {y}).closest('.brief')")
    for name in ("crank_radius", "web_thickness", "fillet_radius"):
        slider = page.locator(f"#a-{name} ~ input[type=range]")
        slider.focus()
        page.keyboard.press("ArrowRight")
        views = page.locator(".views").bounding_box()
        assert 0.0 <= views["y"] < height - views["height"]
        if width < 1000:  # the drawing stands above the slider, else beside it
            assert views["y"] < slider.bounding_box()["y"] - views["height"] + 1.0
        page.wait_for_selector(f'.lit[data-field="{name}"]')
    assert page.evaluate("document.documentElement.scrollWidth") <= width


# A file dropped anywhere on the page, as a person does it.
DROP = """([name, bytes]) => {
    const given = new DataTransfer();
    given.items.add(new File([new Uint8Array(bytes)], name));
    for (const kind of ["dragover", "drop"]) {
        document.querySelector("h1").dispatchEvent(
            new DragEvent(kind, { dataTransfer: given, bubbles: true, cancelable: true }));
    }
}"""


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("note.txt", b"hello", "note.txt"),
        ("picture.toml", b"\x89PNG\x00\xff", "picture.toml"),
        ("mine.toml", b"[engine", "mine.toml"),
    ],
)
def test_a_wrong_file_gets_one_sentence_and_leaves_the_sliders(open_service, name, content, told):
    page = open_service()
    before = page.locator("#a-web_width").input_value()
    page.evaluate(DROP, [name, list(content)])
    page.wait_for_selector('#checked:has-text("given")')
    assert told in page.locator("#checked").inner_text()
    assert page.locator("#checked button").count() == 0
    assert page.locator("#a-web_width").input_value() == before
    assert page.complaints == []


def test_an_engine_dropped_anywhere_sets_the_sliders_and_offers_its_run(open_service):
    page = open_service()
    text = engine_template("mine.toml", 3, 4).replace(
        'web_width = { value = "285 mm"', 'web_width = { value = "290 mm"'
    )
    page.evaluate(DROP, ["mine.toml", list(text.encode())])
    page.wait_for_selector('#checked button:has-text("Run:")')
    assert float(page.locator("#a-web_width").input_value()) == close(290.0, 1e-6)


def test_fixed_dimensions_of_a_model_say_so(open_service):
    page = open_service()
    page.select_option("#source", "six")
    page.wait_for_selector('#a-pin_length-edge:has-text("The model ends here: 139 mm")')


@pytest.mark.parametrize("width", [1400, 390])
def test_the_page_is_accessible_and_fits(open_service, width):
    page = open_service(width)
    page.click("#compare")
    page.fill("#a-web_width", "wide")
    page.wait_for_selector('#a-web_width[aria-invalid="true"]')
    page.click(".formulas summary >> nth=1")
    assert serious(page) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_the_keyboard_turns_and_calculates(open_service):
    page = open_service()
    page.focus("#a-crank_radius")
    page.keyboard.press("Tab")
    before = page.locator("#a-crank_radius").input_value()
    page.keyboard.press("ArrowRight")
    page.wait_for_selector('.throw:not([data-updated="1"])')
    assert float(page.locator("#a-crank_radius").input_value()) > float(before)
    page.focus(".calculate")
    page.keyboard.press("Enter")
    page.wait_for_selector(".cancel:visible")
    page.focus(".cancel")
    page.keyboard.press("Enter")


def test_nothing_leaves_this_machine(open_service, served):
    page = open_service()
    page.click(".calculate")
    page.wait_for_selector(".solid.plot-drawn", timeout=60_000)
    others = [url for url in page.asked if not url.startswith((served.address, "data:", "blob:"))]
    assert others == []
