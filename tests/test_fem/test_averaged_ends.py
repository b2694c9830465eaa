"""End sections of which only the mean motion is given: definition, limits, and the same for all parts.

The stiffness is the least energy of all fields with given mean motions. Fields of rigid end sections are
some of these, so on one mesh rigid sections are stiffer in every direction, to round-off.
"""

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from fem.assembly import assemble_stiffness, symmetric_product
from fem.condensation import condense, nodes_on
from fem.fields import displacement_field
from fem.loads import end_sections, unit_end_loads, unit_pin_loads
from fem.material import STEEL
from fem.superelement import combine_classes
from fem.supports import Neighbors, support_throw
from fem.symmetry import SymmetryClass, axial_class, symmetry_classes
from geometry.solid import LEFT_END, RIGHT_END

# Finite elements throughout: not for the inner loop.
pytestmark = pytest.mark.slow

# What two factorizations of one problem leave; six digits of the stiffness' range are lost in the
# balance of end loads.
SOLVED = 1e-8


@pytest.fixture(scope="module")
def averaged(mesh, half_mesh, full_mesh):
    """By part: the mesh, its stiffness, its classes and their superelement."""
    found = {}
    for one in (mesh, half_mesh, full_mesh):
        matrix = assemble_stiffness(one.points, one.elements, STEEL)
        pins = unit_pin_loads(one)
        classes = tuple(
            condense(one, matrix, pins, symmetry, end_sections="averaged")
            for symmetry in symmetry_classes(one.part)
        )
        found[one.part] = (one, matrix, classes, combine_classes(classes))
    return found


@pytest.fixture(scope="module", params=["quarter", "half", "full"])
def part(request, averaged):
    return averaged[request.param]


@pytest.fixture(scope="module")
def sizes(superelement):
    """Square roots of the diagonal of the stiffness, with which matrices become numbers of a like size."""
    return np.sqrt(np.diag(superelement.stiffness))


def class_end_loads(mesh, symmetry):
    """Loads (3 n, k) that make the mean motions of the meshed ends in this class."""
    columns = []
    for end in end_sections(symmetry):
        unit = unit_end_loads(mesh, end)
        loads = np.zeros((len(mesh.points), 3, 6))
        loads[unit.nodes] = unit.of_class(symmetry)
        columns.append(loads[..., symmetry.end_unknowns].reshape(3 * len(mesh.points), -1))
    return np.hstack(columns)


def test_six_rigid_motions_and_no_more(part, rigid_motions):
    stiffness = part[3].stiffness
    assert np.array_equal(stiffness, stiffness.T)
    assert np.linalg.norm(stiffness @ rigid_motions) <= 1e-9 * np.linalg.norm(stiffness)
    values = np.linalg.eigvalsh(stiffness)
    assert np.abs(values[:6]).max() <= 1e-9 * values[6]
    assert values[6] > 1e-4 * values[-1]


@pytest.mark.parametrize("name", ["quarter", "half"])
def test_parts_have_one_superelement(averaged, sizes, name):
    found, expected = (averaged[one][3] for one in (name, "full"))
    size = np.outer(sizes, sizes)
    assert np.abs((found.stiffness - expected.stiffness) / size).max() <= SOLVED
    assert found.pin_loads == close(expected.pin_loads, abs=SOLVED)
    flexibility = np.sqrt(np.diag(expected.pin_flexibility))
    error = (found.pin_flexibility - expected.pin_flexibility) / np.outer(flexibility, flexibility)
    assert np.abs(error).max() <= SOLVED


def test_rigid_sections_are_stiffer_in_every_direction(averaged, superelement, sizes):
    """And pins between held sections too; the eigenvalues of the difference tell."""
    softer = averaged["quarter"][3]
    values = np.linalg.eigvalsh(
        (superelement.stiffness - softer.stiffness) / np.outer(sizes, sizes)
    )
    assert values.min() >= -1e-9
    # The six rigid motions cost nothing in either.
    assert np.sum(values > 1e-6) == 6
    assert values.max() < 0.5
    size = np.sqrt(np.diag(softer.pin_flexibility))
    more = (softer.pin_flexibility - superelement.pin_flexibility) / np.outer(size, size)
    assert np.linalg.eigvalsh(more).min() >= -1e-9
    assert 1e-4 < np.linalg.eigvalsh(more).max() < 0.2


@pytest.mark.parametrize(
    ("support", "axial", "torsional"),
    [("pinned", 0.0084, 0.0026), ("guided", 0.044, 0.019), (Neighbors(120, 120), 0.018, 0.0077)],
    ids=str,
)
def test_how_far_apart_the_two_are(averaged, superelement, support, axial, torsional):
    """Softer by so much on this mesh; with 70,000 unknowns e_n pinned by 0.7 %."""
    rigid, softer = (support_throw(one, support) for one in (superelement, averaged["quarter"][3]))
    assert softer.axial / rigid.axial - 1.0 == close(axial, rel=0.2)
    assert softer.torsional / rigid.torsional - 1.0 == close(torsional, rel=0.2)


def test_mean_motions_are_those_prescribed(part):
    """Of all classes together, for motions with nothing symmetric in them, on all images of the ends."""
    mesh, _, classes, _ = part
    for symmetry_part in classes:
        loads = class_end_loads(mesh, symmetry_part.symmetry)
        count = len(symmetry_part.symmetry.end_unknowns) * len(end_sections(symmetry_part.symmetry))
        fields = symmetry_part.fields.reshape(3 * len(mesh.points), count)
        # A load of the class works on as many images as the end has.
        assert loads.T @ fields == close(np.eye(count), abs=1e-9)
        held = symmetry_part.pin_fields.reshape(3 * len(mesh.points), -1)
        scale = np.abs(held).max()
        assert np.abs(loads.T @ held).max() <= 1e-7 * scale
    motions = np.random.default_rng(9).normal(size=12)
    field = displacement_field(classes, motions)
    if mesh.part == "full":
        for place, end in ((0, LEFT_END), (6, RIGHT_END)):
            unit = unit_end_loads(mesh, end)
            found = np.einsum("sac,sa->c", unit.values[0], field[unit.nodes])
            assert found == close(motions[place : place + 6], abs=1e-9)


def test_sections_do_warp(averaged):
    """Else this would be the rigid case: under a pull the section is no plane by 5 % and more."""
    mesh, _, classes, _ = averaged["quarter"]
    nodes = nodes_on(mesh, LEFT_END)
    (axial,) = [one for one in classes if one.symmetry == axial_class("quarter")]
    pull = axial.fields[nodes, 2, list(axial.symmetry.end_unknowns).index(2)]
    assert np.ptp(pull) > 0.05


def test_what_holds_the_ends_are_uniform_and_linear_tractions(part):
    """Nodal forces are the end loads times the stiffness, and besides those on the pin nothing at all."""
    mesh, matrix, classes, _ = part
    for one in classes:
        symmetry = one.symmetry
        loads = class_end_loads(mesh, symmetry)
        fields = one.fields.reshape(3 * len(mesh.points), -1)
        forces = symmetric_product(matrix, fields)
        # On a cut the other images hold on as well; there forces along the blocked axes are theirs.
        free = np.ones((len(mesh.points), 3), dtype=bool)
        for surface, axes in symmetry.blocked_axes().items():
            free[np.ix_(nodes_on(mesh, surface), np.array(axes))] = False
        free = free.ravel()
        expected = loads @ one.stiffness
        scale = np.abs(expected).max()
        assert np.abs(forces - expected)[free].max() <= 1e-6 * scale
        pressed = symmetric_product(matrix, one.pin_fields.reshape(3 * len(mesh.points), -1))
        unit = unit_pin_loads(mesh)[0]
        carried = np.zeros((len(mesh.points), 3, 6))
        carried[unit.nodes] = unit.of_class(symmetry)
        components = one.pin_components[:, 1]
        share = carried.reshape(-1, 6)[:, components] / symmetry.copies
        answer = loads @ one.pin_loads[0][:, components] / symmetry.copies
        scale = np.abs(answer).max(axis=0)
        assert (np.abs(pressed - (share - answer))[free].max(axis=0) <= 1e-6 * scale).all()


def test_forces_on_the_ends_balance_loads_on_the_pin(part, rigid_motions, throw):
    """The superelement's pin loads work on rigid motions as the loads themselves do."""
    mesh, _, _, superelement = part
    (unit,) = unit_pin_loads(mesh)
    work = np.zeros((6, 6))
    for image, values in zip(unit.images, unit.values, strict=True):
        arms = image.points(mesh.points[unit.nodes])
        for motion in range(6):
            axis = np.eye(3)[motion % 3]
            turned = np.cross(axis, arms) / throw.crank_radius
            moved = np.broadcast_to(axis, arms.shape) if motion < 3 else turned
            work[motion] += np.einsum("sac,sa->c", values, moved)
    assert rigid_motions.T @ superelement.pin_loads[0] == close(work, abs=1e-8)


def test_solvers_agree(mesh, stiffness, sizes):
    pins = unit_pin_loads(mesh)
    symmetry = axial_class("quarter")
    one, other = (
        condense(mesh, stiffness, pins, symmetry, solver, "averaged")
        for solver in ("auto", "superlu")
    )
    size = sizes[symmetry.end_unknowns]
    assert np.abs((one.stiffness - other.stiffness) / np.outer(size, size)).max() <= SOLVED
    assert one.fields == close(other.fields, abs=1e-7)
    assert one.end_sections == other.end_sections == "averaged"


def test_unknown_end_sections(mesh, stiffness):
    with pytest.raises(InputError, match=r"^end_sections: given 'plane'; allowed are"):
        condense(mesh, stiffness, unit_pin_loads(mesh), SymmetryClass(1, 1), end_sections="plane")
