import html
import json
import re
import shutil
import signal
import subprocess
import sys
import time
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from comparing import close
from crankbase.errors import SolveError
from crankfem.analyses.vibration import run as vibration_run
from crankfem.jobs import pipeline, run_drawing
from crankfem.jobs.run_files import PICTURED, PICTURES, make_folders, the_only_run
from crankfem.report.interactive import mechanism
from crankfem.report.interactive import vibration as interactive_vibration
from regression.models.compliance_model import ComplianceModel
from stand_ins import put_everywhere

pytestmark = pytest.mark.slow

# What makes a browser load something, by tag.
LOADING = {"img": "src", "script": "src", "link": "href", "iframe": "src", "object": "data"}


class Page(HTMLParser):
    """The parts of a report that a test looks at."""

    def __init__(self, text):
        super().__init__()
        self.loaded, self.anchors, self.ids, self.alternatives = [], [], [], []
        self.tags, self.words, self._unread = set(), [], None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.tags.add(tag)
        if tag in ("script", "style"):
            self._unread = tag
        if tag in LOADING and (tag != "script" or "src" in found):
            self.loaded.append(found.get(LOADING[tag]) or "")
        if tag == "img":
            self.alternatives.append(found.get("alt"))
        if tag == "a":
            self.anchors.append(found["href"])
        if "id" in found:
            self.ids.append(found["id"])

    def handle_endtag(self, tag):
        if tag == self._unread:
            self._unread = None

    def handle_data(self, data):
        if self._unread is None:
            self.words.append(data)


def report_of(folder):
    return (folder / "report.html").read_text(encoding="utf-8")


@pytest.mark.further
def test_json_on_standard_output_is_the_content_of_results(finished_run):
    answered = finished_run.answer.json()
    answered.pop("not_used")  # of the command, not of the results
    assert answered == finished_run.results
    assert "Traceback" not in finished_run.answer.err


@pytest.mark.further
def test_the_folder_holds_everything(finished_run):
    names = {path.name for path in finished_run.folder.iterdir()}
    assert {"report.html", "results.json", "model.json", "study.sqlite", "pictures"} <= names
    pictures = finished_run.results["pictures"]
    assert {"drawing", "effects"} <= set(pictures)
    plots = finished_run.results["interactive"]
    assert {"response", "parity", "formulas", "axial_modes", "torsional_campbell"} <= set(plots)
    # Each is made once.
    assert not pictures.keys() & plots.keys()
    for name in (*pictures.values(), *plots.values()):
        assert (finished_run.folder / "pictures" / name).stat().st_size > 1000


@pytest.mark.further
def test_every_picture_of_a_run_is_seen_in_its_way(finished_run):
    results = finished_run.results
    named = {*results["pictures"].values(), *results["interactive"].values()}
    assert {Path(name).stem for name in named} <= PICTURED


@pytest.mark.further
def test_throws_in_the_shaft_are_stiffer_than_pinned(finished_run):
    shares = finished_run.results["shaft"]["axial_beside_pinned"]
    assert len(shares) == 6
    assert all(0.2 < share < 1.0 for share in shares)
    assert shares == close(shares[::-1], rel=1e-6)
    assert min(shares) == close(shares[2])


@pytest.mark.further
def test_the_model_gives_the_numbers_of_the_results(finished_run):
    model = ComplianceModel.load(finished_run.folder / "model.json")
    study = finished_run.results["study"]
    values, held = np.array(study["table"]["values"])[:, 0], np.array(study["table"]["held_out"])
    for name in ("axial_compliance", "torsional_compliance"):
        truth = np.array(study["table"]["responses"][f"{name}_pinned"])
        errors = np.abs(getattr(model, name)(web_thickness=values) / truth - 1.0)
        fits = study["fits"][name]
        chosen = next(form for form in fits["forms"] if form["form"] == fits["chosen"])
        assert errors[held].max() == close(chosen["largest_error_held_out"], rel=1e-6)
        assert model.responses[name].equation == chosen["equation"]
        names = {"web_thickness": values, "ln": np.log, "__builtins__": {}}
        logarithmic = any("ln(" in term for term in chosen["coefficients"])
        total = sum(
            coefficient * eval(term.replace("^", "**"), names)
            for term, coefficient in chosen["coefficients"].items()
        )
        by_hand = np.exp(total) if logarithmic else total
        assert getattr(model, name)(web_thickness=values) == close(by_hand, rel=1e-9)
    assert model.provenance["study"] == study["key"]


@pytest.mark.further
def test_vibration(finished_run):
    for kind, rigid in (("axial", 0), ("torsional", 1)):
        record = finished_run.results["vibration"][kind]
        assert record["source"] == "fe"
        frequencies = [mode["frequency"] for mode in record["modes"]]
        assert frequencies == sorted(frequencies)
        assert sum(mode["rigid"] for mode in record["modes"]) == rigid
        sources = {source["source"]: source for source in record["sources"]}
        assert {"fe", "fe pinned", "regression"} <= set(sources)
        assert sources["fe"]["beside_chosen"] == close(1.0)
        assert sources["fe pinned"]["beside_chosen"] < 1.0
        assert sources["regression"]["beside_chosen"] == close(1.0, abs=0.02)
        for critical in record["criticals"]:
            # Up to 1.15 times the rated speed of 500 1/min, as far as the limit on the stress holds.
            assert 200.0 <= critical["speed_rpm"] <= 575.0
            assert critical["in_running_range"] == (critical["speed_rpm"] <= 515.0)
            speed = 60.0 * critical["frequency"] / critical["order"]
            assert critical["speed_rpm"] == close(speed)
            assert 0.0 <= critical["phase_sum"] <= 1.0 + 1e-9


@pytest.mark.further
def test_the_report_is_one_file_that_loads_nothing(finished_run):
    text = report_of(finished_run.folder)
    page = Page(text)
    assert not page.tags & {"link", "iframe", "object", "embed", "base"}
    assert len(page.loaded) == len(finished_run.results["pictures"])
    assert all(source.startswith("data:image/") for source in page.loaded)
    assert all(page.alternatives)
    assert all(anchor.startswith("#") and anchor[1:] in page.ids for anchor in page.anchors)
    # What scripts load is watched by a browser, in tests/browser.
    unscripted = re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    for loading in ("url(", "@import", "http://", "https://"):
        assert loading not in unscripted
    # The library of the plots stands there once; so does each plot.
    assert text.count('id="plotly"') == 1
    plots = finished_run.results["interactive"]
    assert {"throw_view", "axial_amplitude", "response", "crankpin_polar"} <= set(plots)
    packed = re.findall(r'<script type="application/gzip" id="plot-([a-z_]+)">', text)
    assert set(packed) == set(plots)
    assert len(text) < 4e6


@pytest.mark.further
def test_a_run_checks_itself(finished_run):
    checks = {own["name"]: own for own in finished_run.results["checks"]}
    unmet = {name for name, own in checks.items() if own["met"] is False}
    assert all("chain compared with the whole crankshaft" in name for name in unmet)
    assert checks["Equilibrium of the reactions"]["figure"] < 1e-9
    words = " ".join(" ".join(Page(report_of(finished_run.folder)).words).split())
    assert all(name in words for name in checks)


@pytest.mark.further
def test_a_run_says_how_to_repeat_it(finished_run, quick_six):
    repeat = finished_run.results["repeat"]
    assert repeat["command"] == "crankfem run quick.toml"
    assert repeat["files"][0]["text"] == quick_six
    assert 1.0 < sum(repeat["seconds"].values()) < 1000.0
    assert {"Running the study", "Calculating stresses at the fillets"} <= set(repeat["seconds"])


@pytest.mark.further
def test_lookup_and_fit_continue_from_a_run(finished_run, call, tmp_path):
    answer = call("lookup", finished_run.folder / "model.json", "web_thickness=70mm", "--json")
    model = ComplianceModel.load(finished_run.folder / "model.json")
    value = answer.json()["axial_compliance"]["value"]
    assert value == close(model.axial_compliance(web_thickness=0.070), rel=1e-14)
    answer = call("fit", finished_run.folder / "study.sqlite", "--model", "again.json", "--json")
    assert answer.code == 0, answer.err
    assert answer.json()["computed_now"] == 0
    assert ComplianceModel.load(tmp_path / "again.json").responses == model.responses


@pytest.mark.further
def test_another_choice_of_sources_repeats_no_design(
    finished_run, unseen, quick_six, edit, call, tmp_path
):
    choices = {"vibration.axial_source": '"anderson"', "vibration.torsional_source": '"regression"'}
    (tmp_path / "other.toml").write_text(edit(quick_six, choices), encoding="utf-8")
    shutil.copytree(finished_run.folder, tmp_path / "other-results")
    answer = call("run", "other.toml")
    assert answer.code == 0, answer.err
    assert "Report: other-results/report.html" in answer.out
    results = json.loads((tmp_path / "other-results" / "results.json").read_text(encoding="utf-8"))
    assert results["study"]["computed_now"] == 0
    before = finished_run.results
    assert results["study"]["table"] == before["study"]["table"]
    assert results["vibration"]["axial"]["source"] == "Anderson"
    assert results["vibration"]["torsional"]["source"] == "regression"
    for kind, name in (("axial", "Anderson"), ("torsional", "regression")):
        sources = before["vibration"][kind]["sources"]
        (expected,) = [source for source in sources if source["source"] == name]
        modes = [m["frequency"] for m in results["vibration"][kind]["modes"] if not m["rigid"]]
        assert modes[:3] == close(expected["first_frequencies"], rel=1e-6)


@pytest.mark.further
def test_an_engine_with_torque_table_and_two_mass_check(
    coarsely, quick_four, call, tmp_path, strict
):
    (tmp_path / "four.toml").write_text(quick_four, encoding="utf-8")
    answer = call("run", "four.toml", "--output", "a/b", "--workers", "1", "--json")
    assert answer.code == 0, answer.err
    results = answer.json()
    results.pop("not_used", None)  # of the command, not of the results
    assert strict((tmp_path / "a" / "b" / "results.json").read_text(encoding="utf-8")) == results
    harmonics, check = results["harmonics"], results["two_mass"]
    assert harmonics["amplitude"][0] == close(279.68, abs=0.006)
    assert harmonics["phase_deg"][0] % 360.0 == close(230.16, abs=0.006)
    assert check["stiffness"] == close(942.9e3, rel=1e-4)
    assert check["vibrations_per_minute"] == close(31_145.0, abs=0.6)
    assert check["resonant_speed_rpm"] == close(2224.7, abs=0.06)
    assert check["order"] == 14.0
    words = " ".join(" ".join(Page(report_of(tmp_path / "a" / "b")).words).split())
    for shown in ("942.9 kN m/rad", "31145 1/min", "2224.7 1/min"):
        assert shown in words


@pytest.mark.slow
def test_an_engine_of_one_cylinder_with_the_least_of_inputs(
    lightly, least_engine, edit, call, tmp_path
):
    # Tags, markup of the terminal, and what matplotlib takes for mathematics.
    changes = {"engine.name": '"<b>one</b> & [bold]only[/] é $A_{$ 5"'}
    (tmp_path / "one.toml").write_text(edit(least_engine, changes), encoding="utf-8")
    answer = call("run", "one.toml", "--json")
    assert answer.code == 0, answer.err
    results = answer.json()
    assert results["study"] is None
    assert results["picture_note"] == "there is no OpenGL library"
    assert results["picture_note"] in answer.err
    assert results["throw"]["radial_force"] == 1e5
    assert len(results["shaft"]["axial"]) == 1
    assert not (tmp_path / "one-results" / "model.json").exists()
    text = report_of(tmp_path / "one-results")
    assert "<b>one</b>" not in text
    assert "&lt;b&gt;one&lt;/b&gt; &amp; [bold]only[/] é $A_{$ 5" in text
    assert "drawing" in results["pictures"]
    assert {"axial_campbell", "axial_modes", "formulas"} <= set(results["interactive"])


@pytest.fixture
def one_cylinder(six_cylinders, edit, tmp_path):
    """Write an engine of one cylinder under a name, with gas pressure but no study."""
    gone = ("material", "free_end", "vibration", "study", "study.factors")
    changes = {f"[{name}]": None for name in gone} | {
        "engine.cylinders": "1",
        "engine.crank_angles": '["0 deg"]',
        "engine.firing_order": "[1]",
        "thrust_bearing.main_bearing": "2",
    }

    def write(name):
        own = edit(six_cylinders, changes | {"engine.name": f'"{name}"'})
        (tmp_path / "one.toml").write_text(own, encoding="utf-8")
        return "one.toml"

    return write


@pytest.mark.further
def test_what_cannot_be_drawn_costs_no_other_result(
    coarsely, one_cylinder, call, tmp_path, monkeypatch
):
    folder = tmp_path / "one-results"
    assert call("run", one_cylinder("Engine FIRST")).code == 0
    first = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    assert {"axial_campbell", "torsional_campbell", "crankpin_polar"} <= set(first["interactive"])

    def fail(*_, **__):
        raise ValueError("no such picture")

    monkeypatch.setattr(mechanism, "polar_load", fail)
    monkeypatch.setattr(run_drawing, "write_vtu", fail)
    answer = call("run", one_cylinder("Engine SECOND"), "--json")
    assert answer.code == 0, answer.err
    results = answer.json()
    # What fails for a screen is drawn on paper.
    failed = {"crankpin_polar", "main_bearing_polar"}
    assert set(results["pictures"]) == {*first["pictures"], *failed}
    assert set(results["interactive"]) == set(first["interactive"]) - failed
    for what in ("interactive plot crankpin_polar", "throw.vtu"):
        sentence = f"There is no {what}: ValueError: no such picture"
        assert sentence in results["picture_note"]
        assert sentence in " ".join(answer.err.split())
        assert sentence in html.unescape(report_of(folder))
    # Nothing of the run before is left beside them.
    assert not (folder / "throw.vtu").exists()
    there = {path.name for path in (folder / "pictures").glob("[!.]*")}
    assert there == {*results["pictures"].values(), *results["interactive"].values()}
    assert "Engine FIRST" not in report_of(folder)


@pytest.mark.further
def test_a_run_that_fails_leaves_the_last_one_whole(
    coarsely, one_cylinder, call, tmp_path, monkeypatch
):
    assert call("run", one_cylinder("Engine FIRST")).code == 0
    folder = tmp_path / "one-results"
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}

    def fail(*_, **__):
        raise SolveError("no solution")

    with monkeypatch.context() as patch:
        patch.setattr(pipeline, "engine_vibration", fail)
        answer = call("run", one_cylinder("Engine SECOND"))
    assert answer.code == 3
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before

    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(interactive_vibration, "campbell", interrupt)
    answer = call("run", one_cylinder("Engine THIRD"))
    assert answer.code == 130
    results = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    assert results["engine"]["name"] == "Engine THIRD"
    assert not (folder / "report.html").exists()
    # All numbers are there, so there can be a report; no picture of any run stands in it.
    answer = call("report", folder)
    assert answer.code == 0, answer.err
    page = Page(report_of(folder))
    assert page.loaded == []
    assert "Engine FIRST" not in report_of(folder)


def test_vibration_without_the_study(coupled_vibration, call, monkeypatch):
    run = coupled_vibration("6chn25-34")
    put_everywhere(monkeypatch, vibration_run.engine_vibration, lambda *_, **__: run)
    answer = call("vibration", "6chn25-34", "--coupled", "--json")
    assert answer.code == 0, answer.err
    content = answer.json()
    assert set(content) == {
        *("axial", "torsional", "forced", "assumed", "assessment", "whole", "bearings", "files"),
        *("load", "misfiring", "misfiring_note", "axial_force", "units", "not_comparable"),
        *(
            "firing",
            "firing_remarks",
            "firing_warnings",
            "running_rpm",
            "not_used",
            "said",
            "findings",
        ),
    }
    assert content["torsional"]["modes"][0]["rigid"] is True
    assert content["torsional"]["modes"][0]["frequency"] == close(0.0, abs=1e-2)


def test_run_refuses_a_folder_that_cannot_be(call, quick_six, tmp_path):
    (tmp_path / "quick.toml").write_text(quick_six, encoding="utf-8")
    answer = call("run", "quick.toml", "--output", "quick.toml")
    assert answer.code == 2
    assert answer.err.lstrip().startswith("Error: output: given 'quick.toml'")


@pytest.mark.further
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such locks")
def test_a_second_run_in_a_folder_is_refused(spawn, quick_six, tmp_path):
    (tmp_path / "quick.toml").write_text(quick_six, encoding="utf-8")
    with the_only_run(make_folders(tmp_path / "quick-results", PICTURES)):
        answer = spawn("run", "quick.toml")
    assert answer.code == 2
    assert "another run" in answer.err
    assert not [path.name for path in (tmp_path / "quick-results").rglob("*") if path.is_file()]


@pytest.mark.further
@pytest.mark.usefixtures("interruptible")
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signal")
def test_an_interrupted_study_says_how_to_go_on(spawn_environment, tmp_path):
    command = [
        sys.executable,
        "-c",
        "from crankfem.cli.entry import main; main()",
        "doe",
        "6chn25-34",
    ]
    process = subprocess.Popen(
        command,
        cwd=tmp_path,
        env=spawn_environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    deadline = time.monotonic() + 60.0
    while not (tmp_path / "runs.sqlite-wal").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30.0)
    assert process.returncode == 130
    assert out == ""
    assert err.rstrip().splitlines()[-1].startswith("Stopped. ")
    assert "Traceback" not in err
