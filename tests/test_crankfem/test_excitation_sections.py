"""Sections on what excites: from text with units to pressure map, load, misfire and propeller."""

import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.files.reading.data_files import InputFiles
from crankfem.files.sections.excitation_sections import (
    GasMap,
    Misfire,
    PropellerForcesSection,
    gas_map_load,
    gas_map_pressure,
    motored_for_misfire,
)
from crankfem.files.sections.mechanism_sections import Gas
from dynamics.engine.layout import EngineCylinder, EngineLayout
from dynamics.engine.rods import ConnectingRod
from dynamics.excitation.cylinders import cylinder_forces
from dynamics.gas.pressure import read_pressure_table

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
    ("values", "sentence"),
    [
        ({}, "gas_map.points: given none"),
        (
            {"points": [POINTS[0] | {"speed": 1000}]},
            r"gas_map.points\[0\].speed: given 1000, a bare",
        ),
        ({"points": POINTS, "law": "cubic"}, "gas_map.law: given 'cubic'; allowed is"),
        (
            {"points": [POINTS[0] | {"pressure_table": "no.csv"}]},
            r"gas_map.points\[0\].pressure_table",
        ),
        ({"points": [POINTS[0], POINTS[0]]}, "gas_map.points: given 2 points of which 1 differ"),
    ],
)
def test_wrong_maps_are_refused(file, values, sentence):
    with pytest.raises(InputError, match=sentence):
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
    with pytest.raises(InputError, match=r"propeller_forces.torque_phases: given 2 for 1 shares"):
        _ = wrong.forces
