"""Kinematics of one crank, rod and piston.

Derivatives are compared with five-point differences of a step of 1e-3 rad: their own error is below
1e-10 of the crank radius for the first derivative and, by round-off over the step squared, 1e-9 for
the second, while a wrong term would show at the size of lambda^2 or more.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from dynamics.engine.slider_crank import SliderCrank, crankpin_motion

STEP = 1e-3
ANGLES = np.linspace(0.0, 2.0 * math.pi, 13)
share = st.floats(-1.0, 1.0)


def differences(function, angles):
    """First and second derivative by five points."""
    far, near = 2.0 * STEP, STEP
    values = [function(angles + shift) for shift in (-far, -near, 0.0, near, far)]
    first = np.dot([1.0, -8.0, 0.0, 8.0, -1.0], np.array(values).reshape(5, -1)) / (12.0 * STEP)
    second = np.dot([-1.0, 16.0, -30.0, 16.0, -1.0], np.array(values).reshape(5, -1))
    return first, second / (12.0 * STEP**2)


@st.composite
def drives(draw):
    ratio = draw(st.floats(0.05, 0.5))
    offset = 0.5 * (1.0 - ratio) * draw(share)
    return SliderCrank(0.07, 0.07 / ratio, offset * 0.07 / ratio)


@settings(max_examples=20, deadline=None)
@given(drives(), st.floats(-0.2, 1.2), st.floats(-0.3, 0.3))
def test_all_derivatives_are_those_of_the_positions(drive, along, across):
    length = drive.rod_length
    point = (along * length, across * length)
    for motion in (
        drive.crankpin,
        drive.piston,
        drive.travel,
        lambda angle_deg: drive.rod_point(*point, angle_deg=angle_deg),
    ):
        first, second = differences(
            lambda angle, motion=motion: motion(angle_deg=np.degrees(angle)).place, ANGLES
        )
        found = motion(angle_deg=np.degrees(ANGLES))
        np.testing.assert_allclose(found.first, first, rtol=0.0, atol=1e-9 * length)
        np.testing.assert_allclose(found.second, second, rtol=0.0, atol=1e-8 * length)
    first, second = differences(
        lambda angle: drive.rod(angle_deg=np.degrees(angle)).angle_rad, ANGLES
    )
    np.testing.assert_allclose(
        drive.rod(angle_deg=np.degrees(ANGLES)).first, first, rtol=0.0, atol=1e-9
    )
    np.testing.assert_allclose(
        drive.rod(angle_deg=np.degrees(ANGLES)).second, second, rtol=0.0, atol=1e-8
    )


@settings(max_examples=20, deadline=None)
@given(drives())
def test_the_rod_keeps_its_length_and_the_piston_its_line(drive):
    crank, piston = (
        drive.crankpin(angle_deg=np.degrees(ANGLES)).place,
        drive.piston(angle_deg=np.degrees(ANGLES)).place,
    )
    # Round-off of sums of numbers of the rod's size.
    room = 1e-14 * drive.rod_length
    np.testing.assert_allclose(np.abs(piston - crank), drive.rod_length, rtol=1e-14)
    np.testing.assert_allclose(piston.imag, drive.pin_offset, rtol=0.0, atol=room)
    np.testing.assert_allclose(np.abs(crank), drive.crank_radius, rtol=1e-14)
    assert np.all(piston.real > crank.real)
    np.testing.assert_allclose(
        drive.rod_point(0.0, angle_deg=np.degrees(ANGLES)).place, crank, rtol=0.0, atol=room
    )


@settings(max_examples=20, deadline=None)
@given(drives())
def test_the_piston_stands_still_at_its_ends_of_stroke(drive):
    ends = drive.travel(angle_deg=[drive.top_angle_deg, drive.bottom_angle_deg])
    np.testing.assert_allclose(ends.first.real, 0.0, atol=1e-14 * drive.rod_length)
    np.testing.assert_allclose(
        ends.place.real, [0.0, drive.stroke], rtol=0.0, atol=1e-14 * drive.rod_length
    )
    travel = drive.travel(angle_deg=np.degrees(ANGLES)).place.real
    assert np.all(travel >= -1e-14)
    assert np.all(travel <= drive.stroke + 1e-14)
    assert drive.stroke >= 2.0 * drive.crank_radius * (1.0 - 1e-14)


@settings(max_examples=20, deadline=None)
@given(drives())
def test_running_backwards_mirrors_the_offset(drive):
    mirrored = SliderCrank(drive.crank_radius, drive.rod_length, -drive.pin_offset)
    room = 1e-14 * drive.rod_length
    forth, back = (
        drive.rod_point(0.1, 0.02, angle_deg=np.degrees(ANGLES)),
        mirrored.rod_point(0.1, -0.02, angle_deg=np.degrees(-ANGLES)),
    )
    np.testing.assert_allclose(back.place, forth.place.conj(), rtol=0.0, atol=room)
    np.testing.assert_allclose(back.first, -forth.first.conj(), rtol=0.0, atol=room)
    np.testing.assert_allclose(back.second, forth.second.conj(), rtol=0.0, atol=room)


def test_the_piston_acceleration_in_closed_form():
    """s'' = -R (cos a + (lambda cos 2a + lambda^3 sin^4 a) / (1 - lambda^2 sin^2 a)^1.5), by hand."""
    drive = SliderCrank(0.07, 0.265)
    ratio, sine = 0.07 / 0.265, np.sin(ANGLES)
    bent = (ratio * np.cos(2.0 * ANGLES) + ratio**3 * sine**4) / (1.0 - (ratio * sine) ** 2) ** 1.5
    wanted = -0.07 * (np.cos(ANGLES) + bent)
    np.testing.assert_allclose(
        drive.piston(angle_deg=np.degrees(ANGLES)).second, wanted, rtol=0.0, atol=1e-15
    )


@settings(max_examples=20, deadline=None)
@given(st.floats(0.05, 0.4))
def test_orders_of_the_piston_acceleration_are_the_binomial_series(ratio):
    """-R (cos a + A_2 cos 2a + A_4 cos 4a ...); the next terms are below 0.15 lambda^7."""
    angles = np.arange(64) * math.pi / 32.0
    found = SliderCrank(1.0, 1.0 / ratio).piston(angle_deg=np.degrees(angles)).second.real
    second, fourth = (-2.0 * np.mean(found * np.cos(k * angles)) for k in (2, 4))
    room = 0.15 * ratio**7 / (1.0 - ratio**2) ** 2 + 1e-14
    assert second == close(ratio + ratio**3 / 4.0 + 15.0 * ratio**5 / 128.0, abs=room)
    assert fourth == close(-(ratio**3 / 4.0 + 3.0 * ratio**5 / 16.0), abs=room)


def test_with_a_rod_without_end_the_piston_moves_as_a_cosine():
    # What is left is lambda = 1e-6 of the crank radius.
    drive = SliderCrank(0.07, 0.07e6)
    np.testing.assert_allclose(
        drive.piston(angle_deg=np.degrees(ANGLES)).second,
        -0.07 * np.cos(ANGLES),
        rtol=0.0,
        atol=1.1 * 0.07e-6,
    )
    np.testing.assert_allclose(drive.rod(angle_deg=np.degrees(ANGLES)).angle_rad, 0.0, atol=1.1e-6)


def test_signs_of_a_quarter_turn():
    """The crankpin moves to +n at the top; the rod then leans back, so its turning is negative."""
    drive = SliderCrank(0.07, 0.265)
    quarter = np.array([0.5 * math.pi])
    assert drive.crankpin(angle_deg=np.degrees([0.0])).first[0] == close(0.07j)
    assert drive.crankpin(angle_deg=np.degrees(quarter)).place[0] == close(0.07j)
    assert drive.rod(angle_deg=np.degrees(quarter)).angle_rad[0] == close(-math.asin(0.07 / 0.265))
    assert drive.rod_point(0.1, 0.02, angle_deg=np.degrees([0.0])).place[0] == close(0.17 + 0.02j)


def test_velocity_and_acceleration_of_a_crank_that_speeds_up():
    """Against differences in time of a point of the rod, angle = 1 + 200 t + 5000 t^2 / 2."""
    drive = SliderCrank(0.07, 0.265, 0.01)
    speed, gain, step = 200.0, 5000.0, 2e-5
    times = step * np.arange(-2.0, 3.0)
    places = drive.rod_point(
        0.1, 0.02, angle_deg=np.degrees(1.0 + speed * times + 0.5 * gain * times**2)
    ).place
    velocity = np.dot([1.0, -8.0, 0.0, 8.0, -1.0], places) / (12.0 * step)
    acceleration = np.dot([-1.0, 16.0, -30.0, 16.0, -1.0], places) / (12.0 * step**2)
    point, turn = (
        drive.rod_point(0.1, 0.02, angle_deg=np.degrees([1.0])),
        drive.rod(angle_deg=np.degrees([1.0])),
    )
    assert point.velocity(speed)[0] == close(velocity, rel=1e-9)
    # Round-off: 1e-17 m / (2e-5 s)^2 of 1e3 m/s^2.
    assert point.acceleration(speed, gain)[0] == close(acceleration, rel=1e-8)
    turned = turn.acceleration(speed, gain)[0]
    angles = drive.rod(angle_deg=np.degrees(1.0 + speed * times + 0.5 * gain * times**2)).angle_rad
    wanted = np.dot([-1.0, 16.0, -30.0, 16.0, -1.0], angles) / (12.0 * step**2)
    assert turned == close(wanted, rel=1e-8)


def test_turned_by_a_right_angle_along_becomes_across():
    motion = crankpin_motion(0.07, ANGLES).turned(angle_deg=math.degrees(0.5 * math.pi))
    later = crankpin_motion(0.07, ANGLES + 0.5 * math.pi)
    for name in ("place", "first", "second"):
        np.testing.assert_allclose(
            getattr(motion, name), getattr(later, name), rtol=0.0, atol=1e-16
        )


@pytest.mark.parametrize(
    ("sizes", "words"),
    [
        ((0.0, 0.265), "crank_radius: given 0 m; .*more than zero"),
        ((0.07, -0.265), "rod_length: given -0.265 m; .*more than zero"),
        ((0.07, math.nan), "rod_length: given nan m"),
        (
            (0.265, 0.265),
            "crank_radius: given 0.265 m .* less than rod length minus offset, 0.265 m",
        ),
        ((0.07, 0.1, 0.03), "pin offset of 0.03 m; .*minus offset, 0.07 m, because the crank must"),
        ((0.07, 0.1, -0.03), "pin offset of 0.03 m; .*minus offset, 0.07 m"),
        ((0.07, 0.1, math.inf), "pin_offset: given inf"),
    ],
)
def test_cranks_that_do_not_turn_are_refused(sizes, words):
    with pytest.raises(InputError, match=words):
        SliderCrank(*sizes)


def test_angles_that_are_not_numbers_are_refused():
    drive = SliderCrank(0.07, 0.265)
    with pytest.raises(InputError, match=r"angle_deg\[1\]: given nan"):
        drive.piston(angle_deg=np.degrees([0.0, math.nan]))
    with pytest.raises(InputError, match="along, across"):
        drive.rod_point(math.nan, angle_deg=np.degrees([0.0]))
