"""A store is checked row by row; damaged rows are left out, told of and computed again."""

import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing

import pytest

from crankbase.errors import InputError
from plans import SHARP, plan_of_levels
from puppets import puppet
from refusals import refused
from regression.plans.plan import plan_designs
from regression.records import ExtraRow, Outcome
from regression.runs import workers
from regression.runs.store import ResultStore
from regression.runs.study import check_store, import_results, read_study, run_plan

PLAN = plan_of_levels(SHARP, {"web_width": (0.280, 0.290, 0.300)}, held_out=37, accuracy=0.1)
KEYS = [design.key for design in plan_designs(PLAN).designs]
ROW = ExtraRow("run", {"web_width": 0.3}, {}, (0.3,), {"mass": 170.0}, {}, "a.csv, line 2")
# A worker that does no finite elements.
QUICK = """
for request in requests():
    responses = {"mass": request["inputs"]["throw"]["web_width"]}
    answer({"key": request["key"], "responses": responses, "seconds": 0.5})
"""


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A store with 40 finished designs, and a row from elsewhere."""
    path = tmp_path_factory.mktemp("finished") / "runs.sqlite"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(workers, "spawn_worker", lambda: puppet(QUICK))
        assert run_plan(PLAN, path).computed == 40
    with ResultStore(path) as store:
        store.add_extra_rows(PLAN.key, [ROW])
    return path


@pytest.fixture
def store(finished, tmp_path, monkeypatch):
    """A copy of it, whose designs cost nothing."""
    monkeypatch.setattr(workers, "spawn_worker", lambda: puppet(QUICK))
    return shutil.copy(finished, tmp_path / "runs.sqlite")


def execute(path, *statements):
    with closing(sqlite3.connect(path)) as connection:
        for statement in statements:
            connection.execute(statement)
        connection.commit()


def rows(path):
    """All finished designs to the last byte, with the moment at which each was stored."""
    with closing(sqlite3.connect(path)) as connection:
        return {row[0]: row for row in connection.execute("SELECT * FROM designs")}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("statement", "told"),
    [
        ("UPDATE designs SET seconds = 0.25 WHERE key = '{key}'", "checksum"),
        ("UPDATE designs SET key = 'x' WHERE key = '{key}'", "checksum"),
        ("UPDATE designs SET key = NULL WHERE key = '{key}'", "checksum"),
        ("UPDATE designs SET responses = NULL WHERE key = '{key}'", "no responses"),
        ("UPDATE extra_rows SET study = 'x'", "checksum"),
        ("UPDATE studies SET plan = replace(plan, '0.1', '0.2')", "its plan"),
        ("UPDATE study_designs SET factors = 'cut' WHERE place = 3", "its list of designs"),
        ("UPDATE study_designs SET role = 'run' WHERE place = 30", "its list of designs"),
        ("DELETE FROM study_designs WHERE place = 3", "its list of designs"),
    ],
)
def test_every_kind_of_damage_is_found_and_computed_again(store, statement, told):
    before = rows(store)
    execute(store, statement.format(key=KEYS[0]))
    found = check_store(store)
    assert not found.sound
    reasons = [*found.damaged_rows.values(), *(study.damaged or "" for study in found.studies)]
    assert told in " ".join(reasons)
    assert run_plan(PLAN, store).computed == ("WHERE key" in statement)
    studies = check_store(store).studies
    assert [(study.damaged, study.missing) for study in studies] == [(None, 0)]
    kept = rows(store)
    assert [key for key in KEYS if kept[key] != before[key]] in ([], KEYS[:1])


@pytest.mark.parametrize("share", [0.0, 0.02, 0.5, 0.98])
def test_a_store_that_was_cut_is_damaged_or_none(store, share):
    size = store.stat().st_size
    with store.open("r+b") as file:
        file.truncate(round(share * size))
    if share < 0.01:
        with refused("store"):
            check_store(store)
        return
    found = check_store(store)
    assert not found.sound
    assert found.file_damage
    with refused("store"):
        run_plan(PLAN, store)


def test_a_page_of_noise_is_damage_of_the_file(store):
    with store.open("r+b") as file:
        file.seek(store.stat().st_size // 2 // 4096 * 4096)
        file.write(b"\xa5" * 4096)
    assert check_store(store).file_damage


def test_a_store_whose_tables_have_no_readable_names_is_damaged(store):
    """SQLite's own message then quotes what is no text."""
    content = store.read_bytes().replace(b"tablestudy_designs", b"table\xf5tudy_designs")
    store.write_bytes(content.replace(b"CREATE TABLE study_d", b"CREAXE TABLE study_d"))
    assert "names of its tables" in check_store(store).file_damage
    for readonly in (True, False):
        with refused("store"):
            ResultStore(store, readonly=readonly)


def test_columns_whose_names_cannot_be_read_are_missing(store):
    content = store.read_bytes().replace(b"attempts INTEGER,   ", b"a\xf5tempts INTEGER,   ")
    store.write_bytes(content.replace(b"inputs TEXT NOT NULL, ", b"i nput TEXT NOT NULL, "))
    assert not check_store(store).sound


def test_text_that_is_no_text_damages_no_more_than_itself(store):
    """The list of a study has no checksum, nor has the moment at which a design was finished."""
    noise = "CAST(x'F572756E' AS TEXT)"
    execute(store, f"UPDATE study_designs SET role = {noise} WHERE place = 3")
    execute(store, f"UPDATE designs SET finished_at = {noise} WHERE rowid = 5")
    assert run_plan(PLAN, store).computed == 0
    assert check_store(store).sound


# ------------------------------------------------------------------------------------------- claims


@pytest.mark.slow
def test_two_studies_on_one_store_compute_no_design_twice(tmp_path, monkeypatch):
    monkeypatch.setattr(workers, "spawn_worker", lambda: puppet(QUICK))
    path = tmp_path / "runs.sqlite"
    code = f"""
import sys
from regression.runs.store import *
claims = Claims(Path({str(path)!r}))
print(all(claims.take(key) for key in {KEYS[:2]!r}), flush=True)
input()
"""
    told = []
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as other:
        assert other.stdout.readline() == b"True\n"

        def progress(finished, total, newest):
            # When all others are finished, the other program finishes one of its two and dies.
            if finished == total - 2 and other.poll() is None:
                with ResultStore(path) as store:
                    found = store.outcomes([newest.key])[newest.key]
                    own = next(d for d in plan_designs(PLAN).designs if d.key == KEYS[0])
                    store.record(type(found)(own.key, own.inputs, {"mass": 1.0}, None, 9.0), 6)
                other.kill()
                other.wait()

        table = run_plan(PLAN, path, 2, progress, note=told.append)
    assert (table.computed, len(table.values)) == (39, 40)
    assert told == [f"another program computes designs of this study in {path}: they are shared."]
    assert [path.name for path in tmp_path.iterdir()] == ["runs.sqlite"]


DONE = Outcome("a" * 24, {"throw": {"web_width": 0.3}}, {"mass": 171.0}, None, 0.5)
OTHER = Outcome("b" * 24, {"throw": {"web_width": 0.2}}, {"mass": 114.0}, None, 0.5)
FAILED = Outcome("c" * 24, {"throw": {"web_width": 0.1}}, None, "MeshError: too narrow", 0.25)

# What somebody, or a bad disk, may make of a row.
TAMPERED = {
    "another value": """responses = '{"mass": 17.1}'""",
    "a value less": "responses = '{}'",
    "no responses": "responses = NULL",
    "NaN": """responses = '{"mass": NaN}'""",
    "infinite": """responses = '{"mass": 1e999}'""",
    "text for a number": """responses = '{"mass": "171"}'""",
    "too many digits": """responses = '{"mass": 1' || printf('%.*c', 5000, '0') || '}'""",
    "cut": "responses = substr(responses, 1, 6)",
    "no text": "responses = x'ff00fe'",
    "text of no encoding": "responses = CAST(x'7bff7d' AS TEXT)",
    "other inputs": """inputs = '{"throw": {"web_width": 0.4}}'""",
    "another error": """errors = '{"mass": 0.5}'""",
    "another model": "model_version = 1",
    "failed": "status = 'failed'",
    "unknown status": "status = 'good'",
    "no checksum": "checksum = NULL",
}


def damage_execute(path, *statements):
    connection = sqlite3.connect(path)
    for statement in statements:
        connection.execute(statement)
    connection.commit()
    connection.close()


def tamper(path, kind):
    damage_execute(path, f"UPDATE designs SET {TAMPERED[kind]} WHERE key = '{DONE.key}'")


@pytest.fixture
def path(tmp_path):
    with ResultStore(tmp_path / "runs.sqlite") as store:
        store.register_study("s", {}, [("run", o.key, {}) for o in (DONE, OTHER, FAILED)])
        for outcome in (DONE, OTHER, FAILED):
            store.record(outcome, 9)
        store.add_extra_rows("s", [ROW])
    return tmp_path / "runs.sqlite"


@pytest.mark.parametrize("readonly", [False, True])
@pytest.mark.parametrize("kind", TAMPERED)
def test_a_tampered_row_is_left_out_and_told_of(path, kind, readonly):
    tamper(path, kind)
    with ResultStore(path, readonly=readonly) as store:
        keys = [outcome.key for outcome in (DONE, OTHER, FAILED)]
        assert store.outcomes(keys) == {OTHER.key: OTHER, FAILED.key: FAILED}
        assert list(store.damaged) == [DONE.key]
        assert store.damaged[DONE.key]
        if kind in ("NaN", "infinite"):
            assert f"mass among its responses is {kind[:3].lower()}, " in store.damaged[DONE.key]
        assert [outcome for _, outcome, _ in store.results()] == [OTHER]


@pytest.mark.parametrize("kind", ["another value", "no responses", "NaN"])
def test_anything_takes_the_place_of_a_damaged_row(path, kind):
    """Even a failure: what it says of the design is true, which the damaged result is not."""
    tamper(path, kind)
    worse = Outcome(DONE.key, DONE.inputs, None, "no memory", 1.0)
    with ResultStore(path) as store:
        store.outcomes([DONE.key])
        store.record(worse, 9)
        assert store.outcomes([DONE.key]) == {DONE.key: worse}
        assert store.damaged == {}
        store.record(DONE, 9)
        assert store.outcomes([DONE.key]) == {DONE.key: DONE}


def test_damage_keeps_nobody_from_reading_the_other_rows(path):
    tamper(path, "cut")
    connection = sqlite3.connect(path)
    rows = connection.execute("SELECT mass FROM results WHERE status = 'done' ORDER BY mass")
    assert rows.fetchall() == [(None,), (114.0,)]
    connection.close()


@pytest.mark.parametrize("readonly", [False, True])
@pytest.mark.parametrize(
    "statement",
    [
        *(f"DROP TABLE {name}" for name in ("designs", "study_designs", "studies", "extra_rows")),
        *(f"ALTER TABLE designs DROP COLUMN {name}" for name in ("checksum", "unknowns")),
    ],
)
def test_a_store_that_lacks_a_part_is_refused_and_left_alone(path, statement, readonly):
    damage_execute(path, "DROP VIEW results", statement)
    before = path.read_bytes()
    with refused("store"):
        ResultStore(path, readonly=readonly)
    assert path.read_bytes() == before


# ------------------------------------------------------------------------------------- whole studies

DAMAGE_PLAN = plan_of_levels(SHARP, {"web_width": (0.280, 0.300)}, held_out=2, accuracy=0.1)
FIRST = plan_designs(DAMAGE_PLAN).designs[0].key
# A worker that does no finite elements.


@pytest.fixture
def study(tmp_path, monkeypatch):
    def spawn():
        return puppet(QUICK)

    monkeypatch.setattr(workers, "spawn_worker", spawn)
    path = tmp_path / "study.sqlite"
    assert run_plan(DAMAGE_PLAN, path).computed == 4
    return path


def test_a_study_leaves_a_damaged_row_out_and_computes_it_again(study):
    good = read_study(study)
    damage_execute(
        study, f"""UPDATE designs SET responses = '{{"mass": NaN}}' WHERE key = '{FIRST}'"""
    )
    read = read_study(study)
    assert read.values.tolist() == good.values.tolist()[1:]
    (failure,) = read.failures
    assert "damaged" in failure.reason
    assert list(read.damaged) == [FIRST]
    told = []
    table = run_plan(DAMAGE_PLAN, study, note=told.append)
    assert table.computed == 1
    assert table.damaged == {}
    assert table.responses["mass"].tolist() == good.responses["mass"].tolist()
    assert len(told) == 1
    assert FIRST in told[0]


def test_an_import_leaves_damaged_rows_of_the_other_store_out(study, tmp_path):
    damage_execute(study, f"UPDATE designs SET status = 'failed' WHERE key = '{FIRST}'")
    found = import_results(DAMAGE_PLAN, tmp_path / "new.sqlite", study)
    assert (found.designs, found.rows) == (3, 0)
    assert FIRST in found.damaged


def test_a_damaged_plan_is_told_and_mended_by_the_next_run(study):
    for plan in ("'no plan'", "'[]'", "replace(plan, '0.3', '0.4')"):
        damage_execute(study, f"UPDATE studies SET plan = {plan}")
        with pytest.raises(InputError, match=rf"^study: the plan of {DAMAGE_PLAN.key} in .* is"):
            read_study(study)
        assert run_plan(DAMAGE_PLAN, study).computed == 0
        assert len(read_study(study).values) == 4


@pytest.mark.parametrize("factors", ["'cut", "{}", '{"web_width": "wide"}', '{"web_width": 9.9}'])
def test_a_damaged_list_of_designs_is_that_of_the_plan(study, factors):
    good = read_study(study).values.tolist()
    text = factors.replace("'", "''")
    damage_execute(
        study, f"UPDATE study_designs SET factors = '{text}', design = 'x' WHERE place = 0"
    )
    assert read_study(study).values.tolist() == good
