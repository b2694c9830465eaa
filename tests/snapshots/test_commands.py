"""Printed text of each command, as it was last looked at."""

import shlex
from pathlib import Path

import pytest

from concluded import CHANGES, concluded_otherwise
from crankfem.jobs.pipeline import RunResult
from crankfem.report.writing import write_report
from printed_text import page_words
from puppets import STAND_IN, spawned
from satellite_cases import of_satellites
from snapshots.cases import FURTHER, IMPERIAL, QUICK, STUDY, both
from snapshots.conftest import FOLDER
from stand_ins import (
    calculate_satellites_once,
    calculate_vibration_once,
    stored_results,
    typed,
)

REFUSED = {f"refused-{d}" for d in ("engines", "chains", "studies", "texts", "commands", "calls")}
OTHER = {"stored-run", "report", "report-of-all", "concluded", "warned-engines", *REFUSED}

# Of exact power laws the errors would be round-off.
NEARLY_POWER_LAWS = STAND_IN.replace("** 0.3\n", "** 0.3 + 0.02 * width / pin\n")


@pytest.fixture
def screens(call, coarsely, monkeypatch, tmp_path):
    """Text of command lines in one folder: what is asked, standard output, standard error, exit code."""
    calculate_satellites_once(monkeypatch)
    calculate_vibration_once(monkeypatch)
    spawned(monkeypatch, NEARLY_POWER_LAWS)
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")

    def printed(lines):
        for line in lines:
            answer = call(*shlex.split(line))
            yield f"$ crankfem {line}\n{answer.out}"
            yield f"[standard error]\n{answer.err}" if answer.err else ""
            yield f"[exit code {answer.code}]\n" if answer.code else ""

    return lambda lines: "".join(printed(lines))


@pytest.mark.slow
@pytest.mark.parametrize("name", QUICK)
def test_printed(screens, compare, name):
    compare(name, screens(QUICK[name]))


@pytest.mark.further
@pytest.mark.parametrize("name", FURTHER)
def test_printed_by_long_commands(screens, compare, name, tmp_path):
    text = screens(FURTHER[name])
    if page := of_satellites("PAGES").get(name):
        text += page_words((tmp_path / page).read_text(encoding="utf-8"))
    compare(name, text)


@pytest.mark.slow
def test_printed_of_a_stored_run(screens, compare, monkeypatch):
    """It would take long to calculate."""
    results = typed(stored_results())
    run = RunResult(Path("results"), Path("results/report.html"), results)
    vibration = "crankfem.analyses.vibration.run.engine_vibration"
    monkeypatch.setattr(vibration, lambda *_, **__: results.vibration)
    monkeypatch.setattr("crankfem.jobs.pipeline.run_engine", lambda *_, **__: run)
    lines = (*both("run 6chn25-34"), *both("vibration 6chn25-34"), f"run 6chn25-34 {IMPERIAL}")
    compare("stored-run", screens(lines))


@pytest.mark.slow
def test_words_of_its_report(compare, tmp_path):
    path = write_report(typed(stored_results()), tmp_path, tmp_path / "report.html")
    compare("report", page_words(path.read_text(encoding="utf-8")))


@pytest.mark.slow
def test_concluded(compare):
    """Sentences of the first screen and the verdict, of stored results changed in many ways."""
    lines = [line for name in CHANGES for line in (f"# {name}", *concluded_otherwise(name))]
    compare("concluded", "\n".join(lines))


@pytest.mark.further
def test_words_of_a_report_with_strength_and_misfiring(compare, finished_run):
    page = finished_run.folder / "report.html"
    compare("report-of-all", page_words(page.read_text(encoding="utf-8")))


def test_no_snapshot_is_of_nothing():
    assert {path.stem for path in FOLDER.glob("*.txt")} == {*QUICK, *FURTHER, *OTHER}
