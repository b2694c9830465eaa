"""Major critical speeds near the rated speed: their orders, and the speeds to be kept clear of them."""

import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.assessment.separation import major_criticals
from dynamics.critical import critical_speeds


@pytest.mark.parametrize(
    ("strokes", "drives", "orders", "clear"),
    [
        (4, "propeller", (3.0, 6.0), (80.0, 110.0)),
        (4, "generator", (3.0, 6.0), (90.0, 110.0)),
        (2, "propeller", (6.0,), (80.0, 110.0)),
    ],
)
def test_orders_and_speeds_of_six_in_line(strokes, drives, orders, clear):
    own = major_criticals((), 100.0, cylinders=6, strokes=strokes, drives=drives)
    assert (own.orders, own.clear) == (orders, close(clear))
    assert own.passed


@pytest.mark.parametrize(
    ("speed", "there"), [(89.9, False), (90.0, True), (110.0, True), (110.1, False)]
)
def test_only_major_orders_within_the_speeds_count(speed, there):
    """Order 3 meets the mode at the speed asked for; orders 2.5 and 3.5 beside it are minor."""
    frequency = 3.0 * speed / 6.283185307179586
    met = critical_speeds([frequency], [2.5, 3.0, 3.5], (1.0, 1000.0))
    own = major_criticals(met, 100.0, cylinders=6, strokes=4, drives="generator")
    assert [one.order for one in own.found] == ([3.0] if there else [])
    assert own.passed is not there


def test_the_rated_speed_is_above_zero():
    with pytest.raises(InputError, match="rated_speed: given 0"):
        major_criticals((), 0.0, cylinders=6, strokes=4)
