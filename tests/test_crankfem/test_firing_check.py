"""The sentence that puts misfiring beside normal firing."""

import math

import pytest

from crankfem.analyses.vibration.misfiring import FiringCheck, Reached
from dynamics.assessment.limits import given_limit

STRESS = given_limit("torsional stress", 20e6, "Pa", applies_to="crankshaft", source="maker")
RPM = math.pi / 30.0


def check(normal, misfiring):
    return FiringCheck(STRESS.name, "Pa", STRESS, normal, (4,), misfiring, {(4,): misfiring})


def reached(value, permitted=20e6, place="cylinder 4 - flywheel", speed=1000.0):
    return Reached(place, speed * RPM, value, permitted)


@pytest.mark.parametrize(
    ("normal", "misfiring", "said"),
    [
        # What is permitted is told once where it is the same.
        (
            reached(30e6),
            reached(29e6),
            "145 % of the permitted 20 MPa; with all cylinders firing 30 MPa at 1000 1/min, 150 %.",
        ),
        (
            reached(30e6, 25e6, "free end", 900.0),
            reached(29e6),
            "; with all cylinders firing 30 MPa at 900 1/min, 120 % of the permitted 25 MPa, free end.",
        ),
        # A share has no use where nothing is permitted, or all is unbounded.
        (reached(30e6, math.inf), reached(29e6), "with all cylinders firing 30 MPa at 1000 1/min."),
        (reached(30e6), reached(math.inf), "30 MPa at 1000 1/min, 150 % of the permitted 20 MPa."),
    ],
)
def test_normal_firing_is_told_with_its_share(normal, misfiring, said):
    sentence = check(normal, misfiring).sentence
    assert sentence.startswith(
        "With cylinder 4 misfiring, torsional stress of crankshaft, cylinder 4"
    )
    assert sentence.endswith(said)
