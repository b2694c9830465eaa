"""Power of the gas and load over the speed.

Source: Simpson's rule over a slider-crank's volume; MAN B&W 6S50MC-C, project guide, figure 1.02, layout
point L1: 9480 kW at 127 1/min with 19.0 bar; the propeller law.

Tolerance: 1e-5, samples of the cycle; 0.3 % where 19.0 bar is printed with three digits.

A propeller takes power with the cube of the speed: at half speed a quarter of the mean pressure and an
eighth of the power.
"""

from pathlib import Path

import numpy as np
import pytest

import crankfem as cf
from crankfem.analyses.vibration.engine_excitation import engine_harmonics, forces_over_speeds
from crankfem.analyses.vibration.engine_load import engine_load

pytestmark = pytest.mark.slow

FOLDER = Path(__file__).parents[1] / "data" / "engines"
OWN = ("8l32-42-damper", "5-42-176-propeller", "v12-170-190")


def own_work(engine, pressure):
    """Work of one cylinder over a cycle [J], and the volume swept [m^3], of a slider crank in line."""
    radius, length = 0.5 * engine.engine.stroke, engine.rod.length
    area = 0.25 * np.pi * engine.engine.bore**2
    count = 4 * len(pressure.angles_deg)
    angle = np.linspace(0.0, np.pi * engine.engine.strokes, count + 1)
    sine, rod = np.sin(angle), np.sqrt(length**2 - (radius * np.sin(angle)) ** 2)
    slope = area * (radius * sine + radius**2 * sine * np.cos(angle) / rod)
    weights = np.ones(count + 1)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    work = (
        np.sum(weights * pressure.at(angle_deg=np.degrees(angle)) * slope)
        * (angle[1] - angle[0])
        / 3.0
    )
    return work, 2.0 * radius * area


def own_power(engine, pressure, speed):
    """Indicated power [W] and mean indicated pressure [Pa] at a speed [rad/s]."""
    work, swept = own_work(engine, pressure)
    cycles = speed / (np.pi * engine.engine.strokes)
    return engine.engine.cylinders * work * cycles, work / swept


@pytest.mark.parametrize("name", OWN)
def test_indicated_power_is_the_integral_over_the_volume(name, figure):
    engine = cf.load_engine(FOLDER / f"{name}.toml")
    power, mean = own_power(engine, engine.pressure[0], engine.engine.rated_speed)
    figure("indicated power", engine.power.indicated, power, 1e-5, "W")
    figure("mean indicated pressure", engine.power.mean_indicated_pressure, mean, 1e-5, "Pa")
    given = engine.gas.mean_effective_pressure
    figure("mean pressure that the file gives", mean, given, 1e-5, "Pa")
    figure("power of the torque", cf.run_mechanism(engine).torque.power, power, 1e-5, "W")


def test_published_power_and_mean_effective_pressure(figure):
    power = cf.load_mechanism("6s50mc-c").power
    assert power.consistent
    # 19.0 bar are printed with three digits.
    figure("mean effective pressure of 9480 kW", power.mean_effective_pressure, 19.0e5, 3e-3, "Pa")
    figure("mechanical efficiency", power.mechanical_efficiency, 19.0 / 20.0, 3e-3)


@pytest.mark.parametrize("name", OWN)
def test_a_propeller_takes_the_cube_of_the_speed(name, figure):
    """In what is told, in the torque of the mechanism and in the forces that excite vibration."""
    engine = cf.load_engine(FOLDER / f"{name}.toml")
    rated = engine.engine.rated_speed
    engine = engine.changed(engine={"lowest_speed": 0.4 * rated}, load={"law": "propeller"})
    full, _ = own_power(engine, engine.pressure[0], rated)
    told = engine_load(engine)
    place = int(np.argmin(np.abs(told.speeds - 0.5 * rated)))
    figure("reported power at half speed", told.power[place], full / 8.0, 1e-4, "W")
    mean = engine.power.mean_indicated_pressure
    figure("reported mean pressure", told.mean_pressure[place], mean / 4.0, 1e-4, "Pa")
    turned = cf.run_mechanism(engine, 0.5 * rated)
    figure("power of the torque at half speed", turned.torque.power, full / 8.0, 1e-4, "W")
    speeds = np.array([0.45, 0.5, 0.7, 1.0, 1.1]) * rated
    forces = forces_over_speeds(engine, engine_harmonics(engine), speeds)
    driven = forces.mean_tangential.sum(axis=-1) * forces.crank_radius * speeds
    figure("power of the exciting forces", driven, full * (speeds / rated) ** 3, 1e-4, "W")


def test_friction_stays_where_the_rated_power_tells_it(figure):
    engine = cf.load_engine("6s50mc-c")
    rated = engine.engine.rated_speed
    told = engine_load(engine)
    swept = 6 * 0.25 * np.pi * engine.engine.bore**2 * engine.engine.stroke
    friction = (engine.power.indicated - 9480e3) / (swept * rated / (2.0 * np.pi))
    shaft = told.power - friction * swept * told.speeds / (2.0 * np.pi)
    wanted = 9480e3 * (told.speeds / rated) ** 3
    figure("power at the flywheel", shaft, wanted, 1e-4, "W", scale=9480e3)


@pytest.mark.further
def test_slow_speeds_are_not_taken_at_full_load(figure):
    """At half speed the torque that excites has a quarter of the mean at full load."""
    engine = cf.load_engine(FOLDER / "5-42-176-propeller.toml")
    throw = cf.analyze_throw(engine.throw, engine.material, accuracy=0.1)
    part = cf.engine_vibration(engine, analysis=throw)
    full = cf.engine_vibration(engine.changed(load=None), analysis=throw)
    assert part.load.law == "propeller"
    assert "full load" in full.load.sentence
    for run in (part, full):
        # Without inertia: the mean torque of the gas is what the load says.
        forces = run.forced_torsional.forces
        place = int(np.argmin(np.abs(forces.speeds - 0.5 * engine.engine.rated_speed)))
        share = (forces.speeds[place] / engine.engine.rated_speed) ** 2 if run is part else 1.0
        torque = forces.mean_tangential[place].sum() * forces.crank_radius
        figure(
            "mean torque near half speed",
            torque,
            share * run.load.rated.indicated / engine.engine.rated_speed,
            1e-3,
            "N m",
        )
    loads = [run.forced_torsional.loads.elements.synthesis.amplitude.max() for run in (part, full)]
    assert loads[0] < 0.5 * loads[1]
