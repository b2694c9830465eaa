"""Limits of classification rules at single speeds.

Source: Korean Register, Rules for Steel Ships, RA-05-E, 2025, Part 5 Chapter 4: 201 (crankshafts), 202
(shafts: IACS M68), 203 (generator sets), 206 (barred range); worked out by pocket calculator.

Tolerance: half of the last digit shown.
"""

import numpy as np

from comparing import close
from dynamics.assessment.barred_ranges import BarredRangeRule
from dynamics.assessment.limit_rules import (
    crankshaft_limit,
    generator_set_limit,
    propulsion_shaft_limit,
)


def at(curve, *ratios):
    return (curve.at(100.0 * np.array(ratios)) / 1e6).tolist()


def test_intermediate_shaft_of_500_mm(figure):
    """c_D = 0.35 + 0.93 * 500^-0.2 = 0.61834; (560 + 160) / 18 = 40."""
    limit = propulsion_shaft_limit(560e6, 0.5, 100.0)
    kept = at(limit.continuous, 0.5, 0.9, 1.0, 1.06)
    wanted = [61.83, 34.13, 34.13, np.inf]
    figure("intermediate shaft, continuous running", kept, wanted, 0.005, "MPa", "absolute")
    passed = at(limit.passing, 0.5)
    figure("intermediate shaft, passing", passed, 105.12, 0.01, "MPa", "absolute")
    assert limit.passing.high == close(80.0)


def test_propeller_shaft_may_be_passed_with_more_of_its_lower_limit(figure):
    """1.7 / sqrt(0.55) = 2.2923 times 0.55 * 61.834 = 34.01."""
    limit = propulsion_shaft_limit(560e6, 0.5, 100.0, feature="propeller shaft")
    kept, passed = at(limit.continuous, 0.5), at(limit.passing, 0.5)
    figure("propeller shaft, continuous running", kept, 34.01, 0.005, "MPa", "absolute")
    figure("propeller shaft, passing", passed, 77.96, 0.02, "MPa", "absolute")


def test_crankshaft_of_a_main_engine(figure):
    """45 - 24 * 0.25 = 39; 45 - 24 = 21; 21 + 237 * 0.3 * sqrt(0.1) = 43.48."""
    limit = crankshaft_limit(100.0, strokes=4)
    kept, wanted = at(limit.continuous, 0.5, 1.0, 1.1, 1.16), [39.0, 21.0, 43.48, np.inf]
    figure("crankshaft, continuous running", kept, wanted, 0.005, "MPa", "absolute")
    assert at(limit.passing, 0.5, 0.81) == close([78.0, np.inf])


def test_crankshaft_of_a_two_stroke_engine_and_of_v_engines():
    """45 - 29 * 0.25 = 37.75; 45 - 29 = 16."""
    for limit in (
        crankshaft_limit(100.0, strokes=2),
        crankshaft_limit(100.0, strokes=4, kind="V", firing_interval_deg=50.0),
    ):
        assert at(limit.continuous, 0.5, 1.0) == close([37.75, 16.0])
    even = crankshaft_limit(100.0, strokes=4, kind="V", firing_interval_deg=60.0)
    assert at(even.continuous, 1.0) == close([21.0])


def test_strong_crankshaft():
    """1 + 2/3 (660 / 440 - 1) = 1.3333 for kept speeds, 450 / 225 = 2 for passed ones."""
    limit = crankshaft_limit(
        100.0, strokes=4, tensile_strength=660e6, yield_strength=450e6, alloy=True
    )
    assert at(limit.continuous, 0.5) == close([52.0])
    assert at(limit.passing, 0.5) == close([156.0])


def test_generator_set():
    shaft = generator_set_limit(100.0, part="generator shaft")
    assert at(shaft.continuous, 1.0, 1.11) == close([31.0, np.inf])
    assert at(shaft.passing, 0.9) == close([118.0])
    # Continuous running is limited from 0.9 to 1.1 of the rated speed; below, speeds are only passed.
    assert at(shaft.continuous, 0.89, 0.9, 1.1) == close([118.0, 31.0, 31.0])
    crank = generator_set_limit(100.0, part="crankshaft", strokes=2)
    assert at(crank.continuous, 0.95) == close([16.0])
    assert at(crank.passing, 0.5) == close([90.0])


def test_barred_range_about_half_of_the_rated_speed(figure):
    """16 * 50 / 17.5 = 45.714 and 17.5 * 50 / 16 = 54.6875."""
    bounds = BarredRangeRule(100.0).bounds(50.0)
    figure("barred range", bounds, (45.714, 54.6875), 5e-4, "rad/s", "absolute")
