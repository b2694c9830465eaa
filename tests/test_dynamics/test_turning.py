import math

import numpy as np
import pytest

from comparing import close
from dynamics.cycle import cycle_radians
from dynamics.engine.forces import gas_forces, mechanism_forces, piston_ends
from dynamics.engine.layout import EngineCylinder, EngineLayout, RotatingMass, SlavePin
from dynamics.engine.rods import ConnectingRod
from dynamics.torque import engine_torque
from dynamics.turning.free_turning import turn_freely, turn_steadily
from dynamics.turning.speed_over_angle import speed_over_angle, steady_turning
from parts_in_a_line import cylinder
from refusals import refusals, refusals_of, refused
from small_engines import ROD, SLAVE_ROD, SmoothPressure


class BrokenPressure:
    strokes = 4

    def at(self, *, angle_deg):
        return np.where(np.asarray(np.radians(angle_deg)) > 0.2, np.nan, 1e5)


def constant(value):
    """Return a function of anything."""
    return lambda *_: value


def over_angle(inertia, moment, turns=1.0, start=0.0, **more):
    """Turn from 10 rad/s on."""
    return speed_over_angle(
        inertia, moment, start_angle_deg=start, start_speed=10.0, turns=turns, **more
    )


def freely(speed, duration=20.0, start=17.0, engine=None, **more):
    engine = hinged_pair() if engine is None else engine
    return turn_freely(engine, start_angle_deg=start, start_speed=speed, duration=duration, **more)


def hinged_pair(inertia=0.4):
    main = cylinder(0.12, 3.0, ROD, math.degrees(0.2), math.degrees(-0.5), pin_offset=0.004)
    pin = SlavePin(1, 0.06, angle_deg=math.degrees(1.0))
    hinged = cylinder(0.12, 2.8, SLAVE_ROD, math.degrees(0.2), math.degrees(0.5), slave_pin=pin)
    rotating = [RotatingMass(0.3, angle_deg=math.degrees(2.0))]
    return EngineLayout(0.07, [main, hinged], [1, 2], shaft_inertia=inertia, rotating=rotating)


def test_steps_of_one_degree_are_not_divided():
    """Round-off may make them a little longer: with 360 steps a turn there are fewer than with 400."""
    asked = []

    def moment(_speed, angle):
        asked.append(angle)
        return 0.0

    def count(samples):
        asked.clear()
        over_angle(constant(2.0), moment, start=77.0, samples=samples)
        return len(asked)

    assert count(360) < count(400)


def test_shaft_stops_where_its_energy_is_spent():
    # 2 * 10^2 / 2 J over 20 N m: 5 rad.
    found = over_angle(constant(2.0), constant(-20.0), 2.0)
    # In the shortest steps, of 1/512 deg.
    assert math.radians(found.stopped_at_deg) == close(5.0, abs=math.radians(1.0 / 512.0))
    assert np.radians(found.angle_deg)[-1] <= math.radians(found.stopped_at_deg)


# At 5 rad/s it would turn with less than a millionth of the swing of energy left.
@pytest.mark.parametrize("speed", [1.0, pytest.param(5.0, marks=pytest.mark.slow)])
def test_steady_turning_refuses_a_speed_too_low(speed):
    with refused("mean_speed"):
        steady_turning(constant(1.0), swinging, speed, 1.0)


def swinging(_speed, angle):
    """Take and give 400 J a turn: w^2 = w_0^2 + 400 (1 - cos) with I = 1."""
    return 200.0 * math.sin(angle)


def test_moment_steep_in_the_speed():
    """I w dw/dphi = -500 (w - 1), I = 1: w - 10 + ln((w - 1) / 9) = -500 phi, not a stop."""
    found = over_angle(constant(1.0), lambda w, _: -500.0 * (w - 1.0))
    assert found.stopped_at_deg is None
    speed = found.speed[:4]
    # Most of the way from 10 to 1 rad/s is made within one degree, in a few steps: 1e-7 rad of
    # some 1e-2; 50 in place of 500 leaves 1e-9.
    wanted = -(speed - 10.0 + np.log((speed - 1.0) / 9.0)) / 500.0
    assert np.radians(found.angle_deg)[:4] == close(wanted, abs=1e-7)
    assert found.speed[-1] == close(1.0, rel=1e-9)
    with refused("moment"):
        over_angle(constant(1.0), lambda w, _: -1e6 * (w - 1.0))


def test_moment_that_brakes_steeply_stops_the_shaft():
    """w falls by 4 / 2 for each rad: at rest after 5 rad, where the energy falls without end."""
    found = over_angle(constant(2.0), lambda w, _: -4.0 * w, 2.0)
    # Counted as stopped at 1e-9 of the energy: 3e-5 of the speed.
    assert math.radians(found.stopped_at_deg) == close(
        5.0, abs=5.0 * 3.2e-5 + math.radians(1.0 / 256.0)
    )


@pytest.mark.parametrize(
    ("act", "field"),
    [
        (lambda f: f(constant(-1.0), constant(0.0)), "inertia"),
        (lambda f: f(constant(0.0), constant(0.0)), "inertia"),
        (lambda f: f(math.cos, constant(0.0)), "inertia"),
        (lambda f: f(constant(math.inf), constant(0.0)), "inertia"),
        (lambda f: f(constant(None), constant(0.0)), "inertia"),
        (lambda f: f(constant(1.0), constant(math.nan)), "moment"),
        (lambda f: f(constant(1.0), constant(None)), "moment"),
        (lambda f: f(constant(1.0), lambda _, a: -math.inf if a > 3 else 0.0), "moment"),
    ],
)
def test_functions_that_give_no_number(act, field):
    for turn in (over_angle, lambda *given: steady_turning(*given, 10.0, 1.0)):
        with refused(field):
            act(turn)


@pytest.mark.parametrize("samples", [10.5, 0, True])
def test_results_per_turn_are_whole_numbers(samples):
    with refused("samples"):
        over_angle(constant(1.0), constant(0.0), samples=samples)
    with refused("samples"):
        steady_turning(constant(1.0), constant(0.0), 10.0, 1.0, samples=samples)


def test_acceleration_is_that_of_the_forces():
    """Shaft inertia times acceleration is the torque from equilibrium of pistons and rods."""
    engine, pressure = hinged_pair(), SmoothPressure(4)
    found = freely(80.0, 0.05, engine=engine, gas=pressure, load=30.0, samples=6)
    gas = gas_forces(engine, pressure, shaft_angles_deg=found.angle_deg)
    for place, angle in enumerate(np.radians(found.angle_deg).tolist()):
        forces = mechanism_forces(
            engine,
            float(found.speed[place]),
            gas[:, [place]],
            crank_acceleration=float(found.acceleration[place]),
            shaft_angles_deg=np.degrees([angle]),
        )
        left = engine.shaft_inertia * found.acceleration[place]
        assert left == close(float(forces.torque.sum()) - 30.0, rel=1e-10, abs=1e-8)


def test_load_that_has_no_value_below_standstill():
    """Past the stop the integration tries speeds below zero; the load is not asked for them."""
    found = freely(40.0, load=lambda w, _: 20.0 + 5.0 * math.sqrt(w))
    assert found.stopped
    assert found.energy_error < 1e-9


# From elsewhere the crank comes to the top ever faster, in ever shorter steps.
@pytest.mark.parametrize("start", [0.0, pytest.param(1.0, marks=pytest.mark.slow)])
def test_massless_parts_have_no_inertia_at_the_top(start):
    """A crank without inertia, all of the rod's mass at its piston: I = 0 at both dead centers."""
    rod = ConnectingRod(0.25, 2.0, 0.25 * (1.0 - 1e-12), 0.02)
    bare = EngineLayout(0.07, [EngineCylinder(0.12, 3.0, rod)], [1])
    with refused("inertia"):
        freely(10.0, 1.0, np.degrees(start), bare, model="two-mass")


@pytest.mark.slow
def test_gas_as_a_function_of_place_and_direction():
    told = set()

    def gas(number, position, direction, since_firing):
        told.add((number, direction))
        assert 0.0 <= position <= 1.0
        assert 0.0 <= since_firing < 4.0 * math.pi
        # Works on the way down after firing only.
        return 4e3 * position if direction < 0 and since_firing < 1.5 * math.pi else 0.0

    engine = hinged_pair()
    found = freely(100.0, 0.2, 0.0, engine, gas=gas, samples=21)
    assert told == {(1, 1), (1, -1), (2, 1), (2, -1)}
    assert found.energy_error < 1e-9
    # One stroke of force 4 kN times position: 4 kN times stroke / 2, for each firing.
    turned = freely(100.0, 0.5, np.degrees(-0.1), engine, gas=gas, samples=2001)
    cycles = int((np.radians(turned.angle_deg)[-1] - 3.0) // (4.0 * math.pi))
    end = np.interp(4.0 * math.pi * cycles - 0.1, np.radians(turned.angle_deg), turned.gas.work)
    strokes = [highest - lowest for lowest, highest in map(piston_ends, (engine,) * 2, (1, 2))]
    # Read between samples where the work does not change.
    assert end / cycles == close(2e3 * sum(strokes), rel=1e-6)


@pytest.mark.parametrize("direction_matters", [False, True])
def test_engine_stops_and_says_so(direction_matters):
    gas = constant(0.0) if direction_matters else None
    found = freely(40.0, gas=gas, load=60.0, samples=201)
    assert found.stopped
    assert found.speed[-1] == close(0.0, abs=1e-8)
    assert found.energy_error < 1e-9
    assert np.all(np.diff(found.time) > 0.0)
    # All energy goes into the load.
    assert 60.0 * (np.radians(found.angle_deg[-1] - 17.0)) == close(
        found.kinetic_energy[0], rel=1e-9
    )


def test_engine_that_is_not_driven_does_not_start():
    assert freely(0.0, 1.0, load=10.0).time.tolist() == [0.0]


@pytest.mark.slow
def test_steady_engine_has_the_speed_of_its_energy():
    engine, pressure = hinged_pair(inertia=3.0), SmoothPressure(4)
    found = turn_steadily(engine, 60.0, gas=pressure, samples=180)
    turning = found.turning
    assert turning.mean_speed == close(60.0, rel=1e-9)
    assert np.radians(turning.angle_deg)[-1] == close(cycle_radians(engine.strokes))
    # The load takes the whole indicated work.
    assert found.load == close(engine_torque(engine, 60.0, pressure).mean, rel=1e-9)
    # Set free with that load at that speed, it does the same over time.
    start = float(turning.speed[0])
    free = freely(
        start, float(turning.time[-1]), 0.0, engine, gas=pressure, load=found.load, samples=2
    )
    assert np.radians(free.angle_deg)[-1] == close(cycle_radians(engine.strokes), rel=1e-9)
    assert free.speed[-1] == close(start, rel=1e-8)


test_refusals = refusals_of(
    lambda change: freely(**{"speed": 10.0, "duration": 1.0, "start": 0.0} | change),
    ({"speed": -1.0}, "start_speed"),
    ({"duration": 0.0}, "duration"),
    ({"times": [0.2, 0.1]}, "times"),
    ({"times": [0.0, 2.0]}, "times"),
    ({"samples": 1}, "samples"),
    ({"samples": 10.5}, "samples"),
    ({"load": lambda w, _: math.nan if w < 9.99 else 1.0}, "load"),
    ({"load": constant(None)}, "load"),
    ({"friction": constant(math.inf)}, "friction"),
    ({"gas": constant(math.nan)}, "gas"),
    ({"gas": constant(1e300)}, "gas"),
    ({"gas": BrokenPressure()}, "gas"),
    ({"load": float("nan")}, "load"),
    ({"gas": [SmoothPressure(4)]}, "pressure"),
)


@pytest.mark.parametrize(
    ("speed", "duration"), [(100.0, 1e308), (0.0, 1e308), (1e9, 1.0), (1e4, 86_400.0)]
)
def test_times_that_cannot_be_followed_are_refused(speed, duration):
    with refused("duration"):
        freely(speed, duration)


@pytest.mark.slow
def test_a_shaft_that_turns_faster_and_faster_is_given_up(monkeypatch):
    monkeypatch.setattr("dynamics.turning.free_turning.MOST_TURNS", 20)
    with refused("duration"):
        freely(1.0, 100.0, load=-1e3)


@pytest.mark.slow
def test_a_motion_that_takes_too_many_evaluations_is_given_up(monkeypatch):
    """And what is allowed then is followed."""
    monkeypatch.setattr("dynamics.turning.speed_over_angle.MOST_CALLS", 20_000)
    with refused("turns") as caught:
        over_angle(constant(2.0), constant(0.0), 100.0, samples=90)
    allowed = float(str(caught.value).split()[5])
    assert 1.0 < allowed < 100.0
    over_angle(constant(2.0), constant(0.0), allowed, samples=90)

    monkeypatch.setattr("dynamics.turning.free_turning.MOST_MOMENTS", 100)
    with refused("duration"):
        freely(1.0, 100.0)


def test_the_mean_speed_of_a_shaft_that_stops_at_once_is_its_first():
    found = over_angle(constant(2.0), constant(-1e9))
    assert (found.mean_speed, found.fluctuation) == (10.0, 0.0)


def test_a_shaft_so_heavy_that_nothing_swings():
    assert steady_turning(constant(1e300), constant(0.0), 8.195, 1.0).turning.fluctuation == 0.0


test_refused_calls = refusals(
    ("turns", lambda: steady_turning(constant(2.0), constant(0.0), 10.0, 1e300)),
    ("turns", lambda: over_angle(constant(2.0), constant(0.0), 1e300)),
)
