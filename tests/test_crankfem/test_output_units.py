"""What is printed: tables, units, and what reaches the terminal."""

import re
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from comparing import close
from crankbase.quantity import RPM
from crankbase.sentences import amount, listed
from crankbase.table import SI, UNITS, Column, Table, parse_output_units
from crankbase.units import unit_registry
from crankfem.cli import console
from crankfem.files.reading.data_files import input_path
from satellite_cases import of_satellites

INCH, POUND = 0.0254, 0.45359237
FORCE = POUND * 9.80665
KSI = 1e3 * FORCE / INCH**2


@pytest.mark.parametrize("name", UNITS)
def test_sizes_of_printed_units_are_those_of_pint(name):
    unit, size = UNITS[name]
    # Turns per minute: engineers do not write the turn.
    registry, said = unit_registry(), name.replace("1/min", "turn/min")
    one = registry.Quantity(1.0, registry.parse_units(said)).to(registry.parse_units(unit))
    assert size == close(one.magnitude, rel=1e-12)  # both are factors, but for round-off


def test_without_a_wish_everything_stays_in_si():
    for text in (None, "SI", "si", ""):
        units = parse_output_units(text)
        assert units == SI
        assert all(units.of(name).name == name and not units.of(name).wished for name in UNITS)
    assert SI.quantity(1.27e-9, "m/N", 4) == "1.27e-9 m/N"
    assert SI.of("um").number(None) == SI.of("um").with_name(None) == "unbounded"
    assert SI.written("280 mm") == "280 mm"


def test_large_numbers_have_no_exponent():
    units = parse_output_units("in, lbf")
    assert units.of("kN m").number(30730.0) == "272000"
    # Beyond that a power of ten stands as in engine files.
    assert units.of("N/m").number(9.5e9, 3) == "5.42e7"
    assert parse_output_units("mm, kN").quantity(2.521e-9, "m/N", 4) == "0.002521 mm/kN"


def test_quantities_in_sentences():
    imperial = parse_output_units("imperial")
    given = (
        f"web_width: given {amount(0.34, 'm')}; the range is {listed((0.27, 0.33), 'm', 6, ' to ')}"
    )
    torque, compliance = amount(12e3, "N m"), amount(1.27e-9, "m/N")
    text = f"{given}, at {amount(515.0 / RPM, 'rad/s', 4)} and {torque}, {compliance}."
    assert imperial.written(text) == (
        "web_width: given 13.4 in; the range is 10.6 to 13 in, at 515 1/min and 106000 lbf in, "
        "222e-9 in/lbf."
    )
    # One unit behind a list is that of all its numbers.
    units = parse_output_units("in, rad")
    angles = np.radians([60.0, 90.0, 120.0]).tolist()
    assert units.written(listed(angles, "rad")) == "1.05, 1.57, 2.09 rad"
    assert units.written(listed((0.005, 0.01), "m", 6, " and ")) == "0.197 and 0.394 in"
    # Zeros of a number that is written out are no digits.
    assert imperial.written(amount(3e6, "N s/m", 4)) == "17130 lbf s/in"
    assert parse_output_units("mm, kN").written(amount(2.5e-9, "m/N")) == "0.0025 mm/kN"
    # What has no mark is somebody's: a name, a source, a reason.
    for text in ("6ChN 25/34", "the 500 mm bore series", "doi 10.24143/2073-1574-2021-4-75-83"):
        assert units.written(text) == text


@pytest.mark.slow
@pytest.mark.parametrize("option", [(), ("--json",)])
def test_a_wrong_unit_is_told_before_anything_is_computed(call, option):
    for command in ("throw", "stress", "mechanism", "harmonics", "vibration", "run", "check"):
        answer = call(command, "6chn25-34", "--units", "in, thou", *option)
        assert (answer.code, answer.out) == (2, "")
        assert answer.err.startswith("Error: --units: given 'in' and 'thou'")


@pytest.mark.slow
def test_a_command_prints_its_record_in_other_units(call):
    arguments = ("mechanism", "6chn25-34")
    record = call(*arguments, "--json").json()
    assert call(*arguments, "--json", "--units", "imperial").json() == record
    out = call(*arguments, "--units", "in, lbf, ksi").out
    torque = float(re.search(r"torque (\d+) lbf in", out)[1])
    assert torque * FORCE * INCH == close(record["torque"]["mean"], rel=1e-3)
    row = next(line for line in out.splitlines() if line.startswith("1 to 6")).split()[2:]
    assert float(row[1]) * KSI == close(record["cylinders"][0]["peak_pressure"], rel=1e-3)
    assert float(row[4]) * FORCE == close(record["cylinders"][0]["largest_side_force"], rel=1e-3)
    assert not re.search(r"\b(kN|MPa|mm)\b", out)


@pytest.mark.further
@pytest.mark.parametrize(
    "arguments",
    [
        ("harmonics", "8chn26-26", "--cylinder", "1"),
        *(tuple(line.split()) for line in of_satellites("PRINTED_NUMBERS")),
        ("check", "6chn25-34"),
        ("formulas", "6chn25-34", "--no-fe"),
    ],
)
def test_no_si_unit_of_length_force_or_stress_is_left(call, arguments):
    answer = call(*arguments, "--units", "imperial")
    assert answer.code == 0
    out = answer.out.partition("Inputs")[0]  # inputs stand as they were given
    found = re.findall(r"\d (?:mm|kN|kN m|N m|MPa|m/N)\b|\[(?:mm|kN|kN m|N m|MPa|1e-9 m/N)\]", out)
    assert found == []
    assert re.search(r"\b(in|lbf|ksi)\b", out)


def test_lookup_in_other_units(call, model_file):
    pairs = ("web_width=11.8in", "web_thickness=2677.165 thou")
    value = call("lookup", model_file, *pairs, "--json").json()["axial_compliance"]["value"]
    out = call("lookup", model_file, *pairs, "--units", "in, lbf").out
    shown = float(re.search(r"axial compliance +pinned +([\d.]+)e-9 .* in/lbf", out)[1])
    assert shown * 1e-9 * INCH / FORCE == close(value, rel=1e-3)
    outside = call("lookup", model_file, "web_width=300mm", "web_thickness=100mm", "--units", "in")
    assert "web_thickness: given 3.94 in; the range of the fit is " in outside.out
    assert " mm" not in outside.out


def test_sentences_of_a_file_and_of_a_formula_in_other_units(call):
    told = call("check", "8chn13-14", "--full", "--units", "imperial").out
    assert re.search(
        r"Note: indicated power [\d.]+ hp at \d+ 1/min, mean indicated pressure [\d.]+ ksi", told
    )
    said = call("lookup", "law", "--throw", "8chn13-14", "--units", "in, lbf").out
    assert re.search(r"^Throw of 8chn13-14: crank_radius = 2.76 in, ", said)
    compared = call("formulas", "8chn13-14", "--no-fe", "--full", "--units", "in, lbf").out
    assert re.search(r"the value is [\d.e-]+ rad/\(lbf in\)", " ".join(compared.split()))


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (
            "check mine.toml",
            "crank_radius: given 6.88976 in; allowed is half of engine.stroke, 6.69291",
        ),
        (
            "run mine.toml",
            "crank_radius: given 6.88976 in; allowed is half of engine.stroke, 6.69291 in",
        ),
        (
            "throw mine.toml",
            "throw.fillet_radius: given 2.3622 in; allowed is 0, or 0.0866142 in to",
        ),
        (
            "mechanism 6chn25-34 --speed 3/min",
            "--speed: given '3/min'; allowed is 0.5236 rad/s to 3141.6",
        ),
        (
            "lookup model.json web_width=0.3m web_thickness=60mm pin_length=99mm",
            "pin_length: given 3.89764 in; allowed is 5.47244 in, because it",
        ),
    ],
)
def test_refusals_in_other_units(call, tmp_path, six_cylinders, model_file, edit, line, said):
    command, file, *options = line.replace("model.json", str(model_file)).split()
    if file == "mine.toml":
        changes = {"throw.fillet_radius": '"60 mm"'}
        if command != "throw":
            changes = {"throw.crank_radius": '"175 mm"'}
        (tmp_path / file).write_text(edit(six_cylinders, changes), encoding="utf-8")
    answer = call(command, file, *options, "--units", "in, rad/s")
    assert (answer.code, answer.out) == (2, "")
    assert said in answer.err
    # Without the option, and as text, a refusal is as it was.
    assert " in;" not in call(command, file, *options).err


def test_units_in_a_file(call, tmp_path, six_cylinders):
    text = six_cylinders.replace('"170 mm"', '"6.692913386 inch"').replace(
        '"8.5 MPa"', '"1232.8 psi"'
    )
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    checked = call("check", "mine.toml", "--json").json()
    found = {one["name"]: one["value"] for one in checked["dimensions"]}
    assert found["crank_radius"] == close(0.170, rel=1e-9)
    (tmp_path / "mine.toml").write_text(text.replace(" inch", " psi"), encoding="utf-8")
    answer = call("check", "mine.toml")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("Error: throw.crank_radius: given '6.692913386 psi', which is no")
    assert answer.err.count("\n") == 1


INCHES = parse_output_units("in, lbf")


@pytest.mark.parametrize(
    ("column", "cell", "units", "head", "text"),
    [
        (Column("force", "kN"), 12345.6, SI, "force [kN]", "12.35"),
        (Column("force", "kN"), 4448.2216, INCHES, "force [lbf]", "1000"),
        (Column("speed", "1/min", decimals=1), 52.36, SI, "speed [1/min]", "500.0"),
        (Column("", "mm"), 0.5, SI, "mm", "500"),
        (Column("lowest", "mm", bare=True), 0.0254, INCHES, "lowest", "1"),
        (Column("used", "%", 3), 12.345, SI, "used [%]", "1234"),
        (Column("margin", "%", decimals=1), -1e-9, SI, "margin [%]", "0.0"),
        (Column("order", digits=None), 4.5, SI, "order", "4.5"),
        (Column("terms"), 123456, SI, "terms", "123456"),
        (Column("rho", "mm", joint=" to "), (0.1, 0.2), SI, "rho [mm]", "100 to 200"),
        (Column("peak", missing="unbounded"), None, SI, "peak", "unbounded"),
        (Column("nodes at", decimals=2), [], SI, "nodes at", ""),
        (Column("kind", words=True), "12 m", INCHES, "kind", "12 m"),
    ],
)
def test_a_column_writes_heads_and_cells(column, cell, units, head, text):
    assert (column.head(units), column.text(cell, units)) == (head, text)


def test_numbers_written_with_fewer_digits_are_rounded_once():
    # 81.148 is 81.15 with two decimals; three digits of it are 81.1.
    table = Table("", [Column("frequency", "Hz", decimals=2)], [[81.148], [9.636], [0.0]])
    assert table.texts() == [["81.15"], ["9.64"], ["0.00"]]
    assert table.texts(write=lambda value, _: f"{value:#.3g}") == [["81.1"], ["9.64"], ["0.00"]]


def test_rows_that_read_alike_are_merged_only_where_wished():
    rows = [["1", 1.0], ["2", 1.0 + 1e-9], ["3", 2.0]]
    columns = [Column("cylinder", words=True), Column("p")]
    assert Table("", columns, rows, merged=True).texts() == [["1, 2", "1"], ["3", "2"]]
    assert len(Table("", columns, rows).texts()) == 3


def test_a_row_has_a_cell_for_each_column():
    with pytest.raises(ValueError, match="shorter"):
        Table("", [Column("a"), Column("b")], [[1.0]]).texts()


def test_columns_are_picked_by_name():
    table = Table("t", [Column("a"), Column("b")], [[1.0, 2.0]], marks=["over"])
    picked = table.select("b")
    assert [column.name for column in picked.columns] == ["b"]
    assert (picked.texts(), picked.marks) == ([["2"]], ["over"])


# A window title, hidden text, a C1 sequence, a line written backwards, markup, a picture's name.
EVIL = "\x1b]0;evil\x07\x1b[8m\x9b31m\x7f\u202e[red][link=x]:smile:"
SHOWN = r"\x1b]0;evil\x07\x1b[8m\x9b31m\x7f\u202e[red][link=x]:smile:"
CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
TOML = EVIL.translate({ord(one): f"\\u{ord(one):04x}" for one in "\x1b\x07\x9b\x7f\u202e"})
ROOT = Path(__file__).resolve().parents[2]


def shown(answer, text=SHOWN):
    told = answer.out + answer.err
    assert CONTROL.search(told) is None
    # A table breaks long words.
    assert text in told or text in re.sub(r"\s|[│┃]", "", told)


@pytest.mark.slow
@pytest.mark.parametrize(
    "change",
    [
        {"engine.name": f'"{TOML}"'},
        {"throw.crank_radius": f'{{ value = "170 mm", assumed = "{TOML}" }}'},
        {"throw.crank_radius": f'"{TOML}"'},
        {"throw.web_outline": f'"{TOML}"'},
    ],
)
def test_texts_of_a_file_are_shown(call, tmp_path, edit, six_cylinders, change):
    (tmp_path / "mine.toml").write_text(edit(six_cylinders, change), encoding="utf-8")
    answer = call("check", "mine.toml")
    assert CONTROL.search(answer.out + answer.err) is None
    assert answer.code in (0, 2)
    # As it is, or as Python quotes it.
    assert r"\x1b]0;evil\x07" in re.sub(r"\s|[│┃]", "", answer.out + answer.err)
    assert CONTROL.search(call("check", "mine.toml", "--json").out.replace("\x7f", "")) is None


@pytest.mark.slow
def test_names_of_sections_and_files_are_shown(call, tmp_path, six_cylinders):
    (tmp_path / "mine.toml").write_text(f'{six_cylinders}\n["{TOML}"]\nx = 1\n', encoding="utf-8")
    shown(call("check", "mine.toml"))
    shown(call("check", f"{EVIL}.toml"))
    shown(call(EVIL))
    (tmp_path / f"{EVIL}.toml").write_text(six_cylinders, encoding="utf-8")
    shown(call("check", f"{EVIL}.toml"))


def test_progress_and_tracebacks_are_shown(capsys, monkeypatch):
    with console.RunProgress() as progress:
        progress.step(EVIL)
        progress.warn(EVIL)
    monkeypatch.setenv("CRANKFEM_TRACEBACK", "1")
    with pytest.raises(SystemExit), console.clear_errors():
        raise RuntimeError(EVIL)
    told = capsys.readouterr().err
    assert CONTROL.search(told) is None
    assert told.count(SHOWN) >= 4


@pytest.mark.slow
def test_nothing_else_writes_to_the_terminal():
    writes = re.compile(r"(?<![\w.\">`])print\(|\btyper\.echo\(|sys\.std(?:out|err)\.write\(")
    found = {
        str(path.relative_to(ROOT))
        for package in ("crankbase", "geometry", "fem", "regression", "dynamics", "crankfem")
        for path in (ROOT / package).rglob("*.py")
        for line in path.read_text(encoding="utf-8").splitlines()
        if writes.search(line) and ">>>" not in line
    }
    # A sentence that never changes, and notes of a study in Python.
    assert found == {
        "crankfem/cli/console.py",
        "crankfem/cli/entry.py",
        "crankfem/analyses/study/studies.py",
    }


def words(text):
    return {word.strip(":;") for word in re.sub(r"[\[\]]|--+", " ", text).split()}


@pytest.mark.slow
@pytest.mark.parametrize(
    "line", [("fields", "throw"), ("two-mass", "yamz-5340", "--full"), ("new", "--list")]
)
def test_a_narrow_terminal_loses_nothing(call, monkeypatch, line):
    monkeypatch.setattr(console.output, "_width", 400)
    whole = words(call(*line).out)
    for width in (1, 2, 7, 20, 40, 79):
        monkeypatch.setattr(console.output, "_width", width)
        answer = call(*line)
        assert answer.code == 0
        assert whole - words(answer.out) <= {"field", "name"}  # the first column needs no head


@pytest.mark.slow
@pytest.mark.parametrize("given", [{"COLUMNS": "0"}, {"COLUMNS": "²", "LINES": "²"}])
def test_impossible_sizes_are_none(spawn, spawn_environment, given):
    assert spawn("new", "--list", env=spawn_environment(**given)) == spawn("new", "--list")


@pytest.mark.further
def test_closed_streams_and_poor_encodings(spawn, spawn_environment, tmp_path):
    (tmp_path / "mü.toml").write_bytes(input_path("6chn25-34").read_bytes())
    answer = spawn("check", "mü.toml", env=spawn_environment(PYTHONIOENCODING="ascii"))
    assert (answer.code, answer.err) == (0, "")
    assert r"m\xfc.toml: valid engine file" in answer.out
    start = ["sh", "-c", 'exec "$@" <&- >&- 2>&-', "sh", sys.executable, "-m", "crankfem"]
    for line, code in (("check", "mü.toml"), 0), (("check", "none"), 2):
        assert spawn(*line, command=start).code == code


def test_an_option_of_one_value_is_not_given_twice(call):
    for line in (
        ("throw", "6chn25-34", "--accuracy", "0.1", "--accuracy=0.2"),
        ("throw", "6chn25-34", "--gamma", "90 deg", "--gamma-deg", "120"),
        ("run", "6chn25-34", "--output", "a", "--output", "b"),
    ):
        answer = call(*line)
        assert (answer.code, answer.out) == (2, "")
        assert answer.err.strip() == f"Error: {line[2]}: given more than once; give it once."
    # Some are meant to be, and flags say the same twice.
    assert call("formulas", "6chn25-34", "--constant", "x=1", "--constant", "y=2").code == 2
    assert call("fields", "throw", "--json", "--json").code == 0


def test_help_keeps_names_of_sections(call):
    assert "[two_mass_check]" in call("two-mass", "--help").out


@pytest.mark.slow
def test_a_drawing_of_such_a_name_is_well_formed(call, tmp_path, edit, six_cylinders):
    text = edit(six_cylinders, {"engine.name": f'"<b>&]]>{TOML}"'})
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    assert call("draw", "mine.toml", "--output", "throw.svg").code == 0
    ElementTree.parse(tmp_path / "throw.svg")
