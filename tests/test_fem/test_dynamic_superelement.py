"""Superelements with modes and with motions of their sections, against the whole mesh."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, eigsh

from comparing import close
from condensed_parts import of_modes
from dynamic_shaft import assemble_dynamic_shaft, natural_modes
from fem.analysis import analyze_throw
from fem.material import STEEL
from fem.modes import dynamic_superelement, free_modes, frequencies_of
from fem.solver import assemble_mass, assemble_stiffness, factorize, symmetric_product
from fem.superelement import (
    assemble_shaft,
    combine_classes,
    condense,
    hold_ends,
    nodes_on,
    shaft_compliances,
    sharing_sections,
)
from fem.supports import Neighbors
from fem.symmetry import (
    KEPT,
    SectionMotions,
    _basis,
    _ring,
    both_ends,
    degree_of,
    symmetry_classes,
    unit_pin_loads,
)
from geometry.mesh import mesh_throw
from geometry.solid import LEFT_END, RIGHT_END
from refusals import refused

HIGHEST = 2500.0


@pytest.fixture(scope="module")
def coarse(throw):
    return mesh_throw(throw, 6.0)


@pytest.fixture(scope="module")
def coarse_classes(coarse, condensed):
    return condensed(coarse)[0]


@pytest.fixture(scope="module")
def dynamic(coarse, coarse_classes):
    return dynamic_superelement(coarse, STEEL, coarse_classes, HIGHEST)


@pytest.fixture(scope="module")
def plain(coarse, coarse_classes):
    """Many natural modes and no corrections."""
    return dynamic_superelement(
        coarse, STEEL, coarse_classes, HIGHEST, cutoff_factor=4.0, corrections=False
    )


@dataclass
class Whole:
    mesh: object
    stiffness: sparse.csr_array
    mass: sparse.csr_array
    motions: sparse.csr_array  # (3 n, 12 + inner): rigid end sections and all inner unknowns


@pytest.fixture(scope="module")
def whole(coarse, mirror):
    mesh = mirror(mirror(coarse))
    count = len(mesh.points)
    ends = np.zeros((count, 3, 12))
    inner = np.ones(count, dtype=bool)
    for place, name in enumerate((LEFT_END, RIGHT_END)):
        nodes = nodes_on(mesh, name)
        inner[nodes] = False
        arms = mesh.points[nodes] * (1.0, 1.0, 0.0)
        for axis in range(3):
            ends[nodes, axis, 6 * place + axis] = 1.0
            ends[nodes, :, 6 * place + 3 + axis] = np.cross(np.eye(3)[axis], arms)
    unknowns = sparse.eye_array(3 * count, format="csc")[:, np.repeat(inner, 3)]
    return Whole(
        mesh,
        assemble_stiffness(mesh.points, mesh.elements, STEEL),
        assemble_mass(mesh.points, mesh.elements, STEEL.density),
        sparse.hstack([sparse.csc_array(ends.reshape(-1, 12)), unknowns]).tocsr(),
    )


def full(upper):
    return upper + sparse.triu(upper, k=1).T


@pytest.fixture(scope="module")
def truth(whole):
    """Frequencies of the free throw with rigid end sections, from its whole mesh."""
    stiffness, mass = (
        (whole.motions.T @ full(each) @ whole.motions).tocsr()
        for each in (whole.stiffness, whole.mass)
    )
    shift = 1e7
    with factorize(sparse.triu(stiffness + shift * mass, format="csr")) as factors:
        inverse = LinearOperator(
            stiffness.shape, lambda side: factors.solve(side[:, None])[:, 0], dtype=float
        )
        start = np.random.default_rng(0).normal(size=stiffness.shape[0])
        squares = eigsh(
            stiffness, 24, mass, sigma=-shift, OPinv=inverse, v0=start, return_eigenvectors=False
        )
    return frequencies_of(np.sort(squares))[6:]


def of_free_throw(superelement):
    return natural_modes(superelement.stiffness, superelement.mass)[0][6:]


@pytest.mark.slow
def test_matrices_are_those_of_the_displacement_fields(whole, condensed):
    """The whole mesh has one class and no shares or copies: stiffness and mass by their definition."""
    classes, static = condensed(whole.mesh)
    found = dynamic_superelement(whole.mesh, STEEL, classes, HIGHEST)
    fields = np.concatenate([classes[0].fields, found.shapes], axis=2)
    columns = fields.reshape(whole.mesh.unknowns, -1)
    size = np.sqrt(np.diag(found.mass))
    mass = columns.T @ symmetric_product(whole.mass, columns)
    assert found.mass / np.outer(size, size) == close(mass / np.outer(size, size), abs=1e-9)
    stiffness = columns.T @ symmetric_product(whole.stiffness, columns)
    size = np.sqrt(np.diag(found.stiffness))
    assert found.stiffness / np.outer(size, size) == close(
        stiffness / np.outer(size, size), abs=1e-8
    )
    assert found.stiffness[:12, :12] == close(static.stiffness, rel=1e-9, abs=1.0)
    works = np.array(
        [
            np.einsum("sac,sak->kc", load.of_class(classes[0].symmetry), fields[load.nodes])
            for load in unit_pin_loads(whole.mesh)
        ]
    )
    assert found.pin_loads == close(works, abs=1e-8 * np.abs(works).max())
    ends = np.concatenate([nodes_on(whole.mesh, LEFT_END), nodes_on(whole.mesh, RIGHT_END)])
    assert np.abs(found.shapes[ends]).max() == 0.0


@pytest.mark.slow
def test_each_part_gives_the_same(coarse, mirror, condensed, dynamic, whole):
    for mesh in (mirror(coarse), whole.mesh):
        other = dynamic_superelement(mesh, STEEL, condensed(mesh)[0], HIGHEST)
        assert other.natural == dynamic.natural
        assert other.frequencies == close(dynamic.frequencies, rel=1e-8)
        size = np.sqrt(np.diag(dynamic.mass))[:12]
        assert other.mass[:12, :12] / np.outer(size, size) == close(
            dynamic.mass[:12, :12] / np.outer(size, size), abs=1e-9
        )
        # Signs of shapes are free.
        coupling = np.abs(dynamic.mass[:12, 12:])
        tolerance = 1e-6 * coupling.max()
        assert np.abs(other.mass[:12, 12:]) == close(coupling, abs=tolerance)
        works = np.abs(dynamic.pin_loads)
        for unknowns in (slice(0, 12), slice(12, None)):
            tolerance = 1e-6 * works[:, unknowns].max()
            assert np.abs(other.pin_loads[:, unknowns]) == close(works[:, unknowns], abs=tolerance)
        assert of_free_throw(other) == close(of_free_throw(dynamic), rel=1e-8)


def test_corrections_are_worth_many_modes(coarse, coarse_classes, plain, truth):
    """Twelve corrections and no mode leave 4e-5 in the first two frequencies, twelve modes 4e-3."""
    alone = dynamic_superelement(coarse, STEEL, coarse_classes, 500.0)
    assert alone.natural == 0
    assert len(alone.frequencies) == 12
    corrected = of_free_throw(alone)[:2] / truth[:2] - 1.0
    modal = of_free_throw(of_modes(plain, 12))[:2] / truth[:2] - 1.0
    assert np.all(corrected < 1e-4)
    assert modal.max() > 10.0 * corrected.max()


@pytest.mark.slow
def test_rigid_end_sections_make_the_free_throw_stiffer(coarse, truth):
    """Each frequency rises, by some per cent at most in the lowest modes."""
    ratio = truth[:6] / free_modes(coarse, STEEL, count=6).frequencies
    assert np.all(ratio > 1.0)
    assert ratio.max() < 1.1


def test_no_highest_frequency_is_guyans(coarse, coarse_classes, dynamic, monkeypatch):
    monkeypatch.setattr("fem.solver.SharedSolver.factorize", None)  # there is nothing to factorize
    guyan = dynamic_superelement(coarse, STEEL, coarse_classes, 0.0)
    assert guyan.stiffness.shape == guyan.mass.shape == (12, 12)
    assert guyan.frequencies.shape == (0,)
    assert guyan.shapes.shape == (len(coarse.points), 3, 0)
    cut = of_modes(dynamic, 0)
    assert np.array_equal(cut.mass, guyan.mass)
    assert np.array_equal(cut.stiffness, guyan.stiffness)
    assert np.array_equal(cut.pin_loads, guyan.pin_loads)


def test_shaft_of_throws(dynamic, plain, coarse_classes):
    angles = [0.0, 2.1, 0.4]
    throws = [
        each.turned(angle_deg=np.degrees(angle))
        for each, angle in zip([dynamic, plain, dynamic], angles, strict=True)
    ]
    stiffness, mass = assemble_dynamic_shaft(throws)
    inside = [len(throw.frequencies) for throw in throws]
    assert len(stiffness) == 24 + sum(inside)
    static = combine_classes(coarse_classes)
    expected = assemble_shaft([static.turned(angle_deg=math.degrees(angle)) for angle in angles])
    tolerance = 1e-9 * expected.max()
    assert stiffness[:24, :24] == close(expected, abs=tolerance)
    # What is inside of a throw knows its own ends only.
    second = slice(24 + inside[0], 24 + inside[0] + inside[1])
    assert np.array_equal(mass[6:18, second], throws[1].mass[:12, 12:])
    assert not mass[:6, second].any()
    assert not mass[18:24, second].any()
    assert np.array_equal(mass[second, second], np.eye(inside[1]))
    frequencies, _ = natural_modes(stiffness, mass)
    assert frequencies[5] < 1e-3 * frequencies[6]
    # Pushed along the shaft, all moves as one.
    push = np.zeros(len(mass))
    push[2:24:6] = 1.0
    assert push @ mass @ push == close(3.0 * of_modes(dynamic, 0).mass[2::6, 2::6].sum())


def test_supports_hold_unknowns_at_zero(dynamic):
    held = [0, 1, 6, 7]
    frequencies, shapes = natural_modes(dynamic.stiffness, dynamic.mass, held)
    assert not shapes[held].any()
    assert len(frequencies) == len(dynamic.mass) - 4
    assert np.count_nonzero(frequencies < 1e-3 * frequencies[-1]) == 2


@pytest.mark.slow
def test_another_solver_gives_the_same(coarse, coarse_classes, dynamic):
    found = dynamic_superelement(coarse, STEEL, coarse_classes, HIGHEST, solver="superlu")
    assert found.frequencies == close(dynamic.frequencies, rel=1e-9)


def test_what_cannot_be_built_is_refused(coarse, coarse_classes, dynamic, mesh, stiffness):
    for value in (-1.0, np.inf, np.nan):
        with refused("highest_frequency"):
            dynamic_superelement(coarse, STEEL, coarse_classes, value)
    with refused("cutoff_factor"):
        dynamic_superelement(coarse, STEEL, coarse_classes, 100.0, cutoff_factor=0.9)
    with refused("classes"):
        dynamic_superelement(coarse, STEEL, coarse_classes[:3], 100.0)
    with refused("classes"):
        dynamic_superelement(coarse, STEEL, [*coarse_classes, coarse_classes[0]], 100.0)
    with refused("classes"):
        dynamic_superelement(mesh, STEEL, coarse_classes, 100.0)


def test_averaged_end_sections_are_refused(coarse, coarse_classes):
    matrix = assemble_stiffness(coarse.points, coarse.elements, STEEL)
    pins = unit_pin_loads(coarse)
    averaged = [
        condense(coarse, matrix, pins, each, end_sections="averaged")
        for each in symmetry_classes(coarse.part)
    ]
    with refused("classes"):
        dynamic_superelement(coarse, STEEL, averaged, 100.0)
    mixed = [*coarse_classes[:3], replace(coarse_classes[3], end_sections="averaged")]
    with refused("classes"):
        dynamic_superelement(coarse, STEEL, mixed, 100.0)


@pytest.mark.parametrize("frequency", [None, "x", [1.0], 1j, True, -1.0, np.nan, 1e9])
def test_frequencies_that_are_none_are_refused(mesh, classes, frequency):
    with refused("highest_frequency"):
        dynamic_superelement(mesh, STEEL, classes, frequency)


DEGREES = (1, 2, 4)
PLACES = 0.11 * np.array([[0.0, 0.0], [0.3, -0.8], [-0.7, 0.1], [0.5, 0.5], [-0.2, -0.9]])


@pytest.fixture(params=[0.0, 0.05, 0.1], ids=["solid", "bored", "thin"])
def bore(request):
    return request.param


@pytest.fixture(params=DEGREES)
def motions(request, bore):
    return SectionMotions(request.param, 0.11, bore)


def test_all_polynomials_and_no_more(motions):
    count = 3 * (motions.degree + 1) * (motions.degree + 2) // 2
    fields = motions.fields(np.random.default_rng(0).uniform(-0.1, 0.1, (200, 2))).reshape(600, -1)
    assert fields.shape[1] == motions.count == count
    assert np.linalg.matrix_rank(fields / np.linalg.norm(fields, axis=0), tol=1e-7) == count


def test_another_ring_is_an_exact_change_of_motions(motions):
    other = replace(motions, radius=0.09, bore=0.02)
    assert np.array_equal(motions.amplitudes_of(motions), np.eye(motions.count))
    amplitudes = motions.amplitudes_of(other)
    assert motions.fields(PLACES) @ amplitudes == close(other.fields(PLACES), abs=1e-8)
    assert amplitudes[:, :6] == close(np.eye(motions.count)[:, :6], abs=1e-8)
    both = both_ends(amplitudes)
    assert both[:6, :6] == close(np.eye(6), abs=1e-12)
    assert not both[:6, 6:12].any()


@pytest.mark.parametrize("given", ["bending", 3, 0, True, 2.5, None])
def test_other_choices_are_refused(given):
    with refused("sections"):
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
                condense(one, matrix, pins, part, held=hold_ends(one, matrix, degree))
                for part in symmetry_classes(one.part)
            ]
            found[one.part, degree] = classes, combine_classes(classes)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("part", ["half", "full"])
def test_parts_have_the_same_superelement(solved, part):
    own, other = (solved[name, 2][1].joined for name in ("quarter", part))
    sizes = np.sqrt(np.diag(own.stiffness))
    assert np.abs(own.stiffness - other.stiffness).max() <= 1e-8 * sizes.max() ** 2
    assert other.pin_loads == close(own.pin_loads, abs=1e-7)


@pytest.mark.slow
def test_neighbors_of_other_degree_and_bore_share_the_lower_and_the_wider(solved):
    four, two = solved["quarter", 4][1], solved["quarter", 2][1]
    ring = replace(two.joined.sections, bore=0.05)
    wide = replace(two, bending=two.joined.shared_with(ring))
    assert [one.sections for one in sharing_sections([four, wide])] == [ring, ring]
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


ROUND_OFF = 1e-9


@pytest.mark.slow
def test_rigid_sections_are_part_of_those_that_bend(solved, superelement):
    for degree in DEGREES:
        found = solved["quarter", degree][1]
        size = np.abs(superelement.stiffness).max()
        assert np.abs(found.stiffness - superelement.stiffness).max() <= ROUND_OFF * size
        lower = solved["quarter", 4][1].with_sections(degree).joined
        assert np.abs(lower.stiffness - found.joined.stiffness).max() <= 1e-7 * size
    assert solved["quarter", 4][1].with_sections("rigid").joined.stiffness.shape == (12, 12)
    with refused("sections"):
        solved["quarter", 2][1].with_sections(4)
