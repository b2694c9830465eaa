"""The self-checks of a run.

Round-off of a 12x12 matrix product is some 1e-16; 1e-13 leaves room for its few terms.
"""

import copy
import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from comparing import close
from crankfem.analyses.checks import run_checks, unbalanced_share
from crankfem.analyses.vibration import records
from crankfem.report.text_filters import check_value_text
from fem.angle_law import SYMMETRIC
from fem.solver import asymmetry, rigid_body_residual

STORED = Path(__file__).with_name("report_results.json")
LENGTH, RADIUS = 0.41, 0.17
ROUND_OFF = 1e-13


def beam(length=LENGTH):
    """Stiffness (12, 12) of a slender beam along z, from its textbook entries."""
    bending, stretch, twist = 3.0e6, 5.0e9, 2.0e6
    k = np.zeros((12, 12))
    for row, stiffness in ((2, stretch), (5, twist)):
        k[np.ix_([row, row + 6], [row, row + 6])] = stiffness * np.array([[1.0, -1.0], [-1.0, 1.0]])
    a, b, c, d = (
        bending * value for value in (12.0 / length**3, 6.0 / length**2, 4.0 / length, 2.0 / length)
    )
    for shift, turn, sign in ((0, 4, 1.0), (1, 3, -1.0)):
        places = [shift, turn, shift + 6, turn + 6]
        s = sign * b
        k[np.ix_(places, places)] = [[a, s, -a, s], [s, c, -s, d], [-a, -s, a, -s], [s, d, -s, c]]
    return k


@pytest.fixture
def stored():
    return json.loads(STORED.read_text(encoding="utf-8"))


def checks_of(results):
    return {own["name"]: own for own in run_checks(results, LENGTH, (0.0, RADIUS, LENGTH / 2.0))}


def test_a_beam_moves_freely_as_one_body():
    assert rigid_body_residual(beam(), LENGTH) < ROUND_OFF
    # Held against the motions of another length, its turning meets forces.
    assert rigid_body_residual(beam(), 0.9 * LENGTH) > 1e-4
    held = beam()
    held[0, 0] *= 1.001
    assert rigid_body_residual(held, LENGTH) > 1e-6


def test_a_stiffness_that_is_not_symmetric_is_found():
    assert asymmetry(beam(), LENGTH) == 0.0
    skew = beam()
    skew[0, 4] *= 1.01
    assert asymmetry(skew, LENGTH) > 1e-5


def test_forces_and_moments_must_balance():
    # Two supports carry a load in their middle, half each.
    ends = [{"force": [0.0, 5.0, 0.0], "moment": [0.0, 0.0, 0.0]} for _ in range(2)]
    places, load, middle = [(0, 0, 0), (0, 0, 2.0)], (0, -10.0, 0), (0, 0.3, 1.0)
    assert unbalanced_share(ends, places, load, middle) == 0.0
    # Off the middle by a tenth of the distance, a moment of that share is left over.
    assert unbalanced_share(ends, places, load, (0, 0.3, 1.2)) == close(0.1)
    ends[0]["force"] = [0.0, 4.0, 0.0]
    assert unbalanced_share(ends, places, load, middle) == close(0.1)


def test_all_checks_of_a_run(stored):
    found = checks_of(stored)
    assert len(found) == len(stored["checks"])
    for name in ("Rigid-body motions of the stiffness", "Equilibrium of the reactions"):
        assert found[name]["figure"] < ROUND_OFF
        assert found[name]["met"] is True
    assert found["Error of the axial compliance"]["figure"] == stored["throw"]["error_estimate"]
    reciprocity = stored["throw"]["reciprocity"]
    assert found["Symmetry of the stiffness"]["figure"] == reciprocity["asymmetry"]
    assert found["Axial reaction by reciprocity"]["figure"] == reciprocity["axial_reaction"]
    # With the reasons beside the constants.
    allowed = {name: own["allowed"] for name, own in found.items() if own["shown_unit"] == "1"}
    assert allowed.pop("Opposite neighbors compared with pinned ends") == SYMMETRIC
    assert allowed.pop("Energy of the crank mechanism") == 1e-10
    assert {allowed.pop(f"Power of the {kind} vibration") for kind in ("axial", "torsional")} == {
        1e-6
    }
    assert set(allowed.values()) == {1e-8}
    assert found["Elements mended"]["met"] is None
    assert found["The axial chain compared with the whole crankshaft"]["figure"] == close(
        76.7632 / 81.1461 - 1.0, abs=1e-5
    )
    assert found["The axial chain compared with the whole crankshaft"]["met"] is False
    json.dumps(list(found.values()), allow_nan=False)


def test_what_a_run_does_not_hold_is_not_checked(stored):
    results = copy.deepcopy(stored)
    results |= {"study": None, "mechanism": None, "fillets": None}
    results["vibration"] |= {"forced": None, "whole": None}
    results["formulas"]["fe"]["angle_law"] = None
    assert len(checks_of(results)) == 6


def change(results, path, value):
    """Set a value at a path of keys."""
    *way, last = path
    for key in way:
        results = results[key]
    results[last] = value


@pytest.mark.parametrize(
    ("path", "value", "name"),
    [
        (("throw", "accuracy_met"), False, "Error of the axial compliance"),
        (("throw", "stiffness", 0, 0), 9.96e8, "Rigid-body motions of the stiffness"),
        (("throw", "reciprocity", "asymmetry"), 2e-8, "Symmetry of the stiffness"),
        (("throw", "reciprocity", "axial_reaction"), 2e-8, "Axial reaction by reciprocity"),
        (
            ("throw", "supports", "guided", "reactions", "left", "force", 1),
            210707.0,
            "Equilibrium of the reactions",
        ),
        (
            ("throw", "supports", "pinned", "reactions", "right", "moment", 0),
            -0.01,
            "Equilibrium of the reactions",
        ),
        (("formulas", "fe", "axial"), 1.28939e-9, "Opposite neighbors compared with pinned ends"),
        (("fillets", "accuracy_met"), False, "Error of the fillet stresses"),
        (("mechanism", "energy_error"), -1e-9, "Energy of the crank mechanism"),
        (
            ("vibration", "forced", "axial", "power", "error"),
            1.1e-6,
            "Power of the axial vibration",
        ),
        (
            ("vibration", "whole", "chains", "torsional", "suffices"),
            False,
            "The torsional chain compared with the whole crankshaft",
        ),
    ],
)
def test_a_check_that_fails_says_so(stored, path, value, name):
    results = copy.deepcopy(stored)
    # The stored chains do not suffice; here only what is changed fails.
    for chain in results["vibration"]["whole"]["chains"].values():
        chain["suffices"] = True
    assert all(own["met"] is not False for own in checks_of(results).values())
    change(results, path, value)
    assert [own for own, check in checks_of(results).items() if check["met"] is False] == [name]


def test_a_figure_may_be_negative_but_not_large(stored):
    results = copy.deepcopy(stored)
    results["formulas"]["fe"]["axial"] *= 1.0 - 0.5 * SYMMETRIC
    results["mechanism"]["energy_error"] = -0.5e-10
    found = checks_of(results)
    angle = found["Opposite neighbors compared with pinned ends"]
    assert angle["figure"] == close(-0.5 * SYMMETRIC, rel=1e-6)
    assert angle["met"] is True
    assert found["Energy of the crank mechanism"]["met"] is True


@pytest.mark.parametrize(("unbounded", "error"), [([True, False], 0.25), ([True, True], None)])
def test_power_is_compared_where_vibration_is_bounded(unbounded, error):
    power = SimpleNamespace(
        unbounded=np.array([unbounded]),
        dissipated=np.array([[9.0, 4.0]]),
        error=0.25,
        dashpot_names=(),
    )
    response = SimpleNamespace(speeds=np.array([10.0, 20.0]))
    found = records._power(SimpleNamespace(power=power, response=response))
    assert found["error"] == error


def test_where_vibration_is_unbounded_at_all_speeds_its_power_is_not_judged(stored):
    results = copy.deepcopy(stored)
    results["vibration"]["forced"]["axial"]["power"]["error"] = None
    found = checks_of(results)["Power of the axial vibration"]
    assert (found["figure"], found["met"]) == (None, None)
    assert check_value_text(found) == "none"
