"""Stiffness and mass matrices, against other assemblies and fields of constant strain."""

import math
from itertools import product

import numpy as np
import pytest
from scipy import sparse
from skfem import Basis, BilinearForm, ElementTetP2, ElementVector, MeshTet1, MeshTet2
from skfem.models.elasticity import linear_elasticity
from skfem.quadrature import get_quadrature

from comparing import close
from crankbase.errors import InputError
from fem.assembly import (
    MASS_QUADRATURE_ORDER,
    assemble_mass,
    assemble_stiffness,
    element_masses,
    node_blocks,
    symmetric_product,
)
from fem.material import STEEL, Material
from geometry.shapes import EDGES

SOFT = Material(youngs_modulus=7e10, poisson_ratio=0.45, density=2700.0)


def full(upper):
    return upper + sparse.triu(upper, k=1).T


def oracle(points, elements, material):
    """scikit-fem's own form on the same curved mesh, its unknowns in our numbering."""
    corners = np.unique(elements[:, :4])
    number = np.full(len(points), -1)
    number[corners] = np.arange(len(corners))
    linear = MeshTet1(points[corners].T, number[elements[:, :4]].T)
    middle = {}
    for node, (first, second) in enumerate(EDGES, start=4):
        pairs = np.sort(number[elements[:, [first, second]]], axis=1)
        middle.update(zip(map(tuple, pairs.tolist()), elements[:, node].tolist(), strict=True))
    edge_nodes = [middle[tuple(sorted(edge))] for edge in linear.edges.T.tolist()]
    nodes = np.concatenate([corners, edge_nodes])
    curved = MeshTet2(points[nodes].T, linear.t)
    basis = Basis(curved, ElementVector(ElementTetP2()), intorder=2)
    lame = 2.0 * material.shear_modulus * material.poisson_ratio
    lame /= 1.0 - 2.0 * material.poisson_ratio
    matrix = linear_elasticity(lame, material.shear_modulus).assemble(basis).tocoo()
    ours = np.full(basis.N, -1)
    ours[basis.nodal_dofs] = 3 * corners + np.arange(3)[:, None]
    ours[basis.edge_dofs] = 3 * np.array(edge_nodes) + np.arange(3)[:, None]
    return sparse.csr_array((matrix.data, (ours[matrix.row], ours[matrix.col])), matrix.shape)


@pytest.mark.parametrize("material", [STEEL, SOFT])
def test_stiffness_is_scikit_fems(mesh, material):
    upper = assemble_stiffness(mesh.points, mesh.elements, material)
    expected = oracle(mesh.points, mesh.elements, material)
    assert sparse.tril(upper, k=-1).nnz == 0
    assert abs(full(upper) - expected).max() <= 1e-12 * abs(expected).max()


def test_batches_give_the_same(mesh, monkeypatch):
    whole = assemble_stiffness(mesh.points, mesh.elements, STEEL)
    monkeypatch.setattr("fem.assembly.CHUNK", 37)
    assert abs(whole - assemble_stiffness(mesh.points, mesh.elements, STEEL)).max() == 0.0


def test_symmetric_product():
    rng = np.random.default_rng(0)
    matrix = rng.normal(size=(7, 7))
    matrix += matrix.T
    upper = sparse.csr_array(np.triu(matrix))
    for vectors in (rng.normal(size=7), rng.normal(size=(7, 3))):
        assert symmetric_product(upper, vectors) == close(matrix @ vectors, rel=1e-13)


def test_material():
    assert STEEL.shear_modulus == close(2.1e11 / 2.6)
    text = {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3, "density": "7850 kg/m^3"}
    assert Material.from_text(text) == STEEL
    with pytest.raises(
        InputError, match=r"^material.poisson_ratio: given 0.5; allowed is 0 to 0.49"
    ):
        Material(youngs_modulus=2.1e11, poisson_ratio=0.5, density=7850.0)
    with pytest.raises(InputError, match=r"^material.youngs_modulus: given 210 MPa; allowed is "):
        Material(youngs_modulus=2.1e8, poisson_ratio=0.3, density=7850.0)


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
    expected = mass_oracle(mesh.points, mesh.elements)
    assert sparse.tril(upper, k=-1).nnz == 0
    full = upper + sparse.triu(upper, k=1).T
    # Round-off of some hundred additions.
    assert abs(full - sparse.kron(expected, sparse.eye_array(3))).max() <= 1e-13 * full.max()


def test_batches_give_the_same_mass(mesh, upper, monkeypatch):
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
