"""Hodographs from the definition of the vector itself.

Tolerances: a few operations on numbers of order one leave 1e-14 of the largest value.
"""

import cmath
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from dynamics.balance.moving_masses import FOLD, Hodograph, hodograph_sum, order_vectors

parts = st.builds(cmath.rect, st.floats(0.1, 10.0), st.floats(-math.pi, math.pi, exclude_min=True))
hodographs = st.builds(Hodograph, st.integers(1, 6), parts, parts)


@given(hodographs)
@settings(max_examples=30)
def test_axes_bound_the_vector_and_are_reached(shape):
    around = np.abs(shape.at(shaft_angle_deg=np.linspace(0.0, 360.0, 100)))
    assert np.all(around <= shape.major * (1 + 1e-14))
    assert np.all(around >= shape.minor - 1e-14 * shape.major)
    if shape.angle_deg is None:
        assert shape.minor == close(shape.major, rel=2e-12)
        return
    # A nearly round ellipse shows the direction of its axis only to round-off over its flatness.
    blur = 1e-14 * shape.major / (shape.major - shape.minor)
    assert 0.0 <= math.radians(shape.largest_at_deg) < math.pi / shape.order + blur
    assert -90.0 < shape.angle_deg <= 90.0
    at_largest = complex(shape.at(shaft_angle_deg=shape.largest_at_deg))
    assert abs(at_largest) == close(shape.major, rel=1e-14)
    across = (at_largest * cmath.exp(-1j * math.radians(shape.angle_deg))).imag
    # An axis within FOLD of the horizontal is told as horizontal.
    assert abs(across) <= (1e-14 + 10 * blur + FOLD) * shape.major
    at_least = complex(shape.at(shaft_angle_deg=shape.largest_at_deg + 90.0 / shape.order))
    assert abs(at_least) == close(shape.minor, abs=(1e-14 + blur) * shape.major)


@given(hodographs, st.floats(-4.0, 4.0))
@settings(max_examples=20)
def test_amplitude_along_a_direction(shape, direction):
    turn = cmath.exp(-1j * direction)
    component = order_vectors(
        (shape.at(shaft_angle_deg=np.arange(20) * 18.0) * turn).real, [shape.order]
    )[0]
    assert shape.amplitude_along(angle_deg=np.degrees(direction)) == close(
        component.major, abs=1e-14 * shape.major
    )


def test_sense_and_points():
    forward, backward = Hodograph(1, 2.0, 1.0), Hodograph(2, 1.0, 2j)
    assert (forward.sense, backward.sense) == (1, -1)
    for shape in (forward, backward):
        x, y = shape.points(721)
        # Seen from the flywheel, x to the right, the shaft turns counterclockwise: positive area.
        area = 0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])
        # The polygon of 720 points has 1 - (2 pi / 720)^2 / 6 of the ellipse's area.
        assert area == close(shape.sense * math.pi * shape.major * shape.minor, rel=1.3e-5)
        assert np.max(np.abs(x)) <= shape.x * (1 + 1e-14)
        assert np.max(np.abs(y)) <= shape.y * (1 + 1e-14)


def test_shapes_without_two_axes():
    line = Hodograph(2, 100 * cmath.exp(-0.5j * math.pi), 100 * cmath.exp(-0.5j * math.pi))
    assert line.sense == 0
    assert line.angle_deg == 90.0  # a horizontal axis is written +90 deg
    assert (line.x, line.y) == (close(200.0), close(0.0, abs=1e-13))
    circle = Hodograph(1, 0.0, 3j)
    assert (circle.angle_deg, circle.largest_at_deg, circle.sense) == (None, None, -1)
    point = Hodograph(1, 0.0, 0.0)
    assert (point.angle_deg, point.largest_at_deg, point.sense, point.major) == (None, None, 0, 0.0)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ((0, 1.0, 1.0), "orders: given \\[0\\]; allowed are different whole numbers of 1 or more"),
        ((1.5, 1.0, 1.0), "orders: given \\[1.5\\]"),
        ((-1, 1.0, 1.0), "orders: given \\[-1\\]"),
        ((1, math.nan, 1.0), "forward: given nan; allowed are finite numbers"),
        ((1, 1.0, complex(0.0, math.inf)), "backward: given infj"),
    ],
)
def test_hodographs_refused(given, message):
    with pytest.raises(InputError, match=message):
        Hodograph(*given)


def test_sum_and_turning():
    one, other = Hodograph(2, 1 + 2j, 3.0), Hodograph(2, 1j, 4j)
    angles = np.array([0.0, 0.4, 2.0])
    np.testing.assert_allclose(
        hodograph_sum(2, [one, other.times(2j)]).at(shaft_angle_deg=np.degrees(angles)),
        one.at(shaft_angle_deg=np.degrees(angles))
        + 2j * other.at(shaft_angle_deg=np.degrees(angles)),
        rtol=1e-14,
    )


def test_orders_of_samples():
    angles = 2.0 * np.pi * np.arange(16) / 16
    shapes = [Hodograph(k, complex(k, 1.0), complex(-1.0, k)) for k in (1, 3, 7)]
    vectors = 5.0 + sum(shape.at(shaft_angle_deg=np.degrees(angles)) for shape in shapes)
    for found, shape in zip(order_vectors(vectors, [1, 3, 7]), shapes, strict=True):
        assert found.forward == close(shape.forward, rel=1e-14)
        assert found.backward == close(shape.backward, rel=1e-14)


@pytest.mark.parametrize(
    ("vectors", "orders", "message"),
    [
        ([1.0, 2.0, 3.0, 4.0], [2], "less than half the number of samples"),
        ([1.0, math.nan, 3.0, 4.0], [1], "1 values not finite"),
        ([[1.0, 2.0]], [1], r"shape \(1, 2\)"),
        ([1.0, 2.0, 3.0, 4.0], [0.5], "whole numbers of 1 or more"),
        ([1.0, 2.0, 3.0, 4.0], [], "whole numbers of 1 or more"),
        ([1.0, 2.0, 3.0, 4.0], [1, 1], "different whole numbers"),
    ],
)
def test_what_is_refused(vectors, orders, message):
    with pytest.raises(InputError, match=message):
        order_vectors(vectors, orders)
