"""Forces of cylinders by orders: against mechanism_forces at random angles, and refusals."""

import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.cycle import cycle_radians
from dynamics.engine.forces import gas_forces, mechanism_forces, rod_models
from dynamics.engine.layout import EngineCylinder, EngineLayout, SlavePin
from dynamics.engine.motions import reduced_inertia
from dynamics.engine.rods import ConnectingRod
from dynamics.excitation.cylinders import cylinder_forces, cylinder_harmonics
from dynamics.excitation.pressure_map import propeller_load
from dynamics.gas.cycle_values import usual_gas_cycle
from dynamics.gas.cylinder_volume import cylinder_volume, motored_from_compression
from dynamics.gas.gas_cycle import gas_cycle
from dynamics.gas.pressure import gas_pressure
from dynamics.torque.torque import engine_torque, pin_force_harmonics

ROD = ConnectingRod(0.25, 2.0, 0.08, 0.02, 0.004)
SLAVE_ROD = ConnectingRod(0.18, 1.2, 0.07, 0.008)
SPEEDS = np.array([60.0, 150.0, 240.0])
RANDOM = np.random.default_rng(7)


class SmoothPressure:
    """A pressure of few harmonics: with those of the mechanism, which fade, the orders are all."""

    def __init__(self, strokes, size=1.0):
        self.strokes = strokes
        self.size = size

    def at(self, *, angle_deg):
        angle = np.radians(angle_deg)
        part = 2.0 / self.strokes
        waves = 9.0 * np.cos(part * angle - 0.4) + 3.0 * np.cos(2 * part * angle - 0.7)
        return 1e5 * (12.0 + self.size * waves)


def offset_two_stroke():
    cylinders = [
        EngineCylinder(
            0.12, 3.0, ROD, crank_angle_deg=math.degrees(c), position=0.2 * i, pin_offset=0.003
        )
        for i, c in enumerate(np.radians([0.0, 120.0, 240.0]).tolist())
    ]
    return EngineLayout(0.07, cylinders, [1, 3, 2], strokes=2)


def vee(hinged):
    """Two throws of two cylinders, 60 deg between the banks: rods hinged, or side by side."""
    cylinders = []
    for throw, crank in enumerate((0.0, math.pi)):
        place = 0.2 * throw
        pin = SlavePin(2 * throw + 1, 0.06, angle_deg=60.0) if hinged else None
        rod, apart = (SLAVE_ROD, 0.0) if hinged else (ROD, 0.03)
        cylinders.append(
            EngineCylinder(
                0.12,
                3.0,
                ROD,
                crank_angle_deg=math.degrees(crank),
                bank_angle_deg=-30.0,
                position=place,
            )
        )
        cylinders.append(
            EngineCylinder(
                0.12,
                2.8,
                rod,
                crank_angle_deg=math.degrees(crank),
                bank_angle_deg=30.0,
                position=place + apart,
                slave_pin=pin,
            )
        )
    return EngineLayout(0.07, cylinders, [1, 2, 3, 4])


ENGINES = pytest.mark.parametrize("engine", [offset_two_stroke(), vee(True), vee(False)])


@ENGINES
@pytest.mark.parametrize("model", ["rigid", "two-mass"])
def test_orders_add_up_to_the_forces_of_the_mechanism(engine, model):
    pressure = SmoothPressure(engine.strokes)
    angles = RANDOM.uniform(-20.0, 20.0, 40)
    found = cylinder_forces(engine, SPEEDS, 36.0, pressure, model=model)
    gas = gas_forces(engine, pressure, shaft_angles_deg=np.degrees(angles))
    for place, speed in enumerate(SPEEDS):
        forces = mechanism_forces(
            engine, speed, gas, model=model, shaft_angles_deg=np.degrees(angles)
        )
        tangential, radial = found.at_angle(place, shaft_angle_deg=np.degrees(angles))
        # Orders of rods fade by lambda / 4 each: beyond the 36th they are round-off.
        largest = np.max(np.abs(forces.crankpin))
        assert tangential == close(forces.tangential.T, abs=1e-11 * largest)
        assert radial == close(forces.radial.T, abs=1e-11 * largest)


@ENGINES
def test_power_is_indicated_and_the_sum_of_all_cylinders_is_the_engines(engine):
    pressure = SmoothPressure(engine.strokes)
    found = cylinder_forces(engine, SPEEDS, 12.0, pressure)
    torque = engine_torque(engine, SPEEDS[1], pressure)
    work = torque.indicated_work.sum()
    # The mean is the hundredth part of what the torque swings by: 1e-13 of that is round-off.
    assert found.power == close(work / cycle_radians(engine.strokes) * SPEEDS, rel=1e-11)
    whole = torque.harmonics().up_to(12.0)
    phasors = whole.cosine - 1j * whole.sine
    assert found.torque[:, 1].sum(axis=1) == close(phasors, abs=1e-12 * np.abs(found.torque).max())
    own = pin_force_harmonics(engine, SPEEDS[2], pressure, highest_order=12.0)[1]
    at_shaft = (own.radial.cosine - 1j * own.radial.sine) * np.exp(
        -1j * found.orders * math.radians(own.firing_angle_deg)
    )
    assert found.radial[:, 2, 1] == close(at_shaft, abs=1e-12 * np.abs(at_shaft).max())


def test_inertia_goes_with_the_square_of_the_speed_and_can_be_left_out():
    engine = vee(True)
    both, gas = (
        cylinder_forces(engine, SPEEDS, 6.0, SmoothPressure(4), inertia=own)
        for own in (True, False)
    )
    masses = cylinder_forces(engine, SPEEDS, 6.0)
    assert both.tangential - gas.tangential == close(masses.tangential, abs=1e-9)
    assert np.array_equal(gas.radial[:, 0], gas.radial[:, 2])
    # The ratio of squares is exact but for the last digit, and half orders have none at all.
    assert masses.radial[:, 2] == close(16.0 * masses.radial[:, 0], rel=1e-15)
    assert np.all(masses.tangential[::2] == 0.0)
    assert np.abs(masses.tangential[1::2]).min() > 0.0


@ENGINES
def test_inertia_torque_is_half_the_slope_of_the_inertia_at_the_crank(engine):
    """The mean of that inertia is in the chain, its slope excites: nothing counts twice."""
    angles = RANDOM.uniform(0.0, 20.0, 30)
    _, slope = reduced_inertia(
        engine, rod_models(engine, "rigid"), shaft_angles_deg=np.degrees(angles)
    )
    tangential, _ = cylinder_forces(engine, SPEEDS, 36.0).at_angle(
        1, shaft_angle_deg=np.degrees(angles)
    )
    torque = engine.crank_radius * tangential.sum(axis=1)
    wanted = -0.5 * slope * SPEEDS[1] ** 2
    assert torque == close(wanted, abs=1e-10 * np.abs(wanted).max())


def test_a_failing_cylinder_follows_the_pressure_without_combustion():
    engine, fired, cold = vee(True), SmoothPressure(4), SmoothPressure(4, 0.3)
    mixed = cylinder_forces(engine, SPEEDS, 8.0, fired, misfire={3: 0.25}, motored=cold)
    each = [fired, fired, SmoothPressure(4, 0.75 + 0.25 * 0.3), fired]
    direct = cylinder_forces(engine, SPEEDS, 8.0, each)
    assert mixed.tangential == close(direct.tangential, abs=1e-9)
    assert mixed.mean_radial == close(direct.mean_radial, abs=1e-9)
    all_fire = cylinder_forces(engine, SPEEDS, 8.0, fired)
    same = np.isclose(mixed.tangential, all_fire.tangential, rtol=1e-12, atol=1e-9).all(axis=(0, 1))
    assert same.tolist() == [True, True, False, True]


def test_time_functions_follow_the_speed():
    engine = offset_two_stroke()
    harmonics = cylinder_harmonics(engine, 30.0, SmoothPressure(2))
    angles = RANDOM.uniform(0.0, 50.0, 20)
    turning = np.linspace(50.0, 200.0, 20)
    tangential, radial = harmonics.at(turning, shaft_angle_deg=np.degrees(angles))
    gas = gas_forces(engine, SmoothPressure(2), shaft_angles_deg=np.degrees(angles))
    forces = mechanism_forces(engine, turning, gas, shaft_angles_deg=np.degrees(angles))
    largest = np.max(np.abs(forces.crankpin))
    assert tangential == close(forces.tangential.T, abs=1e-11 * largest)
    assert radial == close(forces.radial.T, abs=1e-11 * largest)
    steady = cylinder_forces(engine, [120.0], 30.0, SmoothPressure(2)).at_angle(
        0, shaft_angle_deg=np.degrees(angles)
    )
    assert np.array(harmonics.at(120.0, shaft_angle_deg=np.degrees(angles))) == close(
        np.array(steady), rel=1e-9
    )


def crank_slider(angle):
    return 0.07 * np.cos(angle) + np.sqrt(0.25**2 - (0.07 * np.sin(angle)) ** 2)


def test_motored_pressure_from_a_fired_diagram():
    cycle = usual_gas_cycle(15.0, intake_pressure=2.5e5, exhaust_pressure=2.2e5)
    volume = cylinder_volume(crank_slider, 0.0133, 15.0)
    fired = gas_cycle(cycle, crank_slider, 0.0133, peak_pressure=16e6).pressure
    cold = gas_cycle(cycle, crank_slider, 0.0133, heat=0.0).pressure
    found = motored_from_compression(fired, volume)
    # The model compresses by one exponent, so that the closed part comes back to round-off. Only
    # the blow-down differs, measured 6.3e-4 of the peak.
    closed = np.abs(np.angle(np.exp(0.5j * np.radians(found.angles_deg)))) < math.radians(60.0)
    assert found.pressure[closed] == close(cold.pressure[closed], rel=1e-9)
    assert np.max(np.abs(found.pressure - cold.pressure)) < 1e-3 * fired.peak_pressure
    assert f"exponent {cycle.heat_capacity_ratio:.4g}" in found.remarks[-1]
    with pytest.raises(InputError, match="below 0, because the gas is compressed there"):
        motored_from_compression(fired, volume, fit_to_deg=12.0)
    lagging = gas_pressure(np.roll(fired.pressure, 600), angles_deg=fired.angles_deg)
    with pytest.raises(InputError, match=r"polytropic exponent .* allowed is one from 1 to 2"):
        motored_from_compression(lagging, volume)


def diagram(step_deg, strokes=4):
    angle = np.radians(np.arange(0.0, 180.0 * strokes, step_deg))
    return gas_pressure(
        SmoothPressure(strokes).at(angle_deg=np.degrees(angle)),
        strokes,
        angles_deg=np.degrees(angle),
    )


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"orders": [0.75]}, r"orders\[0\]: given 0.75; allowed are multiples of 0.5"),
        ({"orders": [1.0, 200.0], "samples": 360}, r"given 200; allowed are orders up to 89.5"),
        (
            {"orders": [1.0, 18.0], "pressure": diagram(10.0)},
            r"given 18; allowed are orders up to 17.5, because the pressure diagrams have 72 samples",
        ),
        ({"speeds": [100.0, 90.0]}, r"speeds\[1\]: given 90 rad/s after 100 rad/s"),
        ({"pressure": [SmoothPressure(4)]}, "pressure: given 1 for 4 cylinders"),
        ({"pressure": diagram(5.0, 2)}, "pressure: given a cycle of 2 strokes; allowed is 4"),
        ({"misfire": {1: 1.0}}, "motored: given none for misfire in cylinder 1"),
        (
            {"misfire": {5: 1.0}, "motored": SmoothPressure(4)},
            "cylinder: given 5; allowed are the whole numbers 1 to 4",
        ),
        (
            {"misfire": {1: 1.5}, "motored": SmoothPressure(4)},
            r"misfire\[1\]: given 1.5; allowed is 0 to 1",
        ),
        ({"misfire": {1: 1.0}, "pressure": None}, "misfire: given without a pressure"),
        ({"load": 0.5}, "load: given without a pressure map"),
        ({"throws": [0, 0, 2, 2]}, "throws: given .* without a gap"),
    ],
)
def test_what_does_not_fit_is_refused(changed, sentence):
    given = {"speeds": SPEEDS, "orders": 6.0, "pressure": SmoothPressure(4)} | changed
    with pytest.raises(InputError, match=sentence):
        cylinder_forces(vee(True), **given)


def test_a_firing_order_that_does_not_fit_the_cranks_is_refused():
    cranks = np.radians([0.0, 180.0, 180.0, 0.0]).tolist()
    cylinders = [
        EngineCylinder(
            0.12, 3.0, ROD, crank_angle_deg=math.degrees(c), bank_angle_deg=0.0, position=0.2 * i
        )
        for i, c in enumerate(cranks)
    ]
    with pytest.raises(
        InputError, match=r"firing_order: given \[1, 4, 3, 2\]; allowed is an order"
    ):
        EngineLayout(0.07, cylinders, [1, 4, 3, 2])


def test_remarks_say_that_one_diagram_served_all_speeds():
    engine = vee(True)
    (remark,) = cylinder_forces(engine, SPEEDS, 6.0, diagram(2.0)).remarks
    assert remark.startswith(
        "One pressure diagram was used at all speeds from 572.958 1/min to 2291.83"
    )
    assert cylinder_forces(engine, SPEEDS[:1], 6.0, diagram(2.0)).remarks == ()
    assert cylinder_forces(engine, SPEEDS, 6.0).remarks == ()


def test_propeller_load():
    assert propeller_load(100.0, 0.9, measure="power")(SPEEDS) == close(0.9 * (SPEEDS / 100.0) ** 3)
    with pytest.raises(InputError, match="measure: given 'thrust'"):
        propeller_load(100.0, measure="thrust")
