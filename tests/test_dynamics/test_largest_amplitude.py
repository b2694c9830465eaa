"""The largest amplitude among many, limits while misfiring, and running speeds before others."""

from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from dynamics.assessment.barred_ranges import BarredRangeRule
from dynamics.assessment.limit_rules import crankshaft_limit
from dynamics.assessment.limits import AmplitudeCurve, given_limit, worst_use
from dynamics.assessment.response_curves import largest_amplitude, speeds_above
from dynamics.assessment.verdict import judge
from dynamics.plots.quantities import quantity_display
from dynamics.response.series import OrderSeries

SPEEDS = np.linspace(40.0, 80.0, 150)


@pytest.fixture
def series():
    rng = np.random.default_rng(7)
    shape = (6, SPEEDS.size, 4)
    values = rng.normal(size=shape) + 1j * rng.normal(size=shape)
    return OrderSeries(
        0.5 * np.arange(1.0, 7.0), SPEEDS, values, np.zeros(shape[:2], bool), ("a", "b", "c", "d")
    )


def test_the_largest_is_that_of_all_sums(series):
    weights = np.where(SPEEDS < 60.0, 1.0 / SPEEDS, 0.0)
    every = weights[:, np.newaxis] * series.synthesis.amplitude
    amplitude, speed, place = largest_amplitude(series, weights)
    assert (speed, place) == np.unravel_index(np.argmax(every), every.shape)
    assert amplitude == close(series.synthesis.amplitude[speed, place])


def test_unbounded_vibration_is_the_largest_where_it_counts(series):
    series.unbounded[2, [10, 140]] = True
    weights = np.where(SPEEDS > 60.0, 1.0, 0.0)
    assert largest_amplitude(series, weights)[:2] == (np.inf, 140)


def test_speeds_above_are_those_of_all_sums(series):
    level = float(np.median(series.synthesis.amplitude.max(axis=1)))
    weights = np.full(SPEEDS.shape, 1.0 / level)
    none = np.zeros(SPEEDS.shape, bool)
    expected = np.max(series.synthesis.amplitude, axis=1) > level
    assert 0 < np.count_nonzero(expected) < SPEEDS.size
    assert np.array_equal(speeds_above(series, weights, none), expected)
    known = none.copy()
    known[:3] = True
    assert np.array_equal(speeds_above(series, weights, known), expected | known)


def test_a_limit_while_misfiring_is_that_for_passing_only_where_something_says_so():
    limit = crankshaft_limit(100.0, strokes=4)
    assert limit.misfiring is limit.continuous
    limit = replace(limit, misfiring_basis="the class")
    speeds = np.array([50.0, 80.0, 80.001, 100.0, 110.0, 116.0])
    ratio = speeds[:4] / 100.0
    plain = 1e6 * (45.0 - 24.0 * ratio**2)
    found = limit.misfiring.at(speeds)
    assert found[:4] == close(plain * [2.0, 2.0, 1.0, 1.0])
    assert found[4] == limit.continuous.at(speeds[4:5])[0]
    assert np.isinf(found[5])
    maker = given_limit("torque", 5.0, "N m", applies_to="coupling", source="maker")
    maker = replace(maker, misfiring_basis="the class")
    assert maker.misfiring is maker.continuous


def test_checks_speak_of_running_speeds_first():
    # The largest use lies above the running range, where the rule goes on to 115 rad/s.
    speeds = np.linspace(20.0, 115.0, 96)
    values = np.where(speeds > 100.0, 60e6, np.where(speeds < 40.0, 80e6, 10e6))
    limit = crankshaft_limit(100.0, strokes=4)
    verdict = judge(
        [(limit, AmplitudeCurve("shaft", speeds, values))], (40.0, 100.0), BarredRangeRule(100.0)
    )
    (check,) = verdict.checks
    speed, value, permitted = check.running
    assert (speed, value) == (100.0, 10e6)
    assert permitted == close(21e6)
    assert check.above[1] == 60e6
    assert check.above[0] > 100.0
    # What decides the status stays the worst of all that is judged.
    assert check.worst_value == 60e6
    assert "at most 10 MPa at 954.9 1/min, 47.6 % of the permitted 21 MPa at running speeds" in (
        check.sentence
    )
    assert "; above them 60 MPa at" in check.sentence
    assert worst_use(limit, check.curve, 0.0, 39.9)[1] == 80e6


def test_diagrams_take_their_height_and_orders_from_running_speeds(series):
    values = series.values.copy()
    values[5, :30] = 1000.0
    values[4, :30] = values[4, 120:] = 500.0
    loud = OrderSeries(series.orders, series.speeds, values, series.unbounded, series.names)
    running = (float(SPEEDS[30]), float(SPEEDS[119]))
    curves = loud.over_speed(0, quantity_display(None, "SI"), running=running, main_orders=1)
    plain = loud.synthesis.plain_sum[30:120, 0]
    assert curves.top == close(1.08 * plain.max())
    assert [band.name for band in curves.bands] == 2 * ["outside the running range"]
    assert curves.bands[0].high == close(running[0] * 30.0 / np.pi)
    (main,) = (one.name for one in curves.series if one.role == "order" and one.main)
    sizes = np.abs(values[:, 30:120, 0]).max(axis=1)
    assert main == f"order {series.orders[np.argmax(sizes)]:g}"
