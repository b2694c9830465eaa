"""A straight shaft by the throw's own condensation, against beam theory.

Sources: the strength of materials of a prismatic shaft of length L between rigid end sections: L/(E A)
in tension, L/(G J) in torsion, L/(E I) in bending, and Timoshenko's deflection L^3/(3 E I) +
L/(kappa G A) with Cowper's shear coefficient of a solid circle, kappa = 6 (1 + nu)/(7 + 6 nu)
(G. R. Cowper, The shear coefficient in Timoshenko's beam theory, J. Appl. Mech. 33, 1966).

Tolerances: the rigid end sections keep the shaft from contracting there, which makes it stiffer in
tension by about nu^2 diameters of its length; two lengths are compared to take that out. The mesh adds
some 0.1 %.
"""

import numpy as np
import pytest

from fem.assembly import assemble_stiffness
from fem.condensation import condense
from fem.material import STEEL
from fem.superelement import combine_classes
from fem.symmetry import symmetry_classes
from geometry.gmsh_session import gmsh_session
from geometry.mesh import SolidProperties, ThrowMesh, element_volumes, read_mesh

DIAMETER = 0.1
AREA = np.pi / 4.0 * DIAMETER**2
POLAR = np.pi / 32.0 * DIAMETER**4


def cylinder_quarter(length):
    """The quarter x >= 0, z <= length / 2 of a cylinder, meshed like a throw's."""
    with gmsh_session("cylinder") as gmsh:
        tag = gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, length / 2.0, DIAMETER / 2.0, angle=np.pi)
        gmsh.model.occ.rotate([(3, tag)], 0, 0, 0, 0, 0, 1, -np.pi / 2.0)
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.2 * DIAMETER)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        points, elements, _ = read_mesh(gmsh, {})
    solid = SolidProperties(AREA * length / 4.0, np.zeros(3), np.zeros((3, 3)))
    return ThrowMesh("quarter", length, ("pin",), points, elements, {}, 1.0, 0, solid)


def flexibility(length):
    """Motions (6, 6) of the right end per unit force and moment there, the left end held."""
    mesh = cylinder_quarter(length)
    volume = element_volumes(mesh.points, mesh.elements).sum()
    assert volume == pytest.approx(mesh.solid.volume, rel=1e-3)
    matrix = assemble_stiffness(mesh.points, mesh.elements, STEEL)
    shapes = np.zeros((1, len(mesh.points)))
    parts = [condense(mesh, matrix, shapes, part) for part in symmetry_classes(mesh.part)]
    whole = combine_classes(parts)
    return np.linalg.inv(whole.stiffness[6:, 6:])


@pytest.fixture(scope="module")
def shafts():
    return {length: flexibility(length) for length in (0.6, 1.0)}


def test_torsion(shafts):
    for length, motions in shafts.items():
        expected = length / (STEEL.shear_modulus * POLAR)
        assert motions[5, 5] == pytest.approx(expected, rel=5e-3)


def test_tension(shafts):
    grown = shafts[1.0][2, 2] - shafts[0.6][2, 2]
    assert grown == pytest.approx(0.4 / (STEEL.youngs_modulus * AREA), rel=5e-3)
    expected = 1.0 / (STEEL.youngs_modulus * AREA)
    assert 0.985 * expected < shafts[1.0][2, 2] < expected


def test_bending(shafts):
    modulus, second = STEEL.youngs_modulus, POLAR / 2.0
    nu = STEEL.poisson_ratio
    kappa = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu)
    grown = shafts[1.0][3, 3] - shafts[0.6][3, 3]
    assert grown == pytest.approx(0.4 / (modulus * second), rel=5e-3)
    shear = 1.0 / (kappa * STEEL.shear_modulus * AREA)
    deflection = 1.0 / (3.0 * modulus * second) + shear
    for axis in (0, 1):
        assert shafts[1.0][axis, axis] == pytest.approx(deflection, rel=0.02)


def test_a_round_shaft_has_no_preferred_plane(shafts):
    for motions in shafts.values():
        assert motions[0, 0] == pytest.approx(motions[1, 1], rel=1e-3)
        assert motions[3, 3] == pytest.approx(motions[4, 4], rel=1e-3)
        # A force along y tilts the end about -x, one along x about +y.
        assert motions[3, 1] == pytest.approx(-motions[4, 0], rel=1e-3)
        size = np.sqrt(np.diag(motions))
        coupling = np.abs(motions / np.outer(size, size))
        assert coupling[np.ix_([2, 5], [0, 1, 3, 4])].max() < 1e-3
        assert coupling[2, 5] < 1e-3
