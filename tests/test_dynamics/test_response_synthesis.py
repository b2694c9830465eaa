"""Sum of orders over the cycle: extremes against known and densely sampled sums."""

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.response.order_excitation import at_angles
from dynamics.response.series import PEAK_ERROR_BOUND, common_order, extreme_angles, synthesis

ONE = np.array([100.0])


def test_known_sums():
    """cos x + cos 2x / 2 peaks at 1.5 and is lowest, -0.75, where cos x = -1/2; two signs, scales."""
    for scale in (1e-200, 1.0, 1e200):
        for turn in (0.0, 0.7123, 3.0):
            phasors = scale * np.array([1.0, 0.5]) * np.exp(1j * turn * np.array([1.0, 2.0]))
            phasors = np.stack((phasors, -phasors), axis=1)[:, np.newaxis, :]
            found = synthesis(np.array([1.0, 2.0]), ONE, phasors)
            np.testing.assert_allclose(found.highest[0] / scale, [1.5, 0.75], rtol=1e-13)
            np.testing.assert_allclose(found.lowest[0] / scale, [-0.75, -1.5], rtol=1e-13)
            np.testing.assert_allclose(found.amplitude[0] / scale, 1.125, rtol=1e-13)
            np.testing.assert_allclose(found.plain_sum[0] / scale, 1.5, rtol=1e-13)
            assert found.period == close(2.0 * np.pi, rel=1e-15)


def test_against_dense_samples():
    """24 half orders with random phases: no sample of 40,001 exceeds, the best comes within 2e-6.

    A sample stands at most half a step, 1.6e-4 rad, from the peak, where the sum has fallen by up
    to (12 * 1.6e-4)^2 / 2 = 1.8e-6 of its amplitude.
    """
    draw = np.random.default_rng(4)
    orders = 0.5 * np.arange(1, 25)
    phasors = draw.normal(size=(24, 1, 40)) + 1j * draw.normal(size=(24, 1, 40))
    found = synthesis(orders, ONE, phasors)
    assert found.period == close(4.0 * np.pi)
    angles = np.linspace(0.0, 4.0 * np.pi, 40_001)
    for place in range(3):
        dense = at_angles(orders, phasors[:, 0, place], angles)
        assert dense.max() <= found.highest[0, place] * (1.0 + 1e-14)
        assert dense.min() >= found.lowest[0, place] * (1.0 + 1e-14)
        half = 0.5 * (dense.max() - dense.min())
        assert found.amplitude[0, place] == close(half, rel=2e-6)
    assert np.all(found.amplitude < found.plain_sum)


def test_bound_of_the_samples_alone():
    """The worst case of the bound: a single wave whose peaks lie between the samples."""
    size = 32
    worst = np.cos(2.0 * np.pi * np.arange(size) / size - np.pi / size)
    assert 1.0 - worst.max() == close(PEAK_ERROR_BOUND, rel=1e-12)
    assert PEAK_ERROR_BOUND < 0.005


def test_plain_sum_is_reached_where_peaks_meet_and_rest_is_rest():
    phasors = np.zeros((3, 1, 2), dtype=complex)
    phasors[:, 0, 0] = [1.0, 2.0, 3.0]
    found = synthesis(np.array([1.0, 3.0, 5.0]), ONE, phasors)
    np.testing.assert_allclose(found.amplitude, [[6.0, 0.0]], rtol=1e-14)
    np.testing.assert_allclose(found.plain_sum, [[6.0, 0.0]], rtol=1e-14)


def test_common_order():
    multiples, common = common_order(np.array([0.5, 1.5, 4.0]))
    assert (multiples.tolist(), common) == ([1, 3, 8], 0.5)
    assert common_order(np.array([4.0, 8.0]))[1] == 4.0
    assert common_order(np.array([1.0 / 3.0, 0.5]))[1] == close(1.0 / 6.0)
    with pytest.raises(InputError, match=r"orders: given 1.414.*; allowed are fractions"):
        common_order(np.array([1.0, np.sqrt(2.0)]))
    with pytest.raises(
        InputError, match=r"multiples of .* only, up to 90; allowed are up to 20000"
    ):
        common_order(np.array([1.0 / 997.0, 90.0]))


def test_of_equal_peaks_the_first_is_told():
    """Order 1 alone has two equal peaks in a cycle of two revolutions; round-off may raise either."""
    orders = np.array([0.5, 1.0])
    for noise in (-1e-13, 1e-13):
        phasors = np.array([noise, np.exp(-0.5j)])
        assert extreme_angles(orders, phasors) == close((0.5, 0.5 + np.pi), rel=1e-6)
