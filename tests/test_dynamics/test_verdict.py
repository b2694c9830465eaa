"""Limits, barred ranges and the verdict."""

import pickle
import re
from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from crankbase.sentences import written
from dynamics.assessment.barred_ranges import BarredRangeRule, barred_ranges, exceeded_ranges
from dynamics.assessment.limit_rules import (
    CRANKSHAFT_RULES,
    crankshaft_limit,
    crankshaft_material_factors,
    generator_set_limit,
    propulsion_shaft_limit,
)
from dynamics.assessment.limits import (
    AmplitudeCurve,
    LimitCurve,
    VibrationLimit,
    axial_force_limit,
    constant_curve,
    given_limit,
    usage,
)
from dynamics.assessment.response_curves import curves_of, refined_maxima
from dynamics.assessment.verdict import Trial, changes, decide, judge
from dynamics.chains.chain import Chain
from dynamics.response.forced import forced_response
from dynamics.response.linear_system import damped
from dynamics.response.loads import alternating_stress, element_loads
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.resonance import refined_speeds
from dynamics.wording import at_speed
from refusals import refusals, refusals_of

SPEEDS = np.linspace(10.0, 115.0, 2101)
RUNNING = (30.0, 100.0)
RULE = BarredRangeRule(100.0)
CRANKSHAFT = crankshaft_limit(100.0, strokes=4)
TORQUE = given_limit("torque", 2e3, "N m", applies_to="coupling", source="maker's sheet 7")


def peak(at, height, width=1.0):
    return AmplitudeCurve("shaft 6 - 7", SPEEDS, height / (1.0 + ((SPEEDS - at) / width) ** 2))


def test_fine_tells_the_worst_of_all_with_its_numbers_and_source():
    verdict = judge([(CRANKSHAFT, peak(50.0, 30e6)), (TORQUE, peak(60.0, 1.9e3))], RUNNING, RULE)
    assert verdict.status == "fine"
    assert verdict.checks[0].limit is TORQUE
    assert verdict.checks[0].margin == close(0.05)
    figures = ("286.5 to 954.9", "1900 N m", "573 1/min", "95 %", "2000 N m", "sheet 7")
    assert all(figure in verdict.sentence for figure in figures)


@pytest.mark.parametrize(
    ("curve", "figure"),
    [(peak(50.0, 80e6), "78 MPa"), (peak(90.0, 30e6), "0.80"), (peak(50.0, np.inf), "unbounded")],
)
def test_not_acceptable(curve, figure):
    verdict = judge([(CRANKSHAFT, curve)], RUNNING, RULE)
    assert verdict.status == "not acceptable"
    assert figure in verdict.sentence


def test_unbounded_without_a_limit_for_passing_is_not_acceptable():
    values = np.where(np.arange(SPEEDS.size) == 800, np.inf, 1.0)
    verdict = judge([(TORQUE, AmplitudeCurve("coupling", SPEEDS, values))], RUNNING, RULE)
    assert verdict.status == "not acceptable"


def test_limit_without_one_for_passing_leaves_a_remark():
    verdict = judge([(TORQUE, peak(50.0, 3e3))], RUNNING, RULE)
    assert (verdict.status, len(verdict.remarks)) == ("barred range needed", 1)


def test_below_the_lowest_running_speed_it_is_only_started_through():
    verdict = judge([(CRANKSHAFT, peak(20.0, 70e6))], RUNNING, RULE)
    assert verdict.status == "fine"
    assert len(verdict.started_through) == 1
    assert judge([(CRANKSHAFT, peak(20.0, 100e6))], RUNNING, RULE).status == "not acceptable"


def test_a_range_below_the_lowest_speed_is_not_judged_at_full_load():
    verdict = judge([(CRANKSHAFT, peak(20.0, 100e6))], RUNNING, RULE, full_load=True)
    assert verdict.status == "fine"
    (below,) = verdict.started_through
    assert below.refusals == ()
    assert "full load" in below.sentence
    # What reaches into the running range is judged.
    (into,) = judge([(CRANKSHAFT, peak(30.0, 200e6))], RUNNING, RULE, full_load=True).barred
    assert not into.allowed


def test_the_strongest_reason_against_barring_is_one_of_running_speeds():
    """More is exceeded below the lowest running speed, in the same range."""
    (barred,) = judge([(CRANKSHAFT, peak(29.0, 200e6))], RUNNING, RULE).barred
    assert barred.low == RUNNING[0] < barred.high
    (reason,) = barred.refusals
    assert float(re.search(r"at ([\d.]+) 1/min", reason)[1]) >= 0.999 * RUNNING[0] * 30.0 / np.pi
    # At the rated speed it matters that it is the rated speed, not how far the range goes on above.
    wide = AmplitudeCurve("shaft", SPEEDS, np.where(SPEEDS > 95.0, 80e6, 1e6))
    (at_rated,) = judge([(CRANKSHAFT, wide)], RUNNING, RULE).barred
    assert at_rated.high > RUNNING[1]
    assert at_rated.refusals[0].startswith("it holds the rated speed")


def test_the_worst_is_the_worst_at_running_speeds_with_its_own_place_and_speed():
    """One place is worse above the running range, another one within."""

    def curve(name, running, above):
        values = np.where(RUNNING[1] < SPEEDS, above, np.where(SPEEDS > 90.0, running, 1e6))
        return AmplitudeCurve(name, SPEEDS, values)

    findings = [(CRANKSHAFT, curve("a", 60e6, 90e6)), (CRANKSHAFT, curve("b", 65e6, 80e6))]
    verdict = judge(findings, RUNNING, RULE)
    worst = verdict.deciding
    assert (worst.curve.name, worst.worst_value) == ("b", 65e6)
    assert RUNNING[0] <= worst.worst_speed <= RUNNING[1]
    assert worst.permitted == CRANKSHAFT.continuous.at(np.array([worst.worst_speed]))[0]
    assert verdict.checks[0].curve.name == "a"
    assert all(use in verdict.sentence for use in (f"b: {worst.use}", verdict.checks[0].use))
    # Where nothing is exceeded at running speeds, what is above them decides.
    findings = [(CRANKSHAFT, curve("a", 6e6, 90e6)), (CRANKSHAFT, curve("b", 7e6, 1e6))]
    kept = judge(findings, RUNNING, RULE)
    assert kept.deciding.curve is kept.checks[0].curve
    assert kept.deciding.worst_speed == kept.checks[0].worst_speed
    assert kept.deciding.curve.name == "a"
    assert kept.checks[0].use in kept.sentence


def other(name, at, height):
    return replace(peak(at, height), name=name)


PASSED = given_limit("torque", 2e3, "N m", applies_to="coupling", source="maker", passing=4e3)


@pytest.mark.parametrize("at", [20.0, 29.5])
def test_where_what_is_passed_on_starting_refuses_that_decides(at):
    """At running speeds all is kept; the range that cannot be passed is below, or reaches into them."""
    # The rule's range about a peak of a hundredth's width is wide enough to reach running speeds from 29.5.
    curves = [(PASSED, other("coupling", at, 5e3)), (CRANKSHAFT, other("shaft", 60.0, 25e6))]
    curves[0] = (
        PASSED,
        AmplitudeCurve("coupling", SPEEDS, 5e3 * np.exp(-(((SPEEDS - at) / 0.1) ** 2))),
    )
    verdict = judge(curves, RUNNING, RULE)
    assert verdict.status == "not acceptable"
    assert all(check.passed for check in verdict.checks)
    check = verdict.deciding
    assert (check.limit, check.curve.name, check.passing) == (PASSED, "coupling", True)
    assert (check.worst_speed, check.permitted) == (close(at), 4e3)
    # By its own numbers: what is reached there, of what may be passed.
    assert check.worst_value == check.curve.values[np.argmin(np.abs(SPEEDS - at))]
    assert check.used == check.worst_value / 4e3 > 1.0
    assert not verdict.deciding_first[0].allowed


def test_of_two_ranges_the_one_that_cannot_be_barred_decides():
    """More of its limit is used where barring helps than where it does not."""
    curves = [(PASSED, other("coupling", 50.0, 3.9e3)), (CRANKSHAFT, other("shaft", 90.0, 35e6))]
    verdict = judge(curves, RUNNING, RULE)
    assert verdict.checks[0].curve.name == "coupling"
    check = verdict.deciding
    assert (check.curve.name, check.passing) == ("shaft", False)
    assert check.worst_speed == close(90.0, rel=0.01)
    assert (
        check.used
        == check.worst_value / CRANKSHAFT.continuous.at(check.worst_speed * np.ones(1))[0]
    )
    assert verdict.deciding_first[0].limits == (CRANKSHAFT.name,)


def test_what_makes_a_barred_range_decides_though_its_peak_is_below_the_running_range():
    curves = [(PASSED, other("coupling", 29.0, 3.9e3)), (CRANKSHAFT, other("shaft", 60.0, 25e6))]
    verdict = judge(curves, RUNNING, RULE)
    assert verdict.status == "barred range needed"
    assert len(verdict.barred) == 1
    check = verdict.deciding
    assert (check.curve.name, check.passing) == ("coupling", False)
    assert check.used > 1.0


@pytest.mark.parametrize(("at", "told"), [(55.0, True), (57.0, False)])
def test_a_strip_between_two_barred_ranges_is_told_where_nothing_can_run_in_it(at, told):
    curves = [(CRANKSHAFT, other("shaft", top, 50e6)) for top in (45.0, at)]
    verdict = judge(curves, RUNNING, RULE)
    (_, low), (high, _) = verdict.ranges_to_bar
    assert (high < 1.05 * low) == told
    assert len(verdict.remarks) == told


def test_below_the_running_range_nothing_is_barred_but_passed():
    """0.8 of the rated speed ends what may be barred; a set passes resonances above it on starting."""
    curve = AmplitudeCurve("coupling", SPEEDS, 3e3 * np.exp(-(((SPEEDS - 81.0) / 0.2) ** 2)))
    assert judge([(PASSED, curve)], (93.0, 100.0), RULE).status == "fine"
    until = replace(PASSED, passing=constant_curve(4e3, 0.0, 80.0))
    verdict = judge([(until, curve)], (93.0, 100.0), RULE)
    assert verdict.status == "not acceptable"
    assert verdict.deciding.used > 1.0


def test_a_range_that_reaches_into_the_running_range_is_barred():
    verdict = judge([(CRANKSHAFT, peak(30.0, 70e6))], RUNNING, RULE)
    assert verdict.status == "barred range needed"
    assert verdict.started_through == ()
    (barred,) = verdict.barred
    # Nothing is barred below the running range; there it is passed on every start.
    assert barred.low == RUNNING[0] < barred.high
    assert written(at_speed(RULE.bounds(30.0)[0])) in barred.ends


def test_rule_is_held_above_the_running_range_as_far_as_it_goes():
    assert judge([(CRANKSHAFT, peak(104.0, 60e6))], RUNNING, RULE).status == "not acceptable"
    assert judge([(TORQUE, peak(110.0, 9e3))], RUNNING, RULE).status == "fine"
    short = AmplitudeCurve(
        "shaft", SPEEDS[SPEEDS < 101.0], np.ones(np.count_nonzero(SPEEDS < 101.0))
    )
    assert len(judge([(CRANKSHAFT, short)], RUNNING, RULE).remarks) == 1


def test_a_limit_that_ends_within_the_running_range_is_told_once_with_its_end():
    speeds = np.linspace(10.0, 120.0, 221)
    findings = [
        (CRANKSHAFT, AmplitudeCurve(name, speeds, 1e6 * speeds)) for name in ("one", "other")
    ]
    verdict = judge(findings, (RUNNING[0], 118.0), RULE)
    assert len(verdict.remarks) == 1
    assert [check.judged[1] for check in verdict.checks] == close([115.0, 115.0])


test_what_cannot_be_judged_is_refused = refusals_of(
    lambda findings, running: judge(findings, running, RULE),
    ([], RUNNING, "findings"),
    ([(TORQUE, peak(50.0, 1.0))], (100.0, 30.0), "running_range"),
    ([(TORQUE, peak(50.0, 1.0))], (5.0, 100.0), "speeds of shaft 6 - 7"),
    (
        [(crankshaft_limit(10.0, strokes=4), peak(50.0, 1.0))],
        RUNNING,
        "limit on torsional stress of crankshaft",
    ),
)


def test_speeds_that_end_where_the_engine_does_cover_its_range():
    """Both were meant to be the same numbers; one of them was rounded the other way."""
    running = (np.nextafter(SPEEDS[0], 0.0), np.nextafter(SPEEDS[-1], 999.0))
    verdict = judge([(TORQUE, peak(50.0, 1.0))], running, RULE)
    assert verdict.status == "fine"
    assert verdict.remarks == ()
    # At the last speed calculated and judged the vibration is largest, and it counts.
    rising = AmplitudeCurve("coupling", SPEEDS, np.append(np.ones(SPEEDS.size - 1), 3e3))
    within = judge([(TORQUE, rising)], (SPEEDS[0], np.nextafter(SPEEDS[-1], 0.0)), RULE)
    assert within.status == "not acceptable"
    assert within.checks[0].worst_value == 3e3


def test_a_limit_that_ends_at_the_highest_speed_judges_all_of_the_range():
    limit = replace(TORQUE, continuous=constant_curve(2e3, 0.0, np.nextafter(RUNNING[1], 0.0)))
    assert judge([(limit, peak(50.0, 1.0))], RUNNING, RULE).remarks == ()


def test_a_range_barred_up_to_the_lowest_running_speed_touches_it():
    low = RULE.bounds(50.0)[1]
    for end in (low, np.nextafter(low, 0.0), np.nextafter(low, 999.0)):
        verdict = judge([(CRANKSHAFT, peak(50.0, 60e6))], (end, 100.0), RULE)
        assert verdict.status == "barred range needed"


@pytest.mark.parametrize("per_minute", [450.0, 1000.0, 1500.0, 2300.0, 3001.0])
@pytest.mark.parametrize(
    ("ratio", "pick"),
    [
        (1.15, lambda n: crankshaft_limit(n, strokes=4).continuous),
        (0.8, lambda n: crankshaft_limit(n, strokes=4).passing),
        (1.05, lambda n: propulsion_shaft_limit(5e8, 0.3, n).continuous),
        (0.8, lambda n: propulsion_shaft_limit(5e8, 0.3, n).passing),
        (1.1, lambda n: generator_set_limit(n, part="crankshaft").continuous),
        (0.9, lambda n: generator_set_limit(n, part="crankshaft").passing),
    ],
)
def test_a_limit_holds_at_its_end_however_that_is_calculated(per_minute, ratio, pick):
    rated = per_minute * np.pi / 30.0
    ends = np.array(
        [ratio * rated, ratio * per_minute * np.pi / 30.0, per_minute * ratio / (30.0 / np.pi)]
    )
    curve = pick(rated)
    assert np.isfinite(curve.at(ends)).all()
    assert np.isfinite(curve.at(np.nextafter(ends, np.inf))).all()
    assert np.isinf(curve.at(ends * (1.0 + 1e-9))).all()
    sent = pickle.loads(pickle.dumps(curve))  # as to another process
    assert np.array_equal(sent.at(ends), curve.at(ends))


test_impossible_curves_are_refused = refusals_of(
    lambda speeds, values: AmplitudeCurve("shaft", speeds, values),
    ([2.0, 1.0], [1.0, 1.0], "speeds of shaft"),
    ([1.0, 2.0], [1.0], "values of shaft"),
    ([1.0, 2.0], [1.0, np.nan], "values of shaft"),
    ([1.0, 2.0], [1.0, -1.0], "values of shaft"),
)


def test_a_yield_strength_is_named_where_nothing_may_be_passed():
    plain, strong = (crankshaft_limit(10.0, strokes=2, yield_strength=y) for y in (225e6, 295e6))
    assert (plain.remark, "1.31" in strong.remark) == ("", True)


def test_strong_steel_enters_the_shaft_rule_up_to_its_cap_and_the_limit_says_so():
    carbon = propulsion_shaft_limit(650e6, 0.3, 10.0)
    capped = propulsion_shaft_limit(600e6, 0.3, 10.0)
    speed = np.array([5.0])
    assert carbon.continuous.at(speed) == capped.continuous.at(speed)
    keyed = propulsion_shaft_limit(600e6, 0.3, 10.0, feature="tapered keyway")
    assert [bool(limit.remark) for limit in (carbon, capped, keyed)] == [True, False, True]
    alloy = propulsion_shaft_limit(650e6, 0.3, 10.0, alloy=True)
    assert alloy.continuous.at(speed) == close(capped.continuous.at(speed) * 810 / 760)
    tail = propulsion_shaft_limit(650e6, 0.3, 10.0, alloy=True, feature="propeller shaft")
    assert tail.continuous.at(speed) == close(capped.continuous.at(speed) * 0.55)


@pytest.mark.parametrize(("alloy", "most"), [(False, 590e6), (True, 835e6)])
def test_a_steel_beyond_the_end_of_the_formula_counts_as_one_at_its_end(alloy, most):
    # By the rule 1 + 2/3 (T / 440 - 1) and Y / 225, and weak steel does not lower a limit.
    assert crankshaft_material_factors(550e6, 450e6, alloy=alloy) == close((7.0 / 6.0, 2.0))
    assert crankshaft_material_factors(400e6, 200e6, alloy=alloy) == (1.0, 1.0)
    speeds = np.linspace(20.0, 100.0, 5)
    for rule in CRANKSHAFT_RULES.values():
        strong, at_end = (
            rule(100.0, strokes=4, tensile_strength=one, alloy=alloy) for one in (900e6, most)
        )
        assert np.array_equal(strong.continuous.values(speeds), at_end.continuous.values(speeds))
        assert ("900 MPa" in strong.remark, "MPa" in at_end.remark) == (True, False)


@pytest.mark.parametrize(
    ("interval", "stress"), [(45.0, 21e6), (60.0, 21e6), (90.0, 16e6), (None, 16e6)]
)
def test_v_engines_have_the_limits_of_engines_in_line_at_two_intervals(interval, stress):
    limit = crankshaft_limit(100.0, strokes=4, kind="V", firing_interval_deg=interval)
    assert limit.continuous.at(np.array([100.0])) == close([stress])


def test_the_limit_of_generator_sets_ends_at_a_tenth_above_the_rated_speed():
    limit = generator_set_limit(100.0, part="crankshaft")
    assert limit.continuous.at(np.array([109.9, 110.1])).tolist() == [21e6, np.inf]


def test_axial_force_limit_makes_the_nominal_web_stress_the_permitted_one():
    """The stress of a bar of the web's section under the force at the lever of the crank radius."""
    limit = axial_force_limit(30e6, 0.17, 0.285, 0.068, source="maker's fatigue strength")
    force = float(limit.continuous.at(np.array([1.0]))[0])
    second_moment = 0.285 * 0.068**3 / 12.0
    stress = force * 0.17 * (0.068 / 2.0) / second_moment + force / (0.285 * 0.068)
    assert stress == close(30e6, rel=1e-12)  # round-off
    assert limit.assumed
    assert "maker's fatigue strength" in limit.source


LIMIT = given_limit(
    "torsional stress", 10.0, "Pa", applies_to="shaft", source="maker", passing=100.0
)


def resonance(speeds, critical, magnifier=40.0):
    ratio = speeds / critical
    return 1.0 / np.abs(1.0 - ratio**2 + 1j * ratio / magnifier)


def test_edges_lie_where_the_limit_is_met_and_never_too_narrow():
    speeds = np.linspace(20.0, 90.0, 701)
    (found,) = exceeded_ranges(LIMIT, AmplitudeCurve("shaft", speeds, resonance(speeds, 50.0)))
    # Of r^4 - (2 - 1/M^2) r^2 + 1 - 1/10^2 = 0, the speeds at which the amplitude is 10.
    low, high = 50.0 * np.sqrt(np.sort(np.roots([1.0, -(2.0 - 1.0 / 40.0**2), 1.0 - 1e-2])))
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


def test_nothing_is_barred_above_the_share_of_the_rated_speed_or_the_limit_for_passing():
    speeds = np.linspace(20.0, 110.0, 1801)
    (high,) = barred_ranges(
        [(LIMIT, AmplitudeCurve("shaft", speeds, resonance(speeds, 78.0)))], RULE, (20.0, 100.0)
    )
    assert not high.allowed
    (strong,) = barred_ranges(
        [(LIMIT, AmplitudeCurve("shaft", speeds, 3.0 * resonance(speeds, 50.0)))],
        RULE,
        (20.0, 100.0),
    )
    assert not strong.allowed


def test_of_locations_that_exceed_the_limit_for_passing_one_is_named_and_the_others_are_counted():
    speeds = np.linspace(20.0, 110.0, 1801)
    sizes = {"a": 3.0, "b": 4.0, "c": 3.5, "kept": 0.5}
    curves = [
        AmplitudeCurve(name, speeds, size * resonance(speeds, 50.0)) for name, size in sizes.items()
    ]
    (found,) = barred_ranges([(LIMIT, one) for one in curves], RULE, (20.0, 100.0))
    (said,) = found.refusals
    assert re.search(r"^b .*; 2 more", said)


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
    assert "120 %" in above.sentence
    # Where running speeds reach into it, it can be barred or not.
    (across,) = barred_ranges([(rule_end, curve)], RULE, (20.0, 110.0))
    assert across.position == "running"
    assert "barred" in across.sentence
    (below,) = barred_ranges([(rule_end, curve)], RULE, (114.0, 119.0))
    assert below.position == "below"
    assert "start" in below.sentence


def test_a_range_that_leaves_no_speed_to_run_at_is_refused():
    speeds = np.linspace(20.0, 110.0, 1801)
    curve = AmplitudeCurve("shaft", speeds, resonance(speeds, 50.0))
    (most,) = barred_ranges([(LIMIT, curve)], RULE, (48.0, 51.0))
    assert len(most.refusals) == 1
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
    short = AmplitudeCurve("shaft", speeds[until], curve.values[until])
    (ending,) = exceeded_ranges(LIMIT, short, 49.0)
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
    assert not refused.allowed


def test_neither_an_end_of_the_speeds_nor_a_bend_of_the_limit_is_a_peak():
    speeds = np.linspace(55.0, 75.0, 401)
    curve = AmplitudeCurve("shaft", speeds, 4.0 * resonance(speeds, 50.0))
    (found,) = exceeded_ranges(LIMIT, curve)
    assert (found.low, found.peaks) == (55.0, ())
    # The vibration rises all along, its use of the limit is largest where the limit bends.
    bent = LimitCurve(lambda speed: np.interp(speed, [40.0, 60.0, 80.0], [20.0, 10.0, 60.0]))
    limit = replace(LIMIT, continuous=bent)
    (found,) = exceeded_ranges(limit, AmplitudeCurve("shaft", speeds, 0.25 * speeds))
    assert found.low < 60.0 < found.high
    assert found.peaks == ()


CHAIN = damped(Chain([0.4, 1.2, 1.2, 25.0], [4e5, 4e5, 5e5]), magnifier=40.0)
ORDERS = np.array([6.0, 7.0, 7.5, 8.0])
PEAK_LIMIT = crankshaft_limit(95.0, strokes=4)
RANGE = (45.0, 1.15 * 95.0)


def uses_at(speeds):
    """Used shares of the limit of the three shafts, all orders together."""
    forces = np.zeros((ORDERS.size, speeds.size, 4), dtype=complex)
    forces[:, :, 1], forces[:, :, 2] = 300.0, 250.0j
    found = forced_response(CHAIN, OrderExcitation(ORDERS, speeds, forces))
    stress = alternating_stress(element_loads(found), dict.fromkeys(range(3), 2e-5))
    return np.array([usage(PEAK_LIMIT, curve) for curve in curves_of(stress)])


def grid(points, further=()):
    natural = np.concatenate((CHAIN.system.elastic_frequencies, further))
    return refined_speeds(natural, 0.5 / 40.0, ORDERS, RANGE, points=points)


def worst(speeds):
    uses = uses_at(speeds)
    place = np.unravel_index(np.argmax(uses), uses.shape)
    return speeds[place[1]], uses[place]


def test_worst_use_is_the_same_on_coarse_and_fine_grids():
    grids = [grid(40), grid(150), grid(150, (61.0, 87.3)), np.linspace(*RANGE, 601)]
    plain, refined = [], []
    for speeds in grids:
        more = refined_maxima(uses_at, speeds)
        assert np.all((speeds[0] <= more) & (more <= speeds[-1]))
        plain.append(worst(speeds))
        refined.append(worst(more))
    exact = worst(np.linspace(0.998 * refined[0][0], 1.002 * refined[0][0], 801))
    for speed, use in refined:
        assert use == close(exact[1], rel=5e-6)
        assert speed == close(exact[0], rel=1e-4)
    # The grids alone differ by far more.
    assert np.ptp([use for _, use in plain]) > 1e-4 * exact[1]


def test_outer_peaks_of_each_exceeded_range_are_refined():
    def uses(speeds):
        near = [1.0 / (1.0 + ((speeds - at) / 0.7) ** 2) for at in (20.03, 22.11, 24.07, 40.01)]
        return np.array([3.0 * near[0] + 4.0 * near[1] + 2.0 * near[2] + 1.5 * near[3] + 0.05])

    dense = np.linspace(10.0, 50.0, 80001)
    values = uses(dense)[0]
    tops = np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] > values[2:])) + 1
    first, highest, last, alone = dense[tops]
    speeds = np.linspace(10.0, 50.0, 161)
    # Neighbors 0.25 apart come 64 times closer.
    near = {"abs": 2 * 0.25 / 64}
    assert refined_maxima(uses, speeds) == close([highest], **near)
    outer = refined_maxima(uses, speeds, least=1.0)
    assert outer == close([first, highest, last, alone], **near)
    # An unbounded value stays where it is.
    unbounded = uses(speeds)
    unbounded[0, 80] = np.inf
    assert refined_maxima(lambda _: unbounded, speeds).size == 0


STEEL = ("limits.tensile_strength", "tensile strength")
BEARING = ("bearings.stiffness", "lateral stiffness")
FINE, BARRED, BAD = "fine", "barred range needed", "not acceptable"


def steels(*tried, taken=440e6):
    return [Trial(*STEEL, value, "Pa", status, value == taken) for value, status in tried]


@pytest.mark.parametrize("order", [1, -1])
def test_the_two_values_beside_the_change_are_told(order):
    tried = steels((440e6, BAD), (506e6, BAD), (507e6, FINE), (835e6, BARRED))[::order]
    found = decide(BAD, tried)
    assert found.status == "undecided"
    assert [one.value for pair in changes(tried) for one in pair] == [506e6, 507e6]


BEARINGS = [
    Trial(*BEARING, value, "N/m", status, value == 2e9)
    for value, status in ((2e8, FINE), (2e9, BAD), (2e10, BARRED))
]
MAGNIFIERS = [
    Trial("damping.torsional_magnifier", "torsional magnifier", value, "", status, value == 40.0)
    for value, status in ((25.0, BARRED), (40.0, FINE), (60.0, BAD))
]


@pytest.mark.parametrize(
    ("verdict", "tried", "status", "told"),
    [
        (BAD, BEARINGS, "undecided", {"2e8 N/m", "2e9 N/m", "2e10 N/m", "bearings.stiffness"}),
        (
            FINE,
            [*steels((440e6, FINE), (590e6, FINE)), *MAGNIFIERS],
            "undecided",
            {"40", "60", "damping.torsional_magnifier"},
        ),
        # A barred range that hangs on a value does not undo the verdict.
        (BARRED, steels((440e6, BARRED), (590e6, FINE)), "acceptable", {"590 MPa", "440 MPa"}),
    ],
)
def test_what_decides_is_named_with_its_values(verdict, tried, status, told):
    found = decide(verdict, tried)
    assert found.status == status
    assert all(one in found.sentence for one in told)


test_impossible_limits_are_refused = refusals_of(
    lambda values: given_limit(
        "torque", **{"unit": "N m", "applies_to": "coupling", "source": "maker"} | values
    ),
    ({"value": 0.0}, "limit on torque of coupling"),
    ({"value": 2.0, "passing": 1.0}, "limit on torque of coupling"),
    ({"value": 2.0, "source": " "}, "limit on torque of coupling"),
)
test_refused = refusals(
    ("tensile_strength", lambda: propulsion_shaft_limit(300e6, 0.3, 10.0)),
    ("feature", lambda: propulsion_shaft_limit(500e6, 0.3, 10.0, feature="weld")),
    ("strokes", lambda: crankshaft_limit(100.0, strokes=3)),
    ("part", lambda: generator_set_limit(100.0, part="pump")),
    ("critical", lambda: BarredRangeRule(10.0).bounds(20.0)),
    ("yield_strength", lambda: crankshaft_material_factors(5e8, 6e8, alloy=True)),
)
