"""The moment of an elastic hinge for a constant crank speed.

Tolerances: 1e-12 where two ways of the same algebra are compared; finite differences of fourth order
with a step of 1e-3 rad leave 1e-10 of the largest value or less, for harmonics up to the fourth.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from dynamics.cycle import even_angles
from dynamics.engine.forces import mechanism_forces
from dynamics.engine.rods import ConnectingRod
from dynamics.hinge.crosshead import (
    KINEMATICS,
    CrossheadEngine,
    piston_gas_force,
    reduced_crank,
    two_stroke_cycle,
)
from dynamics.hinge.moment import hinge_moment

ROD = ConnectingRod(1.55, 150.0, 0.8, 50.0)
ENGINE = CrossheadEngine(0.3, 0.5, 80.0, 0.2, 30.0, ROD, 150.0, 200.0, 110.0)
ANGLES = np.linspace(0.1, 6.2, 41)
STEP = 1e-3


def smooth_force(angles):
    """A gas force without kinks, with the peak past the top."""
    return 5e5 * np.exp(4.0 * (np.cos(angles - 0.3) - 1.0))


def derivative(function, angles):
    far = function(angles - 2.0 * STEP) - function(angles + 2.0 * STEP)
    near = function(angles + STEP) - function(angles - STEP)
    return (8.0 * near + far) / (12.0 * STEP)


def places(angles, engine=ENGINE):
    """Rod center, piston and crank center from the triangle of the mechanism, and the rod's angle."""
    rod, radius = engine.rod, engine.crank_radius
    tilt = np.arcsin(radius * np.sin(angles) / rod.length)
    pin = radius * np.exp(1j * angles)
    center = pin + rod.center_distance * np.exp(-1j * tilt)
    return center, pin + rod.length * np.exp(-1j * tilt), tilt


@pytest.mark.parametrize("kinematics", KINEMATICS)
def test_derivative_of_the_inertia(kinematics):
    found = reduced_crank(ENGINE, kinematics, angles_deg=np.degrees(ANGLES)).inertia_rate
    expected = derivative(
        lambda a: reduced_crank(ENGINE, kinematics, angles_deg=np.degrees(a)).inertia, ANGLES
    )
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(found).max())


def test_exact_kinematics_from_the_triangle():
    found = reduced_crank(ENGINE, angles_deg=np.degrees(ANGLES))
    center, piston, tilt = (
        derivative(lambda a, which=which: places(a)[which], ANGLES) for which in range(3)
    )
    inertia = (
        ENGINE.crank_inertia
        + ROD.mass * np.abs(center) ** 2
        + ROD.inertia * tilt**2
        + ENGINE.sliding_mass * np.abs(piston) ** 2
    )
    np.testing.assert_allclose(found.inertia, inertia, rtol=1e-9)
    np.testing.assert_allclose(found.travel_rate, -piston.real, atol=1e-10)
    rise = ENGINE.crank_mass * 0.2 * np.cos(ANGLES) + ROD.mass * center.imag
    np.testing.assert_allclose(found.weight_moment, -9.81 * rise, atol=1e-7)


def test_same_as_the_forces_of_the_mechanism():
    speed = 9.3
    found = hinge_moment(replace(ENGINE, gravity=0.0), smooth_force, speed, samples=90)
    torque = mechanism_forces(
        ENGINE.layout,
        speed,
        smooth_force(np.radians(found.angles_deg)),
        shaft_angles_deg=found.angles_deg,
    ).torque
    largest = np.abs(found.moment).max()
    np.testing.assert_allclose(found.moment, found.load - torque[0], atol=1e-12 * largest)


def test_without_mass_the_hinge_takes_the_gas_moment():
    rod = replace(ROD, mass=1e-9, inertia=1e-10)
    light = replace(
        ENGINE, crank_mass=0.0, rod=rod, crosshead_mass=0.0, piston_rod_mass=0.0, piston_mass=1e-9
    )
    found = hinge_moment(light, smooth_force, 9.3)
    largest = np.abs(found.moment).max()
    np.testing.assert_allclose(found.moment, found.load - found.gas_moment, atol=1e-9 * largest)
    # The constant inertia of the crank asks for nothing.
    assert found.load == close(np.mean(found.gas_moment), rel=1e-14)


@pytest.mark.parametrize("kinematics", KINEMATICS)
def test_without_gas_the_hinge_takes_inertia_and_weight(kinematics):
    found = hinge_moment(ENGINE, lambda a: np.zeros_like(a), 9.3, kinematics=kinematics)
    assert found.load == 0.0
    expected = 0.5 * 9.3**2 * found.reduced.inertia_rate - found.reduced.weight_moment
    np.testing.assert_allclose(found.moment, expected, atol=1e-12 * np.abs(expected).max())
    assert abs(found.closing_error) < 1e-12


@settings(max_examples=25, deadline=None)
@given(
    speed=st.floats(1.0, 60.0),
    length=st.floats(0.8, 4.0),
    share=st.floats(0.1, 0.9),
    peak=st.floats(-0.5, 1.0),
    kinematics=st.sampled_from(KINEMATICS),
)
def test_the_hinge_gives_over_a_turn_what_it_takes(speed, length, share, peak, kinematics):
    rod = ConnectingRod(length, 150.0, share * length, 5.0)
    engine = replace(ENGINE, rod=rod)
    found = hinge_moment(
        engine, lambda a: 3e5 * np.exp(np.cos(a - peak)), speed, kinematics=kinematics, samples=360
    )
    assert abs(found.closing_error) < 1e-9
    # The derivative of the stored energy is the moment: round-off of a transform of 360 values.
    energy = found.stored_energy
    assert energy[0] == 0.0
    spectrum = np.fft.rfft(energy)
    slope = np.fft.irfft(1j * np.arange(spectrum.size) * spectrum, energy.size)
    np.testing.assert_allclose(-slope, found.moment, atol=1e-9 * np.abs(found.moment).max())


def test_order_of_the_series():
    """The series leaves out lambda^3; the sign printed for the rod is off by lambda."""

    def largest_difference(ratio, kinematics):
        length = ENGINE.crank_radius / ratio
        engine = replace(ENGINE, rod=ConnectingRod(length, 150.0, 0.5 * length, 50.0))
        exact, found = (
            reduced_crank(engine, name, angles_deg=np.degrees(ANGLES))
            for name in ("exact", kinematics)
        )
        return np.array(
            [
                np.abs(found.inertia_rate - exact.inertia_rate).max(),
                np.abs(found.travel_rate - exact.travel_rate).max(),
            ]
        )

    for kinematics, order, which in (("series", 3.0, slice(None)), ("printed", 1.0, slice(1))):
        coarse, fine = (largest_difference(ratio, kinematics)[which] for ratio in (0.02, 0.01))
        # The next term is smaller by lambda^2 (series) or lambda^2 (printed, whose lambda^3 is next).
        np.testing.assert_allclose(np.log2(coarse / fine), order, atol=0.01)


def test_center_of_the_rod_at_the_crosshead_moves_as_it_does():
    """With l_1 = L the rod's center is the crosshead: only plus can be right for its velocity."""
    rod = ConnectingRod(1.55, 150.0, 1.55 * (1.0 - 1e-9), 1e-9)
    with_rod = replace(ENGINE, rod=rod)
    moved = replace(with_rod, rod=replace(rod, mass=1e-9), piston_mass=260.0)
    series, expected = (
        reduced_crank(e, "series", angles_deg=np.degrees(ANGLES)).inertia for e in (with_rod, moved)
    )
    np.testing.assert_allclose(series, expected, rtol=1e-8)
    printed = reduced_crank(with_rod, "printed", angles_deg=np.degrees(ANGLES)).inertia
    assert np.abs(printed / expected - 1.0).max() > 0.1


def test_load_is_the_indicated_work():
    cycle = two_stroke_cycle(
        ENGINE, 15.0, peak_pressure=8e6, mean_effective_pressure=0.8e6, intake_pressure=1.5e5
    )
    force = piston_gas_force(ENGINE, cycle.pressure, 1.5e5)
    found = hinge_moment(ENGINE, force, 9.3)
    # Work from p dV, with another rule of integration over the same samples.
    swept = ENGINE.area * 2.0 * ENGINE.crank_radius
    assert 2.0 * np.pi * found.load == close(0.8e6 * swept, rel=1e-6)
    below = hinge_moment(ENGINE, piston_gas_force(ENGINE, cycle.pressure, 1e5), 9.3)
    assert below.load == close(found.load, rel=1e-12)


def test_samples_of_the_force_serve_as_a_function_does():
    by_function = hinge_moment(ENGINE, smooth_force, 9.3)
    by_samples = hinge_moment(ENGINE, smooth_force(even_angles(2.0 * np.pi, 720)), 9.3)
    # Cubic splines over 0.5 deg: (0.5 deg)^4 / 384 of the fourth derivative, some 30 times the value.
    largest = np.abs(by_function.moment).max()
    np.testing.assert_allclose(by_samples.moment, by_function.moment, atol=1e-9 * largest)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"crank_radius": 1.6}, "crank_radius: given 1.6 m"),
        ({"piston_mass": -1.0}, "piston_mass: given -1 kg"),
        ({"crosshead_mass": np.nan}, "crosshead_mass: given nan"),
        (
            {"crank_inertia": 1.0},
            "crank_inertia: given 1 kg m\\^2; allowed is 3.2 kg m\\^2 or more",
        ),
    ],
)
def test_engines_refused(change, match):
    with pytest.raises(InputError, match=match):
        replace(ENGINE, **change)


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ({"speed": 0.0}, "speed: given 0 rad/s"),
        ({"samples": 10}, "samples: given 10"),
        ({"samples": 100.5}, "samples: given 100.5; allowed are whole numbers of 72 or more"),
        ({"kinematics": "exakt"}, "kinematics: given 'exakt'"),
        ({"gas_force": np.ones(5)}, "gas_force: given 5 values"),
        ({"gas_force": lambda a: a + np.nan}, "gas_force"),
        ({"gas_force": lambda a: a[1:]}, "gas_force: given 1439 values for 1440 angles"),
    ],
)
def test_moments_refused(arguments, match):
    given_values = {"gas_force": smooth_force, "speed": 9.3} | arguments
    force, speed = given_values.pop("gas_force"), given_values.pop("speed")
    with pytest.raises(InputError, match=match):
        hinge_moment(ENGINE, force, speed, **given_values)


def test_series_refuses_a_lateral_center():
    with pytest.raises(InputError, match=r"center_offset: given 0\.1 m"):
        reduced_crank(
            replace(ENGINE, rod=replace(ROD, center_offset=0.1)),
            kinematics="series",
            angles_deg=np.degrees(ANGLES),
        )
