"""The superelement from quarters, against one condensation of the whole mirrored mesh."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import splu

from comparing import close
from fem.assembly import assemble_stiffness
from fem.condensation import nodes_on
from fem.loads import uniform_pin_loads
from fem.material import STEEL
from fem.superelement import section_rotation
from fem.supports import reactions, support_throw
from fem.symmetry import symmetry_classes
from geometry.shapes import smallest_jacobians
from geometry.solid import CRANK_PLANE, LEFT_END, MIDDLE_PLANE


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


def test_whole_mesh_condensed_at_once_gives_the_same(whole, superelement):
    inner, motions = whole.inner(), whole.end_motions()
    loads = np.asarray(whole.matrix @ motions)
    motions[inner] = -factorize(whole.matrix[inner][:, inner]).solve(loads[inner])
    stiffness = motions.T @ (whole.matrix @ motions)
    pin_load = motions.T @ whole.pin_loads()
    size = np.sqrt(np.outer(np.diag(stiffness), np.diag(stiffness)))
    assert np.abs(superelement.stiffness - stiffness).max() <= 1e-8 * np.abs(stiffness).max()
    assert (np.abs(superelement.stiffness - stiffness) / size).max() <= 1e-8
    assert superelement.pin_load == close(pin_load, abs=1e-8)


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


def test_symmetric_and_semidefinite_with_six_rigid_motions(superelement, rigid_motions):
    stiffness = superelement.stiffness
    assert np.array_equal(stiffness, stiffness.T)
    residual = np.linalg.norm(stiffness @ rigid_motions)
    assert residual <= 1e-9 * np.linalg.norm(stiffness)
    values = np.linalg.eigvalsh(stiffness)
    assert np.abs(values[:6]).max() <= 1e-9 * values[6]
    assert values[6] > 1e-4 * values[-1]


def test_pin_load_is_in_equilibrium(superelement, rigid_motions, throw, mesh, pin_shapes):
    """It works on rigid motions as a force at the pin's middle does."""
    height = pin_shapes[0] @ mesh.points[:, 1]
    assert height == close(throw.crank_radius, rel=1e-4)
    arm = np.array([0.0, height, throw.length / 2.0])
    for column in range(3):
        force = np.eye(3)[column]
        expected = np.concatenate([force, np.cross(arm, force) / throw.crank_radius])
        found = rigid_motions.T @ superelement.pin_load[:, column]
        assert found == close(expected, abs=1e-9)


def test_uniform_pin_load(mesh, pin_shapes, throw):
    assert pin_shapes.sum() == close(1.0, rel=1e-14)
    carrying = np.abs(pin_shapes[0]) > 1e-14
    radius = np.hypot(mesh.points[:, 0], mesh.points[:, 1] - throw.crank_radius)
    assert radius[carrying] == close(throw.pin_diameter / 2.0, rel=1e-2)  # straightened edges
    carrying[np.unique(mesh.elements[:, 4:])] = False
    assert radius[carrying] == close(throw.pin_diameter / 2.0, rel=1e-9)
    # A quarter of the pin, from its fillet to its middle and over the half turn x > 0.
    x, y, z = pin_shapes[0] @ mesh.points
    assert x == close(throw.pin_diameter / np.pi, rel=1e-3)
    assert y == close(throw.crank_radius, rel=1e-4)
    half = throw.pin_length / 2.0
    assert z == close(throw.length / 2.0 - (half - throw.fillet_radius) / 2.0, rel=1e-4)


def test_shares_are_four_quarters_of_the_whole(whole, pin_shapes, mesh):
    off_planes = np.setdiff1d(
        np.arange(len(mesh.points)),
        np.concatenate([nodes_on(mesh, CRANK_PLANE), nodes_on(mesh, MIDDLE_PLANE)]),
    )
    assert whole.shares.sum() == close(1.0, rel=1e-14)
    assert whole.shares[off_planes] == close(0.25 * pin_shapes[0][off_planes], abs=1e-14)


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
    size = 2.0 if part == "quarter" else 1.0
    assert together.T @ together == close(size * np.eye(12))
    shares = np.vstack([symmetry.shares for symmetry in classes])
    assert together @ shares == close(np.eye(12))


def test_turning(superelement):
    turned = superelement.turned(angle_deg=np.degrees(0.7)).turned(angle_deg=np.degrees(0.5))
    once = superelement.turned(angle_deg=np.degrees(1.2))
    assert turned.stiffness == close(once.stiffness, rel=1e-9, abs=1e-3)
    assert turned.pin_load == close(once.pin_load, abs=1e-12)
    back = superelement.turned(angle_deg=np.degrees(2.0 * np.pi))
    assert back.stiffness == close(superelement.stiffness, rel=1e-9, abs=1e-3)
    rotation = section_rotation(0.3)
    assert rotation @ rotation.T == close(np.eye(6), abs=1e-15)
    # A quarter turn about z takes x to y.
    assert section_rotation(np.pi / 2.0) @ np.eye(6)[0] == close(np.eye(6)[1], abs=1e-15)
