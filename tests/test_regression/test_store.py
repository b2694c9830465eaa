import json
import math
import sqlite3
from contextlib import closing
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crankbase.errors import InputError
from geometry.throw import CrankThrow
from refusals import refusals, refused
from regression.records import ExtraRow, Outcome, StudyStoppedError, content_key
from regression.runs import store as store_module
from regression.runs.store import ResultStore

DONE = Outcome(
    "a" * 24,
    {"throw": {"web_width": 0.3}},
    {"axial_compliance_pinned": 1.5e-9},
    None,
    0.5,
    errors={"axial_compliance_pinned": 0.004},
    unknowns=14000,
    worker="host:12",
    attempts=2,
)
FAILED = Outcome("b" * 24, {"throw": {"web_width": 0.1}}, None, "MeshError: too narrow", 0.25)

numbers = st.floats(allow_nan=False, allow_infinity=False)
records = st.dictionaries(st.text(), st.one_of(numbers, st.text(), st.lists(numbers)), max_size=6)


@settings(max_examples=40)
@given(records)
def test_keys_do_not_depend_on_the_order_of_fields(record):
    turned = dict(reversed(record.items()))
    assert content_key(turned) == content_key(record)
    assert content_key({"in": turned}) == content_key({"in": record})


@pytest.mark.slow
@settings(max_examples=40)
@given(records, records)
def test_keys_differ_with_the_content(first, second):
    same = json.dumps(first, sort_keys=True) == json.dumps(second, sort_keys=True)
    assert (content_key(first) == content_key(second)) == same


def test_keys_see_the_last_digit_and_the_order_of_lists():
    assert content_key({"x": 0.1}) != content_key({"x": math.nextafter(0.1, 1.0)})
    assert content_key([1, 2]) != content_key([2, 1])
    assert content_key({"x": 0.1}) == content_key({"x": 0.1})


@pytest.mark.slow
@given(st.dictionaries(st.text(min_size=1), numbers, min_size=1, max_size=5))
def test_numbers_come_back_to_the_last_digit(tmp_path_factory, responses):
    with ResultStore(tmp_path_factory.mktemp("store") / "runs.sqlite") as store:
        store.record(Outcome("k", {}, responses, None, 0.0))
        assert store.outcomes(["k"])["k"].responses == responses


@pytest.mark.parametrize("lost", [False, True])
def test_a_result_never_gives_way_to_a_failure(tmp_path, lost):
    """Two programs may compute the same design; the slower one must not undo the other's result."""
    worse = Outcome(DONE.key, DONE.inputs, None, "no memory", 1.0, lost=lost)
    with ResultStore(tmp_path / "runs.sqlite") as store:
        store.record(worse)
        store.record(DONE)
        store.record(worse)
        assert store.outcomes([DONE.key]) == {DONE.key: DONE}
        newer = Outcome(DONE.key, DONE.inputs, {"axial_compliance_pinned": 2e-9}, None, 1.0)
        store.record(newer)
        assert store.outcomes([DONE.key]) == {DONE.key: newer}


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_never_stored(tmp_path, value):
    path = tmp_path / "runs.sqlite"
    with ResultStore(path) as store:
        with pytest.raises(ValueError, match="not JSON compliant"):
            store.record(Outcome("k", {}, {"axial_compliance_pinned": value}, None, 0.0))
        assert store.outcomes(["k"]) == {}
        store.record(DONE)  # the store still works
        assert set(store.outcomes(["k", DONE.key])) == {DONE.key}
    with pytest.raises(ValueError, match="not JSON compliant"):
        content_key({"x": value})


def test_an_error_in_a_transaction_leaves_the_store_as_it_was(tmp_path):
    with ResultStore(tmp_path / "runs.sqlite") as store:
        with pytest.raises(sqlite3.Error):
            store.register_study("s", {}, [("run", "k", {}), ("run", object(), {})])
        store.register_study("s", {}, [("run", "k", {})])
        assert list(store.studies()) == ["s"]


def test_a_store_can_be_read_in_a_folder_that_cannot_be_written(tmp_path, monkeypatch):
    with ResultStore(tmp_path / "runs.sqlite") as store:
        store.record(DONE)
    monkeypatch.setattr("os.access", lambda *_: False)
    with ResultStore(tmp_path / "runs.sqlite", readonly=True) as store:
        assert store.outcomes([DONE.key]) == {DONE.key: DONE}
        assert [path.name for path in tmp_path.iterdir()] == ["runs.sqlite"]


def test_a_study_registered_twice_stands_once(tmp_path):
    designs = [("run", "a", {}), ("run", "b", {}), ("held out", "c", {})]
    with ResultStore(tmp_path / "runs.sqlite") as store:
        store.register_study("s", {"held_out": 1}, designs)
        store.register_study("s", {"held_out": 1}, designs)
        store.register_study("t", {"held_out": 2}, designs[:1])
        assert store.studies() == {"s": {"held_out": 1}, "t": {"held_out": 2}}
        connection = sqlite3.connect(store.path)
        rows = connection.execute("SELECT study, place, role, design FROM study_designs").fetchall()
        connection.close()
    assert sorted(rows) == [
        ("s", 0, "run", "a"),
        ("s", 1, "run", "b"),
        ("s", 2, "held out", "c"),
        ("t", 0, "run", "a"),
    ]


def test_the_columns_of_the_view_are_fields_that_there_are():
    assert set(store_module.DIMENSIONS) <= set(CrankThrow.model_fields)


# --------------------------------------------------------------------------------- rows from elsewhere

ROW = ExtraRow(
    "held out",
    {"web_width": 0.3},
    {"web_outline": "obround"},
    (0.3, 0.1),
    {"mass": 170.0},
    {},
    "a.csv",
)
MEASURED = ExtraRow("measured", {"web_width": 0.3}, {}, None, {"mass": 171.0}, {"mass": 0.1}, "b")


def test_a_computed_row_stands_once_at_its_place_in_the_study(tmp_path):
    """Whatever file and line it comes from, and whether it was fitted or held out there."""
    corrected = replace(ROW, role="run", responses={"mass": 171.0}, source="b.csv, line 9")
    digit = replace(ROW, values=(math.nextafter(0.3, 1.0), 0.1), source="c.csv")
    elsewhere = replace(ROW, values=(0.3, 0.2))
    with ResultStore(tmp_path / "runs.sqlite") as store:
        assert store.add_extra_rows("s", [ROW, MEASURED, ROW, corrected]) == 2
        assert store.extra_rows("s") == (corrected, MEASURED)
        assert store.add_extra_rows("s", [digit, elsewhere]) == 1
        assert store.extra_rows("s") == (digit, MEASURED, elsewhere)


def test_measured_rows_stand_once_if_throw_and_numbers_are_the_same(tmp_path):
    renamed = replace(MEASURED, source="copy of b")
    repeated = replace(MEASURED, responses={"mass": 171.5})
    more = replace(MEASURED, responses={"torsional_compliance_pinned": 4e-8})
    other = replace(MEASURED, dimensions={"web_width": 0.31})
    with ResultStore(tmp_path / "runs.sqlite") as store:
        assert store.add_extra_rows("s", [MEASURED, MEASURED, repeated, more, other]) == 4
        assert store.add_extra_rows("s", [renamed]) == 0
        assert store.extra_rows("s") == (renamed, repeated, more, other)


@pytest.mark.parametrize(
    "layout", [store_module.SCHEMA_VERSION - 1, store_module.SCHEMA_VERSION + 1]
)
@pytest.mark.parametrize("readonly", [False, True])
def test_a_store_of_another_layout_is_refused_and_left_alone(tmp_path, layout, readonly):
    path = tmp_path / "runs.sqlite"
    with ResultStore(path):
        pass
    connection = sqlite3.connect(path)
    connection.execute(f"PRAGMA user_version={layout}")
    connection.close()
    before = path.read_bytes()
    with refused("store"):
        ResultStore(path, readonly=readonly)
    assert path.read_bytes() == before


# -------------------------------------------------------------------------------- what stops a study


def test_a_locked_store_stops_the_study_with_one_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr(store_module, "PATIENCE", 0.1)
    path = tmp_path / "runs.sqlite"
    with ResultStore(path) as store:
        store.record(DONE)
        other = sqlite3.connect(path, isolation_level=None)
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises(StudyStoppedError) as caught:
            store.record(FAILED)
        with pytest.raises(StudyStoppedError, match="another program holds it locked"):
            store.add_extra_rows("s", [ROW])
        other.execute("ROLLBACK")
        other.close()
        assert set(store.outcomes([DONE.key, FAILED.key])) == {DONE.key}
        store.record(FAILED)  # goes on when it is free
        assert set(store.outcomes([DONE.key, FAILED.key])) == {DONE.key, FAILED.key}
    assert str(caught.value).startswith(f"store: {path}")


def test_a_full_store_stops_the_study_and_keeps_what_it_has(tmp_path):
    with ResultStore(tmp_path / "runs.sqlite") as store:
        store.record(DONE)
        (pages,) = store._connection.execute("PRAGMA page_count").fetchone()
        # SQLite then answers as on a full disk.
        store._connection.execute(f"PRAGMA max_page_count={pages}")
        big = Outcome("big", {"text": "x" * 100_000}, None, "no", 0.0)
        for _ in range(2):
            with pytest.raises(StudyStoppedError, match=r"cannot be used now \(the disk is full\)"):
                store.record(big)
        assert set(store.outcomes([DONE.key, "big"])) == {DONE.key}
        store._connection.execute("PRAGMA max_page_count=1000000")
        store.record(big)
    with ResultStore(tmp_path / "runs.sqlite", readonly=True) as store:
        assert set(store.outcomes([DONE.key, "big"])) == {DONE.key, "big"}


def test_a_store_that_cannot_be_written_stops_the_study(tmp_path):
    with ResultStore(tmp_path / "runs.sqlite") as store:
        store.record(DONE)
        store._connection.execute("PRAGMA query_only=ON")  # answers as a read-only file does
        with pytest.raises(StudyStoppedError, match=r"cannot be used now \(it is read-only\)"):
            store.record(FAILED)


@pytest.mark.parametrize(
    "content",
    [b"no database " * 100, b"SQLite format 3\x00" + b"\xff" * 4000],
    ids=["text", "torn"],
)
def test_a_file_of_another_kind_is_refused_and_left_alone(tmp_path, content):
    path = tmp_path / "runs.sqlite"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"^store: given '.*runs\.sqlite'.*give a new file"):
        ResultStore(path)
    # Who only reads wants no new file.
    with refused("store"):
        ResultStore(path, readonly=True)
    assert path.read_bytes() == content


@pytest.mark.parametrize("table", ["notes (text TEXT)", "designs (name TEXT, color TEXT)"])
def test_the_database_of_another_program_is_refused_and_left_alone(tmp_path, table):
    path = tmp_path / "other.sqlite"
    connection = sqlite3.connect(path)
    connection.execute(f"CREATE TABLE {table}")
    connection.commit()
    connection.close()
    before = path.read_bytes()
    with pytest.raises(InputError, match=r"^store: given"):
        ResultStore(path)
    assert path.read_bytes() == before


def test_a_folder_is_no_store(tmp_path):
    for readonly in (False, True):
        with pytest.raises(InputError, match=r"^store: given '.*', which is a folder"):
            ResultStore(tmp_path, readonly=readonly)
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match=r"^store: given"):
        ResultStore(tmp_path / "file" / "runs.sqlite")


def test_an_empty_file_becomes_a_store(tmp_path):
    (tmp_path / "runs.sqlite").touch()
    with ResultStore(tmp_path / "runs.sqlite") as store:
        store.record(DONE)
        assert store.studies() == {}


SLOPED = replace(
    DONE,
    inputs={"throw": {"web_width": 0.3}, "slopes": ["web_width"]},
    slopes={"axial_compliance_pinned": {"web_width": -0.2}},
    slope_errors={"axial_compliance_pinned": 0.015},
)


def test_slopes_come_back_with_their_design(tmp_path):
    path = tmp_path / "runs.sqlite"
    with ResultStore(path) as store:
        store.record(DONE)
    with closing(sqlite3.connect(path)) as made:  # as of releases that had no slopes
        assert not made.execute("SELECT 1 FROM sqlite_master WHERE name = 'slopes'").fetchall()
    with ResultStore(path) as store:
        store.record(SLOPED)
        assert store.outcomes([DONE.key]) == {DONE.key: SLOPED}
        assert list(store.every_outcome()) == [SLOPED]
    with ResultStore(path, readonly=True) as store:
        assert store.outcomes([DONE.key]) == {DONE.key: SLOPED}


MESHED = Outcome(
    "meshed",
    {"throw": {"web_width": 0.3}, "moved": {"throw": {}}},
    {"axial_compliance_pinned": 1e-9},
    None,
    0.1,
    mesh={"tier": "velocities", "quality": 0.3, "straightened": 1, "reference": "abc"},
)


@pytest.mark.parametrize(
    ("statement", "why"),
    [
        ("DROP TABLE meshes", "its mesh is missing"),
        ("UPDATE meshes SET mesh = '[]'", "its mesh cannot be read"),
        ("UPDATE meshes SET mesh = replace(mesh, '0.3', '0.4')", "the checksum of its mesh"),
    ],
)
def test_what_a_moved_mesh_was_made_of_comes_back_unless_it_is_damaged(tmp_path, statement, why):
    path = tmp_path / "runs.sqlite"
    with ResultStore(path) as store:
        store.record(DONE)
    with closing(sqlite3.connect(path)) as made:  # as of releases that moved none
        assert not made.execute("SELECT 1 FROM sqlite_master WHERE name = 'meshes'").fetchall()
    with ResultStore(path) as store:
        store.record(MESHED)
        assert store.outcomes([MESHED.key]) == {MESHED.key: MESHED}
    with closing(sqlite3.connect(path)) as broken:
        broken.execute(statement)
        broken.commit()
    with ResultStore(path) as store:
        assert store.outcomes([MESHED.key]) == {}
        assert store.damaged[MESHED.key].startswith(why)


@pytest.mark.parametrize(
    ("statement", "why"),
    [
        ("DELETE FROM slopes", "its slopes are missing"),
        ("DROP TABLE slopes", "its slopes are missing"),
        ("UPDATE slopes SET shares = replace(shares, '-0.2', '-0.3')", "the checksum of its"),
        ("UPDATE slopes SET shares = replace(shares, '-0.2', '\"x\"')", "web_width among its"),
        ("UPDATE slopes SET shares = '[]'", "its slopes cannot be read"),
        (
            "UPDATE slopes SET shares = replace(shares, '{\"web_width\": -0.2}', '1')",
            "its slopes of axial",
        ),
    ],
)
def test_a_design_whose_slopes_are_damaged_is_computed_again(tmp_path, statement, why):
    path = tmp_path / "runs.sqlite"
    with ResultStore(path) as store:
        store.record(SLOPED)
    with closing(sqlite3.connect(path)) as broken:
        broken.execute(statement)
        broken.commit()
    with ResultStore(path) as store:
        assert store.outcomes([DONE.key]) == {}
        assert store.damaged[DONE.key].startswith(why)
        store.record(SLOPED)
        assert store.outcomes([DONE.key]) == {DONE.key: SLOPED}
        assert not store.damaged


test_refused_calls = refusals(
    ("store", lambda: ResultStore("/proc/runs.sqlite")),
)
