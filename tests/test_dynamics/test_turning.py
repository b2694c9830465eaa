import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.cycle import cycle_radians
from dynamics.engine.forces import gas_forces, mechanism_forces, piston_ends
from dynamics.engine.layout import EngineCylinder, EngineLayout, RotatingMass, SlavePin
from dynamics.engine.rods import ConnectingRod
from dynamics.torque import engine_torque
from dynamics.turning.free_turning import turn_freely, turn_steadily
from dynamics.turning.speed_over_angle import speed_over_angle, steady_turning
from parts_in_a_line import cylinder

ROD = ConnectingRod(0.25, 2.0, 0.08, 0.02, 0.004)
SLAVE_ROD = ConnectingRod(0.18, 1.2, 0.07, 0.008)


class SmoothPressure:
    strokes = 4

    def at(self, *, angle_deg):
        angle = np.radians(angle_deg)
        return 1e5 * (12.0 + 9.0 * np.cos(0.5 * angle - 0.4) + 6.0 * np.cos(angle - 0.7))


class BrokenPressure:
    strokes = 4

    def at(self, *, angle_deg):
        return np.where(np.asarray(np.radians(angle_deg)) > 0.2, np.nan, 1e5)


def constant(value):
    """Return a function of anything."""
    return lambda *_: value


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
        start = {"start_angle_deg": 77.0, "start_speed": 10.0, "turns": 1.0}
        speed_over_angle(constant(2.0), moment, samples=samples, **start)
        return len(asked)

    assert count(360) < count(400)


def test_shaft_stops_where_its_energy_is_spent():
    # 2 * 10^2 / 2 J over 20 N m: 5 rad.
    found = speed_over_angle(
        constant(2.0), constant(-20.0), start_angle_deg=0.0, start_speed=10.0, turns=2.0
    )
    # In the shortest steps, of 1/512 deg.
    assert math.radians(found.stopped_at_deg) == close(5.0, abs=math.radians(1.0 / 512.0))
    assert np.radians(found.angle_deg)[-1] <= math.radians(found.stopped_at_deg)


# At 5 rad/s it would turn with less than a millionth of the swing of energy left.
@pytest.mark.parametrize("speed", [1.0, pytest.param(5.0, marks=pytest.mark.slow)])
def test_steady_turning_refuses_a_speed_too_low(speed):
    with pytest.raises(InputError, match=f"mean_speed: given {speed:g} rad/s; allowed is more"):
        steady_turning(constant(1.0), swinging, speed, 1.0)


def swinging(_speed, angle):
    """Take and give 400 J a turn: w^2 = w_0^2 + 400 (1 - cos) with I = 1."""
    return 200.0 * math.sin(angle)


def test_moment_steep_in_the_speed():
    """I w dw/dphi = -500 (w - 1), I = 1: w - 10 + ln((w - 1) / 9) = -500 phi, not a stop."""
    found = speed_over_angle(
        constant(1.0),
        lambda w, _: -500.0 * (w - 1.0),
        start_angle_deg=0.0,
        start_speed=10.0,
        turns=1.0,
    )
    assert found.stopped_at_deg is None
    speed = found.speed[:4]
    # Most of the way from 10 to 1 rad/s is made within one degree, in a few steps: 1e-7 rad of
    # some 1e-2; 50 in place of 500 leaves 1e-9.
    wanted = -(speed - 10.0 + np.log((speed - 1.0) / 9.0)) / 500.0
    assert np.radians(found.angle_deg)[:4] == close(wanted, abs=1e-7)
    assert found.speed[-1] == close(1.0, rel=1e-9)
    with pytest.raises(InputError, match=r"moment: given one with which the speed does not settle"):
        speed_over_angle(
            constant(1.0),
            lambda w, _: -1e6 * (w - 1.0),
            start_angle_deg=0.0,
            start_speed=10.0,
            turns=1.0,
        )


def test_moment_that_brakes_steeply_stops_the_shaft():
    """w falls by 4 / 2 for each rad: at rest after 5 rad, where the energy falls without end."""
    found = speed_over_angle(
        constant(2.0), lambda w, _: -4.0 * w, start_angle_deg=0.0, start_speed=10.0, turns=2.0
    )
    # Counted as stopped at 1e-9 of the energy: 3e-5 of the speed.
    assert math.radians(found.stopped_at_deg) == close(
        5.0, abs=5.0 * 3.2e-5 + math.radians(1.0 / 256.0)
    )


@pytest.mark.parametrize(
    ("act", "message"),
    [
        (lambda f: f(constant(-1.0), constant(0.0)), "inertia: given -1.0 kg m.2 at .* 0 deg"),
        (lambda f: f(constant(0.0), constant(0.0)), "inertia: given 0.0 kg"),
        (lambda f: f(math.cos, constant(0.0)), "inertia: given -0.* at a shaft angle of 9[01]"),
        (lambda f: f(constant(math.inf), constant(0.0)), "inertia: given inf"),
        (lambda f: f(constant(None), constant(0.0)), "inertia: given None"),
        (lambda f: f(constant(1.0), constant(math.nan)), "moment: given a moment of nan"),
        (lambda f: f(constant(1.0), constant(None)), "moment: given a moment of None"),
        (lambda f: f(constant(1.0), lambda _, a: -math.inf if a > 3 else 0.0), "moment of -inf"),
    ],
)
@pytest.mark.parametrize("turn", [speed_over_angle, steady_turning])
def test_functions_that_give_no_number(turn, act, message):
    arguments = {"turns": 1.0} | (
        {"start_angle_deg": 0.0, "start_speed": 10.0}
        if turn is speed_over_angle
        else {"mean_speed": 10.0}
    )
    with pytest.raises(InputError, match=message):
        act(lambda inertia, moment: turn(inertia, moment, **arguments))


@pytest.mark.parametrize("samples", [10.5, 0, True])
def test_results_per_turn_are_whole_numbers(samples):
    message = f"samples: given {samples}; allowed are whole numbers of 1 or more, because"
    with pytest.raises(InputError, match=message):
        speed_over_angle(
            constant(1.0),
            constant(0.0),
            start_angle_deg=0.0,
            start_speed=10.0,
            turns=1.0,
            samples=samples,
        )
    with pytest.raises(InputError, match=message):
        steady_turning(constant(1.0), constant(0.0), 10.0, 1.0, samples=samples)


def test_acceleration_is_that_of_the_forces():
    """Shaft inertia times acceleration is the torque from equilibrium of pistons and rods."""
    engine, pressure = hinged_pair(), SmoothPressure()
    found = turn_freely(
        engine,
        start_angle_deg=math.degrees(0.3),
        start_speed=80.0,
        duration=0.05,
        gas=pressure,
        load=30.0,
        samples=6,
    )
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
    found = turn_freely(
        hinged_pair(),
        start_angle_deg=math.degrees(0.3),
        start_speed=40.0,
        duration=20.0,
        load=lambda w, _: 20.0 + 5.0 * math.sqrt(w),
    )
    assert found.stopped
    assert found.energy_error < 1e-9


# From elsewhere the crank comes to the top ever faster, in ever shorter steps.
@pytest.mark.parametrize("start", [0.0, pytest.param(1.0, marks=pytest.mark.slow)])
def test_massless_parts_have_no_inertia_at_the_top(start):
    """A crank without inertia, all of the rod's mass at its piston: I = 0 at both dead centers."""
    rod = ConnectingRod(0.25, 2.0, 0.25 * (1.0 - 1e-12), 0.02)
    bare = EngineLayout(0.07, [EngineCylinder(0.12, 3.0, rod)], [1])
    with pytest.raises(InputError, match=r"inertia: given .* clearly above zero"):
        turn_freely(
            bare,
            start_angle_deg=np.degrees(start),
            start_speed=10.0,
            duration=1.0,
            model="two-mass",
        )


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
    found = turn_freely(
        engine, start_angle_deg=0.0, start_speed=100.0, duration=0.2, gas=gas, samples=21
    )
    assert told == {(1, 1), (1, -1), (2, 1), (2, -1)}
    assert found.energy_error < 1e-9
    # One stroke of force 4 kN times position: 4 kN times stroke / 2, for each firing.
    turned = turn_freely(
        engine,
        start_angle_deg=np.degrees(-0.1),
        start_speed=100.0,
        duration=0.5,
        gas=gas,
        samples=2001,
    )
    cycles = int((np.radians(turned.angle_deg)[-1] - 3.0) // (4.0 * math.pi))
    end = np.interp(4.0 * math.pi * cycles - 0.1, np.radians(turned.angle_deg), turned.gas.work)
    strokes = [highest - lowest for lowest, highest in map(piston_ends, (engine,) * 2, (1, 2))]
    # Read between samples where the work does not change.
    assert end / cycles == close(2e3 * sum(strokes), rel=1e-6)


@pytest.mark.parametrize("direction_matters", [False, True])
def test_engine_stops_and_says_so(direction_matters):
    found = turn_freely(
        hinged_pair(),
        start_angle_deg=math.degrees(0.3),
        start_speed=40.0,
        duration=20.0,
        gas=constant(0.0) if direction_matters else None,
        load=60.0,
        samples=201,
    )
    assert found.stopped
    assert found.remark.startswith("The engine stops after ")
    assert found.speed[-1] == close(0.0, abs=1e-8)
    assert found.energy_error < 1e-9
    assert np.all(np.diff(found.time) > 0.0)
    # All energy goes into the load.
    assert 60.0 * (np.radians(found.angle_deg)[-1] - 0.3) == close(
        found.kinetic_energy[0], rel=1e-9
    )


def test_engine_that_is_not_driven_does_not_start():
    found = turn_freely(
        hinged_pair(), start_angle_deg=math.degrees(0.3), start_speed=0.0, duration=1.0, load=10.0
    )
    assert found.remark.startswith("The engine does not start at a shaft angle of 17.1887 deg")
    assert found.time.tolist() == [0.0]


@pytest.mark.slow
def test_steady_engine_has_the_speed_of_its_energy():
    engine, pressure = hinged_pair(inertia=3.0), SmoothPressure()
    found = turn_steadily(engine, 60.0, gas=pressure, samples=180)
    turning = found.turning
    assert turning.mean_speed == close(60.0, rel=1e-9)
    assert np.radians(turning.angle_deg)[-1] == close(cycle_radians(engine.strokes))
    # The load takes the whole indicated work.
    assert found.load == close(engine_torque(engine, 60.0, pressure).mean, rel=1e-9)
    # Set free with that load at that speed, it does the same over time.
    start = float(turning.speed[0])
    free = turn_freely(
        engine,
        start_angle_deg=0.0,
        start_speed=start,
        duration=float(turning.time[-1]),
        gas=pressure,
        load=found.load,
        samples=2,
    )
    assert np.radians(free.angle_deg)[-1] == close(cycle_radians(engine.strokes), rel=1e-9)
    assert free.speed[-1] == close(start, rel=1e-8)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"start_speed": -1.0}, "start_speed: given -1"),
        ({"duration": 0.0}, "duration: given 0"),
        ({"times": [0.2, 0.1]}, "times: given 2 of them; allowed are times that ascend"),
        ({"times": [0.0, 2.0]}, "times: given 2 of them"),
        ({"samples": 1}, "samples: given 1"),
        ({"samples": 10.5}, "samples: given 10.5; allowed are whole numbers of 2 or more"),
        ({"load": lambda w, _: math.nan if w < 9.99 else 1.0}, "load: given a moment of nan N m"),
        ({"load": constant(None)}, "load: given a moment of None"),
        ({"friction": constant(math.inf)}, "friction: given a moment of inf N m at 10 rad/s"),
        ({"gas": constant(math.nan)}, "gas: given a moment of nan"),
        ({"gas": constant(1e300)}, "gas: given a moment of .* numbers of up to 1e.60, because"),
        ({"gas": BrokenPressure()}, "gas: given a moment of nan"),
        ({"load": float("nan")}, "load: given nan"),
        ({"gas": [SmoothPressure()]}, "pressure: given 1 for 2 cylinders"),
    ],
)
def test_refusals(change, message):
    usual = {"start_angle_deg": 0.0, "start_speed": 10.0, "duration": 1.0}
    with pytest.raises(InputError, match=message):
        turn_freely(hinged_pair(), **(usual | change))


@pytest.mark.parametrize(
    ("speed", "duration"), [(100.0, 1e308), (0.0, 1e308), (1e9, 1.0), (1e4, 86_400.0)]
)
def test_times_that_cannot_be_followed_are_refused(speed, duration):
    with pytest.raises(InputError, match=r"^duration: given .* allowed "):
        turn_freely(hinged_pair(), start_angle_deg=0.0, start_speed=speed, duration=duration)


@pytest.mark.slow
def test_a_shaft_that_turns_faster_and_faster_is_given_up(monkeypatch):
    monkeypatch.setattr("dynamics.turning.free_turning.MOST_TURNS", 20)
    with pytest.raises(InputError, match="allowed are 20000 turns"):
        turn_freely(hinged_pair(), start_angle_deg=0.0, start_speed=1.0, duration=100.0, load=-1e3)


@pytest.mark.slow
def test_a_motion_that_takes_too_many_evaluations_is_given_up(monkeypatch):
    """And what is allowed then is followed."""
    monkeypatch.setattr("dynamics.turning.speed_over_angle.MOST_CALLS", 20_000)
    start = {"start_angle_deg": 0.0, "start_speed": 10.0, "samples": 90}
    with pytest.raises(InputError, match=r"turns: given 100; allowed is .* or less") as refused:
        speed_over_angle(constant(2.0), constant(0.0), turns=100.0, **start)
    allowed = float(str(refused.value).split()[5])
    assert 1.0 < allowed < 100.0
    speed_over_angle(constant(2.0), constant(0.0), turns=allowed, **start)

    monkeypatch.setattr("dynamics.turning.free_turning.MOST_MOMENTS", 100)
    with pytest.raises(InputError, match=r"duration: given 100 s; allowed is .* s or less here"):
        turn_freely(hinged_pair(), start_angle_deg=0.0, start_speed=1.0, duration=100.0)


def test_the_mean_speed_of_a_shaft_that_stops_at_once_is_its_first():
    found = speed_over_angle(
        constant(2.0), constant(-1e9), start_angle_deg=0.0, start_speed=10.0, turns=1.0
    )
    assert (found.mean_speed, found.fluctuation) == (10.0, 0.0)


def test_more_turns_than_can_be_followed_are_refused():
    with pytest.raises(InputError, match="turns: given 1e"):
        speed_over_angle(
            constant(2.0), constant(0.0), start_angle_deg=0.0, start_speed=10.0, turns=1e300
        )
    with pytest.raises(InputError, match="turns: given 1e"):
        steady_turning(constant(2.0), constant(0.0), 10.0, 1e300)


def test_a_shaft_so_heavy_that_nothing_swings():
    assert steady_turning(constant(1e300), constant(0.0), 8.195, 1.0).turning.fluctuation == 0.0
