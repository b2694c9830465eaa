"""The commands `harmonics` and `two-mass`."""

import csv

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.table import table_unit
from crankfem.analyses.mechanism.plots import picture_torque_table, table_files
from dynamics.chains.chain import Chain
from dynamics.response.forced import forced_response
from dynamics.response.loads import element_loads
from dynamics.response.order_excitation import OrderExcitation

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
    torque = cf.engine_torque(engine.layout, engine.engine.rated_speed, engine.pressure)
    assert record["mean"] == close(torque.mean, rel=1e-12)


@pytest.mark.slow
def test_large_torques_are_told_in_one_unit_a_table(call):
    answer = call("harmonics", "6s50mc-c", "--orders", "4", "--full")
    assert answer.code == 0
    assert "mean torque 750.00 kN m, indicated power 9974.6 kW" in answer.out
    # No cell is broken to a second line: each row begins with its order.
    throws = answer.out.split("Amplitudes by throw")[1].split("Stars")[0]
    rows = [line.split()[0] for line in throws.split("----\n")[1].splitlines() if line]
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
    assert table_unit(values, "N m").with_unit(values[0]) == f"{text} {name}"
    assert table_unit([], "N").name == "N"


@pytest.mark.slow
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
        assert stream.readline().startswith("# 6ChN 25/34, 500 1/min, ")
        rows = list(csv.DictReader(stream))
    kinds = {row["of"] for row in rows}
    assert {"engine torque", "torque of throw 6"} <= kinds
    assert "radial force of cylinder 2 from gas and inertia" in kinds
    record = answer.json()
    mean = next(row for row in rows if row["order"] == "0.0")
    assert float(mean["amplitude"]) == record["harmonics"]["mean"]
    third = next(row for row in rows if (row["of"], row["order"]) == ("engine torque", "3.0"))
    assert float(third["phase_deg"]) == record["harmonics"]["phase_deg"][5]


@pytest.mark.slow
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
    found = call("harmonics", TABLE, *firing, *arguments, "--json").json()["cylinders"]
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


@pytest.mark.slow
def test_orders_that_all_cancel_have_no_picture_of_round_off(tmp_path, call):
    call("harmonics", "6chn25-34", "--orders", "2", "--pictures", "plots")
    text = (tmp_path / "plots" / "single_harmonics.svg").read_text(encoding="utf-8")
    assert "cancel. -->" in text
    assert "<!-- Order 2 -->" not in text


@pytest.mark.slow
def test_the_picture_of_a_table_ends_at_the_order_asked_for(tmp_path):
    table = cf.load_torque_table(TABLE)
    paths = picture_torque_table(tmp_path, table, table.harmonics().up_to(1.5))
    assert [path.name for path in paths] == table_files(())
    texts = [path.read_text(encoding="utf-8") for path in paths]
    assert "<!-- sum up to order 1.5 -->" in texts[0]
    assert "<!-- order 1.5: 334.2 N m, 190.2 deg -->" in texts[1]
    assert "<!-- Order 1.5 -->" in texts[2]
    assert not any("rder 2" in text for text in texts)


def test_a_header_of_many_columns_is_not_told_in_full(call, tmp_path):
    header = ",".join(f"column_{number}" for number in range(500))
    (tmp_path / "wide.csv").write_text(f"{header}\n", encoding="utf-8")
    answer = call("harmonics", "wide.csv")
    assert answer.code == 2
    assert '"column_0,column_1,' in answer.err
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


SECTION = """
[two_mass_check]
shaft_diameter = "70 mm"
shaft_length = "0.2 m"
shear_modulus = "80 GPa"
engine_inertia = "0.1 kg m^2"
flywheel_inertia = "0.78 kg m^2"
order = 6.0
"""


def test_shipped_engine(call):
    record = call("two-mass", "yamz-5340", "--json").json()
    assert record["resonant_speed_rpm"] == close(2224.7, abs=0.05)
    found = record["resonances"]
    assert [one["order"] for one in found] == [16.0, 15.5, 15.0, 14.5, 14.0]
    for one in found:
        assert one["order"] * one["speed_rpm"] == close(60.0 * record["frequency"])
        assert one["amplitude"] is None


def test_torque_in_the_shaft_is_that_of_a_chain_of_two(call):
    found = call("two-mass", "yamz-5340", "--json").json()["shaft_torque"]
    table = cf.load_torque_table("yamz5340_torque_one_throw.csv")
    # Four rows of samples, each shifted by its firing angle.
    total = sum(np.roll(table.torque, shift // 20) for shift in (0, 540, 180, 360))
    angles = np.radians(table.crank_angle_deg)
    orders = np.array(found["orders"])
    speed = 2300.0 * np.pi / 30.0
    phasors = np.array([2.0 / 36.0 * np.sum(total * np.exp(-1j * k * angles)) for k in orders])
    forces = np.zeros((len(orders), 1, 2), dtype=complex)
    forces[:, 0, 1] = phasors
    stiffness = 8e10 * np.pi * 0.07**4 / (32.0 * 0.2)
    chain = Chain([0.78, 0.1], [stiffness])
    response = forced_response(chain, OrderExcitation(orders, np.array([speed]), forces))
    expected = np.abs(element_loads(response).elements.values[:, 0, 0])
    assert found["torque"] == close(expected.tolist(), abs=1e-8 * expected.max())
    assert [k for k, by in zip(orders, found["exciting"], strict=True) if by > 1.0] == [2, 4, 6, 8]


def test_the_section_alone(call, tmp_path):
    (tmp_path / "two.toml").write_text(SECTION, encoding="utf-8")
    record = call("two-mass", "two.toml", "--order", "14", "--json").json()
    assert record["resonant_speed_rpm"] == close(2224.7, abs=0.05)
    assert record["resonances"] is record["shaft_torque"] is record["running_rpm"] is None
    *_, told, last = call("two-mass", "two.toml").out.splitlines()
    assert "order 6" in told
    assert "5190.9 1/min" in last


def test_the_auxiliary_table_of_the_sums(call, tmp_path):
    """Makushev, Polyakova 2024, table 2, its row of sums; and an engine's, whose sums give A_k and B_k."""
    table = "yamz5340_torque_one_throw.csv"
    assert call("harmonics", table, "--orders", "1", "--sums", "s.csv").code == 0
    with (tmp_path / "s.csv").open(encoding="utf-8") as stream:
        *rows, sums = csv.DictReader(stream)
    assert (len(rows), sums["sample"]) == (36, "sum")
    printed = {"y_Nm": 4441.0, "y_cos_1x": -3865.75, "y_sin_1x": -3224.93}
    printed |= {"y_cos_2x": 2484.88, "y_sin_2x": 6689.29}
    for name, value in printed.items():
        assert float(sums[name]) == close(value, abs=0.006), name
    answer = call("harmonics", "6chn25-34", "--orders", "4", "--sums", "e.csv", "--json").json()
    with (tmp_path / "e.csv").open(encoding="utf-8") as stream:
        *rows, sums = csv.DictReader(stream)
    for name, key in (("cos", "cosine"), ("sin", "sine")):
        found = [2.0 / len(rows) * float(sums[f"y_{name}_{k}x"]) for k in range(1, 9)]
        assert found == close(answer["harmonics"][key], abs=1e-6)
    answer = call("harmonics", table, "--csv", "s.csv", "--sums", "s.csv")
    assert answer.err.startswith("Error: --sums: given s.csv")
