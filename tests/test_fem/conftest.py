import numpy as np
import pytest

from fem.material import STEEL
from fem.solver import assemble_stiffness
from fem.superelement import combine_classes, condense
from fem.symmetry import RADIAL, symmetry_classes, unit_pin_loads
from geometry.mesh import mesh_throw
from geometry.throw import CrankThrow
from mirrored_mesh import add_mirror_image


def condense_classes(mesh, material=STEEL, radials=RADIAL[None]):
    """Condense all symmetry classes of a mesh; give them with their superelement."""
    matrix = assemble_stiffness(mesh.points, mesh.elements, material)
    pins = unit_pin_loads(mesh)
    found = tuple(condense(mesh, matrix, pins, part) for part in symmetry_classes(mesh.part))
    return found, combine_classes(found, radials)


@pytest.fixture(scope="session")
def mirror():
    return add_mirror_image


@pytest.fixture(scope="session")
def condensed():
    return condense_classes


@pytest.fixture(scope="session")
def throw(dimensions):
    return CrankThrow(**dimensions)


@pytest.fixture(scope="session")
def mesh(throw):
    """A coarse quarter, on which every identity must hold as on a fine one."""
    return mesh_throw(throw, 3.0)


@pytest.fixture(scope="session")
def half_mesh(mesh):
    return add_mirror_image(mesh)


@pytest.fixture(scope="session")
def full_mesh(half_mesh):
    return add_mirror_image(half_mesh)


@pytest.fixture(scope="session")
def stiffness(mesh):
    return assemble_stiffness(mesh.points, mesh.elements, STEEL)


@pytest.fixture(scope="session")
def pins(mesh):
    return unit_pin_loads(mesh)


@pytest.fixture(scope="session")
def classes(mesh):
    return condense_classes(mesh)[0]


@pytest.fixture(scope="session")
def superelement(classes):
    return combine_classes(classes)


@pytest.fixture(scope="session")
def rigid_motions(throw):
    """End motions (12, 6) of three translations and three rotations about the left end's center.

    Rotations are divided by the crank radius, so that all columns have motions of a like size.
    """
    motions = np.zeros((12, 6))
    for end, z in ((0, 0.0), (6, throw.length)):
        motions[end : end + 6] = np.eye(6)
        motions[end + 1, 3], motions[end, 4] = -z, z
    motions[:, 3:] /= throw.crank_radius
    return motions
