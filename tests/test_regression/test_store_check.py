"""A store is checked row by row; a damaged one is repaired, and what it lacks is computed again."""

import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing

import numpy as np
import pytest

from crankbase.errors import InputError
from plans import SHARP, plan_of_levels
from puppets import puppet
from regression.plans.plan import plan_designs
from regression.records import ExtraRow, StudyStoppedError
from regression.runs import store_file, workers
from regression.runs.store import ResultStore
from regression.runs.store_check import check_store
from regression.runs.store_repair import rebuild_store
from regression.runs.study import add_runs, run_plan

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


def test_a_store_as_a_study_leaves_it_is_sound(store):
    before = store.read_bytes()
    found = check_store(store)
    assert (found.sound, found.file, dict(found.damaged)) == (True, "", {})
    assert found.status == {"done": 40, "failed": 0, "lost": 0}
    (study,) = found.studies
    assert (study.study, study.damaged, study.designs, study.missing) == (PLAN.key, "", 40, 0)
    assert store.read_bytes() == before


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
def test_every_kind_of_damage_is_found_and_repaired(store, statement, told):
    before = rows(store)
    execute(store, statement.format(key=KEYS[0]))
    found = check_store(store)
    assert not found.sound
    reasons = [*found.damaged.values(), *(study.damaged for study in found.studies)]
    assert told in " ".join(reasons)
    rebuilt = rebuild_store(store)
    assert rebuilt.original.name == "runs.sqlite.damaged"
    assert not check_store(rebuilt.original).sound
    table = run_plan(PLAN, store)
    assert table.computed == 40 - rebuilt.designs <= 1
    again = check_store(store)
    assert (again.sound, again.missing) == (True, 0)
    kept = rows(store)
    assert [key for key in KEYS if kept[key] != before[key]] in ([], KEYS[:1])


def test_a_missing_result_is_no_damage(store):
    execute(store, f"DELETE FROM designs WHERE key = '{KEYS[0]}'")
    found = check_store(store)
    assert (found.sound, found.missing) == (True, 1)


@pytest.mark.parametrize("share", [0.0, 0.02, 0.5, 0.98])
def test_a_store_that_was_cut_keeps_every_row_that_can_be_read(store, share):
    """Cut at any length it is damaged or no store, and what is left of it is kept byte for byte."""
    before = rows(store)
    size = store.stat().st_size
    with store.open("r+b") as file:
        file.truncate(round(share * size))
    if share < 0.01:
        with pytest.raises(InputError, match="no result store"):
            check_store(store)
        return
    found = check_store(store)
    assert not found.sound
    assert found.file
    with pytest.raises(InputError, match=r"damaged .*crankfem doe --repair "):
        run_plan(PLAN, store)
    rebuilt = rebuild_store(store)
    assert rows(store).items() <= before.items()
    assert len(rows(store)) == rebuilt.designs
    assert rebuilt.designs > 0 or share < 0.7
    assert run_plan(PLAN, store).computed == 40 - rebuilt.designs
    assert check_store(store).sound


def test_a_page_of_noise_costs_its_rows_alone(store):
    before = rows(store)
    with store.open("r+b") as file:
        file.seek(store.stat().st_size // 2 // 4096 * 4096)
        file.write(b"\xa5" * 4096)
    assert check_store(store).file
    rebuilt = rebuild_store(store)
    assert 20 < rebuilt.designs <= 40
    assert rows(store).items() <= before.items()


def test_a_store_whose_tables_have_no_readable_names_is_damaged(store):
    """SQLite's own message then quotes what is no text."""
    content = store.read_bytes().replace(b"tablestudy_designs", b"table\xf5tudy_designs")
    store.write_bytes(content.replace(b"CREATE TABLE study_d", b"CREAXE TABLE study_d"))
    assert "names of its tables" in check_store(store).file
    for readonly in (True, False):
        with pytest.raises(InputError, match=r"damaged .*crankfem doe --repair "):
            ResultStore(store, readonly=readonly)
    rebuild_store(store)
    run_plan(PLAN, store)
    assert check_store(store).sound


def test_rows_are_kept_under_names_of_columns_that_cannot_be_read(store):
    before = rows(store)
    content = store.read_bytes().replace(b"attempts INTEGER,   ", b"a\xf5tempts INTEGER,   ")
    content = content.replace(b"inputs TEXT NOT NULL, ", b"i nput TEXT NOT NULL, ")
    assert content.count(b"a\xf5tempts") == content.count(b"i nput") == 1
    store.write_bytes(content)
    assert not check_store(store).sound
    rebuilt = rebuild_store(store)
    assert (rebuilt.designs, rebuilt.extra_rows) == (40, 1)
    assert rows(store) == before
    assert check_store(store).sound


def test_text_that_is_no_text_damages_no_more_than_itself(store):
    """The list of a study has no checksum, nor has the moment at which a design was finished."""
    noise = "CAST(x'F572756E' AS TEXT)"
    execute(store, f"UPDATE study_designs SET role = {noise} WHERE place = 3")
    execute(store, f"UPDATE designs SET finished_at = {noise} WHERE rowid = 5")
    assert rebuild_store(store).designs == 40
    assert run_plan(PLAN, store).computed == 0
    assert check_store(store).sound


def test_a_repaired_store_keeps_added_runs_but_damaged_ones(store):
    add_runs(PLAN, store, np.array([[0.281], [0.282]]))
    assert run_plan(PLAN, store).computed == 2
    execute(store, "UPDATE study_designs SET factors = replace(factors, '0.281', '0.284')")
    assert [study.damaged for study in check_store(store).studies] == ["its list of designs"]
    rebuild_store(store)
    table = run_plan(PLAN, store)
    assert (table.added, table.computed) == (1, 0)
    assert check_store(store).sound


def test_a_store_without_checksums_is_not_taken_for_checked(store):
    execute(
        store,
        "ALTER TABLE designs DROP COLUMN checksum",
        "ALTER TABLE extra_rows DROP COLUMN checksum",
        f"PRAGMA user_version={store_file.CHECKSUMS_SINCE - 1}",
    )
    found = check_store(store)
    assert (found.sound, found.without_checksums) == (True, True)
    execute(store, "UPDATE designs SET responses = '{}'")
    assert len(check_store(store).damaged) == 40
    with pytest.raises(InputError, match="rows of others have no checksums"):
        rebuild_store(store)


def test_what_is_no_store_is_neither_checked_nor_repaired(tmp_path):
    for name, content in (
        ("text", b"no database " * 50),
        ("torn", b"SQLite format 3\0" + b"\xff" * 4000),
    ):
        path = tmp_path / name
        path.write_bytes(content)
        with pytest.raises(InputError, match=r"^store: given .*no result store"):
            check_store(path)
    with pytest.raises(InputError, match="there is no such file"):
        check_store(tmp_path / "none")


def test_a_store_is_not_repaired_while_a_study_runs_in_it(store):
    execute(store, "UPDATE designs SET seconds = 0.25")
    before = store.read_bytes()
    code = (
        f"from regression.runs.store import *; c = Claims(Path({str(store)!r})); print(1, flush=True); "
        "input()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as other:
        other.stdout.readline()
        with pytest.raises(StudyStoppedError, match="another program works on it"):
            rebuild_store(store)
        other.communicate(b"\n")
    assert store.read_bytes() == before
    rebuild_store(store)


# ------------------------------------------------------------------------------------------- claims


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
