"""Stiffness and mass matrices, against other assemblies and fields of constant strain."""

import math
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pytest
from scipy import sparse
from skfem import Basis, BilinearForm, ElementTetP2, ElementVector, MeshTet1, MeshTet2
from skfem.models.elasticity import linear_elasticity

from comparing import close
from fem.material import STEEL, Material
from fem.solver import (
    MASS_QUADRATURE_ORDER,
    assemble_mass,
    assemble_stiffness,
    node_blocks,
    physical_gradients,
    symmetric_product,
)
from geometry.mesh import mesh_throw
from geometry.shapes import EDGES, quadrature, shapes_for_quadrature
from geometry.throw import CrankThrow
from solving import solve_symmetric

SOFT = Material(youngs_modulus=7e10, poisson_ratio=0.45, density=2700.0)


def full(upper):
    return upper + sparse.triu(upper, k=1).T


def curved_mesh(points, elements):
    """scikit-fem's mesh of the same elements, with our numbers of its corners and of the nodes on edges."""
    corners = np.unique(elements[:, :4])
    number = np.full(len(points), -1)
    number[corners] = np.arange(len(corners))
    linear = MeshTet1(points[corners].T, number[elements[:, :4]].T)
    middle = {}
    for node, (first, second) in enumerate(EDGES, start=4):
        pairs = np.sort(number[elements[:, [first, second]]], axis=1)
        middle.update(zip(map(tuple, pairs.tolist()), elements[:, node].tolist(), strict=True))
    edge_nodes = np.array([middle[tuple(sorted(edge))] for edge in linear.edges.T.tolist()])
    nodes = np.concatenate([corners, edge_nodes])
    return MeshTet2(points[nodes].T, linear.t), corners, edge_nodes


def oracle(points, elements, material):
    """scikit-fem's own form on the same curved mesh, its unknowns in our numbering."""
    curved, corners, edge_nodes = curved_mesh(points, elements)
    basis = Basis(curved, ElementVector(ElementTetP2()), intorder=2)
    lame = 2.0 * material.shear_modulus * material.poisson_ratio
    lame /= 1.0 - 2.0 * material.poisson_ratio
    matrix = linear_elasticity(lame, material.shear_modulus).assemble(basis).tocoo()
    ours = np.full(basis.N, -1)
    ours[basis.nodal_dofs] = 3 * corners + np.arange(3)[:, None]
    ours[basis.edge_dofs] = 3 * edge_nodes + np.arange(3)[:, None]
    return sparse.csr_array((matrix.data, (ours[matrix.row], ours[matrix.col])), matrix.shape)


@pytest.mark.slow
@pytest.mark.parametrize("material", [STEEL, SOFT])
def test_stiffness_is_scikit_fems(mesh, material):
    upper = assemble_stiffness(mesh.points, mesh.elements, material)
    expected = oracle(mesh.points, mesh.elements, material)
    assert sparse.tril(upper, k=-1).nnz == 0
    assert abs(full(upper) - expected).max() <= 1e-12 * abs(expected).max()


def test_batches_give_the_same(mesh, monkeypatch):
    whole = assemble_stiffness(mesh.points, mesh.elements, STEEL)
    monkeypatch.setattr("fem.solver.CHUNK", 37)
    assert abs(whole - assemble_stiffness(mesh.points, mesh.elements, STEEL)).max() == 0.0


def test_symmetric_product():
    rng = np.random.default_rng(0)
    matrix = rng.normal(size=(7, 7))
    matrix += matrix.T
    upper = sparse.csr_array(np.triu(matrix))
    for vectors in (rng.normal(size=7), rng.normal(size=(7, 3))):
        assert symmetric_product(upper, vectors) == close(matrix @ vectors, rel=1e-13)


def test_blocks_hold_the_whole_matrix(stiffness):
    blocks = node_blocks(stiffness)
    assert blocks is not None
    found = blocks.of(stiffness)
    by_columns = found.data.reshape(-1, 3, 3).transpose(0, 2, 1)
    whole = sparse.bsr_array(
        (by_columns, found.indices, found.indptr), shape=stiffness.shape
    ).tocsr()
    assert (sparse.triu(whole) != stiffness).nnz == 0
    diagonal = by_columns[found.indptr[:-1]]
    assert np.array_equal(diagonal, diagonal.transpose(0, 2, 1))


def holed() -> np.ndarray:
    upper = np.triu(np.ones((6, 6)))
    upper[0, 4] = 0.0
    return upper


@pytest.mark.parametrize(
    "upper",
    [
        pytest.param(np.triu(np.ones((5, 5))), id="no whole nodes"),
        pytest.param(holed(), id="a block with a hole"),
        pytest.param(np.eye(6), id="no blocks"),
        pytest.param(np.roll(np.triu(np.ones((6, 6))), 3, axis=1), id="no diagonal"),
        pytest.param(np.zeros((3, 3)), id="empty"),
    ],
)
def test_other_patterns_have_none(upper):
    assert node_blocks(sparse.csr_array(upper)) is None


DENSITY = 7850.0


@pytest.fixture(scope="module")
def upper(mesh):
    return assemble_mass(mesh.points, mesh.elements, DENSITY)


def mass_oracle(points, elements):
    """scikit-fem's mass of one displacement component on the same curved mesh, in our numbering."""
    curved, corners, edge_nodes = curved_mesh(points, elements)
    basis = Basis(curved, ElementTetP2(), intorder=MASS_QUADRATURE_ORDER)
    matrix = BilinearForm(lambda u, v, _: DENSITY * u * v).assemble(basis).tocoo()
    ours = np.full(basis.N, -1)
    ours[basis.nodal_dofs[0]] = corners
    ours[basis.edge_dofs[0]] = edge_nodes
    return sparse.csr_array((matrix.data, (ours[matrix.row], ours[matrix.col])), matrix.shape)


def test_mass_is_scikit_fems(mesh, upper):
    expected = mass_oracle(mesh.points, mesh.elements)
    assert sparse.tril(upper, k=-1).nnz == 0
    full = upper + sparse.triu(upper, k=1).T
    # Round-off of some hundred additions.
    assert abs(full - sparse.kron(expected, sparse.eye_array(3))).max() <= 1e-13 * full.max()


def test_batches_give_the_same_mass(mesh, upper, monkeypatch):
    monkeypatch.setattr("fem.solver.CHUNK", 37)
    assert (
        abs(upper - assemble_mass(mesh.points, mesh.elements, DENSITY)).max()
        <= 1e-13 * abs(upper).max()
    )


def test_the_rule_is_exact_to_seventh_order():
    """Integrals of x^a y^b z^c over the reference element: a! b! c! / (a + b + c + 3)!."""
    where, weights = quadrature(3, MASS_QUADRATURE_ORDER)
    for powers in product(range(8), repeat=3):
        if sum(powers) <= 7:
            exact = math.prod(map(math.factorial, powers)) / math.factorial(sum(powers) + 3)
            assert weights @ np.prod(where.T**powers, axis=1) == close(exact, rel=1e-12)


FACES = np.array([[0, 1, 2, 4, 5, 6], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 2, 3, 6, 9, 7]])
ROUND_OFF = 1e-13
ROUND_OFF_OF_STRAINS = 1e-12


@dataclass(frozen=True)
class Solved:
    """Displacements (n, 3) found, and strains (p, 3, 3) at points (p, 3) spread over all elements."""

    displacements: np.ndarray
    strains: np.ndarray
    places: np.ndarray


def boundary_nodes(elements):
    """Nodes on faces that belong to one element only."""
    faces = elements[:, FACES].reshape(-1, 6)
    corners = np.sort(faces[:, :3], axis=1)
    _, first, count = np.unique(corners, axis=0, return_index=True, return_counts=True)
    return np.unique(faces[first[count == 1]])


def patch_straightened(mesh):
    points = mesh.points.copy()
    for node, (first, second) in enumerate(EDGES, start=4):
        middle = 0.5 * (points[mesh.elements[:, first]] + points[mesh.elements[:, second]])
        points[mesh.elements[:, node]] = middle
    return replace(mesh, points=points)


def solve_inside(mesh, prescribed):
    """Prescribe displacements (n, 3) on the boundary of a mesh and solve for the nodes inside."""
    outer = np.zeros((len(mesh.points), 3), dtype=bool)
    outer[boundary_nodes(mesh.elements)] = True
    inside = np.flatnonzero(~outer.ravel())
    assert len(inside) > 1000
    stiffness = assemble_stiffness(mesh.points, mesh.elements, STEEL)
    found = np.where(outer, prescribed, 0.0).reshape(-1, 1)
    loads = -symmetric_product(stiffness, found)[inside]
    found[inside] = solve_symmetric(stiffness[inside][:, inside].tocsr(), loads)[0]
    displacements = found.reshape(-1, 3)
    values, gradients, weights = shapes_for_quadrature(5)
    corners = mesh.points[mesh.elements]
    spatial, _ = physical_gradients(corners, gradients, weights)
    slopes = np.einsum("mqaj,mai->mqij", spatial, displacements[mesh.elements]).reshape(-1, 3, 3)
    strains = 0.5 * (slopes + slopes.transpose(0, 2, 1))
    return Solved(displacements, strains, (values @ corners).reshape(-1, 3))


def stresses(strains):
    shear, nu = STEEL.shear_modulus, STEEL.poisson_ratio
    lame = 2.0 * shear * nu / (1.0 - 2.0 * nu)
    trace = np.trace(strains, axis1=1, axis2=2)
    return lame * trace[:, None, None] * np.eye(3) + 2.0 * shear * strains


def relative(error, size):
    return np.abs(error).max() / np.abs(size).max()


@pytest.fixture(scope="module")
def sharp(dimensions):
    """Only its cylinders are curved."""
    return mesh_throw(CrankThrow(**{**dimensions, "fillet_radius": 0.0}), 3.0)


@pytest.fixture(scope="module")
def filleted(mesh):
    return mesh


@pytest.fixture(scope="module")
def gradient():
    """Gradient of a linear field: stretches, shears and a rotation, all of one size."""
    return 1e-3 * np.random.default_rng(11).normal(size=(3, 3))


@pytest.mark.parametrize(
    ("curved", "order"),
    [(False, 2), (True, 5)],
    ids=["straight elements", "curved elements, rule exact to degree 3 and more"],
)
@pytest.mark.parametrize("kind", ["sharp", "filleted"])
def test_linear_field_is_reproduced(request, monkeypatch, gradient, kind, curved, order):
    monkeypatch.setattr("fem.solver.QUADRATURE_ORDER", order)
    mesh = request.getfixturevalue(kind)
    mesh = mesh if curved else patch_straightened(mesh)
    wanted = mesh.points @ gradient.T
    found = solve_inside(mesh, wanted)
    assert relative(found.displacements - wanted, wanted) < ROUND_OFF
    strain = 0.5 * (gradient + gradient.T)
    assert relative(found.strains - strain, strain) < ROUND_OFF_OF_STRAINS
    stress = stresses(strain[None])
    assert relative(stresses(found.strains) - stress, stress) < ROUND_OFF_OF_STRAINS


def bending(points):
    """Pure bending about x of a bar along z by a unit curvature: stress E y along z, no other."""
    x, y, z = points.T
    nu = STEEL.poisson_ratio
    return np.column_stack([-nu * x * y, -0.5 * (z**2 + nu * (y**2 - x**2)), y * z])


def bending_strains(points):
    nu = STEEL.poisson_ratio
    return points[:, 1, None, None] * np.diag([-nu, -nu, 1.0])


def torsion(points):
    """Twist about z by a unit angle per length; the sections stay plane."""
    x, y, z = points.T
    return np.column_stack([-y * z, x * z, np.zeros_like(z)])


def torsion_strains(points):
    strains = np.zeros((len(points), 3, 3))
    strains[:, 0, 2] = strains[:, 2, 0] = -0.5 * points[:, 1]
    strains[:, 1, 2] = strains[:, 2, 1] = 0.5 * points[:, 0]
    return strains


@pytest.mark.parametrize(
    ("field", "strains"),
    [(bending, bending_strains), (torsion, torsion_strains)],
    ids=["bending", "torsion"],
)
@pytest.mark.parametrize("kind", ["sharp", "filleted"])
def test_straight_elements_reproduce_bending_and_torsion(request, kind, field, strains):
    mesh = patch_straightened(request.getfixturevalue(kind))
    wanted = field(mesh.points)
    found = solve_inside(mesh, wanted)
    expected = strains(found.places)
    assert relative(found.displacements - wanted, wanted) < ROUND_OFF
    assert relative(found.strains - expected, expected) < ROUND_OFF_OF_STRAINS
