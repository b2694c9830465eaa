"""Engine files as crank mechanisms, and their sections on excitation, power and limits."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import crankfem as cf
from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.engine_mechanism import load_any, pressures_at, with_throws
from crankfem.analyses.vibration.engine_excitation import (
    calculated_speeds,
    engine_harmonics,
    failing_harmonics,
)
from crankfem.analyses.vibration.engine_load import engine_load
from crankfem.files.engine.engine_file import load_engine, load_mechanism
from crankfem.files.engine.full_load import motored_for_misfire
from crankfem.files.reading.data_files import InputFiles, input_path
from crankfem.files.sections.excitation_sections import (
    GasMap,
    Misfire,
    PropellerForcesSection,
    gas_map_load,
    gas_map_pressure,
)
from crankfem.files.sections.limits_sections import LimitsInput, RangesInput
from crankfem.files.sections.mechanism_sections import Gas, LoadSection, Rod
from dynamics.cycle import cycle_radians
from dynamics.engine.forces import gas_forces, mechanism_forces
from dynamics.engine.layout import EngineCylinder, EngineLayout
from dynamics.engine.rods import ConnectingRod
from dynamics.excitation.cylinders import cylinder_forces
from dynamics.gas.pressure import read_pressure_table
from geometry.crankshaft import throw_masses
from geometry.mass import MassProperties, unbalance

MASSES = st.floats(0.1, 500.0)


def degrees(values):
    return [round(math.degrees(value), 6) for value in values]


@given(
    length=st.floats(0.05, 3.0), share=st.floats(0.3, 0.9), arm=st.floats(0.02, 2.0), mass=MASSES
)
def test_a_rods_inertia_by_its_swings(length, share, arm, mass):
    """A uniform bar swings about its end as a point at two thirds of its length does; and any body about
    two edges by two periods that give one inertia."""
    rod = {"length": length, "mass": mass, "rotating_mass": share * mass}
    period = 2.0 * math.pi * math.sqrt(2.0 * length / 3.0 / 9.80665)
    bar = Rod(**rod, swing_period=period, swing_distance=0.5 * length)
    assert bar.known_inertia == close(mass * length**2 / 12.0, rel=1e-9)
    about = bar.known_inertia + mass * arm**2
    other = 2.0 * math.pi * math.sqrt(about / (mass * 9.80665 * arm))
    assert Rod(**rod, swing_period=other, swing_distance=arm).known_inertia == close(
        bar.known_inertia, rel=1e-9, abs=1e-12 * about
    )
    with pytest.raises(InputError, match=r"^rod\.swing_period: "):
        Rod(
            **rod, swing_period=0.999 * 2.0 * math.pi * math.sqrt(arm / 9.80665), swing_distance=arm
        )


@pytest.mark.slow
def test_an_engine_whose_rods_were_swung_is_that_of_their_inertia(tmp_path, edit):
    """The published asymmetric rod, swung about the far edge of its small end's bore of 40 mm."""
    text = input_path("8chn13-14").read_text("utf-8")
    plain, path = load_mechanism("8chn13-14"), tmp_path / "swung.toml"
    swings = {"rod.inertia": None, "rod.mass": '"4.2 kg"\nswing_period = "1.0281643346 s"'}
    swings |= {"rod.length": '"265 mm"\nswing_distance = "188 mm"'}
    path.write_text(edit(text, swings), "utf-8")
    swung = load_mechanism(path)
    assert swung.layout.cylinders[0].rod.inertia == close(0.0589, rel=1e-8)
    assert [cylinder.rod.center for cylinder in swung.layout.cylinders] == [
        cylinder.rod.center for cylinder in plain.layout.cylinders
    ]
    assert not any("inertia" in remark for remark in swung.remarks)
    for right, wrong in (
        ('"1.0281643346 s"', '"1.0281643346 s"\ninertia = "0.05 kg m^2"'),
        ('"1.0281643346 s"', '"3 s"'),
        ('swing_distance = "188 mm"', ""),
    ):
        path.write_text(edit(text, swings).replace(right, wrong), "utf-8")
        with pytest.raises(InputError, match=r"^rod\.swing_period: "):
            load_mechanism(path)


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
    assert mechanism.engine.turning_sense == sense
    firing = np.array(np.radians(layout.firing_deg))[np.array(layout.firing_order) - 1]
    assert np.diff(firing) == close(
        [cycle_radians(layout.strokes) / len(firing)] * (len(firing) - 1)
    )
    assert any("rod.inertia is not given" in remark for remark in mechanism.remarks)


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
    mechanism = load_mechanism(written(tmp_path, {peak: 'pressure_table = "gas.csv"'}))
    assert mechanism.pressure[5].at(angle_deg=np.degrees([math.radians(10.0)]))[0] == close(
        1e5 * (1.5 + 80.0 * math.exp(-((2.0 / 25.0) ** 2))), rel=1e-6
    )
    with pytest.raises(InputError, match=r"^gas\.pressure_table: "):
        load_mechanism(written(tmp_path, {peak: 'pressure_table = "no.csv"'}))


def test_a_v_engine_with_flywheel_and_thrust_bearing_is_a_whole_engine():
    read = load_any("8chn13-14")
    assert read.whole
    assert read.throws == (0, 1, 2, 3, 0, 1, 2, 3)
    assert read.pins == read.throws
    assert read.throw_angles_deg == close([0.0, 90.0, 270.0, 180.0])
    assert not load_any("buick-3800").whole


def test_an_engine_in_line_without_flywheel_is_a_mechanism(tmp_path):
    path = tmp_path / "engine.toml"
    text = input_path("6chn25-34").read_text(encoding="utf-8")
    start, end = text.index("[flywheel]"), text.index("[gas]")
    path.write_text(text[:start] + text[end:], encoding="utf-8")
    assert not load_any(path).whole
    with pytest.raises(InputError, match="crank mechanism"):
        load_engine(path)


@pytest.mark.parametrize("name", ["8chn13-14", "6chn25-34"])  # senses +1 and -1
def test_throws_stand_with_their_unbalance_at_their_angles(name):
    mechanism = load_mechanism(name)
    # A throw without any symmetry: its center aside of the crank's plane, unequal ends.
    inertia = np.array([[3.0, 0.1, -0.3], [0.1, 2.0, 0.21], [-0.3, 0.21, 1.5]])
    masses = MassProperties(100.0, np.array([0.02, -0.01, 0.18]), inertia)
    layout = with_throws(mechanism, masses)
    sense, length = mechanism.engine.turning_sense, mechanism.throw.length
    for number, angle in enumerate(np.radians(mechanism.rotation_angles_deg)):
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
    about_shaft = len(mechanism.rotation_angles_deg) * masses.inertia_about_shaft
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


@pytest.mark.slow
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
    assert (one.engine.turning_sense, two.engine.turning_sense) == (1, -1)
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


RATED = 2000.0 * math.pi / 30.0


def write_table(folder, name, peak_bar):
    """A motored diagram with a hump of combustion, as a table of 1 deg."""
    angle = np.arange(-360.0, 360.0, 2.0)
    crank = np.radians(angle)
    way = 0.32 - 0.07 * np.cos(crank) - np.sqrt(0.25**2 - (0.07 * np.sin(crank)) ** 2)
    volume = np.where(np.abs(angle) < 180.0, 1.0 + 14.0 * way / 0.14, 15.0)
    pressure = 1.5 * (15.0 / volume) ** 1.35 + peak_bar * np.exp(-(((angle - 14.0) / 12.0) ** 2))
    rows = [f"{a:g},{p:.6g}" for a, p in zip(angle, pressure, strict=True)]
    text = "\n".join(["# made for a test", "crank_angle_deg,absolute_pressure_bar", *rows])
    (folder / name).write_text(text + "\n")


@pytest.fixture
def file(tmp_path):
    for name, peak in (("low.csv", 20.0), ("mid.csv", 45.0), ("full.csv", 80.0)):
        write_table(tmp_path, name, peak)
    return tmp_path / "engine.toml"


POINTS = [
    {"speed": "1000 1/min", "load": 0.25, "pressure_table": "low.csv"},
    {"speed": "1500 1/min", "load": 0.5625, "pressure_table": "mid.csv"},
    {"speed": "2000 1/min", "load": 1.0, "pressure_table": "full.csv"},
]
LAYOUT = EngineLayout(
    0.07, [EngineCylinder(0.13, 2.0, ConnectingRod(0.25, 2.0, 0.08, 0.02))] * 1, [1]
)


def test_a_map_along_a_curve_reads_its_tables(file):
    section = GasMap.from_text({"points": POINTS})
    found = gas_map_pressure(section, 4, InputFiles(file))
    assert found.speeds == close(np.array([0.5, 0.75, 1.0]) * RATED)
    assert gas_map_load(section, RATED) is None
    full = read_pressure_table(file.parent / "full.csv")
    assert found.at(RATED).pressure == close(
        full.at(angle_deg=found.at(RATED).angles_deg), rel=1e-9
    )
    cylinder_forces(LAYOUT, [0.6 * RATED, 0.9 * RATED], 6.0, found)


def test_points_of_a_map_may_take_columns_of_one_table(file):
    low, full = (
        [line.split(",") for line in (file.parent / name).read_text().splitlines()[1:]]
        for name in ("low.csv", "full.csv")
    )
    rows = [f"{a},{p},{q}" for (a, p), (_, q) in zip(low[1:], full[1:], strict=True)]
    (file.parent / "both.csv").write_text("\n".join(["angle,P1,P2", *rows]), encoding="utf-8")
    section = GasMap.from_text(
        {
            "points": [
                {
                    "speed": f"{speed} 1/min",
                    "pressure_table": "both.csv",
                    "reading": {"columns": {"crank_angle_deg": 1, "absolute_pressure_bar": column}},
                }
                for speed, column in ((1000, "P1"), (2000, "P2"))
            ]
        }
    )
    found = gas_map_pressure(section, 4, InputFiles(file))
    for speed, name in ((0.5 * RATED, "low.csv"), (RATED, "full.csv")):
        alone = read_pressure_table(file.parent / name)
        angles = alone.angles_deg
        assert found.at(speed).at(angle_deg=angles) == close(alone.pressure, rel=1e-6)


def test_a_grid_takes_the_load_of_a_law(file):
    grid = [
        {"speed": f"{speed} 1/min", "load": load, "pressure_table": name}
        for speed in (1000, 2000)
        for load, name in ((0.2, "low.csv"), (1.0, "full.csv"))
    ]
    section = GasMap.from_text({"points": grid, "law": "propeller", "method": "linear"})
    found, load = gas_map_pressure(section, 4, InputFiles(file)), gas_map_load(section, RATED)
    assert load(np.array([0.6 * RATED])) == close([0.36])
    assert found.weights([0.6 * RATED], load) == close(
        np.array([[0.8 * 0.8, 0.8 * 0.2, 0.2 * 0.8, 0.2 * 0.2]])
    )
    constant = GasMap.from_text({"points": grid, "law": "constant", "rated_load": 0.7})
    assert gas_map_load(constant, RATED) == 0.7
    power = GasMap.from_text({"points": grid, "law": "propeller", "measure": "power"})
    assert gas_map_load(power, RATED)(np.array([0.5 * RATED])) == close([0.125])


@pytest.mark.parametrize(
    ("values", "field"),
    [
        ({}, "points"),
        ({"points": [POINTS[0] | {"speed": 1000}]}, r"points\[0\]\.speed"),
        ({"points": POINTS, "law": "cubic"}, "law"),
        ({"points": [POINTS[0] | {"pressure_table": "no.csv"}]}, r"points\[0\]\.pressure_table"),
        ({"points": [POINTS[0], POINTS[0]]}, "points"),
    ],
)
def test_wrong_maps_are_refused(file, values, field):
    with pytest.raises(InputError, match=rf"^gas_map\.{field}: "):
        gas_map_pressure(GasMap.from_text(values), 4, InputFiles(file))


def test_misfire_takes_the_motored_pressure_of_table_or_cycle(file):
    section = Misfire.from_text({"missing_share": 0.5})
    assert section.cylinders is None
    assert section.compression
    assert not Misfire.from_text({"cylinders": [1], "compression": False}).compression
    full = read_pressure_table(file.parent / "full.csv")
    gas = Gas.from_text({"pressure_table": "full.csv", "compression_ratio": 15.0})
    (cold,) = motored_for_misfire(gas, LAYOUT, [full])
    # The table was made with the exponent 1.35, six digits, and 2e-9 of combustion at -40 deg.
    assert cold.peak_pressure == close(1.5e5 * 15.0**1.35, rel=1e-5)
    assert cold.peak_pressure < 0.7 * full.peak_pressure
    by_cycle = Gas.from_text({"peak_pressure": "12 MPa", "compression_ratio": 15.0})
    (modeled,) = motored_for_misfire(by_cycle, LAYOUT, [full])
    assert modeled.source == "cycle model"
    forces = cylinder_forces(
        LAYOUT, [RATED], 4.0, full, misfire={1: section.missing_share}, motored=cold
    )
    whole = cylinder_forces(LAYOUT, [RATED], 4.0, full)
    none = cylinder_forces(LAYOUT, [RATED], 4.0, cold)
    assert forces.mean_torque == close(0.5 * (whole.mean_torque + none.mean_torque))


def test_propeller_section():
    values = {
        "blades": 4,
        "rated_speed": "120 1/min",
        "rated_thrust": "900 kN",
        "rated_torque": "700 kN m",
        "thrust_shares": [0.06, 0.01],
        "torque_shares": [0.05],
        "torque_phases": ["30 deg"],
    }
    section = PropellerForcesSection.from_text(values)
    assert section.node == "propeller"
    forces = section.forces
    assert forces.mean_thrust([2.0 * math.pi]) == close([225e3])
    assert forces.torque_phases_deg == close([30.0])
    assert forces.thrust_phases_deg == close([0.0, 0.0])
    wrong = PropellerForcesSection.from_text(values | {"torque_phases": ["30 deg", "1 deg"]})
    with pytest.raises(InputError, match=r"^propeller_forces\.torque_phases: "):
        _ = wrong.forces


RPM = np.pi / 30.0
POWER_POINTS = [
    {"speed": "200 1/min", "mean_effective_pressure": "3 bar"},
    {"speed": "515 1/min", "mean_effective_pressure": "13 bar"},
]


@pytest.fixture(scope="module")
def engine():
    return cf.load_engine("6chn25-34")


def with_points(*points):
    return LoadSection.from_text({"points": [*POWER_POINTS, *points]})


def pointed(**fields):
    """Points of both speeds with further fields in each."""
    return LoadSection.from_text({"points": [point | fields for point in POWER_POINTS]})


def test_a_load_that_the_cycle_cannot_reach(engine):
    changed = engine.changed(load=pointed(peak_pressure="2 bar"))
    with pytest.raises(InputError, match=r"^load: at 200 1/min"):
        engine_load(changed)


@pytest.mark.parametrize(
    ("rated", "consistent"), [(330e3, False), (429e3, True), (550e3, True), (560e3, False)]
)
def test_rated_power_fits_the_gas_or_not(engine, rated, consistent):
    power = engine.changed(engine={"rated_power": rated}).power
    assert power.consistent is consistent
    assert power.mechanical_efficiency == close(rated / 570.2277e3, 1e-5)
    # Friction is the rest of the mean pressure where the two fit, and unknown where they do not.
    rest = power.mean_indicated_pressure * (1.0 - rated / power.indicated)
    assert power.friction_pressure == (close(rest, 1e-9) if consistent else 0.0)


def test_without_rated_power_nothing_checks(engine):
    power = engine.power
    assert power.consistent
    assert power.mechanical_efficiency is power.mean_effective_pressure is None


@pytest.mark.slow
def test_two_points_are_met_with_a_straight_line_between(engine):
    points = [
        POWER_POINTS[0] | {"peak_pressure": "40 bar", "intake_pressure": "1.1 bar"},
        POWER_POINTS[1] | {"peak_pressure": "84 bar", "intake_pressure": "2.0 bar"},
    ]
    changed = engine.changed(load=LoadSection.from_text({"points": points}))
    told = engine_load(changed)
    assert told.law == "points"
    assert told.speeds / RPM == close([200.0, 250.0, 375.0, 500.0, 515.0])
    share = (told.speeds / RPM - 200.0) / 315.0
    assert told.mean_pressure == close(3e5 + 10e5 * share, 1e-5)
    assert told.peak_pressure == close(40e5 + 44e5 * share + 101325.0, 1e-5)
    assert told.intake_pressure == close(1.1e5 + 0.9e5 * share)


def test_vibration_is_calculated_as_far_as_points_reach(engine):
    changed = engine.changed(load=with_points())
    speeds = calculated_speeds(changed, np.array([0.5]), (), [20.0])
    assert speeds[[0, -1]] / RPM == close([200.0, 515.0])
    with pytest.raises(InputError, match=r"^load\.points: "):
        pressures_at(changed, [600.0 * RPM])


def test_the_boost_goes_with_the_power(engine):
    """Compression in a cylinder without combustion shows it."""
    changed = engine.changed(load={"law": "propeller"})
    (half, full) = pressures_at(changed, np.array([250.0, 500.0]) * RPM, motored=True)
    told = engine_load(changed)
    intake = dict(zip(np.round(told.speeds / RPM), told.intake_pressure, strict=True))
    assert intake[250.0] - 101325.0 == close((intake[500.0] - 101325.0) / 8.0)
    assert half[0].peak_pressure / full[0].peak_pressure == close(intake[250.0] / intake[500.0])


@pytest.mark.slow
def test_a_cylinder_that_misfires_is_motored_at_its_load(engine):
    changed = engine.changed(load={"law": "propeller"}, misfire={"cylinders": (1,)})
    firing = engine_harmonics(changed)
    assert firing.one_diagram == ""
    failing = failing_harmonics(changed, firing)
    speed = np.array([250.0 * RPM])
    burning, motored = (own.phasors(speed)[0, 0, :, 0].real for own in (firing, failing))
    assert (abs(motored) < 0.1 * burning).all()


def test_a_constant_load_is_what_no_section_says(engine):
    given = engine.changed(load={"law": "constant"})
    found = [engine_load(one) for one in (engine, given)]
    assert [one.law for one in found] == ["constant", "constant"]
    assert found[0].mean_pressure == close(found[1].mean_pressure)
    assert "intake_pressure" not in found[0].to_record()["speeds"][0]


def test_a_pressure_map_is_checked_in_place_of_the_gas(engine, tmp_path):
    pressure = engine.pressure[0]
    rows = zip(pressure.angles_deg, pressure.pressure / 1e5, strict=True)
    for name, share in (("low", 0.5), ("full", 1.0)):
        lines = [f"{angle:.9g},{share * bar:.9g}" for angle, bar in rows]
        text = "\n".join(["crank_angle_deg,absolute_pressure_bar", *lines])
        (tmp_path / f"{name}.csv").write_text(f"{text}\n", encoding="utf-8")
        rows = zip(pressure.angles_deg, pressure.pressure / 1e5, strict=True)
    points = [
        {"speed": "200 1/min", "load": 0.5, "pressure_table": "low.csv"},
        {"speed": "515 1/min", "load": 1.0, "pressure_table": "full.csv"},
    ]
    section = GasMap.from_text({"points": points, "method": "linear"})
    changed = engine.changed(engine={"rated_power": 330e3}, gas=None, gas_map=section)
    changed = replace(changed, files=InputFiles(tmp_path / "engine.toml"))
    told = engine_load(changed)
    mean = 1.366668e6 * np.interp(told.speeds / RPM, [200.0, 515.0], [0.5, 1.0])
    assert told.law == "map"
    assert told.mean_pressure == close(mean, 1e-4)
    assert told.rated.indicated == close(570.2277e3 * mean[3] / 1.366668e6, 1e-4)


@pytest.mark.further
def test_console_tells_power_and_load(call, tmp_path):
    text = cf.load_engine("6s50mc-c").path.read_text(encoding="utf-8")
    file = tmp_path / "engine.toml"
    file.write_text(text.replace('"9480 kW"', '"5 MW"'), encoding="utf-8")
    for command in ("check", "mechanism"):
        answer = call(command, str(file))
        assert (answer.code, "0.501" in answer.out) == (0, True)
    fine = call("mechanism", "6s50mc-c", "--speed", "63.5 1/min", "--json").json()
    assert fine["rated"]["mechanical_efficiency"] == close(0.9504, 1e-3)
    # Friction of 1 bar beside a quarter of 19 bar.
    assert fine["mean_indicated_pressure"] == close(1.9e6 / 4.0 + 0.1e6, 1e-2)


def test_power_that_does_not_fit_and_the_load_are_told(engine):
    changed = engine.changed(engine={"rated_power": 330e3}, load={"law": "propeller"})
    told = engine_load(changed).to_record()
    assert not told["rated"]["consistent"]
    # Rated and indicated power that do not fit tell nothing of friction.
    assert "friction" not in told["sentence"]


def test_limits_come_with_their_units_and_sources():
    section = LimitsInput.from_text(
        {
            "axial_amplitude": "0.4 mm",
            "coupling_torque": "2 kN m",
            "coupling_torque_passing": "3 kN m",
            "torsional_amplitude": "0.6 deg",
        },
        "limits",
    )
    found = section.limits(
        100.0, strokes=4, provenance={"limits.axial_amplitude": ("drawing 12", True)}
    )
    assert set(found) == {"axial_amplitude", "coupling_torque", "torsional_amplitude"}
    speed = np.array([50.0])
    assert found["axial_amplitude"].continuous.at(speed) == close([4e-4])
    assert found["axial_amplitude"].source == "drawing 12"
    assert found["axial_amplitude"].assumed
    assert found["coupling_torque"].passing.at(speed) == close([3e3])
    assert found["coupling_torque"].source == "given in the engine file"
    assert found["torsional_amplitude"].continuous.at(speed) == close(np.radians([0.6]))


def test_rules_are_picked():
    section = LimitsInput.from_text(
        {
            "crankshaft_rule": "KR main engine",
            "tensile_strength": "660 MPa",
            "yield_strength": "450 MPa",
            "alloy": True,
            "highest_barred": 0.7,
            "shafts": [
                {
                    "element": "flywheel - propeller",
                    "diameter": "500 mm",
                    "tensile_strength": "560 MPa",
                }
            ],
        },
        "limits",
    )
    found = section.limits(100.0, strokes=4)
    speed = np.array([50.0])
    # Worked out by hand in tests/validation/test_limit_rules.py.
    assert found["crankshaft_stress"].continuous.at(speed) == close([52e6])
    shaft = found["shaft: flywheel - propeller"]
    assert shaft.name == "torsional stress of flywheel - propeller"
    assert shaft.continuous.at(speed) == close([61.83e6], abs=5e3)
    assert section.barred_rule(100.0).highest == close(70.0)
    assert section.barred_rule(100.0).highest_by(shaft) == close(70.0)
    assert LimitsInput().barred_rule(100.0).highest_by(shaft) == close(80.0)
    genset = section.model_copy(update={"crankshaft_rule": "KR generator set"})
    found = genset.limits(100.0, strokes=4)["crankshaft_stress"]
    assert found.continuous.at(np.array([100.0])) == close([28e6])  # 21 * 4/3


def test_ranges_become_spreads_of_each_chain():
    section = RangesInput.from_text(
        {"axial_compliance": [0.97, 1.05], "thrust_stiffness": [0.5, 2.0], "damping": [0.5, 2.0]},
        "ranges",
    )
    assert [(s.kind, s.low, s.high) for s in section.axial_spreads()] == [
        ("compliance", 0.97, 1.05),
        ("ground stiffness", 0.5, 2.0),
        ("all damping", 0.5, 2.0),
    ]
    assert [s.name for s in section.torsional_spreads()] == ["damping"]
    assert (section.samples, section.seed, section.separation_margin) == (200, 0, 0.1)
