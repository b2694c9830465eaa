import csv
import sqlite3
import sys
from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError, MissingLibraryError
from fem.response_table import RESPONSES
from geometry.throw_dimensions import Counterweight
from plans import SHARP, plan_of_levels
from puppets import puppet
from refusals import refused
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan, plan_designs
from regression.records import HELD_OUT, MEASURED, RUN
from regression.runs import study as study_module
from regression.runs import workers
from regression.runs.exchange import export_table, read_rows
from regression.runs.store import ResultStore
from regression.runs.study import import_results, read_study, run_plan
from regression.runs.study_table import study_table
from regression.throw_values import SAME

THROW = SHARP
NAMES = [name for name in RESPONSES if name != "fillet_stress_factor"]
COLUMNS = [f"{n} [{RESPONSES[n].unit}]" if RESPONSES[n].unit else n for n in NAMES]
# All responses of a throw that fails where the web is 280 mm wide, without finite elements; numbers
# with all digits, so that a file that rounds them is seen.
PUPPET = f"""
NAMES = {NAMES!r}
for request in requests():
    width = request["inputs"]["throw"]["web_width"]
    found = {{"key": request["key"], "seconds": 0.1}}
    if width == 0.280:
        found["reason"] = "MeshError: no, \\"never\\""
    else:
        found["responses"] = {{name: width / (3.0 + n) for n, name in enumerate(NAMES)}}
        found["errors"] = {{name: 0.001 / 3.0 for name in NAMES}}
        found["unknowns"] = 14000
    answer(found)
"""
PLAN = plan_of_levels(
    THROW, {"web_width": (0.270, 0.300), "pin_length": (0.130, 0.150)}, held_out=2
)
RATIO = StudyPlan(
    THROW,
    (
        Factor.of_levels("width_ratio", "", (1.5, 1.6)),
        Factor.of_labels("web_outline", ("obround", "rectangle")),
    ),
    relations={"web_width": "width_ratio * pin_diameter"},
    held_out=1,
)


@pytest.fixture(autouse=True)
def puppets(monkeypatch):
    def spawn():
        return puppet(PUPPET)

    monkeypatch.setattr(workers, "spawn_worker", spawn)


@pytest.fixture
def store(tmp_path):
    return tmp_path / "runs.sqlite"


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    """A store with all results of the plan, which what is refused leaves as it is."""
    path = tmp_path_factory.mktemp("planned") / "runs.sqlite"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(workers, "spawn_worker", lambda: puppet(PUPPET))
        run_plan(PLAN, path)
    return path


def read(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def table_of(path, *lines):
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


# -------------------------------------------------------------------------------------------- export


def test_an_exported_table_tells_everything_with_units(store, tmp_path):
    table = run_plan(plan_of_levels(THROW, {"web_width": (0.270, 0.280)}, held_out=1), store)
    assert export_table(table, tmp_path / "runs.csv").rows == 3
    rows = read(tmp_path / "runs.csv")
    assert [row["role"] for row in rows] == [RUN, RUN, HELD_OUT]
    assert [row["status"] for row in rows] == ["done", "failed", "done"]
    assert [float(row["web_width [m]"]) for row in rows[:2]] == [0.270, 0.280]
    assert rows[1]["reason"] == 'MeshError: no, "never"'
    assert rows[1]["axial_compliance_pinned [m/N]"] == ""
    for name in NAMES:
        column = COLUMNS[NAMES.index(name)]
        assert [float(rows[place][column]) for place in (0, 2)] == table.responses[name].tolist()
        assert float(rows[0][f"{name} error"]) == 0.001 / 3.0
    assert float(rows[0]["seconds [s]"]) == 0.1
    assert rows[0]["unknowns"] == "14000"
    assert float(rows[0]["crank_radius [m]"]) == 0.170
    assert rows[0]["web_outline"] == "obround"


def test_factors_that_are_no_fields_have_columns_of_their_own(store, tmp_path):
    export_table(run_plan(RATIO, store), tmp_path / "runs.csv")
    rows = read(tmp_path / "runs.csv")
    assert [float(row["width_ratio"]) for row in rows[:4]] == [1.5, 1.5, 1.6, 1.6]
    assert [row["web_outline"] for row in rows[:4]] == ["obround", "rectangle"] * 2
    assert {float(row["web_width [m]"]) for row in rows[:4]} == {0.27, 0.288}


@pytest.mark.slow
def test_parquet_holds_the_same_table_with_units_as_metadata(store, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    table = run_plan(PLAN, store)
    export_table(table, tmp_path / "runs.csv")
    export_table(table, tmp_path / "runs.parquet")
    found = parquet.read_table(tmp_path / "runs.parquet")
    rows = read(tmp_path / "runs.csv")
    assert found.column_names == list(rows[0])
    for name in found.column_names:
        values = ["" if value is None else str(value) for value in found[name].to_pylist()]
        assert values == [row[name] for row in rows]
    assert found.schema.field("web_width [m]").metadata[b"unit"] == b"m"
    assert found.schema.metadata[b"study"].decode() == PLAN.key


def test_parquet_without_its_package_and_other_formats(store, tmp_path, monkeypatch):
    table = run_plan(PLAN, store)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingLibraryError, match=r"pip install 'crankfem\[tables\]', or write a"):
        export_table(table, tmp_path / "runs.parquet")
    with refused("export"):
        export_table(table, tmp_path / "runs.xlsx")
    with pytest.raises(InputError, match=r"^export: given '.*'; there is no folder"):
        export_table(table, tmp_path / "none" / "runs.csv")
    assert [path.name for path in tmp_path.iterdir() if "runs.sqlite" not in path.name] == []


# ------------------------------------------------------------------------------- import of a CSV table


@pytest.mark.slow
@pytest.mark.parametrize("plan", [PLAN, RATIO], ids=["fields", "ratio and choice"])
def test_an_exported_table_comes_back_with_all_digits(plan, store, tmp_path):
    table = run_plan(plan, store)
    export_table(table, tmp_path / "runs.csv")
    other = tmp_path / "other.sqlite"
    assert import_results(plan, other, tmp_path / "runs.csv").rows == len(table.values)
    assert import_results(plan, other, tmp_path / "runs.csv").rows == 0
    back = read_study(other)
    assert back.values.tolist() == table.values.tolist()
    assert back.held_out.tolist() == table.held_out.tolist()
    assert back.outlines == table.outlines
    for part in ("responses", "errors", "dimensions"):
        one, two = getattr(back, part), getattr(table, part)
        assert {n: c.tolist() for n, c in one.items()} == {n: c.tolist() for n, c in two.items()}
    assert len(back.failures) == len(table.rows)  # nothing of them is computed yet


def test_measured_values_stand_apart(store, tmp_path):
    before = run_plan(PLAN, store)
    table_of(
        tmp_path / "bench.csv",
        "web_width [mm], pin_length [cm] ,main_journal_bore [mm],axial_compliance_pinned [nm/N],source",
        "300,15,20,1.42,test bench",
        "301.5,15,,1.5e0,",
        ",,,1.6,elsewhere",
    )
    assert import_results(PLAN, store, tmp_path / "bench.csv").rows == 3
    table = run_plan(PLAN, store)
    assert table.computed == 0
    assert table.values.tolist() == before.values.tolist()
    first, second, third = table.extra
    assert (first.role, first.source) == (MEASURED, "test bench")
    assert second.source == "bench.csv, line 3"
    assert first.values == (0.3, 0.15)
    assert second.values == (0.3015, 0.15)
    assert third.values is None
    assert first.dimensions["main_journal_bore"] == 0.02
    assert second.dimensions["main_journal_bore"] == 0.0  # as the study's throw has it
    assert third.dimensions["web_width"] == 0.285
    assert first.responses == {"axial_compliance_pinned": close(1.42e-9, rel=1e-15)}
    assert first.errors == {}
    assert [row.role for row in table.rows[-3:]] == [MEASURED] * 3


def test_earlier_rows_are_fitted_beside_the_studys_own(store, tmp_path):
    run_plan(PLAN, store)
    responses = ["axial_compliance_pinned [nm/N]", *COLUMNS[1:]]
    numbers = [str(n + 1.5) for n in range(len(NAMES))]
    table_of(
        tmp_path / "more.csv",
        ",".join(["role", "web_width [mm]", "pin_length [mm]", *responses]),
        ",".join(["run", "285", "140", *numbers]),
        ",".join(["held out", "286", "141", *numbers]),
    )
    import_results(PLAN, store, tmp_path / "more.csv")
    table = read_study(store)
    assert table.values[-2:].tolist() == [[0.285, 0.140], [0.286, 0.141]]
    assert table.held_out[-2:].tolist() == [False, True]
    assert table.responses["axial_compliance_pinned"][-1] == 1.5e-9
    assert table.responses["mass"][-1] == NAMES.index("mass") + 1.5
    # Errors that are not known for every row are not told at all; seconds are those of the study.
    assert table.errors == {}
    assert table.seconds[-2:].tolist() == [0.0, 0.0]
    assert all(np.all(np.isfinite(column)) for column in table.responses.values())


def full_lines(*lines, factors="web_width [mm],pin_length [mm]"):
    """Lines of role and factors, completed by the same number for every response."""
    numbers = ",".join(["1.0"] * len(NAMES))
    return [f"role,{factors}," + ",".join(COLUMNS), *(f"{line},{numbers}" for line in lines)]


def test_no_row_is_both_fitted_and_judged_by(store, tmp_path):
    lines = full_lines("run,285,140", "held out,285,140")
    import_results(PLAN, store, table_of(tmp_path / "a.csv", *lines))
    table = read_study(store)
    assert table.held_out.tolist() == [True]  # the later line stands
    # Nor in a table whose rows differ in a digit that a store tells apart.
    near = 0.285 * (1.0 + 0.9 * SAME)
    rows = [replace(table.extra[0], role=RUN, values=(width, 0.14)) for width in (0.285, near)]
    assert len(study_table(PLAN, (), {}, rows).values) == 1
    far = replace(rows[0], values=(0.285 * (1.0 + 2.0 * SAME), 0.14))
    assert len(study_table(PLAN, (), {}, [*rows, far]).values) == 2


@pytest.mark.parametrize("role", [RUN, HELD_OUT])
@pytest.mark.parametrize(
    ("cells", "column", "given", "allowed"),
    [
        ("269.9,140", "web_width", "269.9 mm", "270 mm to 300 mm"),
        ("300.1,140", "web_width", "300.1 mm", "270 mm to 300 mm"),
        ("285,151", "pin_length", "151 mm", "130 mm to 150 mm"),
    ],
)
def test_rows_beyond_the_studys_ranges_are_not_fitted(
    store, tmp_path, role, cells, column, given, allowed
):
    lines = full_lines(f"{role},{cells}")
    with refused(f"bad.csv, line 2, column {column} [mm]") as caught:
        import_results(PLAN, store, table_of(tmp_path / "bad.csv", *lines))
    assert all(words in str(caught.value) for words in (given, allowed))
    table_of(tmp_path / "good.csv", *full_lines(f"measured,{cells}"))
    assert import_results(PLAN, store, tmp_path / "good.csv").rows == 1


def test_ratios_beyond_their_range_are_not_fitted(store, tmp_path):
    lines = full_lines("run,1.45,obround", factors="width_ratio,web_outline")
    with refused("bad.csv, line 2, column width_ratio"):
        import_results(RATIO, store, table_of(tmp_path / "bad.csv", *lines))


@pytest.mark.slow
def test_designs_of_another_study_beyond_the_ranges_are_left_out(store, tmp_path):
    wider = plan_of_levels(
        THROW, {"web_width": (0.250, 0.285, 0.310), "pin_length": (0.140, 0.145)}, held_out=1
    )
    inside = len([d for d in plan_designs(wider).designs if 0.270 <= d.values[0] <= 0.300])
    assert 2 <= inside <= 3
    run_plan(wider, tmp_path / "other.sqlite")
    found = import_results(PLAN, store, tmp_path / "other.sqlite")
    assert (found.designs, found.rows, found.left_out) == (0, inside, 7 - inside)
    assert all(0.270 <= row.values[0] <= 0.300 for row in read_study(store).extra)


HEADER = "web_width [mm],pin_length [mm],axial_compliance_pinned [m/N]"


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([""], "bad.csv, line 1: empty; the first line must name the columns"),
        (["web_width [mm]", "1"], "bad.csv, line 1: given no response; allowed are axial_"),
        ([HEADER], "bad.csv: given no line with results"),
        ([HEADER.replace("web_width [mm]", "web_with [mm]")], "bad.csv, line 1, column 1"),
        ([HEADER.replace("[mm]", "", 1)], "bad.csv, line 1, column 1 ('web_width'): given"),
        ([HEADER.replace("[mm]", "[kg]", 1)], "bad.csv, line 1, column 1 ('web_width [kg]'):"),
        ([HEADER + ",tilt_stiffness_ratio [m]"], "bad.csv, line 1, column 4"),
        ([HEADER + "]"], "bad.csv, line 1, column 3 ("),
        ([HEADER + ",web_width [m]"], "bad.csv, line 1, column 4 ('web_width [m]'): given twice"),
        ([HEADER, "300,150,1e-9", "300,abc,1e-9"], "bad.csv, line 3, column pin_length [mm]:"),
        ([HEADER, "300,150,nan"], "bad.csv, line 2, column axial_compliance_pinned [m/N]: given"),
        ([HEADER, '"300,5",150,1e-9'], "bad.csv, line 2, column web_width [mm]: given '300,5'"),
        ([HEADER, "300,5,150,1e-9"], "bad.csv, line 2: given 4 cells; allowed are 3"),
        ([HEADER.replace(",", ";"), "300,5;150.5;1e-9"], "bad.csv, line 2, column web_width [mm]:"),
        *(
            (
                [f"web_width [mm],{name}", f"300,{value}"],
                f"bad.csv, line 2, column {name}: given '{value}'; allowed is a number above zero",
            )
            for name, value in [
                ("axial_compliance_pinned [m/N]", "-1e-9"),
                ("torsional_compliance_guided [rad/(N m)]", "0"),
                ("mass [kg]", "-0.0"),
            ]
        ),
        ([HEADER, "300,150,"], "bad.csv, line 2: given no response"),
        ([HEADER, "100,150,1e-9"], "bad.csv, line 2: throw."),
        ([HEADER + ",status", "300,150,1e-9,failed"], "bad.csv: given no line with results"),
        ([HEADER + ",role", "300,150,1e-9,seen"], "bad.csv, line 2, column role: given 'seen'"),
        ([HEADER + ",role", "300,150,1e-9,run"], "bad.csv, line 2: given no"),
        ([HEADER + ",role", "300,,1e-9,run"], "bad.csv, line 2: given no pin_length; a line that"),
        ([HEADER + ",web_outline", "300,150,1e-9,round"], "bad.csv, line 2, column web_outline:"),
    ],
)
def test_bad_tables_are_refused_with_line_and_column(planned, tmp_path, lines, message):
    with pytest.raises(InputError) as caught:
        import_results(PLAN, planned, table_of(tmp_path / "bad.csv", *lines))
    text = str(caught.value)
    assert text.startswith(message)
    assert text.endswith(".")
    assert "\n" not in text
    assert read_study(planned).extra == ()


@pytest.mark.parametrize(
    "lines",
    [
        (HEADER.replace(",", ";"), "300,5;150;1,25e-9"),
        (HEADER.replace(",", "\t"), "300.5\t150\t1.25e-9"),
    ],
)
def test_tables_of_spreadsheets_are_read(tmp_path, lines):
    (row,) = read_rows(table_of(tmp_path / "sheet.csv", *lines), PLAN)
    assert row.values == close((0.3005, 0.15))
    assert row.responses == {"axial_compliance_pinned": close(1.25e-9)}


def test_a_ratio_and_the_dimension_that_follows_must_agree(store, tmp_path):
    head = "web_width [mm],width_ratio,pin_diameter [mm],web_outline,axial_compliance_pinned [m/N]"
    with refused("a.csv, line 2, column web_width [mm]") as caught:
        import_results(RATIO, store, table_of(tmp_path / "a.csv", head, "350,1.6,,obround,1e-9"))
    assert "288 mm" in str(caught.value)
    # With another pin, given in the line, another width follows.
    lines = ["288,1.6,,,1e-9", "304,1.6,190,obround,1e-9", ",1.6,190,obround,2e-9", "350,,,,1e-9"]
    import_results(RATIO, store, table_of(tmp_path / "b.csv", head, *lines))
    with ResultStore(store, readonly=True) as opened:
        widths = [row.dimensions["web_width"] for row in opened.extra_rows(RATIO.key)]
    assert widths == close([0.288, 0.304, 0.304, 0.350], rel=SAME)


WEIGHTED = THROW.model_copy(
    update={
        "counterweight": Counterweight(
            outer_radius=0.26, inner_radius=0.10, angle=2.0, thickness=0.05
        )
    }
)


@pytest.mark.slow
@pytest.mark.parametrize("factors", [("web_width",), ("web_width", "counterweight.thickness")])
def test_measured_dimensions_of_parts_are_kept(store, tmp_path, factors):
    ranges = {"web_width": (0.270, 0.300), "counterweight.thickness": (0.04, 0.06)}
    plan = plan_of_levels(WEIGHTED, {name: ranges[name] for name in factors}, held_out=1)
    head = "web_width [mm],counterweight.thickness [mm],axial_compliance_pinned [m/N]"
    table = table_of(tmp_path / "a.csv", head, "280,45,1e-9", ",45,2e-9", "280,,3e-9")
    assert import_results(plan, store, table).rows == 3
    with ResultStore(store, readonly=True) as opened:
        rows = opened.extra_rows(plan.key)
    assert [row.dimensions.get("counterweight.thickness") for row in rows] == [0.045, 0.045, None]
    # Exported, each column stands once, and the table comes back.
    run_plan(plan, store)
    export_table(read_study(store), tmp_path / "b.csv")
    (header, *_) = (tmp_path / "b.csv").read_text(encoding="utf-8").splitlines()
    assert header.split(",").count("counterweight.thickness [m]") == 1
    import_results(plan, tmp_path / "b.sqlite", tmp_path / "b.csv")
    with ResultStore(tmp_path / "b.sqlite", readonly=True) as opened:
        again = [row for row in opened.extra_rows(plan.key) if row.role == MEASURED]
    assert [row.dimensions.get("counterweight.thickness") for row in again] == [0.045, 0.045, None]


def test_rows_at_the_studys_own_designs_are_counted(store, tmp_path):
    lines = full_lines("run,270,130", "held out,290,140", "measured,270,130")
    table = table_of(tmp_path / "a.csv", *lines)
    assert import_results(PLAN, store, table).coinciding == 1
    run_plan(PLAN, store)
    assert import_results(PLAN, store, table).coinciding == 1


@pytest.mark.parametrize(
    ("column", "value"),
    [("web_thickness [mm]", "70"), ("web_outline", "rectangle"), ("model_version", "5")],
)
def test_rows_that_do_not_belong_to_the_study_are_not_fitted(store, tmp_path, column, value):
    header, cells = full_lines("run,300,150")
    header, cells = f"{header},{column}", f"{cells},{value}"
    with refused(f"bad.csv, line 2, column {column}"):
        import_results(PLAN, store, table_of(tmp_path / "bad.csv", header, cells))
    if column != "model_version":  # as a measured throw it may differ
        table_of(tmp_path / "good.csv", header, cells.replace("run", "measured", 1))
        assert import_results(PLAN, store, tmp_path / "good.csv").rows == 1


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("utf16.csv", b"\xff\xfe\x00w"),
        ("latin.csv", "Lager-Länge".encode("latin-1")),
        ("zero.csv", b"a,b\n\x00\x01"),
        ("open.csv", b'a,"b\n'),
        ("t.parquet", b"PAR1"),
    ],
)
def test_what_is_no_table_is_refused(store, tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with refused(name):
        import_results(PLAN, store, tmp_path / name)
    for path in (tmp_path, tmp_path / "none.csv"):
        with pytest.raises(InputError, match=r"^import: given"):
            import_results(PLAN, store, path)
    assert not store.exists()


# -------------------------------------------------------------------------------- import of a store


@pytest.mark.slow
def test_designs_of_another_store_that_are_the_studys_own_need_no_computing(store, tmp_path):
    other = tmp_path / "other.sqlite"
    part = plan_of_levels(
        THROW, {"web_width": (0.270, 0.300), "pin_length": (0.130, 0.145)}, held_out=2
    )
    run_plan(part, other)
    before = other.read_bytes()
    found = import_results(PLAN, store, other)
    # Two corners are shared; two runs and two held-out designs lie elsewhere in the same plane.
    assert (found.designs, found.rows, found.left_out) == (2, 4, 0)
    assert import_results(PLAN, store, other).designs == 0
    assert other.read_bytes() == before
    table = run_plan(PLAN, store)
    assert table.computed == 4
    assert len(table.values) == 6 + 4
    assert table.held_out.tolist() == [False] * 4 + [True] * 2 + [False] * 2 + [True] * 2
    width = table.values[:, 0]
    np.testing.assert_array_equal(table.responses["axial_compliance_pinned"], width / 3.0)
    assert all(row.source.startswith("other.sqlite, design ") for row in table.rows[6:])


@pytest.mark.parametrize(
    "other",
    [
        plan_of_levels(THROW, {"crank_radius": (0.165, 0.168)}, held_out=1),
        plan_of_levels(THROW, {"web_width": (0.290, 0.310)}, held_out=1, accuracy=0.02),
    ],
    ids=["throw", "accuracy"],
)
def test_a_store_with_nothing_of_the_study_is_refused(store, tmp_path, other):
    run_plan(other, tmp_path / "other.sqlite")
    with refused("import"):
        import_results(PLAN, store, tmp_path / "other.sqlite")


def test_results_of_an_earlier_model_are_left_out(store, tmp_path, monkeypatch):
    other = tmp_path / "other.sqlite"
    with monkeypatch.context() as earlier:
        earlier.setattr(study_module, "MODEL_VERSION", 4)
        run_plan(plan_of_levels(THROW, {"web_width": (0.260, 0.310)}, held_out=1), other)
    with refused("import"):
        import_results(PLAN, store, other)


def test_a_store_with_damaged_rows_alone_is_refused_and_it_is_said(store, tmp_path):
    run_plan(PLAN, tmp_path / "other.sqlite")
    connection = sqlite3.connect(tmp_path / "other.sqlite")
    connection.execute("UPDATE designs SET seconds = 9.0")
    connection.commit()
    connection.close()
    with refused("import"):
        import_results(PLAN, store, tmp_path / "other.sqlite")
