import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from dynamics.critical import critical_speeds, engine_orders, major_orders, vector_sums
from references import even_firing_angles


def test_engine_orders():
    assert engine_orders(4, 2.2).tolist() == [0.5, 1.0, 1.5, 2.0]
    assert engine_orders(2, 3.0).tolist() == [1.0, 2.0, 3.0]
    with pytest.raises(InputError, match=r"highest: given 0\.4; allowed is 0\.5 or more"):
        engine_orders(4, 0.4)


def test_critical_speeds_stand_in_ascending_order_and_within_range():
    found = critical_speeds([0.0, 100.0, 240.0], [2.0, 4.0, 5.0], (100.0, 400.0))
    expected = [(1, 5.0), (1, 4.0), (2, 5.0), (1, 2.0), (2, 4.0)]
    assert [(item.mode, item.order) for item in found] == expected
    assert [item.speed for item in found] == sorted(item.speed for item in found)
    for item in found:
        assert item.order * item.speed == close(2.0 * math.pi * item.frequency)
        assert item.speed_rpm == close(60.0 * item.frequency / item.order)


def test_ends_of_the_range_belong_to_it():
    speed = 2.0 * math.pi * 100.0 / 4.0
    assert len(critical_speeds([100.0], [4.0], (speed, 2.0 * speed))) == 1
    assert len(critical_speeds([100.0], [4.0], (0.5 * speed, speed))) == 1


@pytest.mark.parametrize(
    ("speed_range", "message"),
    [
        ((300.0, 100.0), r"speed_range: given \(300, 100\) rad/s"),
        ((100.0, 100.0), "speed_range: given"),
        ((0.0, 100.0), r"speed_range\[0\]: given 0 rad/s"),
        ((-5.0, 100.0), r"speed_range\[0\]: given -5 rad/s"),
        ((5.0, float("inf")), r"speed_range\[1\]: given inf"),
        ((1.0, 2.0, 3.0), "speed_range: given"),
    ],
)
def test_unusable_ranges_are_refused(speed_range, message):
    with pytest.raises(InputError, match=message):
        critical_speeds([10.0], [1.0], speed_range)


def test_unusable_frequencies_and_orders_are_refused():
    with pytest.raises(InputError, match=r"orders\[0\]: given 0"):
        critical_speeds([10.0], [0.0], (1.0, 2.0))
    with pytest.raises(InputError, match=r"frequencies\[0\]: given -1 Hz"):
        critical_speeds([-1.0], [1.0], (1.0, 2.0))


@pytest.mark.parametrize(
    ("firing_order", "strokes", "major"),
    [
        ((1, 3, 4, 2), 4, [2.0, 4.0, 6.0]),
        ((1, 5, 3, 6, 2, 4), 4, [3.0, 6.0]),
        ((1, 3, 2), 2, [3.0, 6.0]),
    ],
)
def test_major_orders_of_even_firing(firing_order, strokes, major):
    angles = even_firing_angles(firing_order, strokes)
    orders = engine_orders(strokes, 6.0)
    assert major_orders(orders, angles).tolist() == major
    sums = vector_sums(orders, angles)
    expected = np.where(np.isin(orders, major), float(len(firing_order)), 0.0)
    assert sums == close(expected, abs=1e-12)


def test_weights_bring_out_a_minor_order():
    angles = even_firing_angles((1, 3, 4, 2))
    # Order 0.5 fires at 0, 270, 90, 180 deg of phase: 1 - 0.5 and 0.8 + 0.2 at right angles.
    found = vector_sums([0.5], angles, [1.0, 0.8, -0.2, 0.5])
    assert found == close([math.hypot(0.5, 1.0)])


@given(
    st.lists(st.floats(0.0, 12.0), min_size=1, max_size=8),
    st.floats(-7.0, 7.0),
    st.sampled_from((0.5, 1.0, 3.0)),
)
def test_sum_does_not_depend_on_where_the_cycle_starts(angles, shift, order):
    moved = vector_sums([order], np.array(angles) + shift)
    assert moved == close(vector_sums([order], angles), abs=1e-12)


def test_unusable_vector_sums_are_refused():
    with pytest.raises(InputError, match="weights: given 1 values for 2 firing angles"):
        vector_sums([1.0], [0.0, 1.0], [1.0])
    with pytest.raises(InputError, match="firing_angles: given no values"):
        vector_sums([1.0], [])
