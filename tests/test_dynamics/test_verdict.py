import re
from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.assessment.barred_ranges import BarredRangeRule
from dynamics.assessment.limit_rules import crankshaft_limit
from dynamics.assessment.limits import AmplitudeCurve, constant_curve, given_limit
from dynamics.assessment.verdict import judge
from dynamics.assessment.wording import limit_at

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
    assert verdict.sentence == (
        "Fine from 286.5 to 954.9 1/min: torque of coupling, shaft 6 - 7: at most 1900 N m at "
        "573 1/min, 95 % of the permitted 2000 N m (maker's sheet 7)."
    )


def test_barred_range_needed():
    verdict = judge([(CRANKSHAFT, peak(50.0, 60e6))], RUNNING, RULE)
    assert verdict.status == "barred range needed"
    (barred,) = verdict.barred
    assert (barred.low, barred.high) == close(RULE.bounds(50.0))
    assert verdict.sentence.startswith(
        "Barred range needed, 436.5 to 522.2 1/min: torsional stress"
    )
    assert "60 MPa at 477.5 1/min, 154 % of the permitted 39 MPa" in verdict.sentence


def test_what_is_exceeded_a_little_is_told_by_the_margin():
    verdict = judge([(CRANKSHAFT, peak(50.0, 39e6 * 1.002))], RUNNING, RULE)
    assert "39.08 MPa at 477.5 1/min, 100.2 % of the permitted 39 MPa" in verdict.sentence
    (barred,) = verdict.barred
    assert "(shaft 6 - 7), 100.2 % is used at most" in barred.ends
    (far,) = judge([(CRANKSHAFT, peak(50.0, 60e6))], RUNNING, RULE).barred
    assert "(shaft 6 - 7), 154 % is used at most" in far.ends


@pytest.mark.parametrize(
    ("curve", "why"),
    [
        (peak(50.0, 80e6), "80 MPa at 477.5 1/min, where 78 MPa may be passed"),
        (peak(90.0, 30e6), "nothing may be barred above 0.80"),
        (peak(50.0, np.inf), "unbounded at"),
    ],
)
def test_not_acceptable(curve, why):
    verdict = judge([(CRANKSHAFT, curve)], RUNNING, RULE)
    assert verdict.status == "not acceptable"
    assert why in verdict.sentence


def test_unbounded_without_a_limit_for_passing_is_not_acceptable():
    values = np.where(np.arange(SPEEDS.size) == 800, np.inf, 1.0)
    verdict = judge([(TORQUE, AmplitudeCurve("coupling", SPEEDS, values))], RUNNING, RULE)
    assert verdict.status == "not acceptable"
    assert "the torque of coupling is unbounded in it" in verdict.sentence


def test_limit_without_one_for_passing_leaves_a_remark():
    verdict = judge([(TORQUE, peak(50.0, 3e3))], RUNNING, RULE)
    assert verdict.status == "barred range needed"
    assert any("no limit for passing is known" in remark for remark in verdict.remarks)


def test_below_the_lowest_running_speed_it_is_only_started_through():
    verdict = judge([(CRANKSHAFT, peak(20.0, 70e6))], RUNNING, RULE)
    assert verdict.status == "fine"
    assert len(verdict.started_through) == 1
    assert judge([(CRANKSHAFT, peak(20.0, 100e6))], RUNNING, RULE).status == "not acceptable"


def test_a_range_below_the_lowest_speed_is_not_judged_at_full_load():
    finding = [(CRANKSHAFT, peak(20.0, 100e6))]
    verdict = judge(finding, RUNNING, RULE, full_load=True)
    assert verdict.status == "fine"
    (below,) = verdict.started_through
    assert "not judged" in below.sentence
    assert below.refusals == ()
    # What reaches into the running range is judged.
    (into,) = judge([(CRANKSHAFT, peak(30.0, 200e6))], RUNNING, RULE, full_load=True).barred
    assert not into.allowed


def test_the_strongest_reason_against_barring_is_one_of_running_speeds():
    """More is exceeded below the lowest running speed, in the same range."""
    (barred,) = judge([(CRANKSHAFT, peak(29.0, 200e6))], RUNNING, RULE).barred
    assert barred.low < RUNNING[0] < barred.high
    (reason,) = barred.refusals
    told = float(re.search(r"at ([\d.]+) 1/min", reason)[1])
    assert told >= 0.999 * RUNNING[0] * 30.0 / np.pi
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
    worst = verdict.worst
    assert (worst.curve.name, worst.worst_value) == ("b", 65e6)
    assert RUNNING[0] <= worst.worst_speed <= RUNNING[1]
    assert worst.permitted == CRANKSHAFT.continuous.at(np.array([worst.worst_speed]))[0]
    assert verdict.checks[0].curve.name == "a"
    assert f"b: {worst.use}" in verdict.sentence
    assert (
        f"Above the running range, torsional stress of crankshaft, a: {verdict.checks[0].use}"
        in (verdict.sentence)
    )
    # Where nothing is exceeded at running speeds, what is above them decides.
    findings = [(CRANKSHAFT, curve("a", 6e6, 90e6)), (CRANKSHAFT, curve("b", 7e6, 1e6))]
    kept = judge(findings, RUNNING, RULE)
    assert kept.worst is kept.checks[0]
    assert kept.worst.curve.name == "a"


def test_a_range_that_reaches_into_the_running_range_is_barred():
    verdict = judge([(CRANKSHAFT, peak(30.0, 70e6))], RUNNING, RULE)
    assert verdict.status == "barred range needed"
    assert verdict.started_through == ()
    (barred,) = verdict.barred
    assert barred.low < RUNNING[0] < barred.high


def test_rule_is_held_above_the_running_range_as_far_as_it_goes():
    assert judge([(CRANKSHAFT, peak(104.0, 60e6))], RUNNING, RULE).status == "not acceptable"
    assert judge([(TORQUE, peak(110.0, 9e3))], RUNNING, RULE).status == "fine"
    short = AmplitudeCurve(
        "shaft", SPEEDS[SPEEDS < 101.0], np.ones(np.count_nonzero(SPEEDS < 101.0))
    )
    (remark,) = judge([(CRANKSHAFT, short)], RUNNING, RULE).remarks
    assert "the limit goes on to 1098 1/min, the calculation to" in remark


def test_a_limit_that_ends_within_the_running_range_is_told_once_with_its_end():
    speeds = np.linspace(10.0, 120.0, 221)
    findings = [
        (CRANKSHAFT, AmplitudeCurve(name, speeds, 1e6 * speeds)) for name in ("one", "other")
    ]
    verdict = judge(findings, (RUNNING[0], 118.0), RULE)
    assert verdict.remarks == (
        f"{CRANKSHAFT.name}: not judged above 1098 1/min, where the limit ends",
    )
    assert [check.judged[1] for check in verdict.checks] == close([115.0, 115.0])


@pytest.mark.parametrize(
    ("findings", "running", "message"),
    [
        ([], RUNNING, "findings: given none"),
        (
            [(TORQUE, peak(50.0, 1.0))],
            (100.0, 30.0),
            "the lowest and then the highest running speed",
        ),
        (
            [(TORQUE, peak(50.0, 1.0))],
            (5.0, 100.0),
            "allowed are speeds that cover the running range",
        ),
        (
            [(crankshaft_limit(10.0, strokes=4), peak(50.0, 1.0))],
            RUNNING,
            "allowed is one that is stated at running speeds",
        ),
    ],
)
def test_what_cannot_be_judged_is_refused(findings, running, message):
    with pytest.raises(InputError, match=message):
        judge(findings, running, RULE)


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


def test_a_limit_on_one_place_is_named_once():
    assert limit_at("torsional stress of shaft", "shaft") == "torsional stress of shaft"
    assert limit_at("torsional stress of crankshaft", "shaft") == (
        "torsional stress of crankshaft, shaft"
    )
