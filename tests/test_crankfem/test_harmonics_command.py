import csv
import re

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.tables.table_units import table_unit

TABLE = "yamz5340_torque_one_throw.csv"


def test_engine_record(call):
    record = call("harmonics", "6chn25-34", "--json").json()
    assert record["leading_orders"] == [3.0, 6.0, 9.0, 12.0]
    assert record["same_stars"][0] == [0.5, 2.5, 3.5, 5.5, 6.5, 8.5, 9.5, 11.5]
    assert len(record["throws"]) == 6
    assert abs(record["energy_error"]) < 1e-9
    assert record["power"] == close(record["mean"] * record["speed_rpm"] * np.pi / 30.0)
    assert record["harmonics"]["orders"][-1] == 12.0
    amplitude = dict(
        zip(record["harmonics"]["orders"], record["harmonics"]["amplitude"], strict=True)
    )
    assert max(amplitude, key=amplitude.get) == 3.0
    assert amplitude[0.5] < 1e-9 * amplitude[3.0]
    # The same by the public names.
    engine = cf.load_mechanism("6chn25-34")
    torque = cf.engine_torque(engine.layout, engine.rated_speed, engine.pressure)
    assert record["mean"] == close(torque.mean, rel=1e-12)


def test_engine_as_tables(call):
    answer = call("harmonics", "8chn26-26", "--orders", "2.5", "--cylinder", "5")
    assert answer.code == 0
    assert "No order is major; the strongest: 2." in answer.out
    assert "throw 1 (cyl." in answer.out
    assert re.search(
        r"Cylinder 5: tangential force T on the crankpin, phases from\s+its", answer.out
    )
    assert "-0.00" not in answer.out
    assert "Cylinders with hinged rods differ" in answer.out


def test_large_torques_are_told_in_one_unit_a_table(call):
    answer = call("harmonics", "6s50mc-c", "--orders", "4")
    assert answer.code == 0
    assert "mean torque 750.00 kN m, indicated power 9974.6 kW" in answer.out
    assert "Amplitudes by throw [kN m]" in answer.out
    # No cell is broken to a second line: each row begins with its order.
    throws = answer.out.split("Amplitudes by throw")[1].split("Stars")[0]
    rows = [line.split("│")[1].strip() for line in throws.splitlines() if line.startswith("│")]
    assert rows == ["1", "2", "3", "4"]
    assert "hinged rods" not in answer.out


@pytest.mark.parametrize(
    ("values", "name", "text"),
    [
        ((9999.9, -0.04), "N m", "9999.9"),
        ((10000.0,), "kN m", "10.000"),
        ((-279.68,), "N m", "-279.68"),
        ((1e-13,), "N m", "0.0000"),
        ((-1e-13, 100.0), "N m", "0.00"),
        ((2.5e8,), "kN m", "250000"),
        ((0.0,), "N m", "0.0000"),
    ],
)
def test_unit_and_digits_of_a_table(values, name, text):
    unit = table_unit(values, "N m")
    assert unit.with_unit(values[0]) == f"{text} {name}"
    assert table_unit([], "N").name == "N"


def test_speed(call):
    rated = call("harmonics", "6chn25-34", "--json").json()
    slow = call("harmonics", "6chn25-34", "--json", "--speed", "100 1/min").json()
    assert slow["speed_rpm"] == close(100.0)
    # The work of the gas is the same, the masses' part of a harmonic is not.
    assert slow["mean"] == close(rated["mean"], rel=1e-9)
    assert slow["harmonics"]["amplitude"][5] != close(rated["harmonics"]["amplitude"][5], rel=1e-3)


def test_harmonics_of_a_cylinders_forces(call):
    record = call("harmonics", "8chn26-26", "--cylinder", "5", "--orders", "4", "--json").json()
    found = record["cylinder"]
    assert found["number"] == 5
    assert found["firing_angle_deg"] == close(record["firing_angles_deg"][4])
    assert found["tangential"]["inertia"]["mean"] == close(0.0, abs=1e-6)
    both = found["tangential"]["gas and inertia"]["mean"]
    # Crank radius 0.13 m: eight such means are the engine's, but that hinged rods differ.
    assert 8 * 0.13 * both == close(record["mean"], rel=0.05)


def test_tables_and_pictures_are_written(call, tmp_path):
    answer = call(
        *("harmonics", "6chn25-34", "--orders", "6", "--cylinder", "2", "--json"),
        *("--csv", "h.csv", "--pictures", "plots"),
    )
    assert answer.code == 0
    names = {path.name for path in (tmp_path / "plots").glob("[!.]*")}
    assert names == {"torque.svg", "harmonics.svg", "stars.svg"}
    for name in names:
        # Text is drawn; what it says stands beside it as a comment.
        assert "6ChN 25/34, 500 1/min" in (tmp_path / "plots" / name).read_text(encoding="utf-8")
    with (tmp_path / "h.csv").open(encoding="utf-8") as stream:
        assert stream.readline() == "# 6ChN 25/34, 500 1/min, rods as rigid\n"
        rows = list(csv.DictReader(stream))
    kinds = {row["of"] for row in rows}
    assert {"engine torque", "torque of throw 6"} <= kinds
    assert "radial force of cylinder 2 from gas and inertia" in kinds
    record = answer.json()
    mean = next(row for row in rows if row["order"] == "0.0")
    assert float(mean["amplitude"]) == record["harmonics"]["mean"]
    third = next(row for row in rows if (row["of"], row["order"]) == ("engine torque", "3.0"))
    assert float(third["phase_deg"]) == record["harmonics"]["phase_deg"][5]


def test_table_writes_too(call, tmp_path):
    answer = call("harmonics", TABLE, "--csv", "h.csv", "--pictures", "plots")
    assert answer.code == 0
    assert "Table: h.csv" in answer.out
    lines = (tmp_path / "h.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == f"# {TABLE}, 4 strokes per cycle"
    # A header, the mean and 18 orders.
    assert len(lines) == 1 + 20
    assert (tmp_path / "plots" / "torque.svg").is_file()


@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        (
            (TABLE, "--orders", "9.5"),
            "--orders: given 9.5; allowed is 9 or less, because 36 samples",
        ),
        ((TABLE, "--orders", "0"), "--orders: given 0; allowed is an order above 0, because"),
        (
            (TABLE, "--orders", "0.4"),
            "--orders: given 0.4; allowed is 0.5 or more, because that is",
        ),
        (("6chn25-34", "--orders", "0.4"), "--orders: given 0.4; allowed is 0.5 or more"),
        ((TABLE, "--cylinder", "1"), "--cylinder: given 1 with a torque table"),
        ((TABLE, "--speed", "100 1/min"), "--speed: given 100 1/min with a torque table"),
        (("6chn25-34", "--speed", "100"), 'write it with its unit, like "100 1/min"'),
        (("6chn25-34", "--orders", "361"), "--orders: given 361; allowed is 360 or less"),
        (("6chn25-34", "--cylinder", "7"), "--cylinder: given 7; allowed is 1 to 6"),
        (("6chn25-34", "--strokes", "2"), "--strokes: given 2; allowed is 4 or nothing"),
        (("nowhere.toml",), "nowhere.toml: does not exist"),
        (("no-such-engine",), "no-such-engine: does not exist"),
        ((TABLE, "--csv", "nowhere/h.csv"), "there is no folder nowhere"),
    ],
)
def test_refusals_are_one_sentence(call, arguments, fragment):
    answer = call("harmonics", *arguments)
    assert (answer.code, answer.out) == (2, "")
    assert fragment in answer.err
    assert answer.err.count("\n") == 1


def test_a_header_of_many_columns_is_not_told_in_full(call, tmp_path):
    header = ",".join(f"column_{number}" for number in range(500))
    (tmp_path / "wide.csv").write_text(f"{header}\n", encoding="utf-8")
    answer = call("harmonics", "wide.csv")
    assert answer.code == 2
    assert 'given the header "column_0,column_1,' in answer.err
    assert " ... " in answer.err
    assert len(answer.err) < 400


def test_a_table_beside_the_user_comes_before_the_shipped_one(call, tmp_path):
    shipped = call("harmonics", TABLE, "--json").json()
    own = "crank_angle_deg,torque_Nm\n" + "".join(
        f"{angle},{100.0 + 20.0 * np.sin(np.deg2rad(angle))}\n" for angle in range(0, 720, 60)
    )
    (tmp_path / TABLE).write_text(own, encoding="utf-8")
    found = call("harmonics", TABLE, "--json").json()
    assert found["mean"] == close(100.0) != shipped["mean"]
    assert found["amplitude"][found["orders"].index(1.0)] == close(20.0)


@pytest.mark.parametrize("table", ["nothing.csv", f"folder/{TABLE}"])
def test_a_table_that_is_not_there_is_refused(call, table):
    answer = call("harmonics", table)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith(f"Error: {table}: ")
    assert answer.err.count("\n") == 1
