"""A solved throw in scikit-fem, meshio and PyVista, against its own compliances, areas and forces."""

import numpy as np
import pytest
from skfem import Functional
from skfem.models.elasticity import linear_elasticity

from comparing import close
from fem.analysis import analyze_throw
from fem.material import STEEL
from geometry.shapes import determinants, element_volumes, shapes_for_quadrature

pytestmark = pytest.mark.slow

LOADS = [
    "axial force",
    "torque",
    "bending in the crank plane",
    "bending across the crank plane",
    "radial force",
]


@pytest.fixture(scope="module", params=["mesh", "half_mesh"])
def analysis(request, throw):
    """The same mesh as a quarter and as a half."""
    solved = request.getfixturevalue(request.param)
    return analyze_throw(throw, accuracy=0.1, mesher=lambda *_, **__: solved)


@pytest.fixture(scope="module")
def handed(analysis):
    return analysis.to_skfem()


def test_energies_by_scikit_fems_form_are_the_compliances(analysis, handed):
    form = linear_elasticity(STEEL.lame_constant, STEEL.shear_modulus)
    fields = np.array([handed.displacement[load] for load in LOADS])
    works = fields @ (form.assemble(handed.basis) @ fields.T)
    plain = analysis.discrete
    radial = np.array([0.0, -1.0, 0.0])
    assert list(handed.displacement) == LOADS
    assert works[0, 0] == close(plain.axial_compliance(), rel=1e-9)
    assert works[1, 1] == close(plain.torsional_compliance(), rel=1e-9)
    assert works[0, 4] == close(plain.influence_coefficient(), rel=1e-9)
    assert works[4, 4] == close(radial @ plain.pin_compliance()[:3, :3] @ radial, rel=1e-9)


def test_ends_stay_on_the_axis_and_part_by_the_compliance(analysis, handed):
    pulled = handed.displacement["axial force"]
    lengthened = []
    for name in ("left end", "right end"):
        vertices = np.unique(handed.mesh.facets[:, handed.mesh.boundaries[name]])
        unknowns = handed.basis.nodal_dofs[:, vertices]
        assert abs(pulled[unknowns[:2]]).max() < 1e-9 * abs(pulled).max()
        # The section is a plane, whose height over the axis is its motion.
        x, y, _ = handed.mesh.p[:, vertices]
        plane = np.column_stack([np.ones_like(x), x, y])
        lengthened.append(np.linalg.lstsq(plane, pulled[unknowns[2]])[0][0])
    expected = analysis.discrete.axial_compliance()
    assert lengthened[1] - lengthened[0] == close(expected, rel=1e-9)


def test_boundaries_are_the_named_surfaces(analysis, handed, full_mesh):
    @Functional
    def one(w):
        return 1.0 + 0.0 * w.x[0]

    assert set(handed.mesh.boundaries) == set(full_mesh.surfaces)
    for name, corners in full_mesh.surfaces.items():
        assert len(handed.mesh.boundaries[name]) == len(corners)
    end = one.assemble(handed.basis.boundary("left end"))
    assert end == close(np.pi * 0.110**2, rel=2e-3)
    volume = one.assemble(handed.basis)
    assert volume == close(element_volumes(full_mesh.points, full_mesh.elements).sum(), rel=1e-5)


def test_meshio_and_pyvista_have_fields_and_named_faces(analysis, handed, full_mesh):
    mesh = analysis.to_meshio()
    elements = mesh.cells_dict["tetra10"]
    volumes = element_volumes(mesh.points, elements)
    assert volumes.min() > 0.0
    assert volumes.sum() == close(element_volumes(full_mesh.points, full_mesh.elements).sum())
    force, moment = "displacement, axial force [m/N]", "stress, torque [Pa/(N m)]"
    assert len(mesh.point_data) == 2 * len(LOADS)
    assert mesh.point_data[moment].shape == (len(mesh.points), 6)
    # The same values at the same places as in scikit-fem.
    places = np.round(handed.basis.doflocs[:, handed.basis.nodal_dofs[0]].T, 9)
    values = handed.displacement["axial force"][handed.basis.nodal_dofs].T
    by_place = dict(zip(map(tuple, places.tolist()), values, strict=True))
    corners = np.unique(elements[:, :4])
    expected = [by_place[tuple(place)] for place in np.round(mesh.points[corners], 9).tolist()]
    assert mesh.point_data[force][corners] == close(np.array(expected), rel=1e-12, abs=1e-20)

    grid = analysis.to_pyvista()
    assert grid[force] == close(mesh.point_data[force])
    for name, corners in full_mesh.surfaces.items():
        assert grid.cell_data[name].sum() == len(corners)


def test_mean_stress_is_that_of_the_force(analysis):
    """In equilibrium the integral of s_zj is that of z t_j: under the axial force L for zz, else 0.

    The rigid sections hold the width, and so there is a mean of xx and yy.
    """
    mesh = analysis.to_meshio()
    nodal = mesh.point_data["stress, axial force [Pa/N]"][mesh.cells_dict["tetra10"]]
    values, gradients, weights = shapes_for_quadrature(5)
    volumes = determinants(gradients, mesh.points[mesh.cells_dict["tetra10"]]) * weights
    total = np.einsum("mq,qn,mni->i", volumes, values, nodal) / analysis.mesh.length
    assert total[2:] == close(np.array([1.0, 0.0, 0.0, 0.0]), abs=0.01)
