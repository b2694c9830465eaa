"""The consistent mass matrix against scikit-fem's form, closed forms and the throw's own masses."""

import math
from itertools import product

import numpy as np
import pytest
from scipy import sparse
from skfem import Basis, BilinearForm, ElementTetP2, MeshTet1, MeshTet2
from skfem.quadrature import get_quadrature

from comparing import close
from fem.assembly import MASS_QUADRATURE_ORDER, assemble_mass, element_masses, symmetric_product
from geometry.mass import mass_properties, mesh_mass_properties
from geometry.shapes import EDGES, element_quadrature, shapes_for_quadrature

DENSITY = 7850.0


@pytest.fixture(scope="module")
def upper(mesh):
    return assemble_mass(mesh.points, mesh.elements, DENSITY)


def oracle(points, elements):
    """scikit-fem's mass of one displacement component on the same curved mesh, in our numbering."""
    corners = np.unique(elements[:, :4])
    number = np.full(len(points), -1)
    number[corners] = np.arange(len(corners))
    linear = MeshTet1(points[corners].T, number[elements[:, :4]].T)
    middle = {}
    for node, (first, second) in enumerate(EDGES, start=4):
        pairs = np.sort(number[elements[:, [first, second]]], axis=1)
        middle.update(zip(map(tuple, pairs.tolist()), elements[:, node].tolist(), strict=True))
    edge_nodes = np.array([middle[tuple(sorted(edge))] for edge in linear.edges.T.tolist()])
    curved = MeshTet2(points[np.concatenate([corners, edge_nodes])].T, linear.t)
    basis = Basis(curved, ElementTetP2(), intorder=MASS_QUADRATURE_ORDER)
    matrix = BilinearForm(lambda u, v, _: DENSITY * u * v).assemble(basis).tocoo()
    ours = np.full(basis.N, -1)
    ours[basis.nodal_dofs[0]] = corners
    ours[basis.edge_dofs[0]] = edge_nodes
    return sparse.csr_array((matrix.data, (ours[matrix.row], ours[matrix.col])), matrix.shape)


def test_mass_is_scikit_fems(mesh, upper):
    expected = oracle(mesh.points, mesh.elements)
    assert sparse.tril(upper, k=-1).nnz == 0
    full = upper + sparse.triu(upper, k=1).T
    # Round-off of some hundred additions.
    assert abs(full - sparse.kron(expected, sparse.eye_array(3))).max() <= 1e-13 * full.max()


def test_batches_give_the_same(mesh, upper, monkeypatch):
    monkeypatch.setattr("fem.assembly.CHUNK", 37)
    assert (
        abs(upper - assemble_mass(mesh.points, mesh.elements, DENSITY)).max()
        <= 1e-13 * abs(upper).max()
    )


def test_a_straight_element_has_its_closed_form():
    """Integrals of products of barycentric coordinates: a! b! c! d! 6 V / (a + b + c + d + 3)!."""
    corners = np.random.default_rng(2).normal(size=(4, 3))
    if np.linalg.det(corners[1:] - corners[0]) < 0.0:
        corners = corners[[1, 0, 2, 3]]
    points = np.vstack([corners, [0.5 * (corners[a] + corners[b]) for a, b in EDGES]])
    volume = np.linalg.det(corners[1:] - corners[0]) / 6.0
    ((_, found),) = element_masses(points, np.arange(10)[None], DENSITY)
    nodes = [{a} for a in range(4)] + [set(edge) for edge in EDGES]
    expected = np.empty((10, 10))
    for i, first in enumerate(nodes):
        for j, second in enumerate(nodes):
            common = len(first & second)
            expected[i, j] = {
                (1, 1): (1.0, 6.0),
                (1, 2): (-6.0, -4.0),
                (2, 1): (-6.0, -4.0),
                (2, 2): (8.0, 16.0, 32.0),
            }[len(first), len(second)][common]
    assert found[0] == close(DENSITY * volume / 420.0 * expected, rel=1e-12)


def test_the_rule_is_exact_to_seventh_order():
    """Integrals of x^a y^b z^c over the reference element: a! b! c! / (a + b + c + 3)!."""
    where, weights = get_quadrature(MeshTet1.elem.refdom, MASS_QUADRATURE_ORDER)
    for powers in product(range(8), repeat=3):
        if sum(powers) <= 7:
            exact = math.prod(map(math.factorial, powers)) / math.factorial(sum(powers) + 3)
            found = weights @ np.prod(where.T**powers, axis=1)
            assert found == close(exact, rel=1e-12)


def test_a_curved_element_is_integrated_exactly():
    """The next finer rule finds the same; the next coarser one, exact to sixth order, does not."""
    points = np.vstack([np.zeros(3), np.eye(3)])
    points = np.vstack([points, [0.5 * (points[a] + points[b]) for a, b in EDGES]])
    points[4:] += np.random.default_rng(5).uniform(-0.1, 0.1, (6, 3))
    elements = np.arange(10)[None]
    ((_, found),) = element_masses(points, elements, 1.0)

    def by_rule(order):
        values = shapes_for_quadrature(order)[0]
        return (values.T * element_quadrature(points, elements, order)[1]) @ values

    exact = by_rule(9)
    assert found[0] == close(exact, abs=1e-13 * exact.max())
    assert np.abs(by_rule(7) - exact).max() > 1e-6 * exact.max()
    assert np.linalg.eigvalsh(found[0]).min() > 0.0


def test_rigid_motions_have_the_throws_mass_and_inertia(mesh, full_mesh):
    """Exact for the mesh; geometry's rule leaves 1e-9 in second moments, the solid has 0.05 % more."""
    matrix = assemble_mass(full_mesh.points, full_mesh.elements, DENSITY)
    expected = mesh_mass_properties(full_mesh, DENSITY)
    arms = full_mesh.points - expected.center
    motions = np.zeros((len(arms), 3, 6))
    motions[:, :, :3] = np.eye(3)
    for axis in range(3):
        motions[:, :, 3 + axis] = np.cross(np.eye(3)[axis], arms)
    columns = motions.reshape(-1, 6)
    inertia = columns.T @ symmetric_product(matrix, columns)
    assert inertia[:3, :3] == close(expected.mass * np.eye(3), abs=1e-12 * expected.mass)
    size = full_mesh.length * expected.mass
    assert inertia[:3, 3:] == close(np.zeros((3, 3)), abs=1e-12 * size)
    tolerance = 2e-9 * np.abs(expected.inertia).max()
    assert inertia[3:, 3:] == close(expected.inertia, abs=tolerance)
    solid = mass_properties(mesh, DENSITY)
    assert inertia[0, 0] == close(solid.mass, rel=1e-3)
    assert np.diag(inertia)[3:] == close(np.diag(solid.inertia), rel=1e-3)
