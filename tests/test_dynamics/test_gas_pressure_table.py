import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.gas.pressure import read_pressure_table

BAR = "crank_angle_deg,absolute_pressure_bar"


@pytest.fixture
def written(tmp_path):
    def write(text):
        path = tmp_path / "pressure.csv"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def bar(angle, cycle=720.0, peak=8.0):
    """A pressure [bar] with its peak at an angle [deg]."""
    return 2.0 + 118.0 * np.exp(-40.0 * np.sin((angle - peak) * np.pi / cycle) ** 2)


def rows(angles, values):
    return "".join(f"{float(a)!r},{float(p)!r}\n" for a, p in zip(angles, values, strict=True))


def table(angles, values, header=BAR, comments="# Engine X\n# Indicated at rated load\n"):
    return f"{comments}{header}\n{rows(angles, values)}"


@pytest.mark.parametrize(
    ("start", "cycle"), [(0.0, 720.0), (-360.0, 720.0), (-180.0, 360.0), (0.0, 360.0)]
)
@pytest.mark.parametrize("closed", [False, True])
def test_cycle_may_start_anywhere_and_may_be_closed(written, start, cycle, closed):
    angles = np.arange(start, start + cycle + (1.0 if closed else 0.0), 1.0)
    found = read_pressure_table(written(table(angles, bar(angles, cycle))))
    assert found.strokes == cycle / 180.0
    assert found.source == "Engine X\nIndicated at rated load"
    assert found.pressure.size == cycle
    assert found.peak_pressure == close(120e5)
    assert found.peak_angle_deg == close(8.0)
    assert found.pressure == close(1e5 * bar(found.angles_deg, cycle))
    dropped = (f"The closing sample at {start + cycle:g} deg was dropped.",)
    assert found.remarks == (dropped if closed else ())


@pytest.mark.parametrize(("unit", "size"), [("bar", 1e5), ("MPa", 1e6), ("kPa", 1e3), ("Pa", 1.0)])
@pytest.mark.parametrize("kind", ["absolute", "gauge"])
def test_units_and_kinds_of_pressure_give_the_same(written, unit, size, kind):
    angles = np.arange(-360.0, 360.0, 2.0)
    pascal = 1e5 * bar(angles) - (101325.0 if kind == "gauge" else 0.0)
    header = f"crank_angle_deg,{kind}_pressure_{unit}"
    found = read_pressure_table(written(table(angles, pascal / size, header)))
    # Round-off of unit and atmosphere, at the least pressure.
    assert found.pressure == close(1e5 * bar(found.angles_deg), rel=1e-12)
    said = ("101325 Pa of atmosphere were added to the gauge pressure.",)
    assert found.remarks == (said if kind == "gauge" else ())


def test_uneven_angles_are_resampled_and_said(written):
    angles = np.concatenate([np.arange(-360.0, -30.0, 5.0), np.arange(-30.0, 60.0, 1.0)])
    angles = np.concatenate([angles, np.arange(60.0, 360.0, 5.0)])
    found = read_pressure_table(written(table(angles, bar(angles))))
    assert "uneven samples were replaced" in found.remarks[0]
    assert found.peak_pressure == close(120e5)
    assert found.at(angle_deg=angles) == close(1e5 * bar(angles), rel=2e-3)


def test_closing_sample_may_differ_by_what_is_printed(written):
    angles = np.arange(0.0, 721.0, 1.0)
    values = bar(angles)
    values[-1] += 0.1
    assert read_pressure_table(written(table(angles, values))).pressure.size == 720


def test_motored_cycle_is_read(written):
    angles = np.arange(-360.0, 360.0, 1.0)
    values = 1.0 + 34.0 * np.exp(-40.0 * np.sin((angles + 0.7) * np.pi / 720.0) ** 2)
    found = read_pressure_table(written(table(angles, values)))
    assert found.peak_angle_deg == close(-1.0)


ANGLES = np.arange(0.0, 720.0, 5.0)
VALUES = bar(ANGLES, peak=10.0)


def changed(index, value):
    values = VALUES.copy()
    values[index] = value
    return table(ANGLES, values)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", 'no header; allowed is "crank_angle_deg,absolute_pressure_bar" or the like'),
        ("crank_angle_deg,pressure\n0,1\n", 'line 1: given the header "crank_angle_deg,pressure"'),
        ("crank_angle_deg,absolute_pressure_psi\n", "line 1: given the header"),
        (BAR + "\n", "given 0 samples; allowed are 3 or more, over a whole cycle"),
        (BAR + "\n0,1\n1;2\n", 'line 3: given "1;2"; allowed are two numbers'),
        (BAR + "\n0,1\n1,high\n", 'line 3: absolute_pressure_bar: given "high"; allowed are fin'),
        (BAR + "\n0,1\n0,2\n5,3\n", "line 3: crank_angle_deg: given 0 deg after 0 deg"),
        (BAR + "\n0,1\n5,2\n6,3\n", "line 4: .*allowed is one cycle of 720 deg or 360 deg"),
        (table(ANGLES[:-4], VALUES[:-4]), "line 143: .* given angles from 0 to 695 deg"),
        (table(np.append(ANGLES, 730.0), np.append(VALUES, 2.0)), "from 0 to 730 deg"),
        (
            table(np.append(ANGLES, 720.0), np.append(VALUES, VALUES[0] + 1.0)),
            "line 148: absolute_pressure_bar: given .* for the closing sample; allowed is the .* of "
            "line 4",
        ),
        (
            table(np.delete(ANGLES, [50, 51]), np.delete(VALUES, [50, 51])),
            "line 54: crank_angle_deg: given 260 deg after 245 deg; allowed are gaps of 10 deg",
        ),
        (changed(90, 0.0), "line 94: absolute_pressure_bar: given 0; allowed is what gives"),
        (changed(90, -0.5), "line 94: absolute_pressure_bar: given -0.5"),
        (table(ANGLES, VALUES / 1e3), "line 6: .* given a peak of 0.12, which is 0.012 MPa"),
        (table(ANGLES, VALUES * 1e3), "line 6: .*because any other comes from a wrong unit"),
        (
            table(ANGLES, bar(ANGLES, peak=370.0)),
            "line 78: crank_angle_deg: given the highest pressure at 370 deg; allowed is a peak "
            "from -10 to 40 deg, .*; the table looks shifted by 360 deg",
        ),
        (table(ANGLES, bar(ANGLES, peak=100.0)), r"highest pressure at 100 deg; .* center\.$"),
    ],
)
def test_unusable_tables_are_refused_with_file_and_line(written, text, message):
    path = written(text)
    with pytest.raises(InputError, match=message) as raised:
        read_pressure_table(path)
    assert str(raised.value).startswith(str(path))
    assert "\n" not in str(raised.value)


def test_gauge_pressure_below_vacuum_is_refused(written):
    values = VALUES.copy()
    values[90] = -1.02
    path = written(table(ANGLES, values, "crank_angle_deg,gauge_pressure_bar"))
    with pytest.raises(InputError, match=r"line 94: gauge_pressure_bar: given -1\.02"):
        read_pressure_table(path)


def test_strokes_must_agree_with_the_angles(written):
    path = written(table(ANGLES, VALUES))
    assert read_pressure_table(path, 4).strokes == 4
    with pytest.raises(InputError, match="allowed is one cycle of 360 deg,"):
        read_pressure_table(path, 2)
    with pytest.raises(InputError, match="strokes: given 3"):
        read_pressure_table(path, 3)


def test_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"absent\.csv: cannot be read as a pressure table"):
        read_pressure_table(tmp_path / "absent.csv")
