import math

import numpy as np
import pytest

from dynamics.engine.cylinder import EngineCylinder, RotatingMass, SlavePin
from dynamics.engine.forces import mechanism_forces
from dynamics.engine.gas_forces import gas_forces
from dynamics.engine.layout import EngineLayout
from dynamics.engine.motions import piston_ends
from dynamics.mechanism.rods import ConnectingRod
from dynamics.torque.torque import engine_torque
from dynamics.turning.curves import turn_curves
from dynamics.turning.free_turning import turn_freely
from dynamics.turning.speed_over_angle import speed_over_angle, steady_turning
from dynamics.turning.steady_engine import turn_steadily
from geometry.errors import InputError

ROD = ConnectingRod(0.25, 2.0, 0.08, 0.02, 0.004)
SLAVE_ROD = ConnectingRod(0.18, 1.2, 0.07, 0.008)


class SmoothPressure:
    strokes = 4

    def at(self, angle):
        return 1e5 * (12.0 + 9.0 * np.cos(0.5 * angle - 0.4) + 6.0 * np.cos(angle - 0.7))


def constant(value):
    """Return a function of anything."""
    return lambda *_: value


def hinged_pair(inertia=0.4):
    main = EngineCylinder(0.12, 3.0, ROD, 0.2, -0.5, pin_offset=0.004)
    pin = SlavePin(1, 0.06, 1.0)
    hinged = EngineCylinder(0.12, 2.8, SLAVE_ROD, 0.2, 0.5, slave_pin=pin)
    rotating = [RotatingMass(0.3, 2.0)]
    return EngineLayout(0.07, [main, hinged], [1, 2], shaft_inertia=inertia, rotating=rotating)


def test_free_shaft_keeps_its_energy():
    """I = 2 + cos: w = w_0 sqrt(3 / (2 + cos)), the closed form, to round-off."""
    found = speed_over_angle(lambda a: (2.0 + math.cos(a), 0.0), constant(0.0), 0.0, 10.0, 2.0)
    wanted = 10.0 * np.sqrt(3.0 / (2.0 + np.cos(found.angle)))
    assert found.speed == pytest.approx(wanted, rel=1e-14)
    assert found.angle.size == 1441
    assert found.angle[-1] == pytest.approx(4.0 * math.pi)
    assert found.stopped_at is None


def test_speed_dependent_moment_against_the_closed_form():
    """I w' = -c w in time is I dw/dphi = -c: w falls linearly, t = -(I / c) ln(w / w_0)."""
    found = speed_over_angle(constant((2.0, 0.0)), lambda _, w: -0.3 * w, 1.0, 50.0, 3.0)
    wanted = 50.0 - 0.15 * (found.angle - 1.0)
    assert found.speed == pytest.approx(wanted, rel=1e-13)
    assert found.time == pytest.approx(-(2.0 / 0.3) * np.log(wanted / 50.0), abs=1e-14)


def test_shaft_stops_where_its_energy_is_spent():
    # 2 * 10^2 / 2 J over 20 N m: 5 rad.
    found = speed_over_angle(constant((2.0, 0.0)), constant(-20.0), 0.0, 10.0, 2.0)
    assert found.stopped_at == pytest.approx(5.0, abs=math.radians(1.0))
    assert found.angle[-1] <= found.stopped_at


def test_steady_turning_meets_speed_and_repeats():
    def moment(angle, speed):
        return 50.0 + 200.0 * math.sin(2.0 * angle) - 0.01 * speed**2

    found = steady_turning(constant((1.0, 0.0)), moment, 60.0, 1.0, samples=120)
    turning = found.turning
    assert turning.mean_speed == pytest.approx(60.0, rel=1e-9)
    assert turning.speed[-1] == pytest.approx(turning.speed[0], rel=1e-9)
    # The square of the speed averages a little over the mean speed's.
    assert found.load == pytest.approx(50.0 - 0.01 * np.mean(turning.speed[:-1] ** 2), rel=1e-3)
    # Energy swings by 200 J between lowest and highest speed: delta = 200 / (I w^2), nearly.
    assert turning.fluctuation == pytest.approx(200.0 / 60.0**2, rel=5e-3)


def test_steady_turning_refuses_a_speed_too_low():
    with pytest.raises(InputError, match="mean_speed: given 5 rad/s; allowed is more"):
        steady_turning(constant((1.0, 0.0)), lambda a, _: 200.0 * math.sin(a), 5.0, 1.0)


def test_curves_give_values_and_derivatives():
    curves = turn_curves(lambda a: np.array([1.0 / (2.0 + np.cos(a)), 3.0 + 0.0 * a, 0.0 * a]))
    for angle in (0.3, 7.0, -2.0):
        values, slopes = curves.at(angle)
        below = 2.0 + math.cos(angle)
        assert values == pytest.approx([1.0 / below, 3.0, 0.0], abs=1e-14)
        assert slopes == pytest.approx([math.sin(angle) / below**2, 0.0, 0.0], abs=1e-13)


def test_acceleration_is_that_of_the_forces():
    """Shaft inertia times acceleration is the torque from equilibrium of pistons and rods."""
    engine, pressure = hinged_pair(), SmoothPressure()
    found = turn_freely(engine, 0.3, 80.0, 0.05, gas=pressure, load=30.0, samples=6)
    gas = gas_forces(engine, found.angle, pressure)
    for place, angle in enumerate(found.angle.tolist()):
        forces = mechanism_forces(
            engine,
            [angle],
            float(found.speed[place]),
            gas[:, [place]],
            crank_acceleration=float(found.acceleration[place]),
        )
        left = engine.shaft_inertia * found.acceleration[place]
        assert left == pytest.approx(float(forces.torque.sum()) - 30.0, rel=1e-10, abs=1e-8)


def test_energy_balances():
    """Works are integrated beside the speed, which does not know of them."""
    found = turn_freely(
        hinged_pair(inertia=3.0),
        0.3,
        80.0,
        0.15,
        gas=SmoothPressure(),
        load=lambda speed, angle: 0.01 * speed**2 + 5.0 * math.sin(angle) ** 2,
        friction=4.0,
        gravity=9.81,
        samples=31,
    )
    assert found.energy_error < 1e-9
    assert found.friction.work[-1] == pytest.approx(-4.0 * (found.angle[-1] - 0.3), rel=1e-9)
    assert np.all(np.diff(found.load.work) < 0.0)
    # Speed and acceleration are derivatives of the angle: differences over 5 ms, to their order.
    assert np.gradient(found.angle, found.time)[1:-1] == pytest.approx(found.speed[1:-1], rel=0.02)
    assert not found.stopped


def test_work_of_gravity_is_that_of_the_heights():
    """A single crank with a counterweight, by hand: at the top, then half a turn later."""
    rod = ConnectingRod(0.25, 2.0, 0.1, 0.02)
    engine = EngineLayout(
        0.07,
        [EngineCylinder(0.12, 3.0, rod)],
        [1],
        shaft_inertia=0.2,
        rotating=[RotatingMass(0.05, math.pi)],
    )
    found = turn_freely(engine, 0.0, 60.0, 0.2, gravity=9.81, samples=2001)
    place = int(np.argmin(np.abs(found.angle - math.pi)))
    # Piston and rod sink by 2 R, the counterweight's m r rises by 2 m r; near the bottom nothing
    # changes with the angle but by its square.
    wanted = 9.81 * ((3.0 + 2.0) * 0.14 - 2.0 * 0.05)
    off = abs(float(found.angle[place]) - math.pi)
    assert found.gravity.work[place] == pytest.approx(wanted, abs=10.0 * off**2 + 1e-9)


def test_gas_as_a_function_of_place_and_direction():
    told = set()

    def gas(number, position, direction, since_firing):
        told.add((number, direction))
        assert 0.0 <= position <= 1.0
        assert 0.0 <= since_firing < 4.0 * math.pi
        # Works on the way down after firing only.
        return 4e3 * position if direction < 0 and since_firing < 1.5 * math.pi else 0.0

    engine = hinged_pair()
    found = turn_freely(engine, 0.0, 100.0, 0.2, gas=gas, samples=21)
    assert told == {(1, 1), (1, -1), (2, 1), (2, -1)}
    assert found.energy_error < 1e-9
    # One stroke of force 4 kN times position: 4 kN times stroke / 2, for each firing.
    turned = turn_freely(engine, -0.1, 100.0, 0.5, gas=gas, samples=2001)
    cycles = int((turned.angle[-1] - 3.0) // (4.0 * math.pi))
    end = np.interp(4.0 * math.pi * cycles - 0.1, turned.angle, turned.gas.work)
    strokes = [highest - lowest for lowest, highest in map(piston_ends, (engine,) * 2, (1, 2))]
    # Read between samples where the work does not change.
    assert end / cycles == pytest.approx(2e3 * sum(strokes), rel=1e-6)


@pytest.mark.parametrize("direction_matters", [False, True])
def test_engine_stops_and_says_so(direction_matters):
    gas = constant(0.0) if direction_matters else None
    found = turn_freely(hinged_pair(), 0.3, 40.0, 20.0, gas=gas, load=60.0, samples=201)
    assert found.stopped
    assert found.remark.startswith("The engine stops after ")
    assert found.speed[-1] == pytest.approx(0.0, abs=1e-8)
    assert found.energy_error < 1e-9
    assert np.all(np.diff(found.time) > 0.0)
    # All energy goes into the load.
    assert 60.0 * (found.angle[-1] - 0.3) == pytest.approx(found.kinetic_energy[0], rel=1e-9)


def test_engine_that_is_not_driven_does_not_start():
    found = turn_freely(hinged_pair(), 0.3, 0.0, 1.0, load=10.0)
    assert found.remark.startswith("The engine does not start at a shaft angle of 17.1887 deg")
    assert found.time.tolist() == [0.0]


def test_engine_starts_from_rest():
    found = turn_freely(hinged_pair(), 0.3, 0.0, 0.1, gas=constant(5e3), samples=11)
    first = turn_freely(hinged_pair(), 0.3, 0.0, 1e-4, gas=constant(5e3), samples=2)
    assert found.acceleration[0] > 0.0
    assert first.speed[-1] == pytest.approx(first.acceleration[0] * 1e-4, rel=1e-4)


@pytest.mark.slow
def test_steady_engine_has_the_speed_of_its_energy():
    engine, pressure = hinged_pair(inertia=3.0), SmoothPressure()
    found = turn_steadily(engine, 60.0, gas=pressure, samples=180)
    turning = found.turning
    assert turning.mean_speed == pytest.approx(60.0, rel=1e-9)
    assert turning.angle[-1] == pytest.approx(engine.cycle)
    # The load takes the whole indicated work.
    assert found.load == pytest.approx(engine_torque(engine, 60.0, pressure).mean, rel=1e-9)
    # Set free with that load at that speed, it does the same over time.
    start = float(turning.speed[0])
    free = turn_freely(
        engine, 0.0, start, float(turning.time[-1]), gas=pressure, load=found.load, samples=2
    )
    assert free.angle[-1] == pytest.approx(engine.cycle, rel=1e-9)
    assert free.speed[-1] == pytest.approx(start, rel=1e-8)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"start_speed": -1.0}, "start_speed: given -1"),
        ({"duration": 0.0}, "duration: given 0"),
        ({"times": [0.2, 0.1]}, "times: given 2 of them; allowed are times that ascend"),
        ({"times": [0.0, 2.0]}, "times: given 2 of them"),
        ({"samples": 1}, "samples: given 1"),
        ({"load": float("nan")}, "load: given nan"),
        ({"gas": [SmoothPressure()]}, "pressure: given 1 for 2 cylinders"),
    ],
)
def test_refusals(change, message):
    usual = {"start_angle": 0.0, "start_speed": 10.0, "duration": 1.0}
    with pytest.raises(InputError, match=message):
        turn_freely(hinged_pair(), **(usual | change))
