"""Motions of sections: the basis itself, and superelements that have them."""

from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from fem.analysis import analyze_throw
from fem.assembly import assemble_stiffness
from fem.condensation import condense
from fem.fields import displacement_field
from fem.loads import unit_pin_loads
from fem.material import STEEL
from fem.shaft import shaft_compliances, sharing_sections
from fem.superelement import combine_classes, superelement_of_end_forces
from fem.supports import Neighbors, end_motions, reactions, support_throw
from fem.symmetry import (
    KEPT,
    SectionMotions,
    _basis,
    _ring,
    both_ends,
    degree_of,
    section_turn,
    symmetry_classes,
)

ROUND_OFF = 1e-9
DEGREES = (1, 2, 4)
PLACES = 0.11 * np.array([[0.0, 0.0], [0.3, -0.8], [-0.7, 0.1], [0.5, 0.5], [-0.2, -0.9]])


@pytest.fixture(params=[0.0, 0.05, 0.1], ids=["solid", "bored", "thin"])
def bore(request):
    return request.param


@pytest.fixture(params=DEGREES)
def motions(request, bore):
    return SectionMotions(request.param, 0.11, bore)


def test_amplitudes_of_rigid_motions_are_means(motions):
    """Means over the ring, by adding up a fine grid of places: an integration of its own."""
    radii = np.sqrt(np.linspace(motions.bore**2, motions.radius**2, 400, endpoint=False))
    radii = np.sqrt(radii**2 + 0.5 * (motions.radius**2 - motions.bore**2) / 400)
    angles = 2.0 * np.pi * np.arange(64) / 64
    places = np.stack(
        [np.outer(radii, np.cos(angles)), np.outer(radii, np.sin(angles))], axis=-1
    ).reshape(-1, 2)
    fields = motions.fields(places)
    products = np.einsum("qak,qal->kl", fields, fields) / len(places)
    beyond = products[6:, 6:]
    assert beyond == close(np.eye(len(beyond)), abs=1e-4)
    sizes = np.sqrt(np.diag(products)[:6])
    assert products[:6, 6:] / sizes[:, None] == close(np.zeros((6, len(beyond))), abs=1e-4)


def test_all_polynomials_and_no_more(motions):
    count = 3 * (motions.degree + 1) * (motions.degree + 2) // 2
    fields = motions.fields(np.random.default_rng(0).uniform(-0.1, 0.1, (200, 2))).reshape(600, -1)
    assert fields.shape[1] == motions.count == count
    assert np.linalg.matrix_rank(fields / np.linalg.norm(fields, axis=0), tol=1e-7) == count


def test_degrees_are_nested(bore):
    whole = SectionMotions(4, 0.11, bore)
    for sections in (1, 2):
        lower = whole.up_to(sections)
        assert np.array_equal(
            whole.fields(PLACES)[:, :, : lower.count], lower.fields(PLACES)
        ) or whole.fields(PLACES)[:, :, : lower.count] == close(lower.fields(PLACES), abs=1e-9)


def test_mirrors_keep_motions_or_reverse_them(motions):
    fields = motions.fields(PLACES)
    mirrored = motions.fields(PLACES * (-1.0, 1.0)) * np.array([-1.0, 1.0, 1.0])[:, None]
    size = np.abs(fields).max(axis=(0, 1))
    assert mirrored / size == close(fields * motions.mirror_x / size, abs=1e-9)
    turned_over = fields * np.array([1.0, 1.0, -1.0])[:, None]
    assert turned_over == close(fields * motions.mirror_z)


def test_turned_sections_have_the_same_motions(motions):
    angle = 0.7
    cosine, sine = np.cos(angle), np.sin(angle)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    # The displacement of a place, turned with the section, at where the place goes.
    expected = turn @ motions.fields(PLACES)
    both = section_turn(motions, angle)
    left = np.r_[:6, 12 : 12 + motions.bending]
    found = motions.fields(PLACES @ turn[:2, :2].T) @ both[np.ix_(left, left)]
    assert found == close(expected, abs=1e-8 * np.abs(expected).max())


def test_another_ring_is_an_exact_change_of_motions(motions):
    other = replace(motions, radius=0.09, bore=0.02)
    amplitudes = motions.amplitudes_of(other)
    assert motions.fields(PLACES) @ amplitudes == close(other.fields(PLACES), abs=1e-8)
    assert amplitudes[:, :6] == close(np.eye(motions.count)[:, :6], abs=1e-8)
    both = both_ends(amplitudes)
    assert both[:6, :6] == close(np.eye(6), abs=1e-12)
    assert not both[:6, 6:12].any()


@pytest.mark.parametrize("given", ["bending", 3, 0, True, 2.5, None])
def test_other_choices_are_refused(given):
    with pytest.raises(InputError, match=r'^sections: given .*; allowed are "rigid", 1, 2 and 4'):
        degree_of(given)


@pytest.fixture(scope="module")
def solved(mesh, half_mesh, full_mesh):
    """Classes and superelement by part and degree."""
    found = {}
    for one, degrees in ((mesh, DEGREES), (half_mesh, (2,)), (full_mesh, (2,))):
        matrix = assemble_stiffness(one.points, one.elements, STEEL)
        pins = unit_pin_loads(one)
        for degree in degrees:
            classes = [
                condense(one, matrix, pins, part, degree=degree)
                for part in symmetry_classes(one.part)
            ]
            found[one.part, degree] = classes, combine_classes(classes)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("degree", DEGREES)
def test_rigid_motions_symmetry_and_reciprocity(solved, rigid_motions, degree):
    classes, rigid = solved["quarter", degree]
    joined = rigid.joined
    size = np.abs(joined.stiffness).max()
    assert np.abs(joined.stiffness[:, :12] @ rigid_motions).max() <= ROUND_OFF * size
    assert np.abs(joined.stiffness - joined.stiffness.T).max() <= 1e-14 * size
    values = np.linalg.eigvalsh(joined.stiffness)
    assert np.abs(values[:6]).max() <= ROUND_OFF * values[-1]
    assert values[6] > 1e-7 * values[-1]
    by_forces = superelement_of_end_forces(classes, rigid.radials).joined
    assert np.abs(by_forces.stiffness - joined.stiffness).max() <= ROUND_OFF * size
    largest = np.abs(joined.pin_loads).max()
    assert np.abs(by_forces.pin_loads - joined.pin_loads).max() <= ROUND_OFF * largest
    # A unit force on the pin is in equilibrium with what holds the ends, which do not bend rigidly.
    assert rigid_motions[:, :3].T @ joined.pin_loads[0, :12, :3] == close(np.eye(3), abs=1e-9)


@pytest.mark.slow
def test_rigid_sections_are_part_of_those_that_bend(solved, superelement):
    for degree in DEGREES:
        found = solved["quarter", degree][1]
        size = np.abs(superelement.stiffness).max()
        assert np.abs(found.stiffness - superelement.stiffness).max() <= ROUND_OFF * size
        lower = solved["quarter", 4][1].with_sections(degree).joined
        assert np.abs(lower.stiffness - found.joined.stiffness).max() <= 1e-7 * size
    assert solved["quarter", 4][1].with_sections("rigid").joined.stiffness.shape == (12, 12)
    with pytest.raises(InputError, match=r"^sections: given 4; allowed is up to 2 \(rigid, 1, 2\)"):
        solved["quarter", 2][1].with_sections(4)


@pytest.mark.slow
@pytest.mark.parametrize("part", ["half", "full"])
def test_parts_have_the_same_superelement(solved, part):
    own, other = (solved[name, 2][1].joined for name in ("quarter", part))
    sizes = np.sqrt(np.diag(own.stiffness))
    assert np.abs(own.stiffness - other.stiffness).max() <= 1e-8 * sizes.max() ** 2
    assert other.pin_loads == close(own.pin_loads, abs=1e-7)


@pytest.mark.slow
def test_more_motions_soften(solved):
    for step in (0.0, 60.0, 180.0):
        axial = [
            support_throw(
                solved["quarter", 4][1].with_sections(sections), Neighbors(step, step)
            ).axial
            for sections in ("rigid", *DEGREES)
        ]
        assert np.all(np.diff(axial) > -ROUND_OFF * axial[0])
        assert 1e-3 < axial[-1] / axial[0] - 1.0 < 0.03


@pytest.mark.slow
def test_helix_is_a_long_chain(solved):
    found = solved["quarter", 2][1]
    for support in (Neighbors(120.0, 120.0), Neighbors(120.0, 120.0 + 1e-9)):
        answers = support_throw(found, support)
        assert answers.axial == close(support_throw(found, Neighbors(120.0, 120.0)).axial, rel=1e-8)
        assert end_motions(found, support).shape == (12, 8)
    shaft = shaft_compliances([found] * 15, crank_angles_deg=120.0 * np.arange(15))
    assert shaft.axial[7] == close(answers.axial, rel=1e-3)


@pytest.mark.slow
def test_reactions_between_neighbors_balance_the_force(solved):
    found = solved["quarter", 2][1]
    for load in (
        found.joined.pin_loads[0] @ [0, 0, 1.0, 0, 0, 0],
        found.joined.end_load([1.0, 2.0, 0.0]),
    ):
        there = reactions(found, Neighbors(120.0, 90.0), load)
        total = there.left.force + there.right.force
        applied = load[:6] + load[6:12]
        assert total == close(-applied[:3], abs=1e-8 * np.abs(applied).max())


@pytest.mark.slow
def test_fields_are_those_of_the_given_motions(solved, mesh):
    classes, rigid = solved["quarter", 2]
    sections = rigid.joined.sections
    nodes = np.flatnonzero(mesh.points[:, 2] == 0.0)
    given = np.zeros(2 * sections.count)
    given[12 + 3] = 1.0
    field = displacement_field(classes, given)[nodes]
    assert field == close(sections.fields(mesh.points[nodes])[:, :, 9], abs=1e-12)


@pytest.mark.slow
def test_neighbors_of_other_degree_and_bore_share_the_lower_and_the_wider(solved):
    four, two = solved["quarter", 4][1], solved["quarter", 2][1]
    ring = replace(two.joined.sections, bore=0.05)
    wide = replace(two, bending=two.joined.shared_with(ring))
    shared = sharing_sections([four, wide])
    assert [one.sections for one in shared] == [ring, ring]
    # Pinned axially and laterally at mean motions over other rings, the shaft is nearly the same.
    angles = [0.0, 120.0, 240.0]
    one, other = (
        shaft_compliances(row, crank_angles_deg=angles) for row in ([two] * 3, [four, wide, two])
    )
    assert other.axial == close(one.axial, rel=2e-3)
    assert not np.array_equal(other.axial, one.axial)


def test_rings_of_a_long_study_are_not_all_kept():
    for share in np.linspace(0.1, 0.8, 3 * KEPT):
        SectionMotions(2, 0.11, 0.11 * share).fields(np.zeros((1, 3)))
    assert _ring.cache_info().currsize == _basis.cache_info().currsize == KEPT


@pytest.mark.slow
def test_analysis_tells_what_rigid_sections_leave_out(throw):
    found = analyze_throw(throw, accuracy=0.1)
    assert found.sections == 2
    step = Neighbors(180.0, 180.0)
    rigid = found.with_sections("rigid")
    assert rigid.sections == "rigid"
    assert rigid.axial_compliance(step) == close(found.axial_compliance(), rel=1e-8)
    left_out = found.axial_compliance(step) - found.axial_compliance()
    assert found.section_errors().axial == close(left_out, rel=1e-5)
    assert found.section_error == close(left_out / found.axial_compliance(), rel=1e-5)
    assert 0.003 < found.section_error < 0.006
    assert rigid.section_error == 0.0
    assert found.section_errors(step).axial == close(left_out, rel=1e-5)
    assert analyze_throw(throw, accuracy=0.1, sections="rigid").sections == "rigid"
