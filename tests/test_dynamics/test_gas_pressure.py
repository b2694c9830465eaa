import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from dynamics.cycle import cycle_radians
from dynamics.gas.pressure import gas_pressure


def curve(angle, cycle):
    """A smooth periodic pressure with its peak 10 deg after the top."""
    return 2e5 + 9e6 * np.exp(-60.0 * np.sin((angle - np.radians(10.0)) * np.pi / cycle) ** 2)


def even(count, strokes, start=0.0):
    cycle = np.pi * strokes
    angles = np.radians(start) + cycle / count * np.arange(count)
    return gas_pressure(curve(angles, cycle), strokes, angles_deg=np.degrees(angles))


@pytest.mark.parametrize("strokes", [2, 4])
@pytest.mark.parametrize("start", [-360.0, -180.0, -17.3, 0.0, 200.0])
def test_even_samples_are_kept_wherever_the_cycle_starts(strokes, start):
    found = even(360, strokes, start)
    cycle = np.pi * strokes
    assert found.remarks == ()
    assert np.all(np.diff(np.radians(found.angles_deg)) > 0.0)
    assert 0.0 <= np.radians(found.angles_deg)[0] < cycle / 360
    assert np.radians(found.angles_deg)[-1] < cycle
    # Round-off of folding the angles, times the steepest slope of the curve.
    assert found.pressure == close(curve(np.radians(found.angles_deg), cycle), rel=1e-11)


def test_curve_meets_its_samples_exactly_and_repeats():
    found = even(360, 4)
    assert found.at(angle_deg=found.angles_deg).tolist() == found.pressure.tolist()
    angles = np.linspace(-20.0, 40.0, 1001).reshape(7, 143)
    once, later = found.at(angle_deg=angles), found.at(angle_deg=angles + 3.0 * found.cycle_deg)
    assert once.shape == (7, 143)
    # Angles of some 50 rad are rounded at 1e-14, where the curve rises by 30 times its value.
    assert later == close(once, rel=1e-12)


@given(st.lists(st.floats(1e4, 2e7), min_size=72, max_size=90), st.floats(-30.0, 30.0))
@settings(max_examples=50)
def test_curve_stays_between_neighboring_samples(values, angle):
    angles = 2.0 * np.pi / len(values) * np.arange(len(values))
    found = gas_pressure(values, 2, angles_deg=np.degrees(angles))
    place = (
        int(
            np.searchsorted(
                np.radians(found.angles_deg), angle % cycle_radians(found.strokes), side="right"
            )
        )
        - 1
    )
    pair = found.pressure[place], found.pressure[(place + 1) % len(values)]
    value = float(found.at(angle_deg=np.degrees(angle)))
    # Round-off of the cubic on the largest value.
    assert min(pair) - 1e-8 <= value <= max(pair) + 1e-8


@given(st.lists(st.floats(1e4, 2e7), min_size=72, max_size=90), st.integers(1, 71))
@settings(max_examples=50)
def test_curve_does_not_know_where_the_cycle_begins(values, places):
    step = 2.0 * np.pi / len(values)
    angles = step * np.arange(len(values))
    one = gas_pressure(values, 2, angles_deg=np.degrees(angles))
    other = gas_pressure(np.roll(values, places), 2, angles_deg=np.degrees(angles))
    asked = np.linspace(0.0, 2.0 * np.pi, 401)
    # Angles are rounded at 1e-15; the curve rises by at most 3 times the range in a step.
    assert other.at(angle_deg=np.degrees(asked + places * step)) == close(
        one.at(angle_deg=np.degrees(asked)), abs=1e-12 * 2e7
    )


def test_curve_converges_on_a_smooth_pressure():
    """Slopes are of third order but at the extremes: a quarter of the step, error 1/16 or less."""
    errors = []
    angles = np.linspace(0.0, 4.0 * np.pi, 9001)
    for count in (360, 1440):
        errors.append(
            np.max(
                np.abs(even(count, 4).at(angle_deg=np.degrees(angles)) - curve(angles, 4.0 * np.pi))
            )
        )
    assert errors[0] < 2e-3 * 9e6
    assert errors[1] < errors[0] / 14.0


@pytest.mark.parametrize(("strokes", "peak"), [(2, -5.0), (4, -5.0), (2, 12.0), (4, 300.0)])
def test_peak_lies_about_the_top(strokes, peak):
    angles = np.radians(np.arange(0.0, 180.0 * strokes, 1.0))
    values = 2e5 + 1e5 * np.cos((angles - np.radians(peak)) * 2.0 / strokes)
    found = gas_pressure(values, strokes, angles_deg=np.degrees(angles))
    assert found.peak_angle_deg == close(peak)
    assert found.peak_pressure == close(3e5)
    assert found.lowest == close(1e5)


def test_uneven_samples_are_made_even_on_their_curve_and_said():
    coarse = np.concatenate([np.arange(-360.0, -40.0, 4.0), np.arange(-40.0, 60.0, 1.0)])
    angles = np.radians(np.concatenate([coarse, np.arange(60.0, 360.0, 4.0)]))
    found = gas_pressure(
        curve(angles, 4.0 * np.pi), 4, remarks=("Before.",), angles_deg=np.degrees(angles)
    )
    assert found.remarks[0] == "Before."
    assert (
        "255 uneven samples were replaced by 1440 even ones in steps of 0.5 deg"
        in (found.remarks[1])
    )
    assert np.diff(np.radians(found.angles_deg)) == close(np.radians(0.5))
    # The highest sample is one of the even ones.
    assert found.peak_angle_deg == close(10.0)
    assert found.peak_pressure == close(9.2e6, rel=1e-12)
    # Where the samples are 4 deg apart the curve is flat, elsewhere they are 1 deg apart.
    assert found.pressure == close(curve(np.radians(found.angles_deg), 4.0 * np.pi), abs=2e-4 * 9e6)


def test_angles_printed_rounded_are_moved_to_even_places():
    angles = np.round(np.arange(540) * 720.0 / 540.0, 2)
    found = gas_pressure(curve(np.radians(angles), 4.0 * np.pi), angles_deg=angles)
    assert np.radians(found.angles_deg) == close(4.0 * np.pi / 540 * np.arange(540), abs=1e-12)
    assert found.remarks == ("Angles were moved by up to 0.0033 deg to their even places.",)


def test_arrays_are_closed_to_writing():
    with pytest.raises(ValueError, match="read-only"):
        even(360, 4).pressure[0] = 1.0


DEGREES = np.arange(0.0, 360.0, 5.0)


@pytest.mark.parametrize(
    ("degrees", "values", "message"),
    [
        (DEGREES, np.ones(71), "angles_deg: given 72 angles for 71 pressures"),
        (DEGREES, np.zeros(72), r"pressure\[0\]: given 0 Pa; allowed are .* more than zero"),
        (DEGREES, np.full(72, np.nan), r"pressure\[0\]: given nan; allowed are finite"),
        (DEGREES[::-1], np.ones(72), r"angles_deg\[1\]: given 350 deg after 355 deg"),
        (np.append(DEGREES, 360.0), np.ones(73), "without the closing sample"),
        (DEGREES[:60], np.ones(60), "given no sample for 65 deg before 0 deg"),
        (np.delete(DEGREES, [10, 11]), np.ones(70), "given no sample for 15 deg before 60 deg"),
        ([1.0], [1.0], "angles_deg: given 1 samples"),
    ],
)
def test_unusable_samples_are_refused(degrees, values, message):
    with pytest.raises(InputError, match=message):
        gas_pressure(values, 2, angles_deg=degrees)


def test_angle_must_be_a_number():
    with pytest.raises(InputError, match="angle_deg: given nan"):
        even(360, 4).at(angle_deg=np.nan)
    with pytest.raises(InputError, match="strokes: given 3"):
        even(360, 3)
