"""The command doe with workers that do no finite elements: what it takes, says and leaves behind."""

import csv
import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest

from comparing import close
from crankfem.cli.console import progress_text
from fem.responses import RESPONSES
from puppets import PRELUDE, puppet
from regression.records import StudyStoppedError
from regression.runs import store_file as store_module
from regression.runs import workers as workers_module
from regression.runs.store import ResultStore

NAMES = [name for name in RESPONSES if name != "fillet_stress_factor"]
ROOT = Path(__file__).resolve().parents[2]
PUPPET = f"""
for request in requests():
    throw = request["inputs"]["throw"]
    if throw["web_width"] == 0.299:
        time.sleep(600)
    value = 1e-9 * (0.3 / throw["web_width"]) * (throw["pin_length"] / 0.139)
    responses = {{name: (n + 1.0) * value for n, name in enumerate({NAMES!r})}}
    errors = dict.fromkeys(responses, 0.004)
    found = {{"key": request["key"], "responses": responses, "errors": errors, "seconds": 0.1}}
    answer(found | {{"unknowns": 9}})
"""
THROW = """
[throw]
crank_radius = "170 mm"
main_journal_diameter = "220 mm"
pin_diameter = "180 mm"
main_journal_length = "120 mm"
pin_length = "139 mm"
web_width = "285 mm"
web_thickness = "68 mm"
"""
STUDY = (
    THROW
    + """
[study]
held_out = 3
[study.factors]
web_width = ["270 mm", "300 mm", "330 mm"]
pin_length = ["120 mm", "139 mm", "158 mm"]
"""
)


@pytest.fixture
def study(tmp_path, monkeypatch):
    def spawn():
        return puppet(PUPPET)

    monkeypatch.setattr(workers_module, "spawn_worker", spawn)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    return "study.toml"


def rows(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.slow
def test_doe_runs_a_study_and_says_what_it_has(call, study, tmp_path):
    answer = call("doe", study)
    assert answer.code == 0, answer.err
    counted = "9 runs and 3 held-out designs in runs.sqlite; 12 computed now, 0 without a result."
    assert counted in answer.out
    again = call("doe", study, "--json")
    assert again.code == 0
    record = again.json()
    assert (record["runs"], record["held_out"], record["computed_now"]) == (9, 3, 0)
    assert record["fits"]["axial_compliance"]["chosen"]


def test_doe_shows_the_plan_and_computes_nothing(call, study, tmp_path):
    answer = call("doe", study, "--plan")
    assert answer.code == 0
    assert "9 runs" in " ".join(answer.out.split())
    record = call("doe", study, "--plan", "--json").json()
    assert [design["role"] for design in record["designs"]] == ["run"] * 9 + ["held out"] * 3
    assert [path.name for path in tmp_path.iterdir()] == ["study.toml"]


def test_doe_tells_how_the_runs_lie(call, study):
    answer = call("doe", study, "--plan")
    # Of 3 x 3 levels the nearest are half a range apart.
    assert "Runs in the unit cube: nearest runs 0.5 apart, discrepancy 0.0" in answer.out
    assert "No two factors are correlated." in answer.out
    quality = call("doe", study, "--plan", "--json").json()["quality"]
    assert quality["distance"] == close(0.5)
    assert (quality["correlation"], quality["correlated"]) == (0.0, [])
    assert 0.0 < quality["discrepancy"] < 0.1


@pytest.mark.slow
def test_doe_checks_a_store_and_repairs_it(call, study, tmp_path):
    assert call("doe", study).code == 0
    for line in (("runs.sqlite",), (study, "--store", "runs.sqlite")):
        sound = call("doe", "--check", *line)
        assert sound.code == 0
        assert "runs.sqlite: 12 done; no row damaged." in sound.out
        assert "12 designs, 0 without a result." in sound.out
    connection = sqlite3.connect("runs.sqlite")
    connection.execute(
        "UPDATE designs SET responses = replace(responses, '1', '2') WHERE rowid = 3"
    )
    connection.commit()
    connection.close()
    damaged = call("doe", "--check", "runs.sqlite")
    assert damaged.code == 2
    assert "11 done; 1 damaged." in damaged.out
    assert "its checksum does not fit its content." in damaged.out
    assert "12 designs, 1 without a result." in damaged.out
    assert "Error: runs.sqlite is damaged; crankfem doe --repair runs.sqlite" in damaged.err
    record = call("doe", "--repair", "runs.sqlite", "--json").json()
    assert (record["sound"], record["kept"], record["computed_now"]) == (True, 11, 1)
    assert record["designs"] == {"done": 12, "failed": 0, "lost": 0}
    assert record["original"] == "runs.sqlite.damaged"
    (tmp_path / "runs.sqlite").write_bytes((tmp_path / "runs.sqlite").read_bytes()[:9000])
    lost = call("doe", "--repair", "runs.sqlite")
    assert lost.code == 0
    assert (
        "was damaged: 0 sound designs are kept; the damaged file is now runs.sqlite.d" in lost.out
    )
    assert "It holds no study: run one from its file" in lost.out
    again = call("doe", "--repair", study)
    assert "12 designs computed now." in again.out


@pytest.mark.slow
def test_doe_adds_runs_once(call, study, monkeypatch):
    monkeypatch.setattr("crankfem.analyses.study.studies.PLACES", 40)
    answer = call("doe", study, "--more", "3")
    assert answer.code == 0, answer.err
    added = "12 runs and 3 held-out designs in runs.sqlite; {} computed now, 0 without a result, 3 of the"
    assert added.format(15) in answer.out
    assert "3 of the runs added to the plan's." in answer.out
    assert added.format(0) in call("doe", study, "--more", "3").out
    record = call("doe", study, "--json").json()
    assert (record["runs"], record["added"], record["computed_now"]) == (12, 3, 0)


@pytest.mark.slow
def test_doe_exports_over_nothing_of_the_users(call, study, tmp_path):
    for options, code in ((), 2), (("--force",), 0), ((), 0):
        if code == 2:
            (tmp_path / "out.csv").write_text("precious", encoding="utf-8")
        answer = call("doe", study, "--export", "out.csv", *options)
        assert answer.code == code, answer.err
        if code == 2:
            assert (
                "--export out.csv: is not replaced, because crankfem has not made it" in answer.err
            )
            assert (tmp_path / "out.csv").read_text(encoding="utf-8") == "precious"
            assert not (tmp_path / "runs.sqlite").exists()
    assert len(rows(tmp_path / "out.csv")) == 12


@pytest.mark.parametrize("read", ["study.toml", "earlier.csv"])
def test_doe_exports_over_nothing_that_it_reads(call, study, tmp_path, read):
    (tmp_path / "earlier.csv").write_text("web_width [m]\n", encoding="utf-8")
    (tmp_path / "out.csv").symlink_to(read)
    before = (tmp_path / read).read_bytes()
    answer = call("doe", study, "--import", "earlier.csv", "--export", "out.csv", "--force")
    assert answer.code == 2
    assert "because this command reads that file" in answer.err
    assert (tmp_path / read).read_bytes() == before


def test_store_and_table_of_a_study_are_two_files(call, study, tmp_path):
    answer = call("doe", study, "--store", "a.csv", "--export", "./a.csv")
    assert answer.code == 2
    assert "--export: given a.csv, which --store writes too" in answer.err
    assert not (tmp_path / "a.csv").exists()


@pytest.mark.parametrize("file", ["runs.csv", pytest.param("runs.parquet", marks=pytest.mark.slow)])
def test_doe_exports_a_table(call, study, tmp_path, file):
    if file.endswith("parquet"):
        pytest.importorskip("pyarrow")
    answer = call("doe", study, "--export", file)
    assert answer.code == 0
    assert f"12 rows written to {file}." in answer.out
    assert (tmp_path / file).stat().st_size > 1000


@pytest.mark.slow
def test_doe_takes_earlier_and_measured_results_over(call, study, tmp_path):
    assert call("doe", study, "--store", "a.sqlite", "--export", "a.csv").code == 0
    (tmp_path / "bench.csv").write_text(
        "web_width [mm],axial_compliance_pinned [nm/N]\n301,1.02\n", encoding="utf-8"
    )
    taken = ("--import", "a.sqlite", "--import", "bench.csv")
    answer = call("doe", study, "--store", "b.sqlite", *taken, "--export", "b.csv")
    assert answer.code == 0
    assert "a.sqlite: 12 finished designs and 0 further rows imported." in answer.err
    assert "bench.csv: 0 finished designs and 1 further rows imported." in answer.err
    assert "0 computed now, 0 without a result, 1 imported rows." in answer.out
    assert rows(tmp_path / "b.csv")[:12] == rows(tmp_path / "a.csv")
    assert [row["role"] for row in rows(tmp_path / "b.csv")[12:]] == ["measured"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ["--time-limit", "300"],
            "--time-limit: given '300', a bare number that could be in any unit",
        ),
        (["--time-limit", "3 m"], "--time-limit: given '3 m', which is no"),
        (["--time-limit", "0 s"], "time_limit: given 0 s; allowed is a positive"),
        (["--memory-limit", "4"], "--memory-limit: given '4', a bare number"),
        (["--memory-limit", "4 MB"], "memory_limit: given 0.004 GB; allowed is 0.5 GB or more"),
        (["--export", "runs.xlsx"], "export: given 'runs.xlsx'; allowed are .csv and .parquet"),
        (["--export", "none/runs.csv"], "export: given 'none/runs.csv'; there is no folder none"),
        (["--import", "none.csv"], "import: given 'none.csv'; there is no such file"),
        (["--more", "-1"], "more: given -1; allowed is 0 to 1000 further designs"),
        (["--more", "4", "--no-compute"], "--more: given with --no-compute; allowed is one"),
        (["--more", "4", "--plan"], "--plan: given with --export, --import, --mesh or --more"),
        (["--mesh", "inp"], "--mesh: given without --export, or with --import"),
        (["--mesh", "stl", "--export", "out"], "mesh: given 'stl'; allowed are msh, vtu"),
        (["--mesh", "inp", "--export", "a.csv"], "--export: given a.csv with --mesh; allowed is a"),
        (
            ["--check", "--plan"],
            "--check: given with another task; allowed are --check or --repair",
        ),
        (["--repair", "--check"], "--check: given with another task"),
        (["--repair", "--more", "2"], "--repair: given with another task"),
        (["--check"], "store: given 'runs.sqlite'; there is no such file"),
        (["--no-compute"], "store: given 'runs.sqlite'; there is no such file"),
    ],
)
def test_doe_refuses_options(call, study, tmp_path, options, message):
    answer = call("doe", study, *options)
    assert (answer.code, answer.out) == (2, "")
    assert " ".join(answer.err.split()).startswith(f"Error: {message}")
    assert [path.name for path in tmp_path.iterdir()] == ["study.toml"]


def test_doe_says_which_table_cannot_be_read(call, study, tmp_path):
    (tmp_path / "bad.csv").write_text(
        "web_width [mm],axial_compliance_pinned [nm/N]\n301,about 1\n", encoding="utf-8"
    )
    answer = call("doe", study, "--import", "bad.csv")
    assert answer.code == 2
    assert "bad.csv, line 2, column axial_compliance_pinned [nm/N]: given 'about 1'" in answer.err


def test_limits_are_quantities(call, study, monkeypatch):
    given = {}
    monkeypatch.setattr("regression.runs.cluster.silence_dask_log", lambda: None)

    def run_plan(*_, **options):
        given.update(options)
        raise StudyStoppedError("store: runs.sqlite cannot be used now (the disk is full).")

    monkeypatch.setattr("crankfem.analyses.study.studies.run_plan", run_plan)
    answer = call(
        "doe", study, "--time-limit", "2 min", "--memory-limit", "4 GiB", "--dask", "tcp://h:1"
    )
    assert answer.code == 3
    assert answer.err.strip() == "Error: store: runs.sqlite cannot be used now (the disk is full)."
    assert (given["time_limit"], given["memory_limit"]) == (120.0, 4 * 2.0**30)
    assert given["dask"] == "tcp://h:1"


@pytest.mark.slow
def test_a_design_beyond_its_time_is_told_and_the_others_are_fitted(call, study, tmp_path):
    text = STUDY.replace('"300 mm"', '"299 mm", "300 mm"')
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    answer = call("doe", study, "--time-limit", "0.4 s", "--workers", "4")
    assert answer.code == 0
    told = " ".join(answer.err.split())
    assert (
        told.count("lost, to be tried again by the next run: took longer than the limit of 0.4 s")
        == 3
    )
    counted = "9 runs and 3 held-out designs in runs.sqlite; 15 computed now, 3 without a result."
    assert counted in answer.out


def test_a_locked_store_ends_doe_with_one_sentence_and_3(call, study, tmp_path, monkeypatch):
    monkeypatch.setattr(store_module, "PATIENCE", 0.1)
    with ResultStore(tmp_path / "runs.sqlite"):
        pass
    other = sqlite3.connect(tmp_path / "runs.sqlite", isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    answer = call("doe", study)
    other.close()
    assert (answer.code, answer.out) == (3, "")
    assert answer.err.strip().startswith(
        "Error: store: runs.sqlite cannot be used now (another program"
    )
    assert "Traceback" not in answer.err


INTERRUPTED = """
import os, subprocess, sys
from regression.runs import workers as workers_module
workers_module.spawn_worker = lambda: subprocess.Popen(
    [sys.executable, "-S", "-c", os.environ["PUPPET"]], stdin=subprocess.PIPE, stdout=subprocess.PIPE
)
from crankfem.cli.entry import main
main()
"""


@pytest.mark.slow
@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_says_how_many_designs_are_kept(study, tmp_path):
    """One design hangs; the interrupt comes when all others are finished."""
    text = STUDY.replace('"300 mm"', '"299 mm"').replace(
        '"120 mm", "139 mm", "158 mm"', '"120 mm", "158 mm"'
    )
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    process = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED, "doe", study, "--workers", "3"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT), "PUPPET": PRELUDE + PUPPET},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    store, deadline = tmp_path / "runs.sqlite", time.monotonic() + 60.0
    while time.monotonic() < deadline and finished(store) < 7:
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30.0)
    assert (process.returncode, out) == (130, "")
    assert " ".join(err.split()).endswith(
        "Stopped. 7 of 9 designs are finished and kept in runs.sqlite; the same command continues "
        "where it stopped."
    )
    assert finished(store) == 7


def finished(store):
    if not store.is_file():
        return 0
    connection = sqlite3.connect(store)
    try:
        return connection.execute("SELECT count(*) FROM designs").fetchone()[0]
    except sqlite3.OperationalError:
        return 0
    finally:
        connection.close()


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ((0, 5.0, 10), ""),
        ((10, 60.0, 190), "10 designs/min, 19 min left"),
        ((1, 2.0, 3), "30 designs/min, 6 s left"),
        ((200, 1234.0, 0), "9.72 designs/min"),
        ((10, 3600.0, 40), "0.167 designs/min, 4.0 h left"),
    ],
)
def test_pace(given, text):
    assert progress_text(*given) == text


def test_the_store_of_the_command_is_plain_sql(call, study, tmp_path):
    call("doe", study)
    connection = sqlite3.connect(tmp_path / "runs.sqlite")
    query = (
        "SELECT web_width, json_extract(errors, '$.mass') FROM results WHERE role = 'run' LIMIT 1"
    )
    assert connection.execute(query).fetchone() == (0.27, 0.004)
    (plan,) = connection.execute("SELECT plan FROM studies").fetchone()
    connection.close()
    assert json.loads(plan)["accuracy"] == 0.01
