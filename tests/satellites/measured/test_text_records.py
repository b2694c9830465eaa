"""Records in text: what is printed, and what is taken of it."""

import math
import re

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.satellites.measured.records import builder, text
from crankfem.satellites.measured.records.reading import read_record

WHEEL = 0.01 * np.arange(40.0) - 0.2


def written(folder, content, name="record.csv"):
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def table(header, *columns, formats="%.9f", separator=","):
    rows = [
        separator.join(
            (formats if isinstance(formats, str) else formats[k]) % x for k, x in enumerate(row)
        )
        for row in zip(*columns, strict=True)
    ]
    return "\n".join([*([header] if header else []), *rows, ""])


def test_even_times_are_start_and_step_and_not_what_is_printed(tmp_path):
    times = np.arange(4000) / 48000.0
    path = written(
        tmp_path, table("Time [s],wheel [mV]", times, np.sin(times), formats=("%.7f", "%.9f"))
    )
    record = read_record(path)
    wheel = record.channel("wheel")
    assert (wheel.axis, wheel.start, 1.0 / wheel.step) == ("time", 0.0, close(48000.0, rel=1e-12))
    assert np.max(np.abs(wheel.abscissa() - times)) < 1e-15
    assert wheel.si() == close(1e-3 * np.sin(times), abs=1e-12)
    assert "errors up to 5e-08 s" in record.notes[0]
    assert "48000 samples a second" in record.notes[0]


def test_uneven_times_stay_as_they_are_printed(tmp_path):
    edges = np.array([0.0, 0.00051234, 0.00101234, 0.00161])
    record = read_record(written(tmp_path, table("Time [s],Channel 0", edges, [1, 0, 1, 0])))
    level = record.channel("Channel 0")
    assert level.abscissa() == close(edges, abs=1e-12)
    assert level.values.tolist() == [1, 0, 1, 0]
    assert level.step is None


def test_pulse_times_with_too_few_digits_are_refused(tmp_path):
    """At 120 s six digits leave 1 ms of pulses that are 0.3 ms apart."""
    pulses = 120.0 + np.cumsum(3e-4 + 1e-5 * np.sin(np.arange(40.0)))
    path = written(tmp_path, table("t [s],level", pulses, np.ones(40), formats=("%.3f", "%.0f")))
    with pytest.raises(InputError, match=r"errors up to 0.0005 s.*usual step is 0 s and 27 of 40"):
        read_record(path)


@pytest.mark.parametrize("mark", [".", ","])
def test_a_column_of_pulse_times_alone(tmp_path, mark):
    path = written(tmp_path, f"pulse_time_s\n0{mark}001\n0{mark}002\n0{mark}0035001\n")
    (pulses,) = read_record(path).channels
    assert (pulses.name, pulses.unit, pulses.axis) == ("pulse_time", "s", "none")
    assert pulses.si().tolist() == [0.001, 0.002, 0.0035001]
    assert read_record(path).channel("pulse_time_s") is not None


def test_pulse_times_without_a_number_are_counted(tmp_path):
    rows = ["0.001001,1", "nan,2", "0.003,3", ",4", "nan,5", "0.006,6", ",7", ",8"]
    path = written(tmp_path, "\n".join(["pulse_time_s,count", *rows, ""]))
    record = read_record(path)
    assert record.channel("pulse_time").si().tolist() == [0.001001, 0.003, 0.006]
    # Behind the last one the column has ended.
    assert "pulse_time: 3 rows without a number are left out." in record.notes


def test_decimal_commas_a_row_of_units_and_another_order_of_columns(tmp_path):
    path = written(
        tmp_path,
        "Prüfstand 3\nDrehmoment;Zeit;n;p Zyl\n[kNm];[ms];[U/min];[bar(g)]\n"
        "1,5;0,0;600;1,0\n1,6;0,1;601;1,5\n1,7;0,2;602;2,0\n".encode("cp1252"),
    )
    record = read_record(path)
    assert [each.name for each in record.channels] == ["Drehmoment", "n", "p Zyl"]
    torque, speed, pressure = record.channels
    assert torque.abscissa() == close([0.0, 1e-4, 2e-4], abs=1e-15)
    assert torque.si().tolist() == close([1500.0, 1600.0, 1700.0])
    assert speed.si()[0] == close(600.0 * math.pi / 30.0)
    assert (pressure.reference, pressure.si()[1]) == ("gauge", 1.5e5)
    assert "p Zyl: is a pressure above the atmosphere, by its unit bar(g)." in record.notes


@pytest.mark.parametrize(
    ("heading", "unit", "size"),
    [
        ("M [Nm]", "N m", 1.0),
        ("M_kNm", "N m", 1e3),
        ("n / U/min", "rad/s", math.pi / 30.0),
        ("n (min-1)", "rad/s", math.pi / 30.0),
        ("p [bar(g)]", "Pa", 1e5),
        ("x [mil]", "m", 25.4e-6),
        ("f [cpm]", "Hz", 1.0 / 60.0),
        ("U [mV]", "V", 1e-3),
    ],
)
def test_units_of_headings(tmp_path, heading, unit, size):
    path = written(tmp_path, table(f"t [s],{heading}", WHEEL + 0.2, WHEEL))
    (channel,) = read_record(path).channels
    assert channel.name == heading[0]
    assert channel.si_unit == unit
    assert channel.si() == close(size * WHEEL, abs=1e-12 * size)


def test_an_unknown_unit_is_named_and_can_be_given(tmp_path):
    path = written(tmp_path, table("t [s],M [bananas]", WHEEL + 0.2, WHEEL))
    record = read_record(path)
    (channel,) = record.channels
    assert channel.name == "M [bananas]"
    with pytest.raises(InputError, match="its unit is unknown; say it"):
        channel.si()
    (channel,) = read_record(path, units={"M [bananas]": "kNm"}).channels
    assert channel.si() == close(1e3 * WHEEL)


def test_without_header_columns_are_named(tmp_path):
    path = written(tmp_path, table("", WHEEL, WHEEL + 0.2))
    record = read_record(path)
    assert "no header" in record.notes[0]
    with pytest.raises(InputError, match="has no time and no angle"):
        record.channel("column 1").abscissa()
    (wheel,) = read_record(path, columns={"wheel_V": 1, "time_s": 2}).channels
    assert (wheel.name, wheel.unit, 1.0 / wheel.step) == ("wheel", "V", close(100.0))
    with pytest.raises(InputError, match=r"given wheel_V = 3, which is none.*1 to 2"):
        read_record(path, columns={"wheel_V": 3})


def test_a_wheel_in_volts_alone_needs_its_rate(tmp_path):
    path = written(tmp_path, table("wheel [V]", WHEEL))
    with pytest.raises(InputError, match="say the rate of its samples"):
        read_record(path).channels[0].abscissa()
    (wheel,) = read_record(path, rate=50000.0).channels
    assert wheel.abscissa() == close(np.arange(40) / 50000.0, abs=1e-18)


def test_a_rate_that_is_another_than_that_of_the_file_is_refused(tmp_path):
    path = written(tmp_path, table("t [s],wheel [V]", WHEEL + 0.2, WHEEL))
    with pytest.raises(InputError, match=r"given the rate 200 1/s.*100 a second, 2 times apart"):
        read_record(path, rate=200.0)


def test_a_channel_that_has_ended_is_not_continued(tmp_path):
    path = written(tmp_path, "t [s],a,b\n0,1,5\n1,2,6\n2,3,\n3,4,\n")
    record = read_record(path)
    assert record.channel("a").values.tolist() == [1, 2, 3, 4]
    assert record.channel("b").values.tolist() == [5, 6]
    assert record.channel("b").abscissa().tolist() == [0, 1]


def test_over_the_crank_angle_also_one_that_begins_again(tmp_path):
    angles = np.arange(0.0, 1440.0, 30.0)
    path = written(tmp_path, table("°KW [deg],p [bar]", angles % 720.0, angles, formats="%.1f"))
    (pressure,) = read_record(path).channels
    assert (pressure.axis, pressure.start, pressure.step) == ("angle", 0.0, close(np.pi / 6.0))
    assert pressure.abscissa() == close(np.radians(angles), abs=1e-12)


def test_angles_in_radians_that_are_labeled_degrees(tmp_path):
    angles = np.radians(np.arange(-360.0, 360.0))
    path = written(tmp_path, table("crank angle [deg],p [bar]", angles, angles, formats="%.5f"))
    record = read_record(path)
    assert record.channels[0].abscissa() == close(angles, abs=1e-5)
    assert re.search(r"is taken in rad, not in deg: .* it is turns in rad alone", record.notes[0])
    kept = read_record(path, units={"angle": "deg"}).channels[0]
    assert kept.abscissa() == close(np.radians(angles), abs=1e-5)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("t [s],a\n0,1\n1,x\n2,3\n", r'line 3: a: given "x"; allowed are finite numbers'),
        ("t [s],a\n0,1\n2,1\n1,3\n", r"given 1 s after 2 s in sample 3"),
        ("t [s],a\n", "has no numbers"),
        (b"\xff\xfet\x00", "is text in UTF-16; save it as UTF-8"),
        (b"PK\x03\x04", "is a packed file, such as one of a spreadsheet"),
    ],
)
def test_what_is_wrong_is_told(tmp_path, content, told):
    with pytest.raises(InputError, match=told):
        read_record(written(tmp_path, content))


def test_no_file(tmp_path):
    with pytest.raises(InputError, match="does not exist; allowed is the path of a record"):
        read_record(tmp_path / "none.csv")
    with pytest.raises(InputError, match="is a folder"):
        read_record(tmp_path)


@pytest.mark.parametrize("mark", [".", ","])
def test_a_large_text_is_read_in_pieces(tmp_path, monkeypatch, mark):
    times = np.arange(5000) / 48000.0
    content = table("t [s];wheel [V]", times, np.sin(1e3 * times), separator=";")
    path = written(tmp_path, content.replace(".", mark))
    whole = read_record(path).channel("wheel")
    monkeypatch.setattr(text, "MOST_IN_MEMORY", 1000)
    monkeypatch.setattr(builder, "MOST_IN_MEMORY", 1000)
    monkeypatch.setattr(text, "HEAD", 4096)
    monkeypatch.setattr(text, "TAIL", 1024)
    monkeypatch.setattr(text, "LINES", 500)
    assert len(read_record(path).channel("wheel")) == 5000
    pieces = [*read_record(path).channel("wheel").pieces(777)]
    assert [values.size for _, values in pieces] == [*6 * [777], 338]
    assert np.concatenate([values for _, values in pieces]).tolist() == whole.values.tolist()
    places = np.concatenate([places for places, _ in pieces])
    assert np.array_equal(places, whole.abscissa())
    assert read_record(path).channel("wheel").rate == 48000.0
    path.write_bytes(
        path.read_bytes().replace(re.findall(rb"\n(0\S+;)", path.read_bytes())[2], b";")
    )
    with pytest.raises(InputError, match=r'line 4: t \[s\]: given ""'):
        [*read_record(path).channel("wheel").pieces()]


def test_so_are_those_of_a_column_alone(tmp_path):
    path = written(tmp_path, table("pulse_time_s", 120.0 + 3e-4 * np.arange(40.0), formats="%.5e"))
    with pytest.raises(InputError, match=r"pulse_time: given uneven places.*errors up to 0.0005 s"):
        read_record(path)


def test_times_that_may_be_exact_are_taken_with_their_error(tmp_path):
    record = read_record(written(tmp_path, "pulse_time_s\n0.01\n0.02\n0.03\n0.06\n0.07\n"))
    assert record.notes == (
        "pulse_time: has errors up to 0.005 s by their digits, unless they are exact.",
    )


def test_a_heading_that_is_repeated_is_numbered(tmp_path):
    record = read_record(written(tmp_path, table("t_s,p,p", WHEEL + 0.2, WHEEL, 2.0 * WHEEL)))
    assert [each.name for each in record.channels] == ["p", "p #2"]
    assert record.channel("p #2").values[0] == 2.0 * WHEEL[0]


def test_columns_of_pulse_times_need_not_have_one_length(tmp_path):
    record = read_record(
        written(tmp_path, "pulse_time_a_s;pulse_time_b_s\n0.1001;0.2001\n0.3001;\n0.5001;\n")
    )
    assert [each.values.tolist() for each in record.channels] == [
        [0.1001, 0.3001, 0.5001],
        [0.2001],
    ]


def test_text_behind_the_beginning_may_be_in_another_encoding(tmp_path, monkeypatch):
    monkeypatch.setattr(text, "HEAD", 64)
    monkeypatch.setattr(text, "TAIL", 64)
    content = table("t [s],a", WHEEL + 0.2, WHEEL) + "# Prüfstand\n"
    (channel,) = read_record(written(tmp_path, content.encode("cp1252"))).channels
    assert len(channel) == 40


def test_each_channel_is_over_the_time_before_it(tmp_path):
    """As oscilloscopes write channels of several rates side by side."""
    record = read_record(
        written(tmp_path, "time 1 [s],a,time 2 [s],b\n0,1,0.5,5\n1,2,2.5,6\n2,3,4.5,7\n3,4,,\n")
    )
    assert record.channel("a").abscissa().tolist() == [0.0, 1.0, 2.0, 3.0]
    assert record.channel("b").abscissa().tolist() == [0.5, 2.5, 4.5]
    assert "Each channel is over the column of time before it, of 2." in record.notes
