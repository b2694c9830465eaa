"""Pressure maps: a known family of cycles met between its points, and refusals."""

import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.engine.layout import EngineCylinder, EngineLayout
from dynamics.engine.rods import ConnectingRod
from dynamics.excitation.cylinders import cylinder_forces
from dynamics.excitation.pressure_map import pressure_map, pressure_map_from_cycles, propeller_load
from dynamics.gas.cycle_values import usual_gas_cycle
from dynamics.gas.gas_cycle import gas_cycle
from dynamics.gas.pressure import gas_pressure

PER_MINUTE = math.pi / 30.0
ANGLES = np.radians(np.arange(0.0, 720.0, 2.0))
ROD = ConnectingRod(0.25, 2.0, 0.08, 0.02, 0.004)
ENGINE = EngineLayout(0.07, [EngineCylinder(0.13, 2.0, ROD)], [1])
ORDERS = np.arange(0.5, 12.1, 0.5)


def diagram(speed, load):
    """A diagram whose height, place and width of the peak follow speed and load smoothly."""
    peak = 3e6 + 6e6 * load + 1e6 * (speed / 200.0) ** 2
    place, width = 0.1 + 0.15 * speed / 200.0 - 0.05 * load, 0.35 + 0.1 * load
    since = (ANGLES + 2.0 * np.pi) % (4.0 * np.pi) - 2.0 * np.pi
    return gas_pressure(
        1.5e5 + peak * np.exp(-(((since - place) / width) ** 2)), angles_deg=np.degrees(ANGLES)
    )


def grid(speeds, loads, method="cubic"):
    points = [(float(s), float(b), diagram(s, b)) for s in speeds for b in loads]
    return pressure_map(points[::-1], method=method)


@pytest.mark.parametrize(
    ("method", "worst"),
    # Of the largest harmonic; measured 5.4e-5 and 5.3e-3 with five speeds and four loads: cubic splines
    # are of fourth order in the distance of the points, straight lines of second.
    [("cubic", 1e-4), ("linear", 8e-3)],
)
def test_held_out_points_of_a_family_are_met(method, worst):
    found = grid(np.linspace(80.0, 240.0, 5), np.linspace(0.25, 1.0, 4), method)
    speeds, loads = np.array([97.0, 143.0, 181.0, 222.0]), np.array([0.31, 0.6, 0.86, 0.4])
    phasors = found.phasors(ORDERS, speeds, loads)
    for place, (speed, load) in enumerate(zip(speeds, loads, strict=True)):
        own = grid([speed], [load]).phasors(ORDERS, [speed])[:, 0]
        error = np.max(np.abs(phasors[:, place] - own)) / np.max(np.abs(own))
        assert error < worst
        assert (method == "linear") == (error > 1e-3)
        at = found.at(speed, load)
        assert "pressure map at" in at.source
        # Weights of the diagrams are those of the harmonics, so that both are missed by the same.
        missing = np.max(np.abs(diagram(speed, load).pressure - at.pressure))
        assert missing < 2.0 * error * at.peak_pressure
        again = np.fft.rfft(at.pressure)[1:25] * 2.0 / at.pressure.size
        assert phasors[:, place] == close(again, abs=1e-9 * np.abs(again).max())


def test_forces_are_those_of_the_interpolated_diagram():
    found = grid(np.linspace(80.0, 240.0, 4), np.linspace(0.25, 1.0, 4))
    speeds = np.linspace(125.0, 235.0, 5)
    load = propeller_load(240.0)
    forces = cylinder_forces(ENGINE, speeds, 12.0, found, load=load)
    for place in (0, 3):
        own = found.at(float(speeds[place]), float(load(speeds)[place]))
        single = cylinder_forces(ENGINE, speeds[place : place + 1], 12.0, own)
        # Between its samples a diagram is a shape-preserving cubic, which is not linear in them:
        # measured 1.1e-6.
        assert forces.tangential[:, place] == close(
            single.tangential[:, 0], abs=3e-6 * np.abs(single.tangential).max()
        )
    assert forces.remarks == ()
    constant = cylinder_forces(ENGINE, speeds, 12.0, found, load=0.5)
    assert np.abs(constant.tangential[:, -1]).max() < np.abs(forces.tangential[:, -1]).max()


def test_a_map_along_a_curve_takes_no_load():
    speeds = np.linspace(100.0, 200.0, 4)
    points = [(float(s), float((s / 200.0) ** 2), diagram(s, (s / 200.0) ** 2)) for s in speeds]
    found = pressure_map(points)
    assert found.loads is None
    assert found.load_of_speed == close((speeds / 200.0) ** 2)
    # At its points a map has its diagrams.
    assert found.at(100.0).pressure == close(points[0][2].pressure, rel=1e-12)
    assert found.weights([140.0]).sum() == close(1.0)
    with pytest.raises(InputError, match="load: given for a pressure map with one diagram at each"):
        found.at(140.0, 0.5)


@pytest.mark.parametrize(
    ("speed", "load", "sentence"),
    [
        (
            70.0,
            0.5,
            "speed: given 668.451 1/min; allowed is 763.944 1/min to 2291.83 1/min, because",
        ),
        (100.0, 1.2, "load: given 1.2; allowed is 0.25 to 1, because the pressure map has no"),
        (100.0, None, "load: given none; allowed are 0.25 to 1"),
        (100.0, [0.5, 0.6], r"load: given an array of shape \(2,\)"),
    ],
)
def test_a_map_is_never_extended(speed, load, sentence):
    found = grid([80.0, 160.0, 240.0], [0.25, 1.0])
    with pytest.raises(InputError, match=sentence):
        found.weights([speed], load)
    # A range that ends on the map's own end, but for round-off, is inside.
    found.weights([240.0 * (1 + 1e-12)], 1.0)


def test_maps_that_are_none_are_refused():
    own = diagram(100.0, 0.5)
    other = gas_pressure(own.pressure[:180], 2, angles_deg=np.degrees(ANGLES[:180]))
    for points, sentence in (
        ([], "points: given none"),
        ([(100.0, 0.5, own), (100.0, 0.5, own)], "of which 1 differ"),
        ([(100.0, 0.5, own), (120.0, 0.5, other)], "diagrams of 2 and of 4 strokes"),
        (
            [(100.0, 0.5, own), (100.0, 1.0, own), (120.0, 1.0, own)],
            "none at 1145.92 1/min and load 0.5",
        ),
        ([(0.0, 0.5, own)], "pressure map speed: given 0 rad/s"),
    ):
        with pytest.raises(InputError, match=sentence):
            pressure_map(points)
    with pytest.raises(InputError, match="method: given 'nearest'"):
        pressure_map([(100.0, 0.5, own)], method="nearest")
    with pytest.raises(
        InputError, match=r"allowed are orders up to 89.5, because the pressure map's"
    ):
        pressure_map([(100.0, 0.5, own)]).phasors([90.0], [100.0])


def test_a_map_from_cycles_has_its_targets_at_the_points():
    def position(angle):
        return 0.07 * np.cos(angle) + np.sqrt(0.25**2 - (0.07 * np.sin(angle)) ** 2)

    speeds, loads = np.array([1000.0, 1500.0, 2000.0]) * PER_MINUTE, [0.5, 1.0]
    means = np.outer([1.0, 1.05, 0.95], loads) * 16e5
    intakes = 1e5 * (1.0 + np.outer([0.6, 1.0, 1.3], loads))
    found = pressure_map_from_cycles(
        usual_gas_cycle(15.0),
        position,
        0.0133,
        speeds,
        loads,
        mean_effective_pressure=means,
        intake_pressure=intakes,
        exhaust_pressure=0.9 * intakes,
        samples=720,
    )
    bar = float(intakes[1, 1])
    middle = gas_cycle(
        usual_gas_cycle(15.0, intake_pressure=bar, exhaust_pressure=0.9 * bar),
        position,
        0.0133,
        mean_effective_pressure=float(means[1, 1]),
        samples=720,
    )
    assert found.at(speeds[1], 1.0).pressure == close(middle.pressure.pressure, rel=1e-12)
    assert not any("Solved" in text for text in found.remarks)
    with pytest.raises(
        InputError, match="at 1500 1/min and load 1: mean_effective_pressure: given"
    ):
        pressure_map_from_cycles(
            usual_gas_cycle(15.0),
            position,
            0.0133,
            speeds[1:2],
            [1.0],
            mean_effective_pressure=[[1e8]],
            samples=720,
        )
    with pytest.raises(InputError, match=r"peak_pressure: given an array of shape \(2,\)"):
        pressure_map_from_cycles(
            usual_gas_cycle(15.0), position, 0.0133, speeds, [1.0], peak_pressure=[1e7, 2e7]
        )
