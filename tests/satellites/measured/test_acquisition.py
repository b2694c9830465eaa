"""Records of data acquisition: what their libraries give by default, and what is taken here."""

import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.satellites.measured.records.reading import read_record
from satellites.measured.written_records import mdf, tdms, uff

TIME, ANGLE = 1, 2
WAVE = np.sin(0.1 * np.arange(2001.0))


def waveform(step, count, **more):
    return {"wf_increment": step, "wf_samples": count, "wf_start_offset": 0.0} | more


@pytest.mark.slow
def test_two_rates_of_tdms_share_their_instants(tmp_path):
    """nptdms gives 15 of 101 of them apart, by round-off."""
    path = tdms(
        tmp_path / "record.tdms",
        {
            ("g", "fast"): (np.zeros(20001), waveform(1e-4, 20001)),
            ("g", "slow"): (np.zeros(2001), waveform(1e-3, 2001)),
        },
    )
    record = read_record(path)
    fast, slow = (record.channel(name).abscissa() for name in ("fast", "slow"))
    assert np.array_equal(fast[::10], slow)


def test_an_offset_shifts_a_tdms_channel_and_may_be_absent(tmp_path):
    shifted, plain = waveform(1e-3, 5, wf_start_offset=0.25), waveform(1e-3, 5)
    del plain["wf_start_offset"]
    later = waveform(1e-3, 5) | {"wf_start_time": np.datetime64("2026-01-02T03:04:05.500", "us")}
    first = waveform(1e-3, 5) | {"wf_start_time": np.datetime64("2026-01-02T03:04:05.000", "us")}
    path = tdms(
        tmp_path / "record.tdms",
        {
            ("g", name): (np.zeros(5), facts)
            for name, facts in {"a": shifted, "b": plain, "later": later, "first": first}.items()
        },
    )
    record = read_record(path)
    starts = {each.name: each.abscissa()[0] for each in record.channels}
    assert starts == {"a": 0.25, "b": 0.0, "later": close(0.5, abs=1e-9), "first": 0.0}


@pytest.mark.parametrize("status", ["unscaled", "scaled"])
def test_scales_of_tdms_are_applied_where_the_file_has_raw_numbers(tmp_path, status):
    facts = waveform(1e-3, 3, unit_string="kNm", NI_Scaling_Status=status) | {
        "NI_Number_Of_Scales": 1,
        "NI_Scale[0]_Scale_Type": "Linear",
        "NI_Scale[0]_Linear_Slope": 0.5,
        "NI_Scale[0]_Linear_Y_Intercept": 1.0,
        "NI_Scale[0]_Linear_Input_Source": 0xFFFFFFFF,
    }
    numbers = np.array([0, 2, 4], dtype=np.int16)
    path = tdms(tmp_path / "record.tdms", {("g", "M"): (numbers, facts)})
    torque = read_record(path).channel("M")
    assert torque.values.tolist() == ([1.0, 2.0, 3.0] if status == "unscaled" else [0.0, 2.0, 4.0])
    assert torque.si_unit == "N m"


def test_raw_numbers_of_tdms_without_scales_have_no_unit(tmp_path):
    facts = waveform(1e-3, 3, unit_string="V", NI_Scaling_Status="unscaled")
    path = tdms(tmp_path / "record.tdms", {("g", "U"): (np.arange(3, dtype=np.int16), facts)})
    record = read_record(path)
    assert record.channel("U").unit == ""
    assert "does not scale" in record.notes[0]


def test_a_name_in_two_groups_asks_which(tmp_path):
    path = tdms(
        tmp_path / "record.tdms",
        {(group, "M"): (np.zeros(3) + k, waveform(1e-3, 3)) for k, group in enumerate(("A", "B"))},
    )
    record = read_record(path)
    with pytest.raises(InputError, match=r"'M', of which there are 2, in the groups 'A', 'B'; say"):
        record.channel("M")
    assert record.channel("M", "B").values[0] == 1.0
    assert repr(record).startswith("Record(format TDMS, names (M, M), path ")
    assert (
        repr(record.channels[1]) == "Channel(name M, group B, axis time, samples 3, rate 1000 1/s)"
    )
    with pytest.raises(InputError, match=r"not there; did you mean M"):
        record.channel("Mm")


@pytest.mark.slow
def test_masters_of_mdf_are_time_and_angle_and_never_one_table(tmp_path):
    """A table of all has top dead center at 360, or 6.283, and mixes seconds with angles."""
    angles = np.arange(-360.0, 361.0, 1.0)
    peak = np.exp(-(((angles - 12.0) / 20.0) ** 2))
    path = mdf(
        tmp_path / "record.mf4",
        ([("p", "bar", peak)], angles, ("a", ANGLE), "indicating"),
        ([("n", "U/min", [1500.0, 1501.0])], [7.0, 7.5], ("t", TIME), "slow"),
    )
    record = read_record(path)
    pressure, speed = record.channel("p"), record.channel("n")
    assert (pressure.axis, pressure.axis_unit, pressure.group) == ("angle", "deg", "indicating")
    assert np.degrees(pressure.abscissa()[np.argmax(pressure.values)]) == close(12.0)
    assert (speed.axis, speed.abscissa().tolist(), len(speed)) == ("time", [7.0, 7.5], 2)


@pytest.mark.parametrize("end", [720.0, 4.0 * math.pi])
@pytest.mark.parametrize("closed", [True, False])
def test_a_master_in_radians_may_be_labeled_degrees(tmp_path, end, closed):
    """asammdf labels each angle deg, while the standard asks for radians."""
    angles = np.linspace(0.0, end, 721)[: 721 if closed else 720]
    path = mdf(tmp_path / "record.mf4", ([("p", "bar", angles)], angles, ("a", ANGLE), "g"))
    record = read_record(path)
    assert record.channel("p").abscissa()[360] == close(2.0 * math.pi)
    assert record.channel("p").axis_unit == ("deg" if end == 720.0 else "rad")
    assert len(record.notes) == (end != 720.0)
    assert all("it is turns in rad alone" in note for note in record.notes)


def test_a_channel_of_mdf_that_has_ended_is_not_held_on(tmp_path):
    """A table of asammdf holds the last value of a channel as long as any other lasts."""
    path = mdf(
        tmp_path / "record.mf4",
        ([("short", "N m", [0.0, 10.0])], [0.0, 1.0], ("t", TIME), "a"),
        ([("long", "N m", np.ones(5))], [0.0, 0.5, 1.0, 2.0, 3.0], ("t", TIME), "b"),
    )
    record = read_record(path)
    assert record.channel("short").abscissa().tolist() == [0.0, 1.0]
    assert record.channel("long").abscissa().tolist() == [0.0, 0.5, 1.0, 2.0, 3.0]


def test_invalid_samples_of_mdf_are_left_out(tmp_path):
    from asammdf import MDF, Signal

    with MDF(version="4.10") as file:
        invalid = np.array([False, True, False, False])
        file.append(
            [Signal(np.arange(4.0), np.arange(4.0), name="M", unit="Nm", invalidation_bits=invalid)]
        )
        file.save(tmp_path / "record.mf4")
    torque = read_record(tmp_path / "record.mf4").channel("M")
    assert torque.values.tolist() == [0.0, 2.0, 3.0]
    assert torque.abscissa().tolist() == [0.0, 2.0, 3.0]


def test_uff_with_another_count_of_numbers_than_its_header_is_refused(tmp_path):
    """As pyuff writes single precision in binary form."""
    more = {"ord_data_type": 2, "binary": 1}
    path = uff(tmp_path / "r.uff", ("M", "Nm", np.arange(7.0), WAVE[:7], more), force_double=False)
    with pytest.raises(InputError, match="M: has 14 numbers and a header of 7"):
        read_record(path)


def test_an_mdf_that_was_not_finished_is_read_and_left_as_it_is(tmp_path):
    """As after a loss of power: the count of samples is still to be updated."""
    path = mdf(tmp_path / "record.mf4", ([("M", "Nm", WAVE)], np.arange(2001.0), ("t", TIME), "g"))
    content = bytearray(path.read_bytes())
    content[:8], content[60:62] = b"UnFinMF ", b"\x01\x00"
    path.write_bytes(content)
    assert read_record(path).channel("M").values.tolist() == WAVE.tolist()
    assert path.read_bytes() == content


@pytest.mark.slow
def test_even_times_of_uff_have_six_digits(tmp_path):
    """By pyuff the times are 96 us off after 60 s at 48 kHz; a whole rate fits the digits."""
    times = np.arange(48000) / 48000.0
    path = uff(tmp_path / "record.uff", ("M", "kNm", times, np.sin(times), {"binary": 1}))
    record = read_record(path)
    torque = record.channel("M")
    assert (torque.start, 1.0 / torque.step) == (0.0, close(48000.0, rel=1e-14))
    assert torque.si() == close(1e3 * np.sin(times), abs=1e-9)
    assert "errors up to 2.4e-06 s by their digits; 48000 samples a second" in record.notes[0]
    with pytest.raises(InputError, match="given the rate 24000 1/s"):
        read_record(path, rate=24000.0)
    assert 1.0 / read_record(path, rate=48000.1).channel("M").step == close(48000.1)


def test_uneven_times_of_uff_text_are_refused_for_pulses(tmp_path):
    """20 pulse times at 120 s become one."""
    pulses = 120.0 + np.cumsum(1e-5 * (3.0 + np.sin(np.arange(20.0))))
    text = uff(tmp_path / "t.uff", ("tooth", "", pulses, np.ones(20), {"abscissa_spacing": 0}))
    with pytest.raises(InputError, match=r"errors up to 0.0005 s by their digits.*of 20 fall tog"):
        read_record(text)
    more = {"abscissa_spacing": 0, "binary": 1}
    binary = uff(tmp_path / "b.uff", ("tooth", "", pulses, np.ones(20), more))
    assert read_record(binary).channel("tooth").abscissa().tolist() == pulses.tolist()
    values = uff(tmp_path / "v.uff", ("pulse_time", "s", np.arange(20.0), pulses, {}))
    assert read_record(values).channel("pulse_time").si() == close(pulses, abs=1e-9)


@pytest.mark.parametrize("kind", ["tdms", "uff"])
def test_what_is_damaged_is_told(tmp_path, kind):
    write = {
        "tdms": lambda path: tdms(path, {("g", "M"): (WAVE, waveform(1e-3, 2001))}),
        "uff": lambda path: uff(path, ("M", "N m", np.arange(2001.0), WAVE, {})),
    }
    path = write[kind](tmp_path / f"record.{kind}")
    path.write_bytes(path.read_bytes()[: {"tdms": 40, "uff": 300}[kind]])
    with pytest.raises(InputError, match=r"cannot be read as|no channels of numbers"):
        read_record(path)


def test_a_missing_package_is_named_with_its_extra(tmp_path, monkeypatch):
    import sys

    from crankbase.errors import MissingLibraryError

    path = tdms(tmp_path / "record.tdms", {("g", "M"): (WAVE, waveform(1e-3, 2001))})
    monkeypatch.setitem(sys.modules, "nptdms", None)
    with pytest.raises(MissingLibraryError, match=r"nptdms: pip install 'crankfem\[measured\]'"):
        read_record(path)
