"""The superelement from quarters, its supports and limits."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import splu

from comparing import close
from condensed_parts import torsional_compliance
from crankfem.analyses.throw.throw_record import reciprocity
from fem.analysis import analyze_throw
from fem.material import STEEL
from fem.solver import assemble_stiffness
from fem.superelement import (
    RZ,
    UX,
    UY,
    UZ,
    assemble_shaft,
    nodes_on,
    superelement_of_end_forces,
)
from fem.supports import (
    Neighbors,
    class_axial_compliances,
    reactions,
    support_throw,
)
from fem.symmetry import symmetry_classes, uniform_pin_loads
from geometry.shapes import smallest_jacobians
from geometry.solid import LEFT_END
from geometry.throw import CrankThrow
from refusals import refused
from throws import MEDIUM_SPEED


@dataclass
class Whole:
    points: np.ndarray
    elements: np.ndarray
    matrix: sparse.csc_array
    shares: np.ndarray
    ends: tuple

    def end_motions(self):
        """Sparse (3 n, 12): displacements of the end nodes for unit motions of the sections."""
        motions = np.zeros((len(self.points), 3, 12))
        for place, nodes in enumerate(self.ends):
            arms = self.points[nodes] * (1.0, 1.0, 0.0)
            for axis in range(3):
                motions[nodes, axis, 6 * place + axis] = 1.0
                motions[nodes, :, 6 * place + 3 + axis] = np.cross(np.eye(3)[axis], arms)
        return motions.reshape(-1, 12)

    def pin_loads(self):
        return np.kron(self.shares[:, None], np.eye(3))

    def inner(self):
        nodes = np.setdiff1d(np.arange(len(self.points)), np.concatenate(self.ends))
        return (3 * nodes[:, None] + np.arange(3)).ravel()


@pytest.fixture(scope="module")
def whole(full_mesh):
    points, elements = full_mesh.points, full_mesh.elements
    assert len(np.unique(points.round(9), axis=0)) == len(points)
    assert smallest_jacobians(points, elements).min() > 0.0
    upper = assemble_stiffness(points, elements, STEEL)
    return Whole(
        points,
        elements,
        sparse.csc_array(upper + sparse.triu(upper, k=1).T),
        uniform_pin_loads(full_mesh)[0],
        tuple(np.flatnonzero(np.abs(points[:, 2] - z) < 1e-12) for z in (0.0, full_mesh.length)),
    )


def factorize(matrix):
    return splu(
        sparse.csc_matrix(matrix),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )


@pytest.mark.slow
@pytest.mark.parametrize("support", ["pinned", "guided"])
def test_direct_solve_with_blocked_length_gives_the_reactions(whole, superelement, support):
    """One solve of the whole throw under pin forces, the end sections supported directly."""
    free = [3, 4, 9, 10, 11] if support == "pinned" else [11]
    inner, motions = whole.inner(), whole.end_motions()
    reduction = sparse.hstack(
        [
            sparse.csc_array(sparse.identity(len(motions), format="csc"))[:, inner],
            sparse.csc_array(motions[:, free]),
        ],
        format="csc",
    )
    loads = whole.pin_loads()
    reduced = factorize(reduction.T @ whole.matrix @ reduction)
    displacements = reduction @ reduced.solve(np.asarray(reduction.T @ loads))
    residual = motions.T @ (whole.matrix @ displacements - loads)
    for axis in range(3):
        found = reactions(superelement, support, superelement.end_load(np.eye(3)[axis]))
        both = [*found.left.force, *found.left.moment, *found.right.force, *found.right.moment]
        assert np.array(both) == close(residual[:, axis], abs=1e-8)
    # A radial force Z towards the shaft is answered by a compression of c Z / e_n; here Z = -1.
    answers = support_throw(superelement, support)
    thrust = answers.influence / answers.axial
    assert residual[2, 1] == close(-thrust, rel=1e-6)
    assert residual[8, 1] == close(thrust, rel=1e-6)
    assert thrust > 0.0


def test_fields_move_the_end_as_a_rigid_section(mesh, classes):
    ends = nodes_on(mesh, LEFT_END)
    for part in classes:
        for motion, unknown in enumerate(part.symmetry.end_unknowns):
            axis = np.eye(3)[unknown % 3]
            arms = mesh.points[ends]
            wanted = np.cross(axis, arms) if unknown >= 3 else np.tile(axis, (len(ends), 1))
            assert part.fields[ends, :, motion] == close(wanted, abs=1e-12)


@pytest.mark.parametrize("part", ["quarter", "half", "full"])
def test_the_classes_share_out_all_motions(part):
    classes = symmetry_classes(part)
    assert len(classes) == classes[0].copies
    together = np.hstack([symmetry.ends for symmetry in classes])
    assert together.shape == (12, 12)
    assert together.T @ together == close((2.0 if part == "quarter" else 1.0) * np.eye(12))
    assert together @ np.vstack([symmetry.shares for symmetry in classes]) == close(np.eye(12))


ROUND_OFF = 1e-11

DIMENSIONS = MEDIUM_SPEED | {"main_journal_length": 0.135, "fillet_radius": 0.0}


def beside(one, other):
    return np.max(np.abs(one - other)) / np.max(np.abs(other))


@pytest.mark.slow
@pytest.mark.parametrize("end_sections", ["rigid", "averaged"])
@pytest.mark.parametrize("left_web", [None, {"thickness": 0.05}], ids=["equal webs", "unequal"])
def test_both_ways_to_the_superelement_agree(end_sections, left_web):
    throw = CrankThrow(**(DIMENSIONS | {"left_web": left_web}))
    found = analyze_throw(throw, accuracy=0.1, end_sections=end_sections).discrete
    own = found.superelement
    other = superelement_of_end_forces(found.classes, own.radials)
    assert beside(other.stiffness, own.stiffness) < ROUND_OFF
    assert beside(other.pin_loads, own.pin_loads) < ROUND_OFF
    # They are two calculations, not one.
    assert not np.array_equal(other.pin_loads, own.pin_loads)
    assert all(0.0 < figure < ROUND_OFF for figure in reciprocity(found).to_record().values())


def test_pinned_ends_carry_no_tilting_moment(superelement):
    found = reactions(superelement, "pinned", superelement.end_load(np.array([1e5, -1e5, 1e5])))
    assert found.left.moment[:2] == close([0.0, 0.0], abs=1e-6)
    assert found.right.moment[:2] == close([0.0, 0.0], abs=1e-6)
    # The torque is that of the tangential force.
    assert found.left.moment[2] == close(1e5 * 0.170, rel=1e-4)


def test_reactions_superpose(superelement):
    parts = [reactions(superelement, "guided", superelement.end_load(force)) for force in np.eye(3)]
    both = reactions(superelement, "guided", superelement.end_load(np.array([2.0, -3.0, 5.0])))
    wanted = 2.0 * parts[0].left.moment - 3.0 * parts[1].left.moment + 5.0 * parts[2].left.moment
    assert both.left.moment == close(wanted, rel=1e-10, abs=1e-10)


def test_neighbors_in_line_are_guided(superelement):
    found, guided = (
        support_throw(superelement, Neighbors(0, 0)),
        support_throw(superelement, "guided"),
    )
    assert found.axial == close(guided.axial, rel=1e-9)
    assert found.stretches[0] == close(guided.stretches[0], rel=1e-9, abs=1e-20)
    # Under torque all cranks tilt alike and hold each other nowhere.
    assert found.torsional == close(support_throw(superelement, "pinned").torsional, rel=1e-9)


@pytest.mark.parametrize("support", [Neighbors(120, 120), Neighbors(70, 200)], ids=str)
def test_neighbors_against_a_long_shaft(superelement, support):
    """The middle one of 41 throws assembled one by one, with nothing condensed beforehand."""
    reach = 20
    places = np.arange(-reach, reach + 1)
    steps = np.where(places < 0, support.left_deg, support.right_deg)
    shaft = [
        superelement.turned(angle_deg=np.degrees(angle)) for angle in np.radians(steps * places)
    ]
    loads = np.zeros((6 * (len(shaft) + 1), 5))
    loads[-6 + UZ, 0] = loads[-6 + RZ, 1] = 1.0
    # Each throw's left end takes the torque and the axial push of its own pin.
    ends = superelement.pin_load[:6] + superelement.pin_load[6:]
    for place, part in enumerate(shaft):
        loads[6 * place : 6 * place + 12, 2:] += part.pin_load
        loads[[6 * place + UZ, 6 * place + RZ], 2:] -= ends[[UZ, RZ]]
    # Main bearings hold every section laterally, the first one fully.
    blocked = np.zeros((len(shaft) + 1, 6), dtype=bool)
    blocked[:, [UX, UY]] = True
    blocked[0, [UZ, RZ]] = True
    free = np.flatnonzero(~blocked.ravel())
    motions = np.zeros_like(loads)
    motions[free] = np.linalg.solve(assemble_shaft(shaft)[np.ix_(free, free)], loads[free])
    middle = motions[6 * reach : 6 * reach + 12]
    found = support_throw(superelement, support)
    stretch = middle[6 + UZ] - middle[UZ]
    assert found.axial == close(stretch[0], rel=1e-6)
    assert found.torsional == close((middle[6 + RZ] - middle[RZ])[1], rel=1e-6)
    assert found.stretches[0] == close(stretch[2:], rel=1e-5, abs=1e-14)


@pytest.mark.parametrize("support", ["pinned", "guided"])
def test_two_classes_are_enough_for_these_supports(superelement, classes, support):
    expected = support_throw(superelement, support)
    axial, influence = class_axial_compliances(classes[0], support)
    assert axial == close(expected.axial, rel=1e-10)
    assert influence == close(expected.influence, rel=1e-10)
    assert torsional_compliance(classes[-1], support) == close(expected.torsional, rel=1e-10)


@pytest.mark.parametrize("support", ["free", "", None, 180, "Pinned"])
def test_unknown_support(superelement, support):
    with refused("support"):
        support_throw(superelement, support)


@pytest.mark.parametrize("angle", [math.nan, math.inf, "120 deg", None])
def test_neighbors_take_finite_angles(angle):
    with refused("Neighbors.right_deg"):
        Neighbors(120, angle)
