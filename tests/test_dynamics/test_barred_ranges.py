"""Ranges about resonances of known shape, 1 / |1 - (n / n_c)^2 + i / M n / n_c|."""

from dataclasses import replace

import numpy as np

from comparing import close
from dynamics.assessment.barred_ranges import BarredRangeRule, barred_ranges, exceeded_ranges
from dynamics.assessment.limits import (
    AmplitudeCurve,
    LimitCurve,
    VibrationLimit,
    constant_curve,
    given_limit,
)

LIMIT = given_limit(
    "torsional stress", 10.0, "Pa", applies_to="shaft", source="maker", passing=100.0
)
RULE = BarredRangeRule(100.0)


def resonance(speeds, critical, magnifier=40.0):
    ratio = speeds / critical
    return 1.0 / np.abs(1.0 - ratio**2 + 1j * ratio / magnifier)


def test_edges_lie_where_the_limit_is_met_and_never_too_narrow():
    speeds = np.linspace(20.0, 90.0, 701)
    curve = AmplitudeCurve("shaft", speeds, resonance(speeds, 50.0))
    (found,) = exceeded_ranges(LIMIT, curve)
    # Of r^4 - (2 - 1/M^2) r^2 + 1 - 1/10^2 = 0, the speeds at which the amplitude is 10.
    squares = np.sort(np.roots([1.0, -(2.0 - 1.0 / 40.0**2), 1.0 - 1e-2]))
    low, high = 50.0 * np.sqrt(squares)
    # Straight lines over steps of 0.1 stray by step^2/8 times curvature over slope, about 0.001.
    assert low - 2e-3 < found.low < low
    assert high < found.high < high + 2e-3
    assert found.peaks == close((50.0,))
    assert not found.cut_off


def test_ranges_are_widened_to_the_rule_and_merged_where_they_meet():
    speeds = np.linspace(5.0, 120.0, 2301)
    values = 0.7 * sum(resonance(speeds, critical) for critical in (40.0, 44.0, 65.0))
    first, second = barred_ranges(
        [(LIMIT, AmplitudeCurve("shaft", speeds, values))], RULE, (20.0, 100.0)
    )
    assert first.peaks == close((40.0, 44.0), abs=0.06)
    assert first.low == close(RULE.bounds(first.peaks[0])[0])
    assert first.high == close(RULE.bounds(first.peaks[1])[1])
    assert second.low > first.high
    assert first.allowed
    assert second.allowed
    assert second.limits == ("torsional stress of shaft",)


def test_a_range_begins_where_the_limit_falls():
    """A set's limit for passing ends at 30 rad/s; the amplitude is the same on both sides."""
    limit = VibrationLimit(
        "torsional stress",
        "shaft",
        "Pa",
        LimitCurve(lambda speeds: np.where(speeds > 30.0, 16.0, 90.0)),
        "rule",
    )
    curve = AmplitudeCurve("shaft", [20.0, 29.0, 31.5, 40.0], [50.0, 50.0, 50.0, 50.0])
    (found,) = exceeded_ranges(limit, curve)
    assert found.low == close(30.0, abs=1e-9)


def test_beside_an_unbounded_value_the_range_reaches_the_next_speed():
    curve = AmplitudeCurve("shaft", [10.0, 11.0, 12.0, 13.0], [1.0, np.inf, 1.0, 1.0])
    (found,) = exceeded_ranges(LIMIT, curve)
    assert (found.low, found.high) == (10.0, 12.0)
    (barred,) = barred_ranges([(LIMIT, curve)], RULE, (10.0, 13.0))
    assert "reaches no bounds" in barred.refusals[0]


def test_range_that_leaves_the_calculated_speeds_says_so():
    curve = AmplitudeCurve("shaft", [10.0, 11.0, 12.0], [20.0, 15.0, 5.0])
    (found,) = exceeded_ranges(LIMIT, curve)
    assert found.cut_off
    assert found.low == 10.0
    (barred,) = barred_ranges([(LIMIT, curve)], RULE, (10.0, 12.0))
    assert "the range reaches the end of the speeds calculated" in barred.remarks


def test_nothing_is_barred_above_the_share_of_the_rated_speed_or_the_limit_for_passing():
    speeds = np.linspace(20.0, 110.0, 1801)
    (high,) = barred_ranges(
        [(LIMIT, AmplitudeCurve("shaft", speeds, resonance(speeds, 78.0)))], RULE, (20.0, 100.0)
    )
    assert "nothing may be barred above 0.80" in high.refusals[0]
    (strong,) = barred_ranges(
        [(LIMIT, AmplitudeCurve("shaft", speeds, 3.0 * resonance(speeds, 50.0)))],
        RULE,
        (20.0, 100.0),
    )
    assert "0.00012 MPa at 477.5 1/min, where 0.0001 MPa may be passed" in strong.refusals[0]


def test_of_locations_that_exceed_the_limit_for_passing_one_is_named_and_the_others_are_counted():
    speeds = np.linspace(20.0, 110.0, 1801)
    sizes = {"a": 3.0, "b": 4.0, "c": 3.5, "kept": 0.5}
    curves = [
        AmplitudeCurve(name, speeds, size * resonance(speeds, 50.0)) for name, size in sizes.items()
    ]
    (found,) = barred_ranges([(LIMIT, one) for one in curves], RULE, (20.0, 100.0))
    (said,) = found.refusals
    assert said.startswith("b reaches ")
    assert said.endswith("may be passed; 2 more locations exceed what may be passed")


def test_a_limit_that_begins_on_a_falling_flank_has_no_critical_speed_there():
    # Such as a set's, whose continuous limit begins at 0.9 of the rated speed, above the peak at 50 rad/s.
    limit = replace(LIMIT, continuous=constant_curve(10.0, low=52.0))
    speeds = np.linspace(20.0, 110.0, 1801)
    curve = AmplitudeCurve("shaft", speeds, 4.0 * resonance(speeds, 50.0))
    (found,) = exceeded_ranges(limit, curve)
    assert found.low == close(52.0, abs=0.06)
    assert found.peaks == ()
    (barred,) = barred_ranges([(limit, curve)], RULE, (20.0, 100.0))
    assert barred.low == found.low
    assert "16 n" not in barred.ends


def test_what_exceeds_a_limit_above_the_running_range_is_not_called_barred():
    rule_end = VibrationLimit(
        quantity="torsional stress",
        applies_to="crankshaft",
        unit="Pa",
        continuous=constant_curve(100.0, high=115.0),
        source="rule",
    )
    speeds = np.linspace(20.0, 120.0, 2001)
    used = 1.2 * 100.0 / np.max(resonance(speeds, 110.0))
    curve = AmplitudeCurve("shaft", speeds, used * resonance(speeds, 110.0))
    (above,) = barred_ranges([(rule_end, curve)], RULE, (20.0, 100.0))
    assert above.position == "above"
    assert not above.allowed
    assert "barred" not in above.sentence
    assert "120 % of its limit, which applies up to 1098 1/min" in above.sentence
    # Where running speeds reach into it, it can be barred or not.
    (across,) = barred_ranges([(rule_end, curve)], RULE, (20.0, 110.0))
    assert across.position == "running"
    assert "cannot be barred" in across.sentence
    (below,) = barred_ranges([(rule_end, curve)], RULE, (114.0, 119.0))
    assert below.position == "below"
    assert "passed on every start" in below.sentence


def test_a_range_that_leaves_no_speed_to_run_at_is_refused():
    speeds = np.linspace(20.0, 110.0, 1801)
    curve = AmplitudeCurve("shaft", speeds, resonance(speeds, 50.0))
    (most,) = barred_ranges([(LIMIT, curve)], RULE, (48.0, 51.0))
    assert most.refusals == ("it leaves no speed to run at",)
    (part,) = barred_ranges([(LIMIT, curve)], RULE, (48.0, 60.0))
    assert part.allowed


def test_a_flank_at_the_highest_speed_belongs_to_the_peak_beyond():
    speeds = np.linspace(20.0, 110.0, 1801)
    curve = AmplitudeCurve("shaft", speeds, resonance(speeds, 50.0))
    (found,) = exceeded_ranges(LIMIT, curve, 49.0)
    assert found.high == 49.0
    assert found.peaks == close((50.0,))
    assert not found.cut_off
    # What is used beyond, or that speeds end there, does not count.
    assert found.used == close(resonance(49.0, 50.0) / 10.0)
    until = speeds <= 50.0
    (ending,) = exceeded_ranges(
        LIMIT, AmplitudeCurve("shaft", speeds[until], curve.values[until]), 49.0
    )
    assert not ending.cut_off
    (barred,) = barred_ranges([(LIMIT, curve)], RULE, (20.0, 49.0))
    assert (barred.low, barred.high) == close(RULE.bounds(50.0))
    # On the falling side the peak lies within.
    (found,) = exceeded_ranges(LIMIT, curve, 51.0)
    assert (found.high, *found.peaks) == close((51.0, 50.0))
    assert exceeded_ranges(LIMIT, curve, 45.0) == ()


def test_the_lower_of_the_shares_of_limit_and_rule_counts():
    rule_end = VibrationLimit(
        quantity="torsional stress",
        applies_to="crankshaft",
        unit="Pa",
        continuous=LIMIT.continuous,
        passing=constant_curve(100.0, high=90.0),
        source="rule",
    )
    assert RULE.highest_by(LIMIT) == 80.0
    assert RULE.highest_by(rule_end) == 90.0
    assert BarredRangeRule(100.0, 0.7).highest_by(rule_end) == 70.0
    assert BarredRangeRule(100.0, 1.0).highest_by(rule_end) == 90.0
    speeds = np.linspace(20.0, 110.0, 1801)
    curve = AmplitudeCurve("shaft", speeds, resonance(speeds, 78.0))
    (allowed,) = barred_ranges([(rule_end, curve)], RULE, (20.0, 100.0))
    assert allowed.allowed
    (refused,) = barred_ranges([(rule_end, curve)], BarredRangeRule(100.0, 0.7), (20.0, 100.0))
    assert "nothing may be barred above 0.70" in refused.refusals[0]


def test_neither_an_end_of_the_speeds_nor_a_bend_of_the_limit_is_a_peak():
    speeds = np.linspace(55.0, 75.0, 401)
    curve = AmplitudeCurve("shaft", speeds, 4.0 * resonance(speeds, 50.0))
    (found,) = exceeded_ranges(LIMIT, curve)
    assert (found.low, found.peaks) == (55.0, ())
    assert "peak" not in barred_ranges([(LIMIT, curve)], RULE, (20.0, 100.0))[0].ends
    # The vibration rises all along, its use of the limit is largest where the limit bends.
    bent = LimitCurve(lambda speed: np.interp(speed, [40.0, 60.0, 80.0], [20.0, 10.0, 60.0]))
    limit = replace(LIMIT, continuous=bent)
    rising = AmplitudeCurve("shaft", speeds, 0.25 * speeds)
    (found,) = exceeded_ranges(limit, rising)
    assert found.low < 60.0 < found.high
    assert found.peaks == ()
