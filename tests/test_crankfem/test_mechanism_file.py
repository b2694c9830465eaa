"""Engine files as crank mechanisms: V engines, hinged rods, split pins, gas pressure."""

import math
from pathlib import Path

import numpy as np
import pytest

from crankfem.data_files import engine_path
from crankfem.mechanism_file import MechanismFile, load_any, load_mechanism, with_throws
from dynamics.gas.pressure import ATMOSPHERE
from geometry.errors import InputError


def degrees(values):
    return [round(math.degrees(value), 6) for value in values]


def test_a_cross_plane_v8_fires_evenly_in_its_order():
    layout = load_mechanism("8chn13-14").layout
    firing = np.array(degrees(layout.firing))[np.array(layout.firing_order) - 1]
    assert np.diff(firing).tolist() == [90.0] * 7
    # l_shk of the published engine, from the rod's rotating mass.
    assert layout.cylinders[0].rod.center_distance == pytest.approx(0.097, abs=1e-6)


def test_split_pins_make_a_90_degree_v6_fire_evenly():
    layout = load_mechanism("buick-3800").layout
    firing = np.array(degrees(layout.firing))[np.array(layout.firing_order) - 1]
    assert np.diff(firing) == pytest.approx([120.0] * 5)
    places = [cylinder.position for cylinder in layout.cylinders]
    assert places == sorted(places)
    assert places[1] - places[0] == pytest.approx(0.023)  # neighbors on one pin's two halves


def test_hinged_rods_stand_at_the_angle_between_the_banks():
    layout = load_mechanism("8chn26-26").layout
    hinged = layout.cylinders[4]
    assert hinged.slave_pin.main_cylinder == 1
    assert math.degrees(hinged.slave_pin.angle) == pytest.approx(45.0)
    assert hinged.position == layout.cylinders[0].position
    assert layout.cylinders[0].slave_pin is None


@pytest.mark.parametrize(("name", "sense"), [("6chn25-34", -1), ("vw-tdi", 1), ("6s50mc-c", -1)])
def test_engines_in_line_turn_as_their_firing_order_says(name, sense):
    mechanism = load_mechanism(name)
    layout = mechanism.layout
    assert mechanism.turning_sense == sense
    firing = np.array(layout.firing)[np.array(layout.firing_order) - 1]
    assert np.diff(firing) == pytest.approx([layout.cycle / len(firing)] * (len(firing) - 1))
    assert mechanism.rod_model == "two-mass"
    assert any("rod.inertia is not given" in remark for remark in mechanism.remarks)


def test_gas_reaches_what_the_file_asks_for():
    mechanism = load_mechanism("yamz-5340")
    assert mechanism.pressure[0].peak_pressure == pytest.approx(13e6 + ATMOSPHERE, rel=1e-9)
    assert len(mechanism.pressure) == 4
    assert any("combustion_start" in remark for remark in mechanism.pressure[0].remarks)
    assumed = [remark for remark in mechanism.pressure[0].remarks if "intake_pressure" in remark]
    assert len(assumed) == 1


def written(tmp_path, changes, name="6chn25-34"):
    text = engine_path(name).read_text(encoding="utf-8")
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "engine.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_pressure_table_beside_the_file(tmp_path):
    angles = np.arange(-360.0, 360.0, 5.0)
    pressure = 1.5 + 80.0 * np.exp(-(((angles - 8.0) / 25.0) ** 2))
    rows = "\n".join(f"{a:g},{p:.6f}" for a, p in zip(angles, pressure, strict=True))
    (tmp_path / "gas.csv").write_text(f"crank_angle_deg,absolute_pressure_bar\n{rows}\n")
    path = written(tmp_path, {"[gas]\n": '[gas]\npressure_table = "gas.csv"\n'})
    mechanism = load_mechanism(path)
    assert mechanism.pressure[5].at([math.radians(10.0)])[0] == pytest.approx(
        1e5 * (1.5 + 80.0 * math.exp(-((2.0 / 25.0) ** 2))), rel=1e-6
    )
    with pytest.raises(InputError, match=r"gas\.pressure_table: given 'no\.csv', which is neither"):
        load_mechanism(written(tmp_path, {"[gas]\n": '[gas]\npressure_table = "no.csv"\n'}))


@pytest.mark.parametrize(
    ("name", "changes", "message"),
    [
        (
            "8chn26-26",
            {"[1, 5, 3, 7, 4, 8, 2, 6]": "[1, 3, 5, 7, 4, 8, 2, 6]"},
            r"engine\.firing_order: given \[1, 3, 5, .* does not fit the crank angles",
        ),
        (
            "8chn26-26",
            {"value = [1, 2, 3, 4], source": "value = [1, 2, 3, 3], source"},
            r"cylinder 8: crank_angle: given 0 deg; allowed is that of cylinder 3, 180 deg",
        ),
        (
            "8chn26-26",
            {"value = [5, 6, 7, 8], source": "value = [5, 6, 7, 9], source"},
            r"hinged_rods\.cylinders: given 9; allowed is 1 to 8",
        ),
        (
            "buick-3800",
            {'"0 deg", "30 deg", "240 deg"': '"0 deg", "10 deg", "240 deg"'},
            r"engine\.crank_angles: given 10 deg for cylinder 2, whose pin on throw 1 stands at 30 deg",
        ),
        (
            "buick-3800",
            {"[1, 1, 2, 2, 3, 3]": "[1, 1, 2, 2, 4, 4]"},
            r"engine\.throws: given \[1, 1, 2, 2, 4, 4\]; allowed are numbers from 1 up without a gap",
        ),
        (
            "buick-3800",
            {'"45 deg", "-45 deg", "45 deg", "-45 deg", "45 deg", "-45 deg"': '"45 deg"'},
            r"engine\.bank_angles: given 1 angles; allowed is one for each of the 6 cylinders",
        ),
        (
            "8chn13-14",
            {"0.0589 kg m^2": "0.65 kg m^2"},
            r"rod: rod inertia: given 0\.65 kg m\^2; allowed is 0\.\d+ kg m\^2 or less",
        ),
        (
            "6chn25-34",
            {"peak_pressure": "compression_ratio", '"8.5 MPa"': "13.0"},
            r"gas: given no pressure; allowed is one of peak_pressure",
        ),
        (
            "6chn25-34",
            {"[gas]\n": '[gas]\nintake_pressure = "5 bar"\n'},
            r"gas\.peak_pressure: given 8\.60132 MPa; allowed .* \(absolute pressures\)",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(tmp_path, name, changes, message):
    with pytest.raises(InputError, match=message):
        load_mechanism(written(tmp_path, changes, name))


def test_what_a_file_describes():
    assert isinstance(load_any("8chn26-26"), MechanismFile)
    assert type(load_any("6chn25-34")).__name__ == "EngineFile"
    assert type(load_any("8chn14-14")).__name__ == "ThrowFile"
    with pytest.raises(InputError, match=r"the section \[engine\] is missing"):
        load_mechanism("8chn14-14")
    assert load_mechanism(Path("6chn25-34")).name == "6ChN 25/34"


def test_throws_stand_with_their_unbalance_at_their_angles():
    mechanism = load_mechanism("8chn13-14")
    layout = with_throws(mechanism)
    phasors = np.array(
        [mass.static_moment * np.exp(1j * mass.angle) for mass in layout.rotating]
    ).reshape(-1, 2)
    # Each throw the same, turned to its angle.
    turned = phasors * np.exp(-1j * np.array(mechanism.throw_angles))[:, None]
    assert np.abs(turned - turned[0]).max() < 1e-12
    assert abs(turned[0].sum().imag) < 1e-6 * abs(turned[0].sum())  # in the crank's plane
    assert layout.shaft_inertia > 0.1
