import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.harmonics import read_torque_table


@pytest.fixture
def written(tmp_path):
    def write(text):
        path = tmp_path / "torque.csv"
        path.write_text(text, encoding="utf-8")
        return path

    return write


CRANK = "# An engine\n# Source: a book\n\ncrank_angle_deg,torque_Nm\n"
CYCLE = "cycle_angle_deg,torque_Nm\n"


def test_crank_angles_show_the_strokes(written):
    four = read_torque_table(written(CRANK + "0,1\n180,2\n360,3\n540,4\n"))
    assert four.strokes == 4
    assert four.source == "An engine\nSource: a book"
    assert four.crank_angle_deg.tolist() == [0.0, 180.0, 360.0, 540.0]
    assert four.torque.tolist() == [1.0, 2.0, 3.0, 4.0]
    two = read_torque_table(written(CRANK + "0,1\n90,2\n180,3\n270,4\n"))
    assert two.strokes == 2


def test_closing_sample_is_dropped(written):
    table = read_torque_table(written(CRANK + "0,1\n180,2\n360,3\n540,4\n720,1\n"))
    assert table.strokes == 4
    assert table.torque.tolist() == [1.0, 2.0, 3.0, 4.0]


@pytest.mark.parametrize(("strokes", "last"), [(None, 480.0), (4, 480.0), (2, 240.0)])
def test_cycle_angles_are_turned_into_crank_angles(written, strokes, last):
    path = written(CYCLE + "0,1\n120,2\n240,3\n360,1\n")
    table = read_torque_table(path, strokes=strokes)
    assert table.crank_angle_deg.tolist() == [0.0, last / 2.0, last]


def test_harmonics_count_from_crank_angle_zero(written):
    angles = np.arange(-360.0, 360.0, 60.0)
    torques = np.sin(np.radians(angles) + 0.4)
    rows = [f"{angle},{torque:.15g}" for angle, torque in zip(angles, torques, strict=True)]
    found = read_torque_table(written(CRANK + "\n".join(rows))).harmonics()
    assert found.amplitude[1] == close(1.0)
    assert found.phase[1] == close(0.4)


def test_byte_order_mark_and_windows_lines_are_accepted(tmp_path):
    path = tmp_path / "torque.csv"
    path.write_bytes(b"\xef\xbb\xbf" + CYCLE.encode() + b"0,1\r\n120,2\r\n240,3\r\n")
    assert read_torque_table(path).torque.size == 3


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no header; allowed is"),
        ("angle,torque\n0,1\n", 'line 1: given the header "angle,torque"; allowed is'),
        ("0,1\n", 'line 1: given the header "0,1"; allowed is'),
        (CRANK, "given 0 samples; allowed are 3 or more"),
        (CRANK + "0,1\n360,2\n", "given 2 samples"),
        (CRANK + "0,1\n180;2\n", 'line 6: given "180;2"; allowed are two numbers'),
        (CRANK + "0,1\n180,2,5\n", 'line 6: given "180,2,5"; allowed are two numbers'),
        (CRANK + "0,1\n180,two\n", 'line 6: torque_Nm: given "two"; allowed are finite numbers'),
        (CRANK + "0,1\nnan,2\n", 'line 6: crank_angle_deg: given "nan"'),
        (CRANK + "0,1\n180,inf\n", 'line 6: torque_Nm: given "inf"'),
        (CRANK + "0,1\n180,2\n# x\n180,3\n", "line 8: crank_angle_deg: given 180 deg after 180"),
        (CRANK + "0,1\n180,2\n350,3\n540,4\n", r"line \d: crank_angle_deg.*allowed are even steps"),
        (CRANK + "0,1\n90,2\n180,3\n", "line 7: .*allowed is one cycle of 720 deg or 360 deg"),
        (CYCLE + "0,1\n240,2\n480,3\n", "line 4: .*allowed is one cycle of 360 deg,"),
        (CYCLE + "0,1\n120,2\n240,3\n360,1.1\n", "line 5: torque_Nm: given 1.1 for the closing"),
    ],
)
def test_unusable_tables_are_refused_with_file_and_line(written, text, message):
    path = written(text)
    with pytest.raises(InputError, match=message) as raised:
        read_torque_table(path)
    assert str(raised.value).startswith(str(path))
    assert "\n" not in str(raised.value)


def test_strokes_must_agree_with_the_crank_angles(written):
    with pytest.raises(InputError, match="allowed is one cycle of 360 deg,"):
        read_torque_table(written(CRANK + "0,1\n180,2\n360,3\n540,4\n"), strokes=2)


def test_missing_and_unreadable_files_are_named(tmp_path):
    with pytest.raises(InputError, match=r"absent\.csv: cannot be read as a torque table"):
        read_torque_table(tmp_path / "absent.csv")
    path = tmp_path / "binary.csv"
    path.write_bytes(b"\x80\xfe\x00\xd8")
    with pytest.raises(InputError, match=r"binary\.csv: .*line 1 is not UTF-8"):
        read_torque_table(path)
