"""Rows that do not say what was written are left out, told of, and computed again."""

import sqlite3

import pytest

from crankbase.errors import InputError
from plans import SHARP, plan_of_levels
from puppets import puppet
from regression.plans.plan import plan_designs
from regression.records import ExtraRow, Outcome
from regression.runs import store_file, workers
from regression.runs.store import ResultStore
from regression.runs.study import import_results, read_study, run_plan

DONE = Outcome("a" * 24, {"throw": {"web_width": 0.3}}, {"mass": 171.0}, None, 0.5)
OTHER = Outcome("b" * 24, {"throw": {"web_width": 0.2}}, {"mass": 114.0}, None, 0.5)
FAILED = Outcome("c" * 24, {"throw": {"web_width": 0.1}}, None, "MeshError: too narrow", 0.25)
ROW = ExtraRow("run", {"web_width": 0.3}, {}, (0.3,), {"mass": 170.0}, {}, "a.csv, line 2")

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
# Those that can be told without a checksum.
PLAIN = ("a value less", "no responses", "NaN", "infinite", "text for a number", "cut", "failed")


def execute(path, *statements):
    connection = sqlite3.connect(path)
    for statement in statements:
        connection.execute(statement)
    connection.commit()
    connection.close()


def tamper(path, kind):
    execute(path, f"UPDATE designs SET {TAMPERED[kind]} WHERE key = '{DONE.key}'")


@pytest.fixture
def path(tmp_path):
    with ResultStore(tmp_path / "runs.sqlite") as store:
        store.register_study("s", {}, [("run", o.key, {}) for o in (DONE, OTHER, FAILED)])
        for outcome in (DONE, OTHER, FAILED):
            store.record(outcome, 9)
        store.add_extra_rows("s", [ROW])
    return tmp_path / "runs.sqlite"


@pytest.fixture
def older(path):
    """The same store as the release before wrote it, without checksums."""
    execute(
        path,
        "ALTER TABLE designs DROP COLUMN checksum",
        "ALTER TABLE extra_rows DROP COLUMN checksum",
        f"PRAGMA user_version={store_file.CHECKSUMS_SINCE - 1}",
    )
    return path


def test_a_store_without_added_runs_keeps_its_checksums(path):
    """One of the release before gets the column of added runs, and no checksum that hides damage."""
    execute(
        path,
        "DROP VIEW results",
        "ALTER TABLE study_designs DROP COLUMN added",
        f"PRAGMA user_version={store_file.CHECKSUMS_SINCE}",
    )
    tamper(path, "another value")
    for readonly in (True, False):
        with ResultStore(path, readonly=readonly) as store:
            assert store.added_designs("s") == ()
            assert store.outcomes([DONE.key, OTHER.key]) == {OTHER.key: OTHER}
    with ResultStore(path) as store:
        store.add_designs("s", [("run", "k", {"x": 1.0})])
        store.register_study("s", {}, [("run", OTHER.key, {})])
        assert store.added_designs("s") == ({"x": 1.0},)
        assert store.study_designs("s") == (("run", OTHER.key, {}), ("run", "k", {"x": 1.0}))


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


def test_a_damaged_row_from_elsewhere_is_left_out_and_told_of(path):
    execute(path, """UPDATE extra_rows SET responses = '{"mass": 1.0}'""")
    with ResultStore(path) as store:
        assert store.extra_rows("s") == ()
        assert list(store.damaged) == ["row 1 from elsewhere"]
        assert store.add_extra_rows("s", [ROW]) == 0  # imported again it is good again
        assert store.extra_rows("s") == (ROW,)


def test_rows_of_an_earlier_release_are_kept_and_get_a_checksum(older):
    everything = {outcome.key: outcome for outcome in (DONE, OTHER, FAILED)}
    with ResultStore(older, readonly=True) as store:
        assert store.outcomes(everything) == everything
        assert store.extra_rows("s") == (ROW,)
    for _ in range(2):  # the second time there is nothing to do
        with ResultStore(older) as store:
            assert store.outcomes(everything) == everything
            assert store.extra_rows("s") == (ROW,)
            assert store.damaged == {}
    tamper(older, "another value")
    with ResultStore(older) as store:
        assert store.outcomes(everything) == {OTHER.key: OTHER, FAILED.key: FAILED}


@pytest.mark.parametrize("readonly", [False, True])
@pytest.mark.parametrize("kind", PLAIN)
def test_impossible_rows_of_an_earlier_release_are_left_out(older, kind, readonly):
    tamper(older, kind)
    for _ in range(2):  # and they stay damaged once the store is brought up to date
        with ResultStore(older, readonly=readonly) as store:
            assert store.outcomes([DONE.key, OTHER.key]) == {OTHER.key: OTHER}
            assert list(store.damaged) == [DONE.key]


@pytest.mark.parametrize("readonly", [False, True])
@pytest.mark.parametrize(
    ("statement", "lost"),
    [
        *((f"DROP TABLE {name}", f"table {name}") for name in (
            *("designs", "study_designs", "studies", "extra_rows"),
        )),
        ("ALTER TABLE designs DROP COLUMN checksum", "column checksum in the table designs"),
        ("ALTER TABLE designs DROP COLUMN unknowns", "column unknowns in the table designs"),
    ],
)  # fmt: skip
def test_a_store_that_lacks_a_part_is_refused_and_left_alone(path, statement, lost, readonly):
    execute(path, "DROP VIEW results", statement)
    before = path.read_bytes()
    with pytest.raises(
        InputError, match=rf"^store: given .* damaged \(it has no {lost}\); allowed"
    ):
        ResultStore(path, readonly=readonly)
    assert path.read_bytes() == before


# ------------------------------------------------------------------------------------- whole studies

PLAN = plan_of_levels(SHARP, {"web_width": (0.280, 0.300)}, held_out=2, accuracy=0.1)
FIRST = plan_designs(PLAN).designs[0].key
# A worker that does no finite elements.
QUICK = """
for request in requests():
    responses = {"mass": request["inputs"]["throw"]["web_width"]}
    answer({"key": request["key"], "responses": responses, "seconds": 0.5})
"""


@pytest.fixture
def study(tmp_path, monkeypatch):
    def spawn():
        return puppet(QUICK)

    monkeypatch.setattr(workers, "spawn_worker", spawn)
    path = tmp_path / "study.sqlite"
    assert run_plan(PLAN, path).computed == 4
    return path


def test_a_study_leaves_a_damaged_row_out_and_computes_it_again(study):
    good = read_study(study)
    execute(study, f"""UPDATE designs SET responses = '{{"mass": NaN}}' WHERE key = '{FIRST}'""")
    read = read_study(study)
    assert read.values.tolist() == good.values.tolist()[1:]
    ((_, _, reason),) = read.failures
    assert "damaged" in reason
    assert list(read.damaged) == [FIRST]
    told = []
    table = run_plan(PLAN, study, note=told.append)
    assert table.computed == 1
    assert table.damaged == {}
    assert table.responses["mass"].tolist() == good.responses["mass"].tolist()
    assert len(told) == 1
    assert FIRST in told[0]


def test_an_import_leaves_damaged_rows_of_the_other_store_out(study, tmp_path):
    execute(study, f"UPDATE designs SET status = 'failed' WHERE key = '{FIRST}'")
    found = import_results(PLAN, tmp_path / "new.sqlite", study)
    assert (found.designs, found.rows) == (3, 0)
    assert FIRST in found.damaged


def test_a_damaged_plan_is_told_and_mended_by_the_next_run(study):
    for plan in ("'no plan'", "'[]'", "replace(plan, '0.3', '0.4')"):
        execute(study, f"UPDATE studies SET plan = {plan}")
        with pytest.raises(InputError, match=rf"^study: the plan of {PLAN.key} in .* is damaged; "):
            read_study(study)
        assert run_plan(PLAN, study).computed == 0
        assert len(read_study(study).values) == 4


@pytest.mark.parametrize("factors", ["'cut", "{}", '{"web_width": "wide"}', '{"web_width": 9.9}'])
def test_a_damaged_list_of_designs_is_that_of_the_plan(study, factors):
    good = read_study(study).values.tolist()
    text = factors.replace("'", "''")
    execute(study, f"UPDATE study_designs SET factors = '{text}', design = 'x' WHERE place = 0")
    assert read_study(study).values.tolist() == good
