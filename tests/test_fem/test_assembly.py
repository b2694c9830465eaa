import numpy as np
import pytest
from scipy import sparse
from skfem import Basis, ElementTetP2, ElementVector, MeshTet1, MeshTet2
from skfem.models.elasticity import linear_elasticity

from comparing import close
from crankbase.errors import InputError
from fem.assembly import (
    PAIRS,
    QUADRATURE_ORDER,
    assemble_stiffness,
    element_stiffnesses,
    physical_gradients,
    symmetric_product,
)
from fem.material import STEEL, Material
from geometry.shapes import EDGES, shapes_for_quadrature

SOFT = Material(youngs_modulus=7e10, poisson_ratio=0.45, density=2700.0)


def full(upper):
    return upper + sparse.triu(upper, k=1).T


def straightened(points, elements):
    points = points.copy()
    for node, (first, second) in enumerate(EDGES, start=4):
        points[elements[:, node]] = 0.5 * (points[elements[:, first]] + points[elements[:, second]])
    return points


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


def test_element_stiffness_against_its_definition():
    """One curved element, its strain energy from B^T D B in Voigt's notation."""
    rng = np.random.default_rng(5)
    points = np.vstack([np.zeros(3), np.eye(3)])
    points = np.vstack([points, [0.5 * (points[a] + points[b]) for a, b in EDGES]])
    points[4:] += rng.uniform(-0.05, 0.05, (6, 3))
    ((_, found),) = element_stiffnesses(points, np.arange(10)[None], SOFT)
    _, gradients, weights = shapes_for_quadrature(QUADRATURE_ORDER)
    spatial, volumes = physical_gradients(points[None], gradients, weights)
    nu = SOFT.poisson_ratio
    elastic = np.diag([1.0 - 2.0 * nu] * 3 + [0.5 - nu] * 3)
    elastic[:3, :3] += nu
    elastic *= SOFT.youngs_modulus / ((1.0 + nu) * (1.0 - 2.0 * nu))
    expected = np.zeros((30, 30))
    for slopes, volume in zip(spatial[0], volumes[0], strict=True):
        strain = np.zeros((6, 30))
        for axis in range(3):
            strain[axis, axis::3] = slopes[:, axis]
        for row, (i, j) in enumerate([(0, 1), (1, 2), (0, 2)], start=3):
            strain[row, i::3], strain[row, j::3] = slopes[:, j], slopes[:, i]
        expected += volume * strain.T @ elastic @ strain
    first, second = PAIRS
    blocks = expected.reshape(10, 3, 10, 3)[first, :, second]
    assert found[0] == close(blocks, rel=1e-11, abs=1e-12 * expected.max())


def test_rigid_body_motions_cost_nothing(mesh, stiffness):
    motions = np.zeros((len(mesh.points), 3, 6))
    motions[:, :, :3] = np.eye(3)
    arms = mesh.points / np.abs(mesh.points).max()
    for axis in range(3):
        motions[:, :, 3 + axis] = np.cross(np.eye(3)[axis], arms)
    forces = symmetric_product(stiffness, motions.reshape(-1, 6))
    assert np.abs(forces).max() <= 1e-12 * abs(stiffness).max()


def test_patch_of_straight_elements_carries_constant_strain(mesh):
    points = straightened(mesh.points, mesh.elements)
    matrix = assemble_stiffness(points, mesh.elements, STEEL)
    gradient = np.random.default_rng(3).normal(size=(3, 3))
    forces = symmetric_product(matrix, (points @ gradient.T).ravel()).reshape(-1, 3)
    triangles = np.concatenate(list(mesh.surfaces.values()))
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [0, 2]]].reshape(-1, 2), axis=1)
    on_edge = set(map(tuple, edges.tolist()))
    outer = set(triangles.ravel().tolist())
    for node, (first, second) in enumerate(EDGES, start=4):
        for element in mesh.elements:
            pair = sorted((int(element[first]), int(element[second])))
            if tuple(pair) in on_edge:
                outer.add(int(element[node]))
    inner = np.setdiff1d(np.arange(len(points)), sorted(outer))
    assert len(inner) > 100
    assert np.abs(forces[inner]).max() <= 1e-12 * np.abs(forces).max() * len(points)
    # The energy is that of the uniform stress in the whole volume.
    strain = 0.5 * (gradient + gradient.T)
    shear = STEEL.shear_modulus
    lame = 2.0 * shear * STEEL.poisson_ratio / (1.0 - 2.0 * STEEL.poisson_ratio)
    density = lame * np.trace(strain) ** 2 + 2.0 * shear * np.sum(strain**2)
    corners = points[mesh.elements[:, :4]]
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6.0
    energy = np.sum(forces * (points @ gradient.T))
    assert energy == close(density * volume, rel=1e-11)


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
