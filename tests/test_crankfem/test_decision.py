"""Which strengths of an assumed steel decide a verdict, by amplitudes made for it; no finite elements."""

import numpy as np
import pytest

from crankfem.analyses.vibration.assessment import Assessment, engine_decision
from crankfem.analyses.vibration.engine_limits import engine_limits, engine_verdict
from crankfem.files.engine.engine_file import load_engine
from dynamics.assessment.limits import AmplitudeCurve

RATED = load_engine("6chn25-34").engine.rated_speed
SPEEDS = np.linspace(0.1, 1.2, 2201) * RATED


def decided(*peaks, **limits):
    """Return the decision on peaks, as `judged` does."""
    return judged(*peaks, **limits)[1]


def judged(*peaks, **limits):
    """Peaks at shares of the rated speed [MPa], narrow."""
    engine = load_engine("6chn25-34").changed(engine={"drives": "propeller"})
    if limits:
        engine = engine.changed(limits=limits)
    stress = sum(
        1e6 * height / (1.0 + ((SPEEDS / RATED - at) / 0.002) ** 2) for at, height in peaks
    )
    limit = engine_limits(engine)[0]["crankshaft_stress"]
    findings = [(limit, AmplitudeCurve("throw 1 - throw 2", SPEEDS, stress))]
    verdict = engine_verdict(engine, findings)
    return verdict, engine_decision(engine, verdict.status, findings)


# By the rule 45 - 24 r^2 is permitted, up to r = 0.8 twice that in passing: at 0.9 25.56, at 0.6 36.36 and
# 72.72 N/mm2.
KEPT, PASSED = (0.9, 25.56 * 1.1005), (0.6, 72.72 * 1.1)


def test_the_tensile_strength_decides_on_what_is_kept():
    # 440 (1 + 3/2 0.1005) = 506.3
    assert decided(KEPT).sentence == (
        "acceptable with a tensile strength of 507 MPa, not with 506 MPa (440 MPa assumed): give "
        "limits.tensile_strength"
    )


def test_the_yield_strength_decides_on_what_is_passed():
    found = decided(PASSED)
    assert found.sentence == (
        "acceptable with a yield strength of 248 MPa, not with 247 MPa (225 MPa assumed): give "
        "limits.yield_strength"
    )


def test_both_decide_together():
    # Kept asks for 506 MPa, which brings 259 MPa of yield strength: more than the 247.5 that passing asks.
    found = decided(KEPT, PASSED)
    assert found.status == "undecided"
    assert "tensile strength (yield strength in proportion) of 50" in found.sentence
    assert found.sentence.endswith("give limits.tensile_strength and limits.yield_strength")


@pytest.mark.parametrize(
    "limits", [{"tensile_strength": 480e6, "yield_strength": 260e6}, {"crankshaft_stress": 20e6}]
)
def test_what_is_given_is_not_tried(limits):
    found = decided(KEPT, **limits)
    assert (found.status, found.trials) == ("not acceptable", ())


@pytest.mark.parametrize(
    ("peaks", "limits", "begins"),
    [
        ((KEPT,), {}, "Undecided: acceptable with a tensile strength of 507 MPa, not with 506 MPa"),
        ((KEPT,), {"crankshaft_stress": 20e6}, "Not acceptable: torsional stress"),
        (((0.9, 1.0),), {"crankshaft_stress": 20e6}, "Fine from "),
    ],
)
def test_there_is_one_conclusion(peaks, limits, begins):
    verdict, decision = judged(*peaks, **limits)
    said = Assessment(verdict, decision, {}, (), None, None).conclusion
    assert said.startswith(begins)
    # The status of the values used is told as theirs where it is not the conclusion.
    used = f"With the values used, not acceptable{verdict.sentence.removeprefix('Not acceptable')}"
    assert said.endswith(used if decision.status == "undecided" else verdict.sentence)
