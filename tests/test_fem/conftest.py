from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from fem.assembly import assemble_stiffness
from fem.class_compliances import class_axial_compliances
from fem.condensation import condense, nodes_on
from fem.loads import RADIAL, uniform_pin_loads, unit_pin_loads
from fem.material import STEEL
from fem.superelement import combine_classes
from fem.symmetry import axial_class, symmetry_classes
from geometry.mesh import mesh_throw
from geometry.solid import CRANK_PLANE, LEFT_END, MIDDLE_PLANE, RIGHT_END
from geometry.throw import CrankThrow

# A mirror image of a tetrahedron is inside out until two of its corners change places.
SWAPPED = [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]


def add_mirror_image(mesh):
    """Make a half of a quarter, or a full mesh of a half, sharing the nodes on the cut."""
    cut, part = {
        "quarter": (MIDDLE_PLANE, "half"),
        "half": (CRANK_PLANE, "full"),
    }[mesh.part]
    axis, place = (2, 0.5 * mesh.length) if cut == MIDDLE_PLANE else (0, 0.0)
    shared = nodes_on(mesh, cut)
    others = np.setdiff1d(np.arange(len(mesh.points)), shared)
    number = np.arange(len(mesh.points))
    number[others] = len(mesh.points) + np.arange(len(others))
    image = mesh.points[others].copy()
    image[:, axis] = 2.0 * place - image[:, axis]
    surfaces = {}
    for name, facets in mesh.surfaces.items():
        other_side = number[facets][:, ::-1]
        if name == cut:
            continue
        if name == LEFT_END and cut == MIDDLE_PLANE:
            surfaces |= {LEFT_END: facets, RIGHT_END: other_side}
        else:
            surfaces[name] = np.vstack([facets, other_side])
    return replace(
        mesh,
        part=part,
        points=np.vstack([mesh.points, image]),
        elements=np.vstack([mesh.elements, number[mesh.elements][:, SWAPPED]]),
        surfaces=surfaces,
    )


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
def pin_shapes(mesh):
    return uniform_pin_loads(mesh)


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


@pytest.fixture(scope="session")
def axial_compliance():
    """e_n pinned of a throw on a mesh of a given size factor: one class, one solve, made once."""

    @cache
    def compute(throw, size_factor=1.3, material=STEEL):
        mesh = mesh_throw(throw, size_factor)
        matrix = assemble_stiffness(mesh.points, mesh.elements, material)
        part = condense(mesh, matrix, unit_pin_loads(mesh), axial_class(mesh.part))
        return class_axial_compliances(part, "pinned")[0]

    return compute
