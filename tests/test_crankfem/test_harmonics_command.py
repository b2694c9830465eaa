import csv
import re

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.tables.table_units import table_unit
from crankfem.analyses.mechanism.plots import picture_torque_table, table_files

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
    assert names == {"torque.svg", "harmonics.svg", "stars.svg", "single_harmonics.svg"}
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
    answer = call("harmonics", TABLE, "--csv", "h.csv")
    assert answer.code == 0
    assert "Table: h.csv" in answer.out
    lines = (tmp_path / "h.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == f"# {TABLE}, 4 strokes per cycle"
    # A header, the mean and 18 orders.
    assert len(lines) == 1 + 20
    answer = call(
        "harmonics", TABLE, "--orders", "1", "--firing-order", "1-2", "--pictures", "plots"
    )
    names = {path.name for path in (tmp_path / "plots").glob("[!.]*")}
    assert names == {"torque.svg", "harmonics.svg", "single_harmonics.svg", "stars.svg"}


@pytest.mark.parametrize(
    "firing", [("--firing-order", "1-3-4-2"), ("--firing-angles", "0, 540, 180, 360 deg")]
)
def test_cylinders_of_a_table_add_up_as_their_shifted_samples(call, tmp_path, firing):
    arguments = ("--orders", "8.5", "--csv", "h.csv")
    record = call("harmonics", TABLE, *firing, *arguments, "--json").json()
    found = record["cylinders"]
    assert found["firing_angles_deg"] == [0.0, 540.0, 180.0, 360.0]
    assert found["leading_orders"] == [2.0, 4.0, 6.0, 8.0]
    # Four rows of samples, each shifted by its firing angle; their order 9 cancels.
    torque = cf.load_torque_table(TABLE).torque
    total = sum(np.roll(torque, shift // 20) for shift in (0, 540, 180, 360))
    angles = np.radians(np.arange(0, 720, 20))
    own = found["torque"]
    series = own["mean"] + sum(
        amplitude * np.sin(order * angles + np.radians(phase))
        for order, amplitude, phase in zip(
            own["orders"], own["amplitude"], own["phase_deg"], strict=True
        )
    )
    assert series == close(total, abs=1e-9)
    rows = list(csv.DictReader((tmp_path / "h.csv").read_text("utf-8").splitlines()[1:]))
    second = next(
        row for row in rows if (row["of"], row["order"]) == ("torque of all cylinders", "2.0")
    )
    assert float(second["cosine"]) == close(
        2.0 / 36.0 * float(np.sum(total * np.cos(2.0 * angles))), rel=1e-9
    )


def test_partial_sums_against_the_samples(call):
    record = call("harmonics", TABLE, "--orders", "2", "--json").json()
    assert record["orders"] == [0.5, 1.0, 1.5, 2.0]
    torque = cf.load_torque_table(TABLE).torque
    # Least squares with a mean and the same sines and cosines leaves as much.
    angles = np.radians(np.arange(0, 720, 20))
    for place, highest in enumerate(record["orders"]):
        kept = np.arange(0.5, highest + 0.1, 0.5)
        basis = np.column_stack(
            [np.ones(36), *(wave(k * angles) for k in kept for wave in (np.cos, np.sin))]
        )
        left = torque - basis @ np.linalg.lstsq(basis, torque, rcond=None)[0]
        assert record["residual_rms"][place] == close(np.sqrt(np.mean(left**2)))
        assert record["residual_largest"][place] == close(np.max(np.abs(left)))
    assert "matches every sample" in call("harmonics", TABLE).out
    told = call("harmonics", TABLE, "--orders", "2").out
    assert "The sum up to order 2 differs from the samples by at most 1530.2 N m." in told


def test_orders_that_all_cancel_have_no_picture_of_round_off(tmp_path, call):
    told = call("harmonics", "6chn25-34", "--orders", "2", "--pictures", "plots").out
    assert "All orders cancel." in told
    text = (tmp_path / "plots" / "single_harmonics.svg").read_text(encoding="utf-8")
    assert "<!-- All orders up to 2 cancel. -->" in text
    assert "<!-- Order 2 -->" not in text


def test_the_picture_of_a_table_ends_at_the_order_asked_for(tmp_path):
    table = cf.load_torque_table(TABLE)
    shown = table.harmonics().up_to(1.5)
    paths = picture_torque_table(tmp_path, table, shown)
    assert [path.name for path in paths] == table_files(())
    texts = [path.read_text(encoding="utf-8") for path in paths]
    assert "<!-- sum up to order 1.5 -->" in texts[0]
    assert "<!-- order 1.5: 334.2 N m, 190.2 deg -->" in texts[1]
    assert "<!-- Order 1.5 -->" in texts[2]
    assert not any("rder 2" in text for text in texts)


def test_the_order_of_which_one_phase_is_seen_has_no_star(call):
    answer = call("harmonics", TABLE, "--firing-order", "1-2")
    assert (
        "Note: order 9 is left out, because 36 samples resolve only one phase of it" in answer.out
    )
    assert "2 cylinders, each with this torque, fired at 0, 360 deg: mean torque 246.72 N m." in (
        answer.out
    )


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
        (
            (TABLE, "--firing-order", "1-3-3"),
            "--firing-order: given '1-3-3'; allowed is each number",
        ),
        ((TABLE, "--firing-angles", "0, 90"), "--firing-angles: given '0', a bare number"),
        ((TABLE, "--firing-angles", "0 m"), "--firing-angles: "),
        (
            (TABLE, "--firing-order", "1", "--firing-angles", "0 deg"),
            "--firing-order: given '1' with --firing-angles; allowed is one of them",
        ),
        (
            ("6chn25-34", "--firing-order", "1"),
            "--firing-order: given '1' with an engine file; allowed is a torque table",
        ),
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
