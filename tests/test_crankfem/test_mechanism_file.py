"""Engine files as crank mechanisms: V engines, hinged rods, split pins, gas pressure."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.errors import InputError
from crankfem.files.engine.engine_file import EngineFile, load_engine
from crankfem.files.engine.mechanism_file import (
    MechanismFile,
    load_any,
    load_mechanism,
    with_throws,
)
from crankfem.files.reading.data_files import input_path
from dynamics.cycle import cycle_radians
from dynamics.engine.forces import gas_forces, mechanism_forces
from dynamics.gas.pressure import ATMOSPHERE
from geometry.crankshaft import throw_masses
from geometry.mass import MassProperties, unbalance


def degrees(values):
    return [round(math.degrees(value), 6) for value in values]


def test_a_cross_plane_v8_fires_evenly_in_its_order():
    layout = load_mechanism("8chn13-14").layout
    firing = np.array(degrees(np.radians(layout.firing_deg)))[np.array(layout.firing_order) - 1]
    assert np.diff(firing).tolist() == [90.0] * 7
    # l_shk of the published engine, from the rod's rotating mass.
    assert layout.cylinders[0].rod.center_distance == close(0.097, abs=1e-6)


def test_split_pins_make_a_90_degree_v6_fire_evenly():
    layout = load_mechanism("buick-3800").layout
    firing = np.array(degrees(np.radians(layout.firing_deg)))[np.array(layout.firing_order) - 1]
    assert np.diff(firing) == close([120.0] * 5)
    places = [cylinder.position for cylinder in layout.cylinders]
    assert places == sorted(places)
    assert places[1] - places[0] == close(0.023)  # neighbors on one pin's two halves


def test_hinged_rods_stand_at_the_angle_between_the_banks():
    layout = load_mechanism("8chn26-26").layout
    hinged = layout.cylinders[4]
    assert hinged.slave_pin.main_cylinder == 1
    assert hinged.slave_pin.angle_deg == close(45.0)
    assert hinged.position == layout.cylinders[0].position
    assert layout.cylinders[0].slave_pin is None


@pytest.mark.parametrize(("name", "sense"), [("6chn25-34", -1), ("vw-tdi", 1), ("6s50mc-c", -1)])
def test_engines_in_line_turn_as_their_firing_order_says(name, sense):
    mechanism = load_mechanism(name)
    layout = mechanism.layout
    assert mechanism.turning_sense == sense
    firing = np.array(np.radians(layout.firing_deg))[np.array(layout.firing_order) - 1]
    assert np.diff(firing) == close(
        [cycle_radians(layout.strokes) / len(firing)] * (len(firing) - 1)
    )
    assert any("rod.inertia is not given" in remark for remark in mechanism.remarks)


def test_gas_reaches_what_the_file_asks_for():
    mechanism = load_mechanism("yamz-5340")
    assert mechanism.pressure[0].peak_pressure == close(13e6 + ATMOSPHERE, rel=1e-9)
    assert len(mechanism.pressure) == 4
    assert any("combustion_start" in remark for remark in mechanism.pressure[0].remarks)
    assumed = [remark for remark in mechanism.pressure[0].remarks if "intake_pressure" in remark]
    assert len(assumed) == 1


def written(tmp_path, changes, name="6chn25-34"):
    text = input_path(name).read_text(encoding="utf-8")
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
    lines = input_path("6chn25-34").read_text(encoding="utf-8").splitlines()
    (peak,) = (line for line in lines if line.startswith("peak_pressure"))
    path = written(tmp_path, {peak: 'pressure_table = "gas.csv"'})
    mechanism = load_mechanism(path)
    assert mechanism.pressure[5].at(angle_deg=np.degrees([math.radians(10.0)]))[0] == close(
        1e5 * (1.5 + 80.0 * math.exp(-((2.0 / 25.0) ** 2))), rel=1e-6
    )
    with pytest.raises(InputError, match=r"gas\.pressure_table: given 'no\.csv', which is neither"):
        load_mechanism(written(tmp_path, {peak: 'pressure_table = "no.csv"'}))


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
            r"cylinder 8: crank_angle_deg: given 0 deg; allowed is that of cylinder 3, 180 deg",
        ),
        (
            "8chn26-26",
            {"value = [5, 6, 7, 8], source": "value = [5, 6, 7, 9], source"},
            r"hinged_rods\.cylinders: given 9; allowed is 1 to 8",
        ),
        (
            "buick-3800",
            {'"0 deg", "30 deg", "240 deg"': '"0 deg", "10 deg", "240 deg"'},
            r"engine\.crank_angles: given 10 deg for cylinder 2, whose pin on throw 1 is at 30 deg",
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
            r"^rod\.inertia: given 0\.65 kg m\^2; allowed is 0\.\d+ kg m\^2 or less",
        ),
        (
            "8chn13-14",
            {"inertia = ": "# inertia = "},
            r"^rod\.center_offset: given 9 mm without inertia; allowed are both",
        ),
        (
            "8chn13-14",
            {'"140 mm"': '"180 mm"'},
            r"^throw\.crank_radius: given 70 mm; allowed is half of engine\.stroke, 90 mm",
        ),
        (
            "8chn26-26",
            {"value = [5, 6, 7, 8], source": "value = [5, 5, 7, 8], source"},
            r"^hinged_rods\.cylinders: given \[5, 5, 7, 8\]; allowed is each number once",
        ),
        (
            "6chn25-34",
            {'"37 kg"': '"0 kg"'},
            r"^rod\.rotating_mass: given 0 kg; allowed is above 0",
        ),
        (
            "6chn25-34",
            {"[piston]\n": '[piston]\npin_offset = "200 mm"\n'},
            r"^piston\.pin_offset: given 200 mm; allowed is 170 mm or less either way",
        ),
        (
            "6chn25-34",
            {"[gas]\n": '[gas]\npressure_table = "x.csv"\n'},
            r"^gas\.peak_pressure: given together with pressure_table; allowed is one of the two",
        ),
        (
            "6chn25-34",
            {"peak_pressure": "compression_ratio", '"8.5 MPa"': "13.0"},
            r"^gas\.peak_pressure: given neither it nor mean_effective_pressure",
        ),
        (
            "6chn25-34",
            {"[gas]\n": '[gas]\nintake_pressure = "5 bar"\n'},
            r"gas\.peak_pressure: given 8\.5 MPa above ambient; allowed in all are 16\.09",
        ),
        (
            "6chn25-34",
            {"[gas]\n": '[gas]\ncombustion_start = "-84 deg"\ncombustion_duration = "1 deg"\n'},
            r"^gas\.combustion_duration: given 1 deg; allowed is 2 deg or more",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(tmp_path, name, changes, message):
    with pytest.raises(InputError, match=message):
        load_mechanism(written(tmp_path, changes, name))


def test_unusual_inertias_are_told(tmp_path):
    path = written(tmp_path, {"0.0589 kg m^2": "0.0001 kg m^2"}, "8chn13-14")
    (remark,) = (text for text in load_mechanism(path).remarks if "inertia" in text)
    assert remark.startswith("rod.inertia is 0.0015 times that of two masses at its pins; usual")


def test_a_v_engine_with_flywheel_and_thrust_bearing_is_a_whole_engine():
    read = load_any("8chn13-14")
    assert isinstance(read, EngineFile)
    assert read.throws == (0, 1, 2, 3, 0, 1, 2, 3)
    assert read.pins == read.throws
    assert read.throw_angles_deg == close([0.0, 90.0, 270.0, 180.0])
    assert isinstance(load_any("buick-3800"), MechanismFile)


def test_an_engine_in_line_without_flywheel_is_a_mechanism(tmp_path):
    path = tmp_path / "engine.toml"
    text = input_path("6chn25-34").read_text(encoding="utf-8")
    start, end = text.index("[flywheel]"), text.index("[gas]")
    path.write_text(text[:start] + text[end:], encoding="utf-8")
    assert isinstance(load_any(path), MechanismFile)
    with pytest.raises(InputError, match="describes a crank mechanism, not a whole engine"):
        load_engine(path)


def test_what_a_file_describes():
    assert isinstance(load_any("8chn26-26"), MechanismFile)
    assert type(load_any("6chn25-34")).__name__ == "EngineFile"
    assert type(load_any("8chn14-14")).__name__ == "ThrowFile"
    with pytest.raises(
        InputError, match=r"the sections \[engine\], \[rod\], \[piston\] are missing"
    ):
        load_mechanism("8chn14-14")
    assert load_mechanism(Path("6chn25-34")).name == "6ChN 25/34"


@pytest.mark.parametrize("name", ["8chn13-14", "6chn25-34"])  # senses +1 and -1
def test_throws_stand_with_their_unbalance_at_their_angles(name):
    mechanism = load_mechanism(name)
    # A throw without any symmetry: its center aside of the crank's plane, unequal ends.
    inertia = np.array([[3.0, 0.1, -0.3], [0.1, 2.0, 0.21], [-0.3, 0.21, 1.5]])
    masses = MassProperties(100.0, np.array([0.02, -0.01, 0.18]), inertia)
    layout = with_throws(mechanism, masses)
    sense, length = mechanism.turning_sense, mechanism.throw.length
    for number, angle in enumerate(np.radians(mechanism.throw_angles_deg)):
        found = unbalance(
            masses.moved(angle_deg=math.degrees(sense * angle), along=number * length), 0.0
        )
        pair = layout.rotating[2 * number : 2 * number + 2]
        phasors = np.array(
            [mass.static_moment * np.exp(1j * math.radians(mass.angle_deg)) for mass in pair]
        )
        places = np.array([mass.position for mass in pair])
        # y - i x of the layout; where the shaft turns against the file's sense, x is mirrored.
        for values, expected in (
            (phasors.sum(), found.static),
            ((phasors * places).sum(), found.dynamic),
        ):
            assert values == close(complex(expected[1], -sense * expected[0]), abs=1e-9)
    about_shaft = len(mechanism.throw_angles_deg) * masses.inertia_about_shaft
    assert layout.shaft_inertia == close(about_shaft + mechanism.attached_inertia)
    flywheel_and_free_end = {"8chn13-14": 2.66, "6chn25-34": 452.0}[name]
    assert mechanism.attached_inertia == close(flywheel_and_free_end)


def test_the_throws_unbalance_comes_from_their_solid():
    mechanism = load_mechanism("buick-3800")
    masses = throw_masses(mechanism.throw, mechanism.material.density)
    assert with_throws(mechanism) == with_throws(mechanism, masses)


def mirrored(text):
    """The same engine with angles counted the other way round."""
    lines = text.splitlines()
    for place, line in enumerate(lines):
        if line.startswith(("crank_angles", "bank_angles", "throw_angles")):
            head, values, tail = re.fullmatch(r"(.*?\[)(.*?)(\].*)", line).groups()
            turned = re.sub(
                r'"(-?)([\d.]+ deg)"', lambda m: f'"{"" if m[1] else "-"}{m[2]}"', values
            )
            lines[place] = head + turned + tail
    return "\n".join(lines)


@pytest.mark.parametrize("name", ["8chn26-26", "8chn13-14"])
def test_the_sense_in_which_a_file_counts_angles_makes_no_difference(tmp_path, name):
    text = input_path(name).read_text(encoding="utf-8")
    other = tmp_path / "other.toml"
    changed = mirrored(text)
    if name == "8chn26-26":
        text = text.replace("[hinged_rods]\n", '[hinged_rods]\npin_angle = "50 deg"\n')
        changed = changed.replace("[hinged_rods]\n", '[hinged_rods]\npin_angle = "-50 deg"\n')
    same = tmp_path / "same.toml"
    same.write_text(text, encoding="utf-8")
    other.write_text(changed, encoding="utf-8")
    one, two = load_mechanism(same), load_mechanism(other)
    assert (one.turning_sense, two.turning_sense) == (1, -1)
    angles = np.linspace(0.0, 4.0 * math.pi, 50)
    forces = [
        mechanism_forces(
            m.layout,
            50.0,
            gas_forces(m.layout, m.pressure, shaft_angles_deg=np.degrees(angles)),
            shaft_angles_deg=np.degrees(angles),
        )
        for m in (one, two)
    ]
    assert np.radians(two.layout.firing_deg) == close(np.radians(one.layout.firing_deg))
    assert np.abs(forces[0].crankpin - forces[1].crankpin).max() < 1e-9 * 1e6


def test_all_cylinders_breathe_from_one_receiver():
    mechanism = load_mechanism("8chn26-26")
    assumed = {
        remark
        for pressure in mechanism.pressure
        for remark in pressure.remarks
        if "intake_p" in remark
    }
    assert len(assumed) == 1
    # The hinged rods' pistons move otherwise: their pressure is their own.
    first, hinged = mechanism.pressure[0], mechanism.pressure[4]
    assert first is mechanism.pressure[3]
    assert hinged is mechanism.pressure[7]
    assert np.abs(first.pressure / hinged.pressure - 1.0).max() > 1e-4


def test_a_shipped_torque_table_by_name(tmp_path):
    shipped = cf.load_torque_table("yamz5340_torque_one_throw.csv")
    assert shipped.torque.size == 36
    path = tmp_path / "own.csv"
    path.write_text("crank_angle_deg,torque_Nm\n0,1\n180,2\n360,3\n540,4\n", encoding="utf-8")
    assert cf.load_torque_table(path).torque.tolist() == [1.0, 2.0, 3.0, 4.0]
    for missing in ("none.csv", tmp_path / "yamz5340_torque_one_throw.csv"):
        with pytest.raises(InputError, match="cannot be read"):
            cf.load_torque_table(missing)
