"""Fields of files that say how a table is to be read."""

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.engine_mechanism import input_warnings, load_any
from crankfem.analyses.file_check import check_file
from crankfem.files.reading.data_files import data_folder, input_path

CYCLES = 5


@pytest.fixture
def bench(tmp_path):
    """A record of five cycles of a calculated pressure, as an indicator exports it."""
    pressure = load_any("6chn25-34").pressure[0]
    rows = ["CA;P2;P1", "°KW;bar;bar"]
    for cycle in range(CYCLES):
        for angle in np.arange(0.0, 720.0, 1.0):
            value = float(pressure.at(angle_deg=angle - 360.0)) / 1e5 * (0.98 + 0.01 * cycle)
            rows.append(f"{720.0 * cycle + angle:g};1;{value:.6f}".replace(".", ","))
    (tmp_path / "bench.csv").write_bytes("\n".join(rows).encode("cp1252"))
    return pressure


def written(tmp_path, edit, reading):
    text = edit(input_path("6chn25-34").read_text("utf-8"), {"gas.peak_pressure": None})
    given = 'pressure_table = "bench.csv"\n' + (f"reading = {reading}\n" if reading else "")
    (tmp_path / "mine.toml").write_text(text.replace("[gas]\n", f"[gas]\n{given}"), "utf-8")
    return tmp_path / "mine.toml"


READING = '{ columns = { crank_angle_deg = "CA", absolute_pressure_bar = "P1" }, top = "360 deg" }'


@pytest.mark.slow
def test_a_record_of_a_bench_is_read_as_its_engine_file_says(tmp_path, edit, bench):
    path = written(tmp_path, edit, READING)
    pressure = load_any(path).pressure[0]
    # Of the even samples of the model to those of a degree: their shape-preserving curve.
    assert pressure.peak_pressure == close(bench.peak_pressure, rel=1e-3)
    assert pressure.peak_angle_deg == close(bench.peak_angle_deg, abs=1.0)
    remarks = check_file(str(path)).remarks
    assert any("gas.pressure_table: " in one and "5 cycles" in one for one in remarks)
    assert any("'P2'" in one for one in remarks)


def test_a_table_that_does_not_say_what_it_holds_is_refused_with_the_cure(tmp_path, edit, bench):
    with pytest.raises(InputError, match="CA,P2,P1"):
        _ = load_any(written(tmp_path, edit, None)).pressure


def test_a_reading_without_a_table_is_refused(tmp_path, edit):
    text = input_path("6chn25-34").read_text("utf-8")
    (tmp_path / "mine.toml").write_text(
        text.replace("[gas]\n", '[gas]\nreading = { sheet = "a" }\n'), "utf-8"
    )
    with pytest.raises(InputError, match=r"gas\.reading: "):
        load_any(tmp_path / "mine.toml")


def test_a_torque_table_by_its_engine_file_and_by_options(call, tmp_path, edit):
    shipped = data_folder() / "tables" / "yamz5340_torque_one_throw.csv"
    rows = [line for line in shipped.read_text("utf-8").splitlines() if line[:1].isdigit()]
    (tmp_path / "m.csv").write_text("\n".join(["x;y", *rows]).replace(",", ";"), "utf-8")
    plain = call("harmonics", shipped, "--json").json()
    options = ("--columns", "cycle_angle_deg=x, torque_Nm=2")
    assert call("harmonics", "m.csv", *options, "--json").json()["amplitude"] == plain["amplitude"]
    answer = call("harmonics", "m.csv", "--columns", "x")
    assert answer.code == 2
    assert answer.err.startswith("Error: --columns: ")
    text = edit(
        input_path("yamz-5340").read_text("utf-8"),
        {
            "torque.table": '"m.csv"',
            "torque.reading": "{ columns = { cycle_angle_deg = 1, torque_Nm = 2 } }",
        },
    )
    (tmp_path / "mine.toml").write_text(text, "utf-8")
    assert input_warnings(load_any(tmp_path / "mine.toml")) == ()
