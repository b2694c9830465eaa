from functools import cache

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from fem import responses
from fem.analysis import analyze_throw
from fem.fillet_stress import fillet_stresses
from fem.material import STEEL
from fem.responses import RESPONSES, evaluate_throw
from fem.supports import Neighbors, all_end_motions
from geometry.throw import CrankThrow
from geometry.throw_dimensions import Web

# Finite elements throughout: not for the inner loop.
pytestmark = pytest.mark.slow

PLAIN = CrankThrow(
    crank_radius=0.170,
    main_journal_diameter=0.220,
    pin_diameter=0.180,
    main_journal_length=0.120,
    pin_length=0.139,
    web_width=0.285,
    web_thickness=0.068,
    fillet_radius=0.012,
)
UNEQUAL = PLAIN.model_copy(update={"right_web": Web(thickness=0.080)})


def changed(throw, **values):
    return CrankThrow(**throw.model_dump() | values)


@cache
def evaluated(throw, accuracy):
    return evaluate_throw(throw, accuracy=accuracy)


@pytest.fixture(scope="module")
def coarse():
    return evaluated(PLAIN, 0.03)


def end_moments(analysis, throw):
    """End moments by the analysis's reactions, where the length is kept, and its angle law."""
    length = throw.length

    def held(support):
        radial, tangential = (
            analysis.reactions(force, support) for force in ((0, -1, 0), (-1, 0, 0))
        )
        ends = [tangential.left.moment[1] / length, tangential.right.moment[1] / length]
        return radial, (ends[0] - ends[1]) / 2.0, (ends[0] + ends[1]) / 2.0

    def axial(support):
        """End moments of an axial force: what the superelement is held with while it is pulled."""
        motions = all_end_motions(analysis.superelement, support)[:, 0]
        whole = analysis.superelement if support == "guided" else analysis.superelement.joined
        ends = whole.stiffness @ motions / length
        return -ends[3], ends[9]

    radial, opposed, alike = held("guided")
    left, right = axial("guided")
    push = radial.left.force[2]
    found = {
        "radial_end_moment_left_guided": left * push - radial.left.moment[0] / length,
        "radial_end_moment_right_guided": right * push + radial.right.moment[0] / length,
        "axial_end_moment_left_guided": left,
        "axial_end_moment_right_guided": right,
        "tangential_end_moment_opposed_guided": opposed,
        "tangential_end_moment_alike_guided": alike,
    }
    if throw is not PLAIN:
        return found
    radial, opposed, _ = held(Neighbors(0.0, 0.0))
    left, _ = axial(Neighbors(0.0, 0.0))
    turned = held(Neighbors(90.0, 90.0))[1]
    return found | {
        "radial_end_moment_in_line": left * radial.left.force[2] - radial.left.moment[0] / length,
        "axial_end_moment_in_line": left,
        "tangential_end_moment_in_line": opposed,
        "tangential_end_moment_opposite": held(Neighbors(180.0, 180.0))[2],
        "cross_tilt_stiffness_ratio": turned / (opposed - turned),
    }


@pytest.mark.parametrize("throw", [PLAIN, UNEQUAL], ids=["equal webs", "unequal webs"])
def test_responses_are_those_of_the_whole_analysis(throw):
    found = evaluate_throw(throw, accuracy=0.05)
    analysis = analyze_throw(throw, accuracy=0.05)
    wanted = {"mass": analysis.mass}
    for support in ("pinned", "guided"):
        answer = analysis.supported(support)
        wanted[f"axial_compliance_{support}"] = answer.axial
        wanted[f"torsional_compliance_{support}"] = answer.torsional
        wanted[f"influence_coefficient_{support}"] = answer.influence
        reaction = analysis.reactions((0.0, -1.0, 0.0), support).left.force[2]
        wanted[f"axial_reaction_{support}"] = reaction
    for name, angle in (("in_line", 0.0), ("opposite", 180.0)):
        answer = analysis.supported(Neighbors(angle, angle))
        wanted[f"axial_compliance_{name}"] = answer.axial
        wanted[f"influence_coefficient_{name}"] = answer.influence
    low, high = wanted["axial_compliance_in_line"], wanted["axial_compliance_opposite"]
    middle = analysis.axial_compliance(Neighbors(90.0, 90.0))
    wanted["tilt_stiffness_ratio"] = (high - middle) / (middle - low)
    wanted |= end_moments(analysis, throw)
    alike = throw is PLAIN
    assert set(found.values) == set(wanted)
    assert alike == (set(wanted) == set(RESPONSES) - {"fillet_stress_factor"})
    # The same mesh and the same matrices, added up in another order; the ratio is one of differences.
    for name, value in wanted.items():
        assert found.values[name] == close(value, rel=1e-8), name
    assert found.errors["axial_compliance_pinned"] == close(analysis.error_estimate)
    assert found.unknowns == analysis.mesh.unknowns


@pytest.mark.slow
@pytest.mark.parametrize(
    ("throw", "accuracy", "reference"),
    [
        (PLAIN, 0.03, 0.003),
        (changed(PLAIN, web_thickness=0.045, pin_bore=0.06, main_journal_bore=0.08), 0.05, 0.005),
    ],
    ids=["plain", "bored and thin"],
)
def test_true_errors_are_those_estimated(throw, accuracy, reference):
    coarse, fine = evaluated(throw, accuracy), evaluated(throw, reference)
    for name, value in fine.values.items():
        if name == "mass":
            continue
        true = abs(value / coarse.values[name] - 1.0)
        estimate = coarse.errors[name]
        assert true < estimate, name


@pytest.mark.slow
def test_errors_fall_with_the_accuracy(coarse):
    finer = evaluate_throw(PLAIN, accuracy=0.004)
    for name, error in finer.errors.items():
        if name != "mass":
            assert 0.0 < error < coarse.errors[name], name
    assert coarse.errors["mass"] < 1e-4


def test_neighbors_soften_what_rigid_sections_make_the_same(coarse):
    values = coarse.values
    for name, rigid in (("opposite", "pinned"), ("in_line", "guided")):
        beside = values[f"axial_compliance_{name}"] / values[f"axial_compliance_{rigid}"]
        assert 1.003 < beside < 1.02
    for load in ("radial", "axial"):
        held = values[f"{load}_end_moment_left_guided"]
        assert values[f"{load}_end_moment_right_guided"] == close(held, rel=1e-9)
        assert values[f"{load}_end_moment_in_line"] == close(held, rel=0.02)
    # Out of plane the webs are stiffer: every throw with a crank radius has a ratio above 1.
    assert 1.8 < values["tilt_stiffness_ratio"] < 3.4


def test_every_response_says_what_it_is(coarse):
    for name, kind in RESPONSES.items():
        assert kind.unit in ("m/N", "rad/(N m)", "kg", ""), name
        assert kind.symbol
        assert kind.meaning
    assert len({kind.symbol for kind in RESPONSES.values()}) == len(RESPONSES)
    assert all(np.isfinite(list(coarse.values.values())))


@pytest.mark.slow
def test_the_largest_stress_factor(monkeypatch):
    """Of the stresses that are computed on the way; large fillets are soon solved."""
    throw = changed(PLAIN, fillet_radius=0.018)
    asked, made = [], []

    def noted(*arguments, mesher):
        asked.append(arguments)
        made.append(fillet_stresses(*arguments, mesher=mesher))
        return made[-1]

    monkeypatch.setattr(responses, "fillet_stresses", noted)
    found = evaluate_throw(throw, accuracy=0.1, stresses=True)
    assert asked == [(throw, STEEL, 0.05)]
    wanted = max(p.factor for p in made[0].peaks if p.load.kind in ("bending", "torsion"))
    assert found.values["fillet_stress_factor"] == wanted
    assert 0.0 < found.errors["fillet_stress_factor"] <= 0.05


def test_stresses_of_sharp_corners_are_refused():
    with pytest.raises(InputError, match="fillet"):
        evaluate_throw(changed(PLAIN, fillet_radius=0.0), accuracy=0.1, stresses=True)
