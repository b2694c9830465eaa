"""Recovered stresses and the energy of the error, against fields whose stress is known.

A box cut into congruent cells of six straight tetrahedra holds every quadratic displacement exactly; a
cubic one with an error that the patches of inner corners average away, so that there the recovered
stress is exact but for what is held back. `HELD_BACK` adds 1e-5 of the samples' weight to the quadratic
terms, against smallest eigenvalues of 1e-3 to 1e-2 inside: 1e-3 to 1e-2 of such a term is lost, and the
constant takes 1e-5 to 1e-4 of the stress in exchange. Of a linear stress patches lose 1e-9 over their
eigenvalue. That is 1e-5 and less even for the few at the body's edges with three or four elements
(eigenvalues down to 1e-7, one 0), for in the direction in which their samples say nothing quadratic
terms take part, which are held back 10,000 times as much.
Round-off of strains is 1e-16 times the quotient of displacement and element size, some 1e-13.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from skfem import MeshTet

import fem.correction
from comparing import close
from fem.assembly import assemble_stiffness, physical_gradients, symmetric_product
from fem.condensation import condense
from fem.correction import energy_errors, recovered_stress, strain_energy, stresses_at
from fem.loads import unit_pin_loads
from fem.material import STEEL, Material
from fem.supports import axial_motion, support_throw
from fem.symmetry import axial_class
from geometry.shapes import EDGES, shapes_for_quadrature
from solving import solve_symmetric

# xx, yy, zz, xy, yz, zx of a 3 x 3 matrix.
ROWS, COLUMNS = [0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]
ROUND_OFF = 1e-11


def box(cells, uneven=0.0):
    """Ten-node tetrahedra of a unit cube; inner corners are moved at random by a share of a cell."""
    along = np.linspace(0.0, 1.0, cells + 1)
    linear = MeshTet.init_tensor(along, along, along)
    points, corners = linear.p.T.copy(), linear.t.T.copy()
    inside = np.all((points > 1e-9) & (points < 1.0 - 1e-9), axis=1)
    moves = np.random.default_rng(1).uniform(-uneven, uneven, (inside.sum(), 3))
    points[inside] += moves / cells
    turned = np.linalg.det(points[corners[:, 1:]] - points[corners[:, :1]]) < 0.0
    corners[turned] = corners[turned][:, [1, 0, 2, 3]]
    ends = np.sort(corners[:, np.array(EDGES)].reshape(-1, 2), axis=1)
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    middles = points[edges].mean(axis=1)
    return np.vstack([points, middles]), np.hstack(
        [corners, len(points) + number.reshape(-1, len(EDGES))]
    )


def straightened(mesh):
    points = mesh.points.copy()
    for node, ends in enumerate(EDGES, start=4):
        points[mesh.elements[:, node]] = points[mesh.elements[:, ends]].mean(axis=1)
    return points


def stress_of(slopes, material=STEEL):
    """Hooke's law, written with E and nu, for slopes (..., i, j) = d u_i / d x_j."""
    strain = 0.5 * (slopes + np.swapaxes(slopes, -1, -2))
    nu = material.poisson_ratio
    trace = np.trace(strain, axis1=-2, axis2=-1)[..., None, None]
    stress = strain + nu / (1.0 - 2.0 * nu) * trace * np.eye(3)
    return material.youngs_modulus / (1.0 + nu) * stress[..., ROWS, COLUMNS]


def quadratic(points):
    """A displacement with all ten terms of second order in all components, and its slopes."""
    rng = np.random.default_rng(2)
    linear, square = rng.normal(size=(3, 3)), rng.normal(size=(3, 3, 3))
    square += square.transpose(0, 2, 1)
    field = points @ linear.T + 0.5 * np.einsum("ijk,nj,nk->ni", square, points, points)
    return field, linear + np.einsum("ijk,nk->nij", square, points)


def cubic(points):
    """The gradient of a harmonic polynomial of fourth order, which is in equilibrium, and its slopes."""
    x, y, z = points.T
    none = np.zeros_like(x)
    field = np.array(
        [
            4 * x**3 - 12 * x * y**2,
            -12 * x**2 * y + 4 * y**3 + 0.7 * (4 * y**3 - 12 * y * z**2),
            0.7 * (-12 * y**2 * z + 4 * z**3),
        ]
    )
    xx, xy, yz = 12 * (x**2 - y**2), -24 * x * y, -16.8 * y * z
    zz = 8.4 * (z**2 - y**2)
    slopes = np.array([[xx, xy, none], [xy, -xx - zz, yz], [none, yz, zz]])
    return field.T, slopes.transpose(2, 0, 1)


def worst(found, expected):
    return float(np.abs(found - expected).max() / np.abs(expected).max())


@pytest.fixture(scope="module")
def cube():
    return box(4)


@pytest.fixture(scope="module")
def uneven_cube():
    return box(4, 0.15)


@pytest.fixture(scope="module")
def field(mesh):
    """A displacement of the throw with nothing smooth or symmetric in it [m]."""
    return 1e-6 * np.random.default_rng(3).normal(size=mesh.points.shape)


def inner_corners(points, elements):
    """Corners that no face of the cube touches."""
    corners = np.unique(elements[:, :4])
    return corners[np.minimum(points, 1.0 - points)[corners].min(axis=1) > 1e-9]


def test_the_stress_of_uniform_strain(mesh):
    """Curved elements, too, hold it; the constant is not held back."""
    slopes = np.random.default_rng(4).normal(size=(3, 3))
    expected = stress_of(slopes)
    _, gradients, _ = shapes_for_quadrature(4)
    moved = mesh.points @ slopes.T
    raw = stresses_at(mesh.points, mesh.elements, moved, STEEL, gradients)
    assert worst(raw, np.broadcast_to(expected, raw.shape)) <= ROUND_OFF
    found = recovered_stress(mesh.points, mesh.elements, moved, STEEL)
    assert worst(found, np.broadcast_to(expected, found.shape)) <= ROUND_OFF
    errors = energy_errors(mesh.points, mesh.elements, moved, STEEL)
    assert 0.0 <= errors.relative <= ROUND_OFF**2


def test_a_rigid_motion_has_no_stress(mesh):
    """Displacements of 1 m leave the round-off of as large strains."""
    moved = np.array([1.0, -2.0, 0.5]) + np.cross([0.3, 0.8, -1.1], mesh.points)
    found = recovered_stress(mesh.points, mesh.elements, moved, STEEL)
    assert np.abs(found).max() <= ROUND_OFF * STEEL.youngs_modulus


def test_linear_stress_is_exact_at_every_node(mesh):
    points = straightened(mesh)
    moved, slopes = quadratic(points)
    expected = stress_of(slopes)
    _, gradients, _ = shapes_for_quadrature(4)
    values = shapes_for_quadrature(4)[0]
    raw = stresses_at(points, mesh.elements, moved, STEEL, gradients)
    assert worst(raw, values @ expected[mesh.elements]) <= ROUND_OFF
    found = recovered_stress(points, mesh.elements, moved, STEEL)
    assert worst(found, expected) <= 1e-5
    assert energy_errors(points, mesh.elements, moved, STEEL).relative <= 1e-12


def test_only_what_is_held_back_keeps_linear_stress_from_being_exact(mesh, monkeypatch):
    """Without it, fits to samples that lie on a linear function are that function."""
    monkeypatch.setattr(fem.correction, "HELD_BACK", np.array([0.0] * 4 + [1e-5] * 6))
    points = straightened(mesh)
    moved, slopes = quadratic(points)
    found = recovered_stress(points, mesh.elements, moved, STEEL)
    assert worst(found, stress_of(slopes)) <= ROUND_OFF


def test_quadratic_stress_is_exact_at_inner_corners(cube, monkeypatch):
    points, elements = cube
    inner = inner_corners(points, elements)
    assert len(inner) == 27
    moved, slopes = cubic(points)
    expected = stress_of(slopes)

    def error():
        found = recovered_stress(points, elements, moved, STEEL)
        return np.abs(found - expected)[inner].max() / np.abs(expected).max()

    values, gradients, _ = shapes_for_quadrature(4)
    raw = stresses_at(points, elements, moved, STEEL, gradients)
    of_elements = np.abs(raw - values @ expected[elements]).max() / np.abs(expected).max()
    assert of_elements > 0.01
    assert error() <= 1e-4
    # So little that corners of the cube, with too few samples for a fit, have some solution.
    monkeypatch.setattr(fem.correction, "HELD_BACK", np.full(10, 1e-15))
    assert error() <= ROUND_OFF


def test_recovered_stress_is_better_than_that_of_uneven_elements(uneven_cube):
    """At inner corners some 20 times; on faces the patches are one-sided and gain nothing."""
    points, elements = uneven_cube
    moved, slopes = cubic(points)
    expected = stress_of(slopes)
    error = np.abs(recovered_stress(points, elements, moved, STEEL) - expected).max(axis=1)
    values, gradients, _ = shapes_for_quadrature(4)
    raw = stresses_at(points, elements, moved, STEEL, gradients)
    of_elements = np.abs(raw - values @ expected[elements]).max()
    assert error[inner_corners(points, elements)].max() < 0.1 * of_elements
    assert error.max() < 1.5 * of_elements


@pytest.mark.parametrize("uneven", [0.0, 0.15])
def test_the_estimate_is_the_energy_of_the_true_error(uneven):
    """The cubic field is prescribed on the faces and solved for inside.

    On congruent cells inside, the estimate is 0.95 of the truth, however small they are: stresses at
    edge middles are not as good as those at corners. At the faces single elements are off by half, up
    and down, and all together are not.
    """
    points, elements = box(4, uneven)
    exact, slopes = cubic(points)
    expected = stress_of(slopes)
    stiffness = assemble_stiffness(points, elements, STEEL)
    inside = np.minimum(points, 1.0 - points).min(axis=1) > 1e-9
    free = np.flatnonzero(np.repeat(inside, 3))
    solved = np.where(inside[:, None], 0.0, exact).reshape(-1, 1)
    loads = -symmetric_product(stiffness, solved)[free]
    solved[free] = solve_symmetric(stiffness[free][:, free].tocsr(), loads)[0]
    moved = solved.reshape(-1, 3)
    errors = energy_errors(points, elements, moved, STEEL)
    values, gradients, weights = shapes_for_quadrature(4)
    _, volumes = physical_gradients(points[elements], gradients, weights)
    raw = stresses_at(points, elements, moved, STEEL, gradients)
    # On straight elements the exact stress, of second order, is its own interpolation.
    truth = np.sum(volumes * strain_energy(raw - values @ expected[elements], STEEL), axis=1)
    assert 0.95 < errors.elements.sum() / truth.sum() < 0.98
    shares = errors.elements / truth
    inner = inside[elements].all(axis=1)
    assert inner.sum() > 40
    assert 0.9 < shares[inner].min() < shares[inner].max() < 1.0
    assert 0.5 < shares.min() < shares.max() < 1.8


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3, 0.45])
def test_strain_energy_is_stress_times_strain(poisson_ratio):
    material = Material(youngs_modulus=7e10, poisson_ratio=poisson_ratio, density=2700.0)
    slopes = np.random.default_rng(5).normal(size=(50, 3, 3))
    strain = 0.5 * (slopes + slopes.transpose(0, 2, 1))
    stress = stress_of(slopes, material)
    # Shear stresses do work on both of a strain's equal components.
    expected = (stress * strain[:, ROWS, COLUMNS] * ([1.0] * 3 + [2.0] * 3)).sum(axis=1)
    assert strain_energy(stress, material) == close(expected, rel=1e-12)


def test_the_energy_is_that_of_the_stiffness(mesh, stiffness, field):
    """Exactly on straight elements; on curved ones rules of second and fourth order make 0.06 %."""
    energy = energy_errors(mesh.points, mesh.elements, field, STEEL).energy
    product = field.ravel() @ symmetric_product(stiffness, field.ravel())
    assert energy == close(product, rel=2e-3)
    points = straightened(mesh)
    straight = assemble_stiffness(points, mesh.elements, STEEL)
    energy = energy_errors(points, mesh.elements, field, STEEL).energy
    product = field.ravel() @ symmetric_product(straight, field.ravel())
    assert energy == close(product, rel=1e-12)


def test_the_energy_under_a_unit_axial_force_is_the_compliance(mesh, stiffness, superelement):
    """A quarter holds a quarter; rules of second and fourth order on curved elements make 0.06 %."""
    part = condense(mesh, stiffness, unit_pin_loads(mesh), axial_class("quarter"))
    moved = part.fields @ axial_motion(part, "pinned")
    errors = energy_errors(mesh.points, mesh.elements, moved, STEEL)
    quarter = support_throw(superelement, "pinned").axial / 4.0
    assert errors.energy == close(quarter, rel=2e-3)
    assert errors.elements.shape == (len(mesh.elements),)
    assert errors.elements.min() >= 0.0
    # Of the converged 1.281e-9 m/N this mesh misses 5.0 %; the estimate, 3.8 %, is without its safety.
    truth = 1.0 - 4.0 * quarter / 1.281e-9
    assert 0.6 * truth < errors.relative < truth


def test_batches_do_not_matter(mesh, field, monkeypatch):
    stress = recovered_stress(mesh.points, mesh.elements, field, STEEL)
    errors = energy_errors(mesh.points, mesh.elements, field, STEEL)
    monkeypatch.setattr(fem.correction, "CHUNK", 37)
    assert len(mesh.elements) % 37 != 0
    again = recovered_stress(mesh.points, mesh.elements, field, STEEL)
    # Sums in another order, in systems of a condition of some 1e5.
    assert worst(again, stress) <= 1e-10
    others = energy_errors(mesh.points, mesh.elements, field, STEEL)
    assert others.elements == close(errors.elements, rel=1e-9)
    assert others.energy == close(errors.energy, rel=1e-12)


def test_a_throw_in_millimeters_has_the_same_stress(mesh, field):
    """Patches are scaled by their own size, so that nothing depends on the unit of length."""
    stress = recovered_stress(mesh.points, mesh.elements, field, STEEL)
    scaled = recovered_stress(1e3 * mesh.points, mesh.elements, 1e3 * field, STEEL)
    assert worst(scaled, stress) <= 1e-10
    errors, others = (
        energy_errors(scale * mesh.points, mesh.elements, scale * field, STEEL)
        for scale in (1.0, 1e3)
    )
    assert others.relative == close(errors.relative, rel=1e-10)
    assert others.energy == close(1e9 * errors.energy, rel=1e-10)


def test_axes_may_change_places(mesh, field):
    """x, y, z become y, z, x, and so do the components of the stress."""
    stress = recovered_stress(mesh.points, mesh.elements, field, STEEL)
    cycled = recovered_stress(mesh.points[:, [2, 0, 1]], mesh.elements, field[:, [2, 0, 1]], STEEL)
    assert worst(cycled, stress[:, [2, 0, 1, 5, 3, 4]]) <= 1e-10


def test_a_turned_body_has_turned_stresses(uneven_cube):
    """Inside; what is held back is not the same in all directions, and is 1e-4 at most there."""
    points, elements = uneven_cube
    turn = Rotation.from_rotvec([0.4, -0.9, 0.3]).as_matrix()
    moved, _ = cubic(points)
    stress = recovered_stress(points, elements, moved, STEEL)
    turned = recovered_stress(points @ turn.T, elements, moved @ turn.T, STEEL)
    matrices = np.zeros((len(points), 3, 3))
    matrices[:, ROWS, COLUMNS] = matrices[:, COLUMNS, ROWS] = stress
    expected = (turn @ matrices @ turn.T)[:, ROWS, COLUMNS]
    inner = inner_corners(points, elements)
    assert worst(turned[inner], expected[inner]) <= 1e-4
