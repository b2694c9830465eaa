"""The report, written from the stored results of a run: no finite elements, no pictures.

``report_results.json`` is the results.json of ``crankfem run 6chn25-34``, with long lists cut short and
numbers rounded to six digits (the stiffness is not).
"""

import copy
import json
import re
from collections import Counter
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import pytest

from crankfem.report import numbers
from crankfem.report.about import about_record, repeat_record
from crankfem.report.compliances import compliance_tables, regression_record
from crankfem.report.figures import load_figures, script_text
from crankfem.report.summary import summary
from crankfem.report.writing import script, write_report

STORED = Path(__file__).with_name("report_results.json")
VOID = {"meta", "img", "br", "link", "input", "hr"}
SQUARE = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 75 150"><rect width="9" height="9"/></svg>'


class Page(HTMLParser):
    """The elements of a report with the text in each."""

    def __init__(self, text):
        super().__init__()
        self.elements, self._open = [], []
        self.feed(text)
        assert self._open == []

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes), []))
        if tag not in VOID:
            self._open.append(self.elements[-1])

    def handle_endtag(self, tag):
        assert self._open.pop()[0] == tag
        if tag in ("td", "th", "dt", "dd", "li"):
            self.handle_data(" ")

    def handle_data(self, data):
        for _, _, text in self._open:
            text.append(data)

    def all(self, tag, **attributes):
        """Return (attributes, text) of all such elements."""
        return [
            (found, " ".join("".join(text).split()))
            for name, found, text in self.elements
            if name == tag and all(found.get(key) == value for key, value in attributes.items())
        ]

    def section(self, name):
        return self.all("section", id=name)[0][1]


@pytest.fixture(scope="module")
def stored():
    return json.loads(STORED.read_text(encoding="utf-8"))


@pytest.fixture
def results(stored):
    return copy.deepcopy(stored)


@pytest.fixture
def page(tmp_path):
    def render(results):
        path = write_report(results, tmp_path, tmp_path / "report.html")
        return Page(path.read_text(encoding="utf-8"))

    return render


def without_gas(results):
    results["mechanism"] = None
    results["vibration"] |= {"forced": None, "assessment": None}
    for chain in results["vibration"]["whole"]["chains"].values():
        chain |= {"chain_amplitude": None, "shaft_amplitude": None}
    results["engine"]["radial_force_from_gas"] = False
    return results


def of_an_older_run(results):
    for name in ("fillets", "fillet_note", "checks", "repeat", "interactive"):
        del results[name]
    for name in ("python", "platform", "processors", "packages"):
        del results["about"][name]
    return results


def without_study(results):
    results["study"] = None
    return results


def with_unbounded_vibration(results):
    for forced in results["vibration"]["forced"].values():
        forced["resonances"][0] |= {"amplitude": None, "estimate": None, "unbounded": True}
        forced["loads"][0]["peak"] = None
    results["vibration"]["assessment"]["checks"][0] |= {"value": None, "used": None}
    return results


def without_fillets(results):
    results |= {"fillets": None, "fillet_note": "the throw has no fillets"}
    return results


CASES = (
    lambda results: results,
    without_gas,
    of_an_older_run,
    without_study,
    with_unbounded_vibration,
    without_fillets,
)


@pytest.mark.parametrize("case", CASES)
def test_every_report_is_a_sound_page(results, page, case):
    found = page(case(results))
    assert len(found.all("h1")) == len(found.all("main")) == 1
    ids = Counter(own["id"] for _, own, _ in found.elements if "id" in own)
    assert max(ids.values()) == 1
    anchors = [own["href"] for own, _ in found.all("a")]
    assert len(anchors) > 20
    assert all(anchor[1:] in ids for anchor in anchors)
    sections = [own for own, _ in found.all("section")]
    assert all(own["aria-labelledby"] in ids for own in sections)
    # Every section stands in the contents, on wide and on narrow screens.
    assert all(anchors.count(f"#{own['id']}") >= 2 for own in sections)
    assert len(found.all("table")) == len(found.all("caption"))
    assert all("scope" in own for own, _ in found.all("th"))
    scrolled = found.all("div", **{"class": "scroll"})
    assert all(own["tabindex"] == "0" and own["aria-label"] for own, _ in scrolled)
    levels = [int(tag[1]) for tag, _, _ in found.elements if re.fullmatch("h[1-6]", tag)]
    assert all(after <= before + 1 for before, after in pairwise(levels))


@pytest.mark.parametrize("case", CASES)
def test_no_word_of_the_program_stands_where_an_engineer_reads(results, page, case):
    (_, text) = page(case(results)).all("main")[0]
    words = set(re.findall(r"[\w.]+", text))
    assert not words & {"None", "nan", "inf", "True", "False", "null", "undefined"}
    (_, sources) = page(results).all("section", id="modes")[0]
    assert "finite elements" in sources
    assert not re.search(r"\bfe\b", sources)


def test_the_first_screen_says_what_matters(results, page):
    first = page(results).section("verdict")
    assert first.startswith("Not acceptable")
    for shown in (
        "24.48 MPa at 497.8 1/min",
        "115 % of the permitted 21.21 MPa",
        "406.2 to 465.6 1/min cannot be barred",
        "27 of 37 inputs are assumed",
        "1.289e-9 m/N",
        "error about 0.96 %",
        "76.8 Hz",
        "87.0 Hz",
        "whole crankshaft in its bearings: 81.1 Hz",
        "511.8 9 (major) 341 µm",
        "434.9 12 (major) 1.42 mrad",
    ):
        assert shown in first


def test_without_gas_pressure_critical_speeds_stand_in_for_resonances(results, page):
    found = page(without_gas(results))
    first = found.section("verdict")
    assert first.startswith("Not judged: no gas pressure is given")
    assert "11 critical speeds of orders up to 12 lie in the running range" in first
    assert "383.8 12 1.00" in first
    assert "Amplitudes and stresses against limits" not in first
    there = {own["id"] for own, _ in found.all("section")}
    assert there.isdisjoint({"response", "limits", "loads"})
    assert {"campbell", "modes", "balance", "whole"} <= there


def test_without_any_critical_speed_that_is_said(results, page):
    results = without_gas(results)
    for kind in ("axial", "torsional"):
        results["vibration"][kind]["criticals"] = []
    found = page(results)
    assert "0 critical speeds" in found.section("verdict")
    assert "No axial critical speed lies in the running range" in found.section("campbell")


@pytest.mark.parametrize(
    ("status", "sentence", "shown"),
    [
        ("fine", "Fine from 200 to 515 1/min: torsional", "fine"),
        ("barred range needed", "Barred range needed, 400 to 450 1/min: torsional", "barred"),
        ("not acceptable", "Not acceptable: torsional", "bad"),
    ],
)
def test_the_verdict_has_its_color_and_headline(results, status, sentence, shown):
    results["vibration"]["assessment"] |= {"status": status, "sentence": sentence}
    found = summary(results)
    assert (found["status"], found["headline"]) == (shown, sentence.partition(":")[0])


def test_unbounded_vibration_is_called_so(results):
    found = summary(with_unbounded_vibration(results))
    assert "unbounded at 497.8 1/min; permitted is 21.21 MPa" in found["sentences"][0]


def test_each_limit_stands_once_at_its_worst_place(results):
    checks = results["vibration"]["assessment"]["checks"]
    checks.append(checks[0] | {"limit": "axial force", "used": 0.5, "passed": True})
    shown = summary(results)["limits"]
    assert [own["limit"] for own in shown] == ["torsional stress of crankshaft", "axial force"]
    assert shown[0]["used"] == max(check["used"] for check in checks)


def test_compliances_of_all_sources_stand_side_by_side(results):
    found = compliance_tables(results)
    axial, torsional = (found["tables"][kind]["rows"] for kind in ("axial", "torsional"))
    assert [row["name"] for row in axial[:3]] == [
        "finite elements, pinned",
        "finite elements, mean in the shaft",
        "regression of the study",
    ]
    assert axial[0]["beside"] == 1.0
    assert axial[1]["frequency"] == pytest.approx(76.76, abs=0.01)
    assert len(axial) == 3 + 9
    assert len(torsional) == 3 + 5
    # A remark that several formulas share is a note said once.
    assert len(found["notes"]) == len(set(found["notes"]))
    used = {number for row in (*axial, *torsional) for number in row["notes"]}
    assert used == set(range(1, len(found["notes"]) + 1))
    applying = [row["beside"] for row in axial[3:] if row["applies"]]
    assert found["range"]["axial"] == (min(applying), max(applying))


def test_the_regression_answers_with_the_chosen_form(results):
    found = regression_record(results["study"], {"axial_compliance": 1.3e-9})
    assert set(found) == {"axial"}
    fits = results["study"]["fits"]["axial_compliance"]
    (chosen,) = [form for form in fits["forms"] if form["form"] == fits["chosen"]]
    assert found["axial"]["largest_error_held_out"] == chosen["largest_error_held_out"]
    assert regression_record(None, {}) is None


def test_a_plot_goes_with_its_picture(results, page, tmp_path):
    (tmp_path / "a.svg").write_text(SQUARE, encoding="utf-8")
    (tmp_path / "a.json").write_text('{"data":[{"name":"</script><b>"}]}', encoding="utf-8")
    results |= {"pictures": {"drawing": "a.svg"}, "interactive": {"drawing": "a.json"}}
    own = load_figures(results, tmp_path)["drawing"]
    assert (own.width, own.height) == (100, 200)
    assert json.loads(own.plot) == {"data": [{"name": "</script><b>"}]}
    assert own.source.startswith("data:image/svg+xml;base64,")
    found = page(results)
    assert len(found.all("div", **{"class": "interactive", "data-plot": "drawing"})) == 1
    ((_, data),) = found.all("script", id="plot-drawing")
    assert json.loads(data) == json.loads(own.plot)
    # The library once, what uses it, and what opens folded parts for printing.
    scripts = [own for own, _ in found.all("script") if own.get("type") is None]
    assert len(scripts) == 3
    assert not any("src" in own for own in scripts)


def test_a_report_without_plots_carries_no_library(results, tmp_path):
    path = write_report(results, tmp_path, tmp_path / "report.html")
    assert path.stat().st_size < 200_000


def test_the_same_results_make_the_same_report(results, tmp_path):
    one, two = (
        write_report(results, tmp_path, tmp_path / f"{name}.html").read_bytes() for name in "ab"
    )
    assert one == two


def test_a_missing_picture_is_an_error(results, page):
    results["pictures"] = {"drawing": "drawing.svg"}
    with pytest.raises(FileNotFoundError, match=r"drawing\.svg"):
        page(results)


def test_scripts_hold_nothing_that_a_page_cannot():
    assert script("'\x1a' + '</script>'") == r"'\x1a' + '<\/script>'"
    assert str(script_text('{"a": "<!--"}\n')) == '{"a": "\\u003c!--"}'


def test_the_input_can_be_had_from_the_report(results, page):
    repeat = page(results).section("repeat")
    file = results["repeat"]["files"][0]
    assert file["sha256"] in repeat
    assert 'name = "6ChN 25/34"' in repeat
    assert "crankfem run 6chn25-34.toml" in repeat
    assert results["about"]["packages"]["gmsh"] in repeat


def test_what_a_run_was_made_with(tmp_path):
    about = about_record()
    assert re.match(r"\d+\.\d+", about["version"])
    assert about["packages"]["numpy"] is not None
    file = tmp_path / "my engine.toml"
    file.write_bytes(b"abc")
    record = repeat_record(file, [file], {"a": 1.0})
    assert record["command"] == 'crankfem run "my engine.toml"'
    ((own),) = record["files"]
    # The example of FIPS 180-2.
    assert own["sha256"] == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert own["text"] == "abc"


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        (numbers.significant(1.6), "1.600"),
        (numbers.significant(34.1041), "34.10"),
        (numbers.significant(15597.4, 5), "15597"),
        (numbers.percent(2e-7), "below 0.001"),
        (numbers.percent(0.0), "0"),
        (numbers.fixed(-1e-12, 2), "0.00"),
        (numbers.quantity(None, "Pa"), "unbounded"),
        (numbers.quantity(24478491.8, "Pa"), "24.48 MPa"),
        (numbers.motion(1.41734e-3, "torsional"), "1.42 mrad"),
        (numbers.tiny(-3.87e-13), "4e-13"),
        (numbers.tiny(2e-7), "2e-7"),
        (numbers.duration(7.26), "7.3 s"),
        (numbers.duration(59.6), "1 min 0 s"),
        (numbers.duration(3725.0), "1 h 2 min"),
        (numbers.moment("2026-11-21T21:30:07+05:30"), "21 November 2026, 21:30 UTC+05:30"),
        (numbers.tied("at 497.8 1/min, 9 of 10"), "at 497.8\N{NO-BREAK SPACE}1/min, 9 of 10"),
        (str(numbers.head("a <b> [mm]")), 'a &lt;b&gt; <span class="nowrap">[mm]</span>'),
    ],
)
def test_numbers_are_written_for_reading(written, expected):
    assert written == expected
