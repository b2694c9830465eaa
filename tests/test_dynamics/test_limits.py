from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.assessment.barred_ranges import BarredRangeRule
from dynamics.assessment.limit_rules import (
    CRANKSHAFT_RULES,
    crankshaft_limit,
    generator_set_limit,
    propulsion_shaft_limit,
)
from dynamics.assessment.limits import (
    AmplitudeCurve,
    LimitCurve,
    axial_force_limit,
    given_limit,
    usage,
)


def test_given_limit_is_the_same_at_all_speeds():
    limit = given_limit("torque", 2e3, "N m", applies_to="coupling", source="maker", passing=3e3)
    assert limit.name == "torque of coupling"
    assert limit.continuous.at(np.array([1.0, 1e4])).tolist() == [2e3, 2e3]
    assert limit.passing.at(np.array([5.0])).tolist() == [3e3]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"value": 0.0}, "given 0 N m; allowed are finite numbers of more than zero"),
        ({"value": 2.0, "passing": 1.0}, "given 1 N m while a barred range is passed; allowed are"),
        ({"value": 2.0, "source": " "}, "given no source; allowed is a sentence"),
    ],
)
def test_impossible_limits_are_refused(values, message):
    given = {"unit": "N m", "applies_to": "coupling", "source": "maker"} | values
    with pytest.raises(InputError, match=message):
        given_limit("torque", **given)


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


def test_a_limit_holds_from_its_beginning_and_is_used_there():
    curve = LimitCurve(np.ones_like, 11.5, 23.0)
    places = np.array([np.nextafter(11.5, 0.0), 11.5, 23.0, np.nextafter(23.0, 99.0)])
    assert curve.at(places).tolist() == [1.0, 1.0, 1.0, 1.0]
    assert np.isinf(curve.at(np.array([11.4999, 23.0001]))).all()
    limit = replace(given_limit("force", 1.0, "N", applies_to="x", source="y"), continuous=curve)
    assert usage(limit, AmplitudeCurve("shaft", places, [2.0] * 4)).tolist() == [2.0] * 4


def test_usage_counts_unbounded_and_leaves_out_speeds_without_a_limit():
    limit = crankshaft_limit(100.0, strokes=4)
    curve = AmplitudeCurve("shaft", [50.0, 100.0, 116.0], [39e6 / 2, np.inf, 1e9])
    assert usage(limit, curve) == close([0.5, np.inf, 0.0])


@pytest.mark.parametrize(
    ("speeds", "values", "message"),
    [
        ([2.0, 1.0], [1.0, 1.0], "that do not ascend"),
        ([1.0, 2.0], [1.0], "given an array of shape"),
        ([1.0, 2.0], [1.0, np.nan], "allowed is an amplitude of zero or more"),
        ([1.0, 2.0], [1.0, -1.0], "allowed is an amplitude of zero or more"),
    ],
)
def test_impossible_curves_are_refused(speeds, values, message):
    with pytest.raises(InputError, match=message):
        AmplitudeCurve("shaft", speeds, values)


def test_strong_steel_enters_the_shaft_rule_up_to_its_cap_and_the_limit_says_so():
    carbon = propulsion_shaft_limit(650e6, 0.3, 10.0)
    capped = propulsion_shaft_limit(600e6, 0.3, 10.0)
    speed = np.array([5.0])
    assert carbon.continuous.at(speed) == capped.continuous.at(speed)
    assert "650 MPa enters the rule as 600 MPa" in carbon.remark
    assert capped.remark == ""
    alloy = propulsion_shaft_limit(650e6, 0.3, 10.0, alloy=True)
    assert alloy.continuous.at(speed) == close(capped.continuous.at(speed) * 810 / 760)
    tail = propulsion_shaft_limit(650e6, 0.3, 10.0, alloy=True, feature="propeller shaft")
    assert tail.continuous.at(speed) == close(capped.continuous.at(speed) * 0.55)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: propulsion_shaft_limit(300e6, 0.3, 10.0), "given 300 MPa; allowed is 400 MPa or"),
        (
            lambda: propulsion_shaft_limit(500e6, 0.3, 10.0, feature="weld"),
            "feature: given 'weld'; allowed are integral flange",
        ),
        (lambda: crankshaft_limit(100.0, strokes=3), "strokes: given 3; allowed are 2 and 4"),
        (
            lambda: generator_set_limit(100.0, part="pump"),
            "part: given 'pump'; allowed are crankshaft, generator shaft",
        ),
        (lambda: BarredRangeRule(10.0).bounds(20.0), "allowed is less than twice the rated speed"),
    ],
)
def test_what_a_rule_does_not_cover_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()


@pytest.mark.parametrize(
    ("alloy", "most", "said"),
    [
        (
            False,
            590e6,
            "900 MPa enters the rule as 590 MPa, where its formula ends for carbon steel",
        ),
        (
            True,
            835e6,
            "900 MPa enters the rule as 835 MPa, where its formula ends for low alloy steel",
        ),
    ],
)
def test_a_steel_beyond_the_end_of_the_formula_counts_as_one_at_its_end(alloy, most, said):
    speeds = np.linspace(20.0, 100.0, 5)
    for rule in CRANKSHAFT_RULES.values():
        strong, at_end = (
            rule(100.0, strokes=4, tensile_strength=one, alloy=alloy) for one in (900e6, most)
        )
        assert np.array_equal(strong.continuous.values(speeds), at_end.continuous.values(speeds))
        assert said in strong.remark
        assert "enters the rule" not in at_end.remark


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
