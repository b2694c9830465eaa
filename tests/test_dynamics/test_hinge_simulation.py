"""The crank let turn with a hinge, without it, and with a flywheel."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from comparing import close
from crankbase.errors import InputError
from dynamics.engine.rods import ConnectingRod
from dynamics.hinge.crosshead import CrossheadEngine
from dynamics.hinge.moment import hinge_moment
from dynamics.hinge.profile import GasSpring, hinge_profile
from dynamics.hinge.simulation import best_pressure, flywheel_for, simulate_hinge, steady_hinge_turn

ENGINE = CrossheadEngine(
    0.3, 0.5, 80.0, 0.2, 30.0, ConnectingRod(1.55, 150.0, 0.8, 50.0), 150.0, 200.0, 110.0
)
SPEED = 9.32


def smooth_force(angles):
    return 5e5 * np.exp(4.0 * (np.cos(angles - 0.3) - 1.0))


@pytest.fixture(scope="module")
def point():
    return hinge_moment(ENGINE, smooth_force, SPEED)


@pytest.fixture(scope="module")
def profile(point):
    return hinge_profile(point, GasSpring(0.031, 1.0, 5e6), 0.8)


def test_the_hinge_makes_the_speed_constant(point, profile):
    """Integrated with the moment of spring and guides; the bound is 0.1 %, measured is 1e-8."""
    with_hinge = simulate_hinge(point, profile, samples=720)
    without = simulate_hinge(point, start_speed=SPEED, samples=720)
    assert without.stopped_at_deg is None
    assert without.fluctuation > 1.0
    assert with_hinge.fluctuation < 1e-3 * without.fluctuation
    assert with_hinge.fluctuation < 1e-6
    assert with_hinge.mean_speed == close(SPEED, rel=1e-6)


def test_from_another_speed_the_hinge_does_not(point, profile):
    """Its moment holds the inertia's at one speed: at another one that of the rest is left."""
    slow = simulate_hinge(point, profile, start_speed=0.7 * SPEED, samples=720)
    assert slow.fluctuation > 0.1


def test_steady_hinge_turn_is_what_integration_gives(point):
    turn = steady_hinge_turn(point, flywheel=3000.0)
    run = simulate_hinge(point, flywheel=3000.0, samples=720)
    # Both use splines through the same 2880 values; the fluctuation is that of four times as many
    # values in one of them, between which a smooth extremum is missed by 1e-5 of the swing.
    assert turn.mean_speed == close(SPEED, rel=1e-12)
    assert run.fluctuation == close(turn.fluctuation, rel=1e-4)
    np.testing.assert_allclose(run.speed[:-1], turn.speed[::4], rtol=1e-8)
    assert abs(turn.gain) < 1e-7 * np.ptp(point.stored_energy)


def test_equation_of_motion_in_time(point):
    """I phi'' + I' phi'^2 / 2 = Q integrated over the time, with everything evaluated where needed."""

    def slope(_, state):
        reduced, moment = point.at_angles(angles_deg=np.degrees(state[:1]))
        inertia, rate = float(reduced.inertia[0]), float(reduced.inertia_rate[0])
        return state[1], (float(moment[0]) - 0.5 * rate * state[1] ** 2) / inertia

    turn = steady_hinge_turn(point, top_speed=SPEED)
    duration = 0.6 * 2.0 * np.pi / turn.mean_speed
    found = solve_ivp(slope, (0.0, duration), (0.0, SPEED), rtol=1e-9, atol=1e-9)
    angle, speed = found.y[:, -1]
    # Straight lines between 2880 values of a smooth curve: 1e-6 of it.
    expected = np.interp(angle, np.radians(turn.angles_deg), turn.speed)
    assert 2.0 < angle < 6.0
    assert speed == close(expected, rel=1e-5)


def test_flywheel_reaches_what_it_is_for(point):
    inertia = flywheel_for(point, 0.01)
    assert steady_hinge_turn(point, flywheel=inertia).fluctuation == close(0.01, rel=1e-9)
    # Classical: at an almost constant speed it stores what the hinge would store. The engine's own
    # inertia is 0.1 % of it, and squares of the fluctuation are left out: another 1 %.
    stored = float(np.ptp(point.stored_energy))
    assert inertia == close(stored / (0.01 * SPEED**2), rel=0.01)
    assert flywheel_for(point, 50.0) > 0.0
    with pytest.raises(InputError, match="fluctuation: given 1e-12"):
        flywheel_for(point, 1e-12)


def test_no_flywheel_where_none_is_needed(point, profile):
    assert flywheel_for(point, 0.01, profile) == 0.0


def test_light_engine_wants_the_pressure_of_its_gas_force():
    """Where inertia and weights do not change, twice the gas force takes twice the pressure."""
    rod = ConnectingRod(1.55, 1e-6, 0.8, 1e-7)
    light = replace(ENGINE, rod=rod, crosshead_mass=0.0, piston_rod_mass=0.0, piston_mass=1e-6)
    light = replace(light, gravity=0.0, crank_inertia=300.0)
    made_for = hinge_moment(light, smooth_force, SPEED)
    guides = hinge_profile(made_for, GasSpring(0.031, 1.0, 5e6), 0.8)
    twice = hinge_moment(light, lambda a: 2.0 * smooth_force(a), 1.3 * SPEED)
    best = best_pressure(twice, guides)
    # The search ends within 1e-10 of the logarithm; splines of the guides leave 1e-8 of the moment.
    assert best.ratio == close(2.0, rel=1e-6)
    assert best.fitted_ratio == close(2.0, rel=1e-7)
    assert best.fluctuation < 1e-5
    assert best.moment_residual < 1e-6
    assert best.unchanged is None or best.unchanged > 0.1


def test_best_pressure_at_the_design_is_the_designs(point, profile):
    best = best_pressure(point, profile)
    assert best.ratio == close(1.0, abs=1e-6)
    assert best.fluctuation <= best.unchanged < 1e-6


def test_refusals(point, profile):
    with pytest.raises(InputError, match=r"speed: given a mean of 89 1/min; allowed is .* 1/min"):
        steady_hinge_turn(point)
    with pytest.raises(InputError, match="top_speed: given 9 rad/s beside a mean speed of 9 rad/s"):
        steady_hinge_turn(point, speed=9.0, top_speed=9.0)
    with pytest.raises(InputError, match=r"top_speed: given 0.01 rad/s; allowed is more than"):
        steady_hinge_turn(point, top_speed=0.01)
    with pytest.raises(InputError, match="flywheel: given -1 kg"):
        steady_hinge_turn(point, flywheel=-1.0)
    with pytest.raises(InputError, match="bounds: given 2 to 1"):
        best_pressure(point, profile, bounds=(2.0, 1.0))
    with pytest.raises(InputError, match="between which the crank completes revolutions"):
        best_pressure(point, profile, bounds=(0.1, 0.2))
