"""A compressor that a motor drives: what its file may hold, its power, its order at the top, its chain."""

import math
from pathlib import Path

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.engine_mechanism import input_warnings
from crankfem.analyses.shaft.chains import engine_torsional_chain
from crankfem.files.engine.engine_file import load_engine
from dynamics.gas.compressor import CompressorCycle
from dynamics.gas.pressure import read_pressure_table

FILE = Path(__file__).parents[1] / "data" / "engines" / "3-250-200-compressor.toml"
COMPRESSOR = {"suction_pressure", "discharge_pressure", "clearance", "exponent"}


@pytest.fixture(scope="module")
def compressor():
    return load_engine(FILE)


def test_power_is_compared_by_size(compressor):
    power = compressor.power
    swept = 0.25 * math.pi * 0.25**2 * 0.2
    taken_in = swept * (1.06 - 0.06 * 4.0 ** (1.0 / 1.35))
    work = 1e5 * taken_in * 1.35 / 0.35 * (4.0 ** (0.35 / 1.35) - 1.0)
    assert power.indicated == close(-3.0 * work * 10.0, 1e-5)
    assert power.mechanical_efficiency == close(3.0 * work * 10.0 / 50e3, 1e-5)
    assert power.mean_effective_pressure == close(-50e3 / (3.0 * swept * 10.0), 1e-5)
    assert power.consistent
    starved = compressor.changed(engine={"rated_power": 500e3})
    assert not starved.power.consistent


def test_values_are_compared_with_the_torque_by_size(compressor):
    """Without a rated power the indicated one counts, which a driven machine takes: it is negative."""
    unrated = compressor.changed(engine={"rated_power": None}, limits={"coupling_torque": 300.0})
    assert unrated.power.indicated < 0.0
    assert input_warnings(unrated) == ()


def test_cylinders_are_numbered_in_the_order_of_their_tops(compressor):
    assert compressor.engine.top_order == (1, 2, 3)
    turned = compressor.changed(engine={"crank_angles": np.radians([0.0, 120.0, 240.0]).tolist()})
    assert turned.engine.top_order == (1, 3, 2)


@pytest.mark.slow
def test_opposed_cylinders_may_be_at_the_top_together(compressor):
    opposed = compressor.changed(
        engine={
            "cylinders": 2,
            "crank_angles": (0.0, math.pi),
            "bank_angles": (0.5 * math.pi, -0.5 * math.pi),
            "throws": (1, 2),
        },
        thrust_bearing={"main_bearing": 3},
    )
    assert opposed.engine.firing_intervals_deg == close([0.0, 360.0])
    torque = cf.run_mechanism(opposed).torque.total
    alone = cf.run_mechanism(compressor, model="two-mass").torque.total
    assert np.mean(torque) == close(2.0 / 3.0 * np.mean(alone), 1e-6)


def test_the_motor_is_a_node_behind_its_coupling(compressor):
    chain = engine_torsional_chain(compressor, np.full(3, 2e-7), np.ones(3)).chain
    assert chain.names[-1] == "motor"
    assert chain.elements[-1] == "flywheel - motor"
    assert chain.inertia[-1] == 6.0
    assert chain.stiffness[-1] == 12e3
    assert chain.loss_factor[-1] == close(0.8 / (2.0 * math.pi), 1e-12)


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"engine": {"driven_by": "wind"}}, "engine.driven_by"),
        ({"engine": {"driven_by": ""}}, "engine.firing_order"),
        ({"engine": {"driven_by": "", "firing_order": (1, 2, 3)}}, "gas.discharge_pressure"),
        ({"engine": {"driven_by": "", "firing_order": (1, 2, 3)}, "gas": None}, "driver"),
        ({"engine": {"firing_order": (1, 2, 3)}}, "engine.firing_order"),
        ({"engine": {"drives": "generator"}}, "engine.drives"),
        ({"engine": {"strokes": 4}}, "engine.strokes"),
        ({"driven": {"inertia": 1.0, "coupling_stiffness": 1e4}}, "driven"),
        (
            {"driver": {"variation": {"amplitude": (1e-3, 1e-2), "stiffness": (1.0, 1.2)}}},
            "driver.variation.amplitude",
        ),
        ({"misfire": {"cylinders": (1,)}}, "misfire"),
        ({"load": {"law": "propeller"}}, "load"),
        ({"gas": {"clearance": None}}, "gas.clearance"),
        ({"gas": {"peak_pressure": 4e5}}, "gas.peak_pressure"),
        ({"gas": {"compression_ratio": 14.0}}, "gas.compression_ratio"),
        ({"gas": {"discharge_pressure": 0.9e5}}, "gas.discharge_pressure"),
        ({"gas": {"discharge_pressure": 90e5}}, "gas.discharge_pressure"),
        ({"gas": dict.fromkeys(COMPRESSOR) | {"peak_pressure": 4e5}}, "gas.discharge_pressure"),
    ],
)
def test_what_does_not_fit_a_driven_machine_is_refused(compressor, changes, field):
    with pytest.raises(InputError, match=field.replace(".", r"\.")) as told:
        compressor.changed(**changes)
    assert str(told.value).startswith(field)


def test_rules_for_engines_do_not_judge_it(compressor):
    with pytest.raises(InputError, match=r"limits\.crankshaft_stress"):
        cf.engine_vibration(compressor.changed(limits={"crankshaft_stress": None}))


def test_a_diagram_with_a_flat_delivery_is_that_of_a_compressor(tmp_path, compressor):
    cycle = CompressorCycle(1e5, 4e5, 0.06, 1.35)
    layout = compressor.layout
    cylinder = layout.cylinders[0]

    def position(angle):
        return 0.1 * np.cos(angle) + np.sqrt(0.45**2 - (0.1 * np.sin(angle)) ** 2)

    pressure = cycle.pressure(position, cylinder.area)
    angles = np.arange(-180.0, 180.0)
    table = tmp_path / "indicator.csv"
    rows = [
        f"{a:g},{p / 1e5:.6f}" for a, p in zip(angles, pressure.at(angle_deg=angles), strict=True)
    ]
    table.write_text("crank_angle_deg,absolute_pressure_bar\n" + "\n".join(rows) + "\n")
    with pytest.raises(InputError, match=r"engine\.driven_by"):
        read_pressure_table(table, 2)
    read = read_pressure_table(table, 2, fires=False)
    assert read.peak_pressure == 4e5
    assert read.at(angle_deg=200.0) == close(pressure.at(angle_deg=200.0), 1e-5)


@pytest.mark.slow
def test_torque_is_told_by_its_size(compressor):
    torque = cf.run_mechanism(compressor).torque
    assert torque.mean < 0.0
    assert torque.nonuniformity == close(np.ptp(torque.total) / -torque.mean)
