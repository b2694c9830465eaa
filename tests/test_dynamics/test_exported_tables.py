"""Tables as spreadsheets and measuring systems export them give what a plain table gives, or are refused."""

import sys

import numpy as np
import openpyxl
import pytest

from comparing import close
from crankbase.errors import InputError, MissingLibraryError
from dynamics.gas.pressure import read_pressure_table
from dynamics.harmonics import harmonics, read_torque_table
from dynamics.sample_tables import TableReading
from refusals import refused

STEP = 2.0
ANGLES = STEP * np.arange(360)  # of a four-stroke cycle
ORDERS = np.array([0.5, 1.0, 1.5, 3.0, 4.5])


def torque_at(degrees):
    """A torque of some orders, with digits that a table prints."""
    phases = np.radians(np.multiply.outer(ORDERS, np.asarray(degrees)))
    waves = np.array([40.0, 25.0, 90.0, 35.0, 12.0]) @ np.sin(phases + ORDERS[:, None])
    return np.round(150.0 + waves, 6)


TORQUE = torque_at(ANGLES)
PLAIN = harmonics(TORQUE, 4)


def comma(value):
    return repr(float(value)).replace(".", ",")


def thousands(value):
    """As 1.234,5 with a point between thousands."""
    text = f"{value:,.6f}"
    return text.translate(str.maketrans(",.", ".,"))


def lines(separator, write=repr, head="crank_angle_deg{0}torque_Nm", ends="", factor=1.0):
    rows = [
        f"{write(float(a))}{separator}{write(float(factor * t))}{ends}"
        for a, t in zip(ANGLES, TORQUE, strict=True)
    ]
    return "\n".join([head.format(separator) + ends, *rows]) + "\n"


BY_NUMBER = {"crank_angle_deg": 1, "torque_Nm": 2}
BY_NAME = {"crank_angle_deg": "CA", "torque_Nm": "M1"}
UNITS_ROW = "Test bench 7;cycle 12\n\nCA;M1\n°KW;Nm"
THREE = "\n".join(
    ["CA;speed;M1;", "deg;1/min;Nm;"]
    + [f"{comma(a)};1500;{comma(t)};" for a, t in zip(ANGLES, TORQUE, strict=True)]
)
EXPORTS = {
    "comma": (lines(","), None),
    "semicolon": (lines(";"), None),
    "semicolon and decimal comma": (lines(";", comma), None),
    "tab and decimal comma": (lines("\t", comma), None),
    "spaces and decimal comma": (lines("   ", comma), None),
    "decimal comma in quotes": (lines(",", lambda value: f'"{comma(value)}"'), None),
    "points between thousands": (
        lines(";", lambda value: thousands(value * 1e3 if value > 720.0 else value)),
        None,
    ),
    "Windows line ends and a mark of UTF-8": ("\ufeff" + lines(";").replace("\n", "\r\n"), None),
    "empty columns at the end": (lines(";", comma, ends=";;;"), None),
    "empty lines and a comment of another program": ("% bench 7\n\n" + lines(",") + "\n\n", None),
    "no header": (lines(";", comma).split("\n", 1)[1], BY_NUMBER),
    "title, names and a row of units": (lines(";", comma, head=UNITS_ROW), BY_NAME),
    "units in brackets": (lines(",", head="CA [deg]{0}M1 [Nm]"), BY_NAME),
    "three columns": (THREE, BY_NAME),
    "three columns by number": (THREE, {"crank_angle_deg": 1, "torque_Nm": 3}),
    "in kN m": (lines(",", factor=1e-3), {"crank_angle_deg": 1, "torque_kNm": 2}),
}


@pytest.fixture
def read(tmp_path):
    """Write a table and read it."""

    def read(text, columns=None, strokes=4, encoding="utf-8"):
        path = tmp_path / "torque.csv"
        path.write_bytes(text.encode(encoding))
        reading = None if columns is None else TableReading(columns=columns)
        return read_torque_table(path, strokes=strokes, reading=reading)

    return read


def written(angles, values):
    rows = zip(angles, values, strict=True)
    return "\n".join(["crank_angle_deg,torque_Nm", *(f"{a:.9g},{t:.12g}" for a, t in rows)])


def check(table, rel=1e-9):
    found = table.harmonics()
    size = float(np.max(PLAIN.amplitude))
    assert found.mean == close(PLAIN.mean, rel=rel)
    assert np.max(np.abs(found.amplitude[:20] - PLAIN.amplitude[:20])) <= rel * size
    assert np.max(np.abs(found.sine[:20] - PLAIN.sine[:20])) <= rel * size


@pytest.mark.parametrize("export", EXPORTS)
def test_an_export_gives_the_harmonics_of_the_plain_table(read, export):
    check(read(*EXPORTS[export]))


@pytest.mark.parametrize("encoding", ["utf-16", "cp1252"])
def test_other_encodings(read, encoding):
    text = lines("\t", comma, head=UNITS_ROW.replace(";", "\t"))
    check(read(text, BY_NAME, encoding=encoding))


def write_sheets(path, **sheets):
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        page = book.create_sheet(name)
        for row in rows:
            page.append(row)
    book.save(path)


def test_a_spreadsheet(tmp_path):
    path = tmp_path / "torque.xlsx"
    rows = [["CA", "M1", None], ["deg", "Nm"], *zip(ANGLES, TORQUE, strict=True)]
    write_sheets(path, torque=[[*row] for row in rows], notes=[["bench", 7]])
    with pytest.raises(InputError, match="several sheets with cells: torque, notes"):
        read_torque_table(path, strokes=4, reading=TableReading(columns=BY_NAME))
    check(read_torque_table(path, strokes=4, reading=TableReading(columns=BY_NAME, sheet="torque")))


def test_a_spreadsheet_without_openpyxl_names_the_extra(tmp_path, monkeypatch):
    path = tmp_path / "torque.xlsx"
    write_sheets(path, torque=[["crank_angle_deg", "torque_Nm"], [0, 1]])
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(MissingLibraryError, match=r"pip install 'crankfem\[spreadsheets\]'"):
        read_torque_table(path)


def record(cycles, scatter=0.0, closing=True, restart=False):
    """Cycles one behind the other, each with its own gain about one; and their samples."""
    gains = 1.0 + scatter * np.linspace(-1.0, 1.0, cycles)
    parts, samples = [], []
    for number, gain in enumerate(gains):
        begin = 0.0 if restart else 720.0 * number
        values = 150.0 + gain * (TORQUE - 150.0)
        parts += [
            f"{begin + a!r},{t!r}" for a, t in zip(ANGLES.tolist(), values.tolist(), strict=True)
        ]
        samples.append(values)
        if closing and (restart or number == cycles - 1):
            parts.append(f"{begin + 720.0!r},{float(values[0])!r}")
    return "\n".join(["crank_angle_deg,torque_Nm", *parts]), np.array(samples)


@pytest.mark.parametrize("restart", [False, True])
@pytest.mark.parametrize("closing", [False, True])
def test_several_cycles_give_their_mean_and_tell_the_scatter(read, restart, closing):
    text, samples = record(9, 0.04, closing, restart)
    table = read(text)
    check(table)
    (remark,) = (remark for remark in table.remarks if "cycles" in remark)
    assert f"{np.max(np.std(samples, axis=0, ddof=1)):.3g} Nm" in remark


def test_an_incomplete_cycle_at_the_end_is_left_out_and_told(read):
    table = read(record(4, closing=False)[0].rsplit("\n", 100)[0])
    check(table)
    assert any("260 samples" in remark for remark in table.remarks)


def test_cycles_that_are_no_repetitions_are_refused(read):
    """The two revolutions of a four-stroke cycle are none of a two-stroke engine."""
    with refused("torque.csv"):
        read(lines(","), strokes=2)


def test_a_closing_row_that_differs_by_noise(read):
    noise = 0.3 * np.random.default_rng(3).standard_normal(ANGLES.size + 1)
    values = np.append(TORQUE, TORQUE[0]) + noise
    angles = np.append(ANGLES, 720.0)
    table = read(written(angles, values))
    assert table.torque[0] == close(0.5 * (values[0] + values[-1]), rel=1e-8)
    assert any("their mean is used" in remark for remark in table.remarks)
    assert not any("dropped" in remark for remark in table.remarks)
    with refused("torque_Nm"):
        read(written(angles, np.append(values[:-1], values[0] + 3.0)))


@pytest.mark.parametrize("begin", [0, 14, 100, 250])
def test_one_revolution_of_a_four_stroke_torque_is_no_cycle(read, begin):
    part = slice(begin, begin + 180) if begin <= 180 else slice(0, 180)
    values = np.roll(TORQUE, -max(begin - 180, 0))[part]
    text = written(STEP * np.arange(180), values)
    with pytest.raises(InputError, match="four-stroke"):
        read(text, strokes=None)
    assert any("close" in remark for remark in read(text, strokes=2).remarks)


def test_a_two_stroke_cycle_is_told_to_be_one(read):
    angles = np.arange(0.0, 360.0, 2.0)
    values = np.round(100.0 + 30.0 * np.sin(np.radians(3.0 * angles)), 6)
    table = read(written(angles, values), strokes=None)
    assert table.strokes == 2
    assert any("720 deg" in remark for remark in table.remarks)


def test_uneven_digitized_points_lie_on_a_spline(read):
    """Steps of 1 to 5 deg of orders up to 4.5: a cubic spline is within 5/384 h^4 max |f''''|."""
    draw = np.random.default_rng(5)
    angles = np.cumsum(draw.uniform(1.0, 5.0, 400))
    angles = np.round(angles[angles < 719.0], 3)
    table = read(written(angles, torque_at(angles)))
    slope = float(np.sum(np.array([40.0, 25.0, 90.0, 35.0, 12.0]) * ORDERS**4))
    gap = np.radians(np.max(np.diff(angles, append=angles[0] + 720.0)))
    bound = 5.0 / 384.0 * slope * gap**4
    assert np.max(np.abs(table.torque - torque_at(table.crank_angle_deg))) < bound
    assert any("uneven samples were replaced" in remark for remark in table.remarks)


def test_all_faults_are_told_at_once_with_the_cure(read):
    """No known header, gaps, a word for a number, and a line that is cut short."""
    kept = [
        line
        for line in THREE.split("\n")
        if not line.startswith(("100,", "102,", "104,", "106,", "108,"))
    ]
    kept[40] = kept[40].rsplit(";", 2)[0].rsplit(";", 1)[0]
    kept[60] = kept[60].replace(kept[60].split(";")[2], "overload")
    for columns, told in (
        (None, ["line 1: ", 'columns = { crank_angle_deg = "CA", torque_Nm =', "line 41: "]),
        (BY_NAME, ["line 41: ", 'torque_Nm: given "overload"']),
    ):
        with pytest.raises(InputError) as caught:
            read("\n".join(kept), columns)
        assert all(one in str(caught.value) for one in told)
    del kept[60], kept[40]
    with refused("crank_angle_deg"):
        read("\n".join(kept), BY_NAME)


@pytest.mark.parametrize(
    "columns",
    [
        {"crank_angle_deg": 1},
        {"crank_angle_deg": 1, "torque_Nm": 7},
        {"crank_angle_deg": 1, "torque_Nm": "M2"},
        {"crank_angle_deg": 1, "torque_kNm": 3},
        {"angle": 1, "torque_Nm": 3},
        {"crank_angle_deg": 1, "torque_Nm": 1},
    ],
)
def test_columns_that_are_not_there(read, columns):
    with pytest.raises(InputError, match=r"columns|torque_kNm"):
        read(THREE, columns)


def test_a_row_of_units_against_the_header_is_refused(read):
    with refused('"torque_Nm"'):
        read(lines(";").replace("torque_Nm\n", "torque_Nm\ndeg;kNm\n", 1))


@pytest.mark.parametrize(
    ("unit", "reference"),
    [
        ("bar(a)", "absolute"),
        ("bara", "absolute"),
        ("bar(g)", "gauge"),
        ("barg", "gauge"),
        ("bar ü", "gauge"),
    ],
)
def test_units_say_whether_a_pressure_is_absolute(tmp_path, unit, reference):
    angles = np.arange(-360.0, 360.0, 2.0)
    pressure = 2.0 + 100.0 * np.exp(-(((angles - 10.0) / 20.0) ** 2))
    rows = [f"{a:g};{p:.6f}" for a, p in zip(angles, pressure, strict=True)]
    for head in (["CA;p", f"deg;{unit}"], ["CA;p", f"[deg];[{unit}]"], [f"CA [deg];p [{unit}]"]):
        (tmp_path / "p.csv").write_text("\n".join([*head, *rows]), encoding="utf-8")
        for named in ("absolute", "gauge"):
            columns = {"crank_angle_deg": "CA", f"{named}_pressure_bar": "p"}
            reading = TableReading(columns=columns)
            if named == reference:
                assert read_pressure_table(tmp_path / "p.csv", 4, reading=reading).pressure.size
                continue
            with pytest.raises(InputError, match=f"but named {named}_pressure_bar"):
                read_pressure_table(tmp_path / "p.csv", 4, reading=reading)


def test_points_and_commas_before_decimals_are_refused(read):
    with pytest.raises(InputError, match="points and commas"):
        read(lines(";", comma).replace("\n10,0;", "\n10.0;"))


def test_an_indicator_record_with_its_own_top(tmp_path):
    """Names, units, decimal commas, three columns, 0 to 720 deg with the firing top at 360 deg."""
    rows = ["CA;PCYL1;PCYL2", "degCA;bar;bar"]
    for angle in np.arange(0.0, 720.0, 1.0):
        pressure = 2.0 + 100.0 * np.exp(-(((angle - 370.0) / 20.0) ** 2))
        rows.append(f"{comma(angle)};{comma(round(pressure, 6))};1,0")
    (tmp_path / "p.csv").write_text("\n".join(rows), encoding="utf-8")
    columns = {"crank_angle_deg": "CA", "absolute_pressure_bar": "PCYL1"}
    with refused("crank_angle_deg"):
        read_pressure_table(tmp_path / "p.csv", 4, reading=TableReading(columns=columns))
    found = read_pressure_table(
        tmp_path / "p.csv", 4, reading=TableReading(columns=columns, top=2.0 * np.pi)
    )
    assert found.peak_angle_deg == close(10.0)
    assert found.peak_pressure == close(102.0e5)
    assert any("'PCYL2'" in remark for remark in found.remarks)
