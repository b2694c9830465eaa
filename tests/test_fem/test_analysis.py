"""Analyses of throws, and compliance over the crank angle."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fem.analysis
import fem.first_mesh
from comparing import close
from crankbase.errors import InputError
from fem.analysis import (
    Problem,
    analyze_axial,
    analyze_throw,
    refined_sizes,
    solve_level,
    solve_to_accuracy,
)
from fem.angle_law import AngleLaw, angle_law, is_symmetric
from fem.material import STEEL
from fem.solver import Stopwatch
from fem.supports import Neighbors, class_axial_compliances
from geometry.mesh import mesh_throw
from geometry.throw import CrankThrow
from geometry.throw_dimensions import Web
from parts_in_a_line import crank_throw
from refusals import refused


@pytest.fixture(scope="module")
def analysis(throw):
    return analyze_throw(throw, accuracy=0.03)


def test_an_analysis_tells_what_it_is(analysis, throw):
    assert analysis.throw == throw
    assert analysis.material == STEEL
    assert analysis.accuracy == 0.03
    assert 0.0 < analysis.error_estimate <= 0.03
    assert analysis.accuracy_met
    assert analysis.solver in ("pardiso", "superlu")
    assert analysis.stiffness.shape == (12, 12)


def test_compliances_and_reactions_of_an_analysis(analysis):
    pinned = analysis.axial_compliance()
    assert pinned == analysis.axial_compliance("pinned") == analysis.supported("pinned").axial
    assert pinned == close(1.27e-9, rel=0.02)
    assert 3.0 < pinned / analysis.axial_compliance("guided") < 8.0
    assert analysis.axial_compliance(Neighbors(120, 120)) < pinned
    assert analysis.torsional_compliance() > analysis.torsional_compliance("guided") > 0.0
    found = analysis.reactions(pin_force=(0, -1e5, 0), support="pinned")
    thrust = analysis.influence_coefficient() * 1e5 / pinned
    assert found.left.force == close([0.0, 5e4, thrust], rel=1e-6, abs=1e-6)
    assert found.right.force == close([0.0, 5e4, -thrust], rel=1e-6, abs=1e-6)
    assert found.left.moment.shape == found.right.moment.shape == (3,)


def test_masses_of_an_analysis(analysis, throw):
    assert analysis.mass == close(7850.0 * throw.volume, rel=1e-4)
    assert analysis.center_of_mass[2] == close(throw.length / 2.0)
    assert 0.0 < analysis.center_of_mass[1] < throw.crank_radius
    assert np.linalg.eigvalsh(analysis.inertia).min() > 0.0


@pytest.mark.parametrize("accuracy", [0.0, -0.01, 0.0009, 0.11, 1.0, math.nan, math.inf, "1 %"])
def test_accuracy_out_of_range(throw, accuracy):
    with refused("accuracy"):
        analyze_throw(throw, accuracy=accuracy)


def test_unknown_supports_are_refused_everywhere(analysis):
    for call in (
        analysis.axial_compliance,
        analysis.torsional_compliance,
        analysis.influence_coefficient,
        analysis.supported,
        lambda support: analysis.reactions((0.0, -1.0, 0.0), support),
    ):
        with refused("support"):
            call("fixed")


@pytest.mark.parametrize(
    "force", [(0.0, -1.0), 5.0, (0.0, math.nan, 0.0), np.zeros((3, 1)), "1 kN"]
)
def test_pin_force_that_is_no_force(analysis, force):
    with pytest.raises(InputError, match=r"^pin_force: given "):
        analysis.reactions(force)


@pytest.mark.parametrize("pin", [1, -1, 0.0, True, None, "0"])
def test_pin_that_the_throw_has_not(analysis, pin):
    for call in (
        lambda: analysis.reactions((0.0, -1.0, 0.0), pin=pin),
        lambda: analysis.influence_coefficient(pin=pin),
    ):
        with refused("pin"):
            call()


@pytest.mark.slow
@pytest.mark.parametrize("end_sections", ["rigid", "averaged"])
def test_the_axial_analysis_alone_gives_the_same(throw, end_sections):
    whole = analyze_throw(throw, accuracy=0.05, end_sections=end_sections)
    alone = analyze_axial(throw, accuracy=0.05, end_sections=end_sections)
    assert alone.error_estimate == whole.error_estimate
    assert alone.accuracy_met
    for support in ("pinned", "guided"):
        assert alone.axial_compliance(support) == close(whole.axial_compliance(support), rel=1e-9)
        assert alone.influence_coefficient(support) == close(
            whole.influence_coefficient(support), rel=1e-9
        )
    with refused("support"):
        alone.axial_compliance(Neighbors(120, 120))


def test_unknown_end_sections(throw):
    with refused("end_sections"):
        analyze_throw(throw, accuracy=0.1, end_sections="soft")


def test_times_are_told(analysis):
    named = {"geometry", "mesh", "assembly", "factorization", "solves", "error estimate"}
    assert named <= set(analysis.seconds)
    assert all(seconds >= 0.0 for seconds in analysis.seconds.values())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("radius", "accuracies", "finest"),
    [
        (None, (0.02, 0.005), 0.0012),
        pytest.param(0.040, (0.02, 0.005), 0.0012, marks=pytest.mark.further),
        pytest.param(0.0, (0.02, 0.006), 0.003, marks=pytest.mark.further),
    ],
    ids=["usual", "large", "sharp"],
)
def test_error_estimate_covers_the_true_error(dimensions, radius, accuracies, finest):
    """The truth is the corrected answer of a mesh with four times the unknowns."""
    throw = CrankThrow(**dimensions | ({} if radius is None else {"fillet_radius": radius}))
    problem = Problem(STEEL, "auto", "rigid", Stopwatch())
    judged = [solve_to_accuracy(throw, accuracy, problem) for accuracy in accuracies]
    sizes = refined_sizes(judged[-1].mesh, judged[-1].errors, finest)
    factor = (sizes.expected_unknowns() / (5.2 * judged[-1].mesh.unknowns)) ** (1.0 / 3.0)
    reference = solve_level(mesh_throw(throw, factor, sizes=sizes), problem)
    assert reference.mesh.unknowns > 4 * judged[-1].mesh.unknowns
    for accuracy, found in zip(accuracies, judged, strict=True):
        error = abs(found.axial / reference.axial - 1.0)
        assert error <= found.error_estimate <= accuracy
        plain = class_axial_compliances(found.axial_part.discrete, "pinned")[0]
        assert error <= 0.4 * (1.0 - plain / reference.axial)


@pytest.mark.slow
def test_an_accuracy_that_cannot_be_met_is_told(throw, monkeypatch):
    for module in (fem.analysis, fem.first_mesh):
        monkeypatch.setattr(module, "MOST_UNKNOWNS", 12_000)
    found = analyze_axial(throw, accuracy=0.001)
    assert not found.accuracy_met
    assert found.error_estimate > 0.001
    # The budget is used: the best mesh within it is better than the first one.
    assert found.mesh.unknowns > 8_000
    assert found.error_estimate < analyze_axial(throw, accuracy=0.1).error_estimate


THROW = crank_throw(0.170, 0.220, 0.180, 0.120, 0.139, 0.285, 0.068, fillet_radius=0.012)


@pytest.fixture(scope="module")
def bending():
    return analyze_throw(THROW, accuracy=0.1)


@pytest.fixture(scope="module")
def angle_analysis(bending):
    return bending.with_sections("rigid")


@pytest.mark.parametrize("gamma", [1.0, 30.0, 60.0, 90.0, 120.0, 144.0, 179.0, -120.0, 240.0])
def test_the_law_is_that_of_the_assembled_chain(angle_analysis, gamma):
    law, chain = angle_analysis.angle_law, angle_analysis.supported(Neighbors(gamma, gamma))
    # Exact where sections are rigid.
    assert law.axial(gamma) == close(chain.axial, rel=1e-8)
    assert law.influence(gamma) == close(chain.influence, rel=1e-8)


numbers = st.floats(0.1, 10.0)


@given(numbers, numbers, numbers, st.floats(-720.0, 720.0))
def test_the_law_stays_between_its_ends_and_folds(low, more, ratio, gamma):
    law = AngleLaw(low, low + more, ratio, low, low + more)
    assert low * (1 - 1e-12) <= law.axial(gamma) <= (low + more) * (1 + 1e-12)
    assert law.axial(gamma) == close(law.axial(360.0 - gamma), rel=1e-9)
    assert law.axial(0.0) == low
    assert law.axial(180.0) == close(low + more, rel=1e-12)


def test_a_ratio_of_one_is_linear_in_the_cosine():
    law = AngleLaw(1.0, 3.0, 1.0, 1.0, 3.0)
    gammas = np.linspace(0.0, 180.0, 7)
    assert law.axial(gammas) == close(2.0 - np.cos(np.deg2rad(gammas)))


@pytest.mark.slow
def test_throws_without_symmetry_are_refused():
    unequal = THROW.model_copy(update={"right_web": Web(thickness=0.080)})
    found = analyze_throw(unequal, accuracy=0.1)
    assert not is_symmetric(found.superelement)
    twice = np.repeat(found.superelement.pin_loads, 2, axis=0)
    assert not is_symmetric(replace(found.superelement, pin_loads=twice))
    with pytest.raises(InputError, match="equal webs"):
        angle_law(found.superelement)


@pytest.mark.parametrize(
    "gamma", [float("nan"), float("inf"), "x", "120", True, None, ["x"], [[1.0], [1.0, 2.0]]]
)
def test_angles_must_be_numbers(angle_analysis, gamma):
    with refused("gamma_deg"):
        angle_analysis.angle_law.axial(gamma)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("ratio", value) for value in (0.0, -1.0, math.nan, math.inf)),
        *(("in_line", value) for value in (0.0, -1e-9, math.nan)),
        ("opposite", math.inf),
        ("influence_in_line", math.nan),
        ("influence_opposite", -math.inf),
    ],
)
def test_numbers_of_no_throw_are_refused(name, value):
    law = AngleLaw(1e-9, 2e-9, 1.5, -1e-10, 0.0)  # the influence has a sign
    with refused(name):
        replace(law, **{name: value})
