import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from dynamics.gas.cylinder_volume import (
    indicated_mean_effective_pressure,
    indicated_work,
    periodic_slope,
)

R, L, AREA = 0.07, 0.25, 0.0133


def position(angle):
    return R * np.cos(angle) + np.sqrt(L**2 - (R * np.sin(angle)) ** 2)


def position_slope(angle):
    rod = np.sqrt(L**2 - (R * np.sin(angle)) ** 2)
    return -R * np.sin(angle) * (1.0 + R * np.cos(angle) / rod)


def even(count, strokes=4):
    return np.pi * strokes / count * np.arange(count)


@given(st.floats(0.0, 1e6), st.floats(-1e6, 1e6), st.floats(-1e6, 1e6), st.sampled_from((2, 4)))
def test_work_of_a_harmonic_pressure(mean, cosine, sine, strokes):
    """p = p0 + a cos x + b sin x on dV = v sin x dx does the work pi b v in each turn."""
    angle = even(90, strokes)
    pressure = mean + cosine * np.cos(angle) + sine * np.sin(angle)
    work = indicated_work(pressure, 1e-3 * np.sin(angle), strokes)
    # Round-off of 90 terms of up to 3e6 Pa times 1e-3 m^3.
    assert work == close(strokes / 2 * np.pi * 1e-3 * sine, rel=1e-12, abs=1e-10)


@given(st.floats(-1e6, 1e6), st.lists(st.floats(1e4, 2e7), min_size=72, max_size=144))
def test_constant_pressure_under_the_piston_does_no_work(under, values):
    angle = even(len(values))
    slope = -AREA * position_slope(angle)
    whole = indicated_work(values, slope)
    # Round-off of the largest term, pressure times slope.
    most = (abs(under) + max(values)) * np.max(np.abs(slope))
    assert indicated_work(np.array(values) - under, slope) == close(whole, abs=1e-13 * most)


@given(st.lists(st.floats(1e4, 2e7), min_size=72, max_size=144), st.floats(0.0, 2e5))
def test_gas_torque_does_the_indicated_work(values, under):
    """Torque by the paper's P sin(alpha + beta) / cos(beta) R, work from p dV."""
    angle = even(len(values))
    beta = np.arcsin(R / L * np.sin(angle))
    force = AREA * (np.array(values) - under)
    torque = force * R * np.sin(angle + beta) / np.cos(beta)
    slope = -AREA * position_slope(angle)
    # Round-off of the work that goes to and fro.
    exchanged = indicated_work(np.array(values) + under, np.abs(slope))
    assert 4.0 * np.pi * np.mean(torque) == close(
        indicated_work(values, slope), abs=1e-13 * exchanged
    )


@pytest.mark.parametrize("count", [720, 1441])
def test_slope_of_the_piston_position(count):
    """Orders of the position fall as (R / 2 L)^k: the series has died out long before half."""
    angle = even(count)
    slope = periodic_slope(position(angle), 4.0 * np.pi)
    assert slope == close(position_slope(angle), abs=1e-12 * R)


def test_slope_of_samples_that_alternate_is_unseen():
    assert periodic_slope(np.array([1.0, -1.0] * 4), 1.0) == close(np.zeros(8), abs=1e-14)


def test_mean_effective_pressure_is_work_over_swept_volume():
    assert indicated_mean_effective_pressure(3000.0, 1.5e-3) == 2e6
    with pytest.raises(InputError, match="swept: given 0"):
        indicated_mean_effective_pressure(3000.0, 0.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: indicated_work([1.0, 2.0], [1.0]), "volume_slope: given 1 values for 2 of press"),
        (lambda: indicated_work([], []), "volume_slope: given 0 values for 0"),
        (lambda: indicated_work([1.0, np.inf], [1.0, 1.0]), r"pressure\[1\]: given inf"),
        (lambda: indicated_work([1.0], [1.0], 3), "strokes: given 3"),
    ],
)
def test_unusable_arrays_are_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
