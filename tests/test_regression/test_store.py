import json
import math
import sqlite3

import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.errors import InputError
from regression.store import Outcome, ResultStore, content_key

DONE = Outcome(
    "a" * 24, {"throw": {"web_width": 0.3}}, {"axial_compliance_pinned": 1.5e-9}, None, 0.5
)
FAILED = Outcome("b" * 24, {"throw": {"web_width": 0.1}}, None, "MeshError: too narrow", 0.25)

numbers = st.floats(allow_nan=False, allow_infinity=False)
records = st.dictionaries(st.text(), st.one_of(numbers, st.text(), st.lists(numbers)), max_size=6)


@given(records)
def test_keys_do_not_depend_on_the_order_of_fields(record):
    turned = dict(reversed(record.items()))
    assert content_key(turned) == content_key(record)
    assert content_key({"in": turned}) == content_key({"in": record})


@given(records, records)
def test_keys_differ_with_the_content(first, second):
    same = json.dumps(first, sort_keys=True) == json.dumps(second, sort_keys=True)
    assert (content_key(first) == content_key(second)) == same


def test_keys_see_the_last_digit_and_the_order_of_lists():
    assert content_key({"x": 0.1}) != content_key({"x": math.nextafter(0.1, 1.0)})
    assert content_key([1, 2]) != content_key([2, 1])
    assert content_key({"x": 0.1}) == content_key({"x": 0.1})


@pytest.mark.parametrize("outcome", [DONE, FAILED], ids=["done", "failed"])
def test_outcomes_come_back_as_they_went_in(tmp_path, outcome):
    path = tmp_path / "runs.sqlite"
    with ResultStore(path) as store:
        store.record(outcome)
        assert store.outcomes([outcome.key, "unknown"]) == {outcome.key: outcome}
    with ResultStore(path) as store:
        assert store.outcomes([outcome.key]) == {outcome.key: outcome}


@given(st.dictionaries(st.text(min_size=1), numbers, min_size=1, max_size=5))
def test_numbers_come_back_to_the_last_digit(tmp_path_factory, responses):
    with ResultStore(tmp_path_factory.mktemp("store") / "runs.sqlite") as store:
        store.record(Outcome("k", {}, responses, None, 0.0))
        assert store.outcomes(["k"])["k"].responses == responses


def test_a_later_outcome_replaces_an_earlier_one(tmp_path):
    with ResultStore(tmp_path / "runs.sqlite") as store:
        store.record(FAILED)
        better = Outcome(FAILED.key, FAILED.inputs, {"axial_compliance_pinned": 2e-9}, None, 1.0)
        store.record(better)
        assert store.outcomes([FAILED.key]) == {FAILED.key: better}


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
            store.register_study("s", {}, [("run", "k"), ("run", object())])
        store.register_study("s", {}, [("run", "k")])
        assert list(store.studies()) == ["s"]


def test_the_file_is_written_ahead(tmp_path):
    path = tmp_path / "runs.sqlite"
    with ResultStore(path):
        connection = sqlite3.connect(path)
        assert connection.execute("PRAGMA journal_mode").fetchone() == ("wal",)
        connection.close()


def test_what_is_recorded_is_seen_by_others_at_once(tmp_path):
    path = tmp_path / "runs.sqlite"
    with ResultStore(path) as writer, ResultStore(path) as reader:
        writer.record(DONE)
        assert reader.outcomes([DONE.key]) == {DONE.key: DONE}
        reader.record(FAILED)
        assert writer.outcomes([FAILED.key]) == {FAILED.key: FAILED}


def test_missing_folders_are_made(tmp_path):
    path = tmp_path / "a" / "b" / "runs.sqlite"
    with ResultStore(path):
        assert path.is_file()


def test_a_study_registered_twice_stands_once(tmp_path):
    designs = [("run", "a"), ("run", "b"), ("held out", "c")]
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


def test_results_can_be_read_with_plain_sql(tmp_path):
    path = tmp_path / "runs.sqlite"
    with ResultStore(path) as store:
        store.register_study("s", {}, [("run", DONE.key), ("run", FAILED.key), ("held out", "c")])
        store.record(DONE)
        store.record(FAILED)
    connection = sqlite3.connect(path)
    connection.row_factory = sqlite3.Row
    rows = [dict(row) for row in connection.execute("SELECT * FROM results ORDER BY place")]
    width = connection.execute(
        "SELECT json_extract(inputs, '$.throw.web_width') FROM designs WHERE status = 'done'"
    ).fetchone()[0]
    connection.close()
    assert [row["role"] for row in rows] == ["run", "run", "held out"]
    assert [row["status"] for row in rows] == ["done", "failed", None]
    assert [row["axial_compliance_pinned"] for row in rows] == [1.5e-9, None, None]
    assert rows[1]["reason"] == "MeshError: too narrow"
    assert rows[0]["seconds"] == 0.5
    assert width == 0.3


@pytest.mark.parametrize(
    "content",
    [b"no database " * 100, b"SQLite format 3\x00" + b"\xff" * 4000],
    ids=["text", "torn"],
)
def test_a_file_of_another_kind_is_refused_and_left_alone(tmp_path, content):
    path = tmp_path / "runs.sqlite"
    path.write_bytes(content)
    with pytest.raises(
        InputError, match=r"^store: given '.*runs\.sqlite'.*give a new file name\.$"
    ):
        ResultStore(path)
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
    with pytest.raises(InputError, match=r"^store: given"):
        ResultStore(tmp_path)
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match=r"^store: given"):
        ResultStore(tmp_path / "file" / "runs.sqlite")


def test_an_empty_file_becomes_a_store(tmp_path):
    (tmp_path / "runs.sqlite").touch()
    with ResultStore(tmp_path / "runs.sqlite") as store:
        store.record(DONE)
        assert store.studies() == {}
