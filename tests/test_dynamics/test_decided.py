"""One conclusion from the verdicts with several values of what is assumed."""

import pytest

from dynamics.assessment.verdict import Trial, changes, decide

STEEL = ("limits.tensile_strength", "tensile strength")
BEARING = ("bearings.stiffness", "lateral stiffness")
FINE, BARRED, BAD = "fine", "barred range needed", "not acceptable"


def steels(*tried, taken=440e6):
    return [Trial(*STEEL, value, "Pa", status, value == taken) for value, status in tried]


def test_a_verdict_that_never_changes_needs_no_words():
    found = decide(BAD, steels((440e6, BAD), (590e6, BAD)))
    assert (found.status, found.sentence) == ("not acceptable", "")
    found = decide(FINE, steels((440e6, FINE), (590e6, FINE)))
    assert (found.status, found.sentence) == ("acceptable", "")
    assert decide(BARRED, []).status == "acceptable"


@pytest.mark.parametrize("order", [1, -1])
def test_the_two_values_beside_the_change_are_told(order):
    tried = steels((440e6, BAD), (506e6, BAD), (507e6, FINE), (835e6, BARRED))[::order]
    found = decide(BAD, tried)
    assert found.status == "undecided"
    assert found.sentence == (
        "acceptable with a tensile strength of 507 MPa, not with 506 MPa (440 MPa assumed): give "
        "limits.tensile_strength"
    )
    assert [one.value for pair in changes(tried) for one in pair] == [506e6, 507e6]


def test_a_verdict_that_comes_and_goes_names_all_values():
    tried = [
        Trial(*BEARING, value, "N/m", status, value == 2e9)
        for value, status in ((2e8, FINE), (2e9, BAD), (2e10, BARRED))
    ]
    assert decide(BAD, tried).sentence == (
        "acceptable with a lateral stiffness of 2e8 N/m or 2e10 N/m, not with 2e9 N/m (assumed): give "
        "bearings.stiffness"
    )


def test_each_field_that_decides_is_named():
    magnifier = [
        Trial(
            "damping.torsional_magnifier", "torsional magnifier", value, "", status, value == 40.0
        )
        for value, status in ((25.0, BARRED), (40.0, FINE), (60.0, BAD))
    ]
    found = decide(FINE, steels((440e6, FINE), (590e6, FINE)) + magnifier)
    assert (found.status, found.sentence) == (
        "undecided",
        "acceptable with a torsional magnifier of 40 (assumed), not with 60: give "
        "damping.torsional_magnifier",
    )


def test_a_barred_range_that_hangs_on_a_value_does_not_undo_the_verdict():
    found = decide(BARRED, steels((440e6, BARRED), (590e6, FINE)))
    assert (found.status, found.sentence) == (
        "acceptable",
        "no speeds need be barred with a tensile strength of 590 MPa, not with 440 MPa (assumed): give "
        "limits.tensile_strength",
    )
