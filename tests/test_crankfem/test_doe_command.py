"""The commands `doe` and `fit`, with workers that do no finite elements."""

import csv
import json
import math
import os
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.study import studies
from crankfem.analyses.study.response_fits import fit_study
from crankfem.analyses.study.studies import run_grown, worst_designs
from fem.response_table import RESPONSES
from geometry.shapes import element_volumes
from plans import FILLETED, plan_of_levels, table_of_function
from puppets import PRELUDE, puppet
from regression.models.compliance_model import ComplianceModel
from regression.plans.designs import DesignChoice
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan
from regression.records import StudyStoppedError
from regression.runs import store as store_module
from regression.runs import workers
from regression.runs import workers as workers_module
from regression.runs.store import ResultStore
from regression.runs.study import read_study
from throws import MEDIUM_SPEED_TOML

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
THROW = "\n" + MEDIUM_SPEED_TOML
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


STORES = []  # of the study, once it is computed


@pytest.fixture
def studied(study, call):
    """The study beside its store."""
    path = Path("runs.sqlite")
    if not STORES:
        assert call("doe", study).code == 0
        STORES.append(path.read_bytes())
    path.write_bytes(STORES[0])
    return study


def rows(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.further
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
    answer = call("plan", study)
    assert answer.code == 0
    assert "9 runs" in " ".join(answer.out.split())
    record = call("plan", study, "--json").json()
    assert [design["role"] for design in record["designs"]] == ["run"] * 9 + ["held out"] * 3
    assert [path.name for path in tmp_path.iterdir()] == ["study.toml"]


@pytest.mark.further
def test_doe_checks_a_store_and_computes_a_damaged_row_again(call, studied, tmp_path):
    sound = call("verify", "runs.sqlite")
    assert sound.code == 0
    assert "12 designs, 0 without a result." in sound.out
    connection = sqlite3.connect("runs.sqlite")
    connection.execute(
        "UPDATE designs SET responses = replace(responses, '1', '2') WHERE rowid = 3"
    )
    connection.commit()
    connection.close()
    damaged = call("verify", "runs.sqlite")
    assert damaged.code == 2
    assert "11 done; 1 damaged." in damaged.out
    assert "12 designs, 1 without a result." in damaged.out
    assert "1 computed now" in call("doe", studied).out
    record = call("verify", "runs.sqlite", "--json").json()
    assert record["sound"]
    assert record["designs"] == {"done": 12, "failed": 0, "lost": 0}
    (tmp_path / "runs.sqlite").write_bytes((tmp_path / "runs.sqlite").read_bytes()[:9000])
    for line in (("verify", "runs.sqlite"), ("doe", studied)):
        lost = call(*line)
        assert lost.code == 2
        assert "use a copy of it, or give a new file name." in " ".join(lost.err.split())


@pytest.mark.further
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
def test_results_are_written_over_nothing_of_the_users(call, studied, tmp_path):
    for options, code in ((), 2), (("--force",), 0), ((), 0):
        if code == 2:
            (tmp_path / "out.csv").write_text("precious", encoding="utf-8")
        answer = call("results", "runs.sqlite", "out.csv", *options)
        assert answer.code == code, answer.err
        if code == 2:
            assert "out.csv: is not replaced, because crankfem has not made" in answer.err
            assert (tmp_path / "out.csv").read_text(encoding="utf-8") == "precious"
    assert len(rows(tmp_path / "out.csv")) == 12


@pytest.mark.slow
@pytest.mark.parametrize("store", ["runs.sqlite", "out.csv"])
def test_results_are_written_over_nothing_that_is_read(call, studied, tmp_path, store):
    Path("runs.sqlite").rename(store)
    if store != "out.csv":
        (tmp_path / "out.csv").symlink_to(store)
    before = (tmp_path / store).read_bytes()
    answer = call("results", store, "./out.csv", "--force")
    assert answer.code == 2
    assert (tmp_path / store).read_bytes() == before


@pytest.mark.parametrize("file", ["runs.csv", pytest.param("runs.parquet", marks=pytest.mark.slow)])
def test_results_are_a_table(call, studied, tmp_path, file):
    if file.endswith("parquet"):
        pytest.importorskip("pyarrow")
    answer = call("results", "runs.sqlite", file, "--study", studied)
    assert answer.code == 0
    assert f"12 rows written to {file}." in answer.out
    assert (tmp_path / file).stat().st_size > 1000


@pytest.mark.further
def test_earlier_and_measured_results_are_imported(call, studied, tmp_path):
    assert call("results", "runs.sqlite", "a.csv").code == 0
    (tmp_path / "bench.csv").write_text(
        "web_width [mm],axial_compliance_pinned [nm/N]\n301,1.02\n", encoding="utf-8"
    )
    for file, counted in (
        ("runs.sqlite", "12 finished designs and 0"),
        ("bench.csv", "0 finished designs and 1"),
    ):
        answer = call("import", studied, file, "--store", "b.sqlite")
        assert answer.code == 0
        assert answer.out.startswith(f"{file}: {counted}")
    answer = call("doe", studied, "--store", "b.sqlite")
    assert "0 computed now, 0 without a result, 1 imported rows." in answer.out
    assert call("results", "b.sqlite", "b.csv").code == 0
    assert rows(tmp_path / "b.csv")[:12] == rows(tmp_path / "a.csv")
    assert [row["role"] for row in rows(tmp_path / "b.csv")[12:]] == ["measured"]


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
    assert answer.err.lstrip().startswith("Error: store: ")
    assert (given["time_limit"], given["memory_limit"]) == (120.0, 4 * 2.0**30)
    assert given["dask"] == "tcp://h:1"


@pytest.mark.further
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
    assert answer.err.strip().startswith("Error: store: runs.sqlite ")
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


@pytest.mark.further
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


@pytest.mark.slow
def test_the_store_of_the_command_is_plain_sql(studied, tmp_path):
    connection = sqlite3.connect(tmp_path / "runs.sqlite")
    query = (
        "SELECT web_width, json_extract(errors, '$.mass') FROM results WHERE role = 'run' LIMIT 1"
    )
    assert connection.execute(query).fetchone() == (0.27, 0.004)
    (plan,) = connection.execute("SELECT plan FROM studies").fetchone()
    connection.close()
    assert json.loads(plan)["accuracy"] == 0.01


@pytest.mark.slow
def test_fit_prints_and_saves_a_model(store, call, tmp_path):
    answer = call("fit", store, "--full")
    assert answer.code == 0, answer.err
    text = " ".join(answer.out.split())
    for part in (
        "All responses",
        "log-cubic *",
        "Chosen by its errors: ",
        "Sobol, first",
        "Model: model.json",
    ):
        assert part in text
    model = ComplianceModel.load(tmp_path / "model.json")
    assert model.axial_compliance(web_width=0.31, web_thickness=0.06) == close(
        1e-9 * (0.2 + 0.3 / 0.31 * (0.05 / 0.06) ** 1.5), rel=5e-3
    )


@pytest.mark.slow
def test_fit_loads_no_statistics(store, spawn):
    """They take a second, which every run would wait for."""
    code = (
        "import sys, crankfem.jobs.pipeline; from crankfem.cli.entry import main; main(); "
        "print([name for name in ('scipy.stats', 'gmsh') if name in sys.modules])"
    )
    answer = spawn(
        store, "--full", command=[sys.executable, "-c", code, "fit"], folder=store.parent
    )
    assert "Sobol, first" in answer.out
    assert answer.out.splitlines()[-1] == "[]", answer.err


@pytest.mark.further
def test_fit_writes_diagrams_and_json(store, call, tmp_path):
    answer = call("fit", store, "--plots", "diagrams", "--json", "--model", "other.json")
    assert answer.code == 0, answer.err
    assert answer.json()["fits"]["mass"]["chosen"] in ("interactions", "quadratic")
    assert len(list((tmp_path / "diagrams").glob("axial_compliance_*.svg"))) == 4
    assert (tmp_path / "other.json").exists()


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("--form", "cubic", "form: given 'cubic'; allowed are linear"),
        ("--response", "nothing", "response: given 'nothing'; allowed are axial_compliance, mass"),
        ("--model", "nowhere/model.json", "there is no folder nowhere"),
        ("--model", ".", "--model: given ., which is a folder; allowed is a file to write"),
    ],
)
def test_fit_refuses(store, call, tmp_path, option, value, message):
    answer = call("fit", store, option, value)
    assert (answer.code, answer.out) == (2, "")
    assert message in " ".join(answer.err.split())
    assert not (tmp_path / "model.json").exists()


@pytest.mark.slow
@pytest.mark.parametrize("quiet", [(), ("-q",)])
def test_fit_tells_of_a_damaged_row_and_does_without(store, call, tmp_path, quiet):
    connection = sqlite3.connect(store)
    connection.execute("UPDATE designs SET responses = '{\"mass\": NaN}' WHERE rowid = 1")
    connection.commit()
    connection.close()
    answer = call("fit", store, *quiet)
    assert answer.code == 0, answer.err
    assert "1 row is damaged in" in " ".join(answer.err.split())
    assert ComplianceModel.load(tmp_path / "model.json").responses["mass"].runs == 11


GROWTH_THROW = FILLETED
BOX = {"web_width": (0.270, 0.330), "web_thickness": (0.040, 0.100), "pin_length": (0.120, 0.158)}


def compliance(x):
    width, thickness, length = x[:, 0], x[:, 1], x[:, 2]
    pin = 0.17**2 * (length + 0.33 * thickness) / (2.1e11 * math.pi * 0.18**4 / 64)
    web = 8 * 0.17**3 / (2.1e11 * width * (thickness**2 + 0.03**2) ** 1.5)
    return 0.6 * pin + 0.5 * web


@pytest.mark.slow
def test_added_runs_keep_constraints_and_relations_and_are_new(monkeypatch):
    monkeypatch.setattr(studies, "PLACES", 100)
    factors = (
        Factor("web_width", "m", 0.270, 0.330),
        Factor("web_thickness", "m", 0.040, 0.100),
        Factor("pin_length", "m", 0.120, 0.158),
        Factor.of_labels("web_outline", ("obround", "rectangle")),
    )
    plan = StudyPlan(
        GROWTH_THROW,
        factors,
        DesignChoice("latin hypercube", runs=24),
        relations={"main_journal_length": "400 mm - pin_length - 2 * web_thickness"},
        constraints=("web_width > 240 mm + web_thickness",),
    )
    table = table_of_function(plan, compliance)
    found = worst_designs(table, fit_study(table), 12)
    assert all(variant.throw is not None for variant in plan.variants().at(found))
    assert np.all(found[:, 0] > 0.240 + found[:, 1] - 1e-9)
    assert set(found[:, 3]) <= {0.0, 1.0}
    present = {row.values for row in table.rows}
    assert len({tuple(row) for row in found.tolist()} - present) == 12


WORKER = """
for request in requests():
    throw = request["inputs"]["throw"]
    value = 1e-9 * (throw["web_width"] / 0.3) ** -2.2 * (0.5 + throw["pin_length"] / 0.139)
    responses = {"axial_compliance_pinned": value}
    found = {"key": request["key"], "responses": responses, "errors": {}, "seconds": 0.5}
    answer(found | {"unknowns": 9})
"""
TWO = {"web_width": (0.280, 0.300, 0.330), "pin_length": (0.130, 0.150, 0.170)}


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr(workers, "spawn_worker", lambda: puppet(WORKER))
    monkeypatch.setattr(studies, "PLACES", 60)


@pytest.mark.slow
def test_the_store_remembers_what_was_added(quick, tmp_path):
    plan = plan_of_levels(GROWTH_THROW, TWO, held_out=3)
    store = tmp_path / "runs.sqlite"
    first = run_grown(plan, store, more=4)
    assert (first.added, first.computed, len(first.values)) == (4, 9 + 3 + 4, 16)
    again = run_grown(plan, store, more=4)
    assert (again.added, again.computed) == (4, 0)
    assert run_grown(plan, store).added == 4  # without being asked for
    assert [row.values for row in again.rows] == [row.values for row in first.rows]
    larger = run_grown(plan, store, more=6)
    assert (larger.added, larger.computed) == (6, 2)
    assert [row.values for row in larger.rows[:16]] == [row.values for row in first.rows]
    read = read_study(store)
    assert read.plan.key == plan.key
    assert (read.added, len(read.values), int(read.held_out.sum())) == (6, 18, 3)


@pytest.mark.slow
def test_an_interrupted_growth_goes_on_with_the_same_runs(quick, tmp_path):
    plan = plan_of_levels(GROWTH_THROW, TWO, held_out=3)
    store = tmp_path / "runs.sqlite"

    def interrupt(finished, *_):
        if finished == 14:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_grown(plan, store, progress=interrupt, more=4)
    chosen = [design[2] for design in read_designs(store, plan)]
    table = run_grown(plan, store, more=4)
    assert (table.added, len(table.values)) == (4, 16)
    assert table.computed <= 2
    assert [design[2] for design in read_designs(store, plan)] == chosen


def read_designs(store, plan):
    with ResultStore(store, readonly=True) as results:
        return results.study_designs(plan.key)


@pytest.mark.parametrize("more", [-1, 1001, 2.5, True])
def test_numbers_that_no_study_grows_by(tmp_path, more):
    plan = plan_of_levels(GROWTH_THROW, TWO, held_out=3)
    with pytest.raises(InputError, match=r"^more: "):
        run_grown(plan, tmp_path / "runs.sqlite", more=more)
    assert not (tmp_path / "runs.sqlite").exists()


@pytest.mark.slow
def test_too_few_throws_to_grow_by(monkeypatch):
    factors = tuple(Factor(name, "m", *ends) for name, ends in BOX.items())
    plan = StudyPlan(GROWTH_THROW, factors, DesignChoice("latin hypercube", runs=24))
    table = table_of_function(plan, compliance)
    monkeypatch.setattr(studies, "draw_feasible_points", lambda *_, **__: None)
    with pytest.raises(InputError, match=r"^more: "):
        worst_designs(table, fit_study(table), 10)


EXPORT_STUDY = (
    THROW
    + """
[study]
held_out = 1
[study.factors]
pin_length = ["120 mm", "158 mm"]
"""
)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text(EXPORT_STUDY, encoding="utf-8")
    return tmp_path / "designs"


def lines(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def write_lines(path, table):
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(table[0]))
        writer.writeheader()
        writer.writerows(table)


def masses_of_steel(files):
    """What another program makes of the meshes: of their curved tetrahedra."""
    meshio = pytest.importorskip("meshio")
    for file in files:
        mesh = meshio.read(file)
        elements = np.vstack([cells.data for cells in mesh.cells if cells.type == "tetra10"])
        yield 7850.0 * float(element_volumes(mesh.points, elements).sum())


@pytest.mark.further
def test_designs_go_out_and_results_of_another_program_come_back(call, folder):
    answer = call("designs", "study.toml", "designs", "--mesh", "inp")
    assert answer.code == 0, answer.err
    assert "3 designs, of which 3 have a file in the folder (3 written now)" in answer.out
    table = lines(folder / "designs.csv")
    assert [line["role"] for line in table] == ["run", "run", "held out"]
    assert [line["pin_length [m]"] for line in table[:2]] == ["0.12", "0.158"]
    masses = list(masses_of_steel(folder / line["file"] for line in table))
    # 38 mm of pin, and no more, make the difference.
    pin = 7850.0 * np.pi / 4.0 * 0.180**2 * 0.038
    assert masses[1] - masses[0] == close(pin, rel=2e-3)
    results = [line | {"mass [kg]": m} for line, m in zip(table, masses, strict=True)]
    write_lines(folder / "results.csv", results)
    taken = ("import", "study.toml", "designs/results.csv", "--alone", "--json")
    imported = call(*taken).json()
    assert (imported["rows"], imported["coinciding"]) == (3, 0)
    answer = call("fit", "runs.sqlite", "--json")
    assert answer.code == 0, answer.err
    record = answer.json()
    assert (record["runs"], record["held_out"], record["computed_now"]) == (2, 1, 0)
    assert record["table"]["responses"]["mass"] == close(masses)
    (fitted,) = record["fits"]
    assert fitted == "mass"
    # A straight line through two runs.
    linear = next(f for f in record["fits"]["mass"]["forms"] if f["form"] == "linear")
    slope = (masses[1] - masses[0]) / 0.038
    assert linear["coefficients"]["pin_length"] == close(slope)
    again = call(*taken).json()
    assert (again["designs"], again["rows"]) == (0, 0)
    assert call("lookup", "model.json", "pin_length=130mm").code == 0


@pytest.fixture
def export_quick(monkeypatch):
    """Files without a kernel, and a throw of 158 mm that cannot be meshed."""
    made = []

    def write(design, file):
        made.append(file.name)
        if design.inputs["throw"]["pin_length"] == 0.158:
            raise studies.MeshError("mesh: no way of meshing succeeded.")
        with studies.atomic_file(file, "solid") as part:
            part.write_text("solid", encoding="utf-8")

    monkeypatch.setattr(studies, "_write", write)
    return made


def test_what_is_there_is_not_made_again(call, folder, export_quick):
    line = ("designs", "study.toml", "designs")
    record = call(*line, "--json").json()
    assert record["written"] == 2
    (failed,) = record["failures"]
    assert record["failures"][failed] == "mesh: no way of meshing succeeded."
    assert record["files"][1] == failed
    export_quick.clear()
    answer = call(*line)
    assert len(export_quick) == 1  # the one that is missing
    assert "3 designs, of which 2 have a file in the folder (0 written now)" in answer.out
    assert f"Not written: {failed}: mesh: no way" in " ".join(answer.out.split())


@pytest.mark.parametrize("name", ["designs.csv", "mesh"])
def test_nothing_of_the_users_is_replaced(call, folder, export_quick, name):
    line = ("designs", "study.toml", "designs")
    files = call(*line, "--json").json()["files"]
    mine = folder / "designs.csv" if name == "designs.csv" else folder.parent / files[0]
    (folder / ".crankfem-outputs.json").unlink()
    for file in folder.glob("0*"):
        file.unlink()
    mine.write_text("mine", encoding="utf-8")
    if name == "mesh":
        (folder / "designs.csv").unlink()
    export_quick.clear()
    answer = call(*line)
    assert answer.code == 2
    assert mine.read_text(encoding="utf-8") == "mine"
    assert export_quick == []
