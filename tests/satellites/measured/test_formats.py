"""The same record in all formats, and structures of Matlab, HDF5 and Parquet."""

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.satellites.measured.measurement import load
from crankfem.satellites.measured.records.reading import read_record
from satellites.measured.written_records import hdf5, mat73, mdf, parquet, tdms, uff

RATE = 50000.0
TIMES = np.arange(5000) / RATE
WHEEL = np.sin(2.0 * np.pi * 730.0 * TIMES) + 0.1 * np.cos(91.0 * TIMES)


def text(path, times, wheel):
    np.savetxt(path, np.c_[times, wheel], delimiter=",", header="t [s],wheel [V]", comments="")
    return path


def mat5(path, times, wheel):
    from scipy.io import savemat

    savemat(path, {"t": times, "wheel": wheel, "wheel_unit": "V"})
    return path


FORMATS = {
    "csv": text,
    "tdms": lambda path, times, wheel: tdms(
        path, {("g", "wheel"): (wheel, {"wf_increment": times[1], "unit_string": "V"})}
    ),
    "mf4": lambda path, times, wheel: mdf(path, ([("wheel", "V", wheel)], times, ("t", 1), "g")),
    "uff": lambda path, times, wheel: uff(path, ("wheel", "V", times, wheel, {"binary": 1})),
    "mat": mat5,
    "h5": lambda path, times, wheel: hdf5(path, {"wheel": (wheel, {"unit": "V", "dt": times[1]})}),
    "parquet": lambda path, times, wheel: parquet(path, {"t_s": times, "wheel_V": wheel}),
}


@pytest.mark.parametrize("kind", [*FORMATS])
def test_the_same_record_in_each_format(tmp_path, kind):
    path = FORMATS[kind](tmp_path / f"record.{kind}", TIMES, WHEEL)
    record = read_record(path, units={"time": "s"} if kind == "mat" else None)
    (wheel,) = record.channels
    assert (wheel.name, wheel.unit, wheel.axis) == ("wheel", "V", "time")
    assert np.max(np.abs(wheel.si() - WHEEL)) < 1e-9
    assert np.max(np.abs(wheel.abscissa() - TIMES)) < 1e-15
    pieces = [*wheel.pieces(999)]
    assert [values.size for _, values in pieces] == 5 * [999] + [5]
    assert np.array_equal(np.concatenate([values for _, values in pieces]), wheel.si())
    assert np.array_equal(np.concatenate([places for places, _ in pieces]), wheel.abscissa())


@pytest.mark.slow
def test_orders_are_the_same_from_each_format(tmp_path):
    """Of a 60-2 wheel with 0.2 degrees of order 3; UFF text alone has fewer digits."""
    times = np.arange(50000) / RATE
    rigid = 2.0 * np.pi * 25.0 * times
    turned = rigid + np.radians(0.2) * np.cos(3.0 * rigid + 0.5)
    passed = np.mod(turned / (2.0 * np.pi), 1.0) < 58.0 / 60.0
    wheel = np.where(passed, np.sin(60.0 * turned), 0.0)
    found = {}
    for kind, write in FORMATS.items():
        path = write(tmp_path / f"record.{kind}", times, wheel)
        measured = load(path, teeth="60-2", units={"time": "s"} if kind == "mat" else None)
        found[kind] = measured.orders([0.5, 3.0]).amplitude
    path = uff(tmp_path / "text.uff", ("wheel", "V", times, wheel, {}))
    in_text = load(path, teeth="60-2").orders([0.5, 3.0]).amplitude
    assert np.abs(found["csv"][:, 1]) == close(np.radians(0.2), rel=0.02)
    for amplitude in found.values():
        assert np.max(np.abs(amplitude - found["csv"])) < 1e-9 * np.radians(0.2)
    assert np.max(np.abs(in_text - found["csv"])) < 1e-8 * np.radians(0.2)


def test_in_uff_text_values_have_the_digits_of_double_precision(tmp_path):
    path = uff(tmp_path / "record.uff", ("wheel", "V", TIMES, WHEEL, {}))
    (wheel,) = read_record(path).channels
    assert np.max(np.abs(wheel.si() - WHEEL)) < 1e-11
    assert wheel.error == close(0.5e-10 * 4999)
    more = {"ord_data_type": 2}
    path = uff(tmp_path / "s.uff", ("wheel", "V", TIMES, WHEEL, more), force_double=False)
    record = read_record(path)
    assert np.max(np.abs(record.channels[0].si() - WHEEL)) < 1e-5
    assert record.notes[0] == "wheel: its values have six digits."


@pytest.mark.parametrize("write", ["mat5", "mat73"])
def test_structures_of_matlab_are_searched(tmp_path, write):
    from scipy.io import savemat

    tree = {
        "Run": {
            "time": TIMES,
            "cells": [WHEEL, 2.0 * WHEEL],
            "sensor": {"values": 3.0 * WHEEL, "unit": "kNm"},
        },
        "matrix": np.c_[WHEEL, WHEEL + 1.0, WHEEL + 2.0],
    }
    path = tmp_path / "record.mat"
    if write == "mat5":
        cells = np.empty(2, dtype=object)
        cells[:] = tree["Run"]["cells"]
        savemat(path, tree | {"Run": tree["Run"] | {"cells": cells}})
    else:
        mat73(path, tree)
    record = read_record(path)
    assert record.format == ("MAT 5" if write == "mat5" else "MAT 7.3")
    with pytest.raises(InputError, match=r'unit of its time is unknown.*units = \{ time = "s" \}'):
        record.channel("sensor").abscissa()
    record = read_record(path, units={"time": "s"})
    sensor = record.channel("sensor")
    assert (sensor.group, sensor.unit) == ("Run", "kNm")
    assert sensor.si() == close(3000.0 * WHEEL, abs=1e-9)
    assert np.max(np.abs(sensor.abscissa() - TIMES)) < 1e-15
    assert record.channel("cells(2)").values == close(2.0 * WHEEL, abs=1e-12)
    assert record.channel("matrix(3)").values == close(WHEEL + 2.0, abs=1e-12)
    assert len(record.channel("matrix(3)")) == 5000


def test_start_and_increment_beside_the_values(tmp_path):
    """As Simcenter Testlab exports."""
    from scipy.io import savemat

    tree = {
        "Signal": {
            "x_values": {"start_value": 0.5, "increment": 1.0 / RATE, "number_of_values": 5000},
            "y_values": {"values": WHEEL, "quantity": {"label": "Nm"}},
        }
    }
    savemat(tmp_path / "record.mat", tree)
    (torque,) = read_record(tmp_path / "record.mat").channels
    assert (torque.name, torque.unit) == ("Signal", "Nm")
    assert torque.abscissa() == close(0.5 + TIMES, rel=1e-15)


def test_groups_of_hdf5_have_their_own_times(tmp_path):
    angles = np.arange(720.0)
    tree = {
        "slow": {"time": TIMES[::10], "M": (WHEEL[::10], {"units": "N m"})},
        "indicating": {
            "crank_angle": (angles, {"unit": "deg"}),
            "p": (1.0 + angles, {"unit": "bar"}),
        },
        "table": np.array([(0.0, 1.0), (0.1, 2.0)], dtype=[("time_s", float), ("F_kN", float)]),
    }
    record = read_record(hdf5(tmp_path / "record.h5", tree), units={"time": "s"})
    assert record.channel("M").step == close(10.0 / RATE, rel=1e-12)
    assert record.channel("p").abscissa()[90] == close(np.pi / 2.0)
    assert record.channel("F").si().tolist() == [1000.0, 2000.0]
    assert record.channel("F").abscissa() == close([0.0, 0.1], abs=1e-15)


def test_times_in_single_precision_are_even_within_it(tmp_path):
    tree = {"time": (TIMES.astype(np.float32), {"unit": "s"}), "M": (WHEEL, {"unit": "N m"})}
    (torque,) = read_record(hdf5(tmp_path / "record.h5", tree)).channels
    assert torque.error == close(np.float32(TIMES[-1]) * 2.0**-24, rel=0.01)
    assert np.max(np.abs(torque.abscissa() - TIMES)) < 1e-9


def test_gaps_of_parquet_are_left_out_and_time_stamps_are_seconds(tmp_path):
    import pyarrow as pa

    stamps = pa.array([1_000_000_000, 1_000_000_500, 1_000_001_000], pa.timestamp("us"))
    path = parquet(
        tmp_path / "record.parquet",
        {"when_time": stamps, "M_Nm": [1.0, None, 3.0], "name": ["a", "b", "c"]},
    )
    record = read_record(path)
    (torque,) = record.channels
    assert torque.values.tolist() == [1.0, 3.0]
    assert torque.abscissa() == close([0.0, 1e-3], abs=1e-12)
    assert record.notes[0] == "name: holds no numbers."


def test_row_groups_of_parquet_are_no_bounds_of_pieces(tmp_path):
    columns = {"t_s": TIMES, "wheel_V": WHEEL}
    path = parquet(tmp_path / "record.parquet", columns, row_group_size=700)
    pieces = [*read_record(path).channel("wheel").pieces(999)]
    assert [values.size for _, values in pieces] == [*5 * [999], 5]
    assert np.array_equal(np.concatenate([values for _, values in pieces]), WHEEL)


def test_a_number_that_is_none_is_told_when_it_is_read(tmp_path):
    broken = WHEEL.copy()
    broken[41] = np.nan
    record = read_record(
        hdf5(tmp_path / "record.h5", {"wheel": (broken, {"unit": "V", "fs": RATE})})
    )
    with pytest.raises(InputError, match="wheel: sample 42 is no finite number"):
        record.channel("wheel").si()


def test_a_scale_beside_the_numbers_is_told(tmp_path):
    tree = {"M": (WHEEL, {"unit": "N m", "fs": RATE, "scale_factor": 2.0, "label": "Torque"})}
    record = read_record(hdf5(tmp_path / "record.h5", tree))
    assert record.notes == ("M: has a scale or offset, which is not applied.",)
    assert record.channel("M").si_unit == "N m"


def test_damage_that_is_found_on_the_way_is_told(tmp_path):
    tree = {"wheel": (np.random.default_rng(1).normal(size=5000), {"unit": "V", "fs": RATE})}
    path = hdf5(tmp_path / "record.h5", tree)
    wheel = read_record(path).channel("wheel")
    path.write_bytes(path.read_bytes()[:4000])
    with pytest.raises(InputError, match="cannot be read"):
        wheel.si()


def test_times_since_1970_are_even_within_double_precision(tmp_path):
    path = parquet(tmp_path / "record.parquet", {"t_s": 1.7e9 + TIMES, "wheel_V": WHEEL})
    record = read_record(path)
    wheel = record.channel("wheel")
    assert (wheel.start, wheel.rate) == (0.0, RATE)
    assert np.max(np.abs(wheel.abscissa() - TIMES)) < 1e-15
    assert record.notes[0] == "Times count from 1700000000 s of the file."
    assert "errors up to 1.2e-07 s by their digits; 50000 samples a second" in record.notes[1]
