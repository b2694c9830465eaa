"""Curves through samples against scipy's."""

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from crankbase.monotone_curve import MonotoneCurve


@pytest.mark.parametrize("seed", range(40))
def test_the_curve_is_scipys_bit_for_bit(seed):
    """With turns, level stretches, and few samples; within the samples and at them."""
    random = np.random.default_rng(seed)
    count = int(random.integers(2, 40)) if seed else 2
    places = np.cumsum(random.uniform(0.1, 3.0, count))
    values = np.round(random.normal(size=count), int(random.integers(0, 4)))
    asked = np.concatenate([places, random.uniform(places[0], places[-1], (200))])
    expected = PchipInterpolator(places, values)(asked)
    assert np.array_equal(MonotoneCurve(places, values)(asked), expected)
    shape = (20, 10)
    assert MonotoneCurve(places, values)(asked[-200:].reshape(shape)).shape == shape
