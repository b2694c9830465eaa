"""The command `measured`: its tables, files and JSON."""

import numpy as np
import pytest

from comparing import close
from crankfem.satellites.measured.calibration.orders_table import read_orders


@pytest.fixture
def record(tmp_path):
    """Pulses of a wheel 60-2 at 800 1/min, moved by orders 0.5 and 3."""
    rigid = np.linspace(0.0, 100 * 2 * np.pi, 400_000)
    moved = rigid + 1e-3 * np.cos(3 * rigid - 1.1) + 2e-3 * np.cos(0.5 * rigid + 0.4)
    teeth = np.arange(1, 99 * 60)
    teeth = teeth[teeth % 60 < 58]
    times = np.interp(teeth * 2 * np.pi / 60, moved, rigid) / (800 * np.pi / 30)
    file = tmp_path / "run.csv"
    np.savetxt(file, times, fmt="%.9f", header="pulse_time_s", comments="")
    return file


@pytest.mark.slow
def test_json_and_files_hold_the_orders(call, record, tmp_path):
    answer = call(
        *("measured", str(record), "--teeth", "60-2", "--orders", "0.5,3", "--mark-angle", "0 deg"),
        *("--csv", str(tmp_path / "t"), "--pictures", str(tmp_path / "p"), "--json"),
    )
    assert answer.code == 0, answer.err
    found = answer.json()
    assert found["orders"] == [0.5, 3.0]
    assert found["amplitude"][0] == close([2e-3, 1e-3], rel=1e-4)
    assert found["speed_rpm"] == close([800.0], rel=1e-4)
    assert found["largest"][1]["phase_deg"] == close(np.degrees(-1.1), abs=0.05)
    assert found["unit"] == "rad"
    assert (tmp_path / "p" / "orders_map.svg").is_file()
    again = read_orders(tmp_path / "t" / "measured_orders.csv", "free end")
    assert again.amplitude[0] == close([2e-3 * np.exp(0.4j), 1e-3 * np.exp(-1.1j)], rel=1e-3)


def test_the_largest_order_is_told(call, record):
    answer = call("measured", str(record), "--teeth", "60-2")
    assert answer.code == 0, answer.err
    assert "Largest order: 0.5, 0.115 deg at 800 1/min." in answer.out


@pytest.mark.slow
def test_what_does_not_fit_is_refused(call, record):
    for options, word in (
        (("--teeth", "36-1"), "60-2"),
        (("--teeth", "60-2", "--orders", "a"), "--orders"),
        (("--teeth", "60-2", "--strokes", "3"), "--strokes"),
        (("--teeth", "60-2", "--engine", "5rt-flex50d"), "factor"),
    ):
        answer = call("measured", str(record), *options)
        assert answer.code == 2
        assert word in answer.err


def test_places_and_files_in_the_way_are_refused_before_a_record_is_read(call, tmp_path):
    words = ("measured", str(tmp_path / "none.csv"), "--teeth", "60-2", "--engine", "cat-3116")
    (tmp_path / "overlay.html").write_text("mine")
    for options, word in (
        (("--at", "rudder"), "--at"),
        (("--at", "free end", "--pictures", str(tmp_path)), "overlay.html"),
        (("--at", "free end"), "none.csv"),
    ):
        answer = call(*words, *options)
        assert answer.code == 2
        assert word in answer.err
    assert (tmp_path / "overlay.html").read_text() == "mine"


@pytest.mark.parametrize(
    ("header", "word"), [("time_s,speed_rpm", "rpm over time"), ("wheel", "no unit over no time")]
)
def test_what_is_no_signal_of_a_wheel_is_refused(call, tmp_path, header, word):
    time = np.arange(0.0, 2.0, 1e-4)
    rows = np.column_stack((time, 1500.0 + np.sin(300.0 * time)))[:, 2 - len(header.split(",")) :]
    path = tmp_path / "speed.csv"
    np.savetxt(path, rows, delimiter=",", comments="", header=header)
    answer = call("measured", str(path), "--teeth", "3")
    assert answer.code == 2
    assert word in answer.err
