"""One throw meshed as a quarter, as a half and whole.

Source: the throw's symmetry: quarter in four classes of motion, half in two, whole in one, on meshes that
share no node.

Tolerance: 1 %, the error of any of these meshes (size factor 1.2); loads on the ends 0.5 %, measured 0.2.

A wrong sign or factor in any class shows. The quarter's axial compliance is 1.1 % below the converged one;
halves and whole meshes are 0.1 to 0.65 % stiffer.
"""

import numpy as np
import pytest

from comparing import close
from fem.material import STEEL
from fem.solver import assemble_stiffness
from fem.superelement import combine_classes, condense
from fem.supports import Neighbors, support_throw
from fem.symmetry import radial_directions, symmetry_classes, unit_pin_loads
from geometry.mesh import mesh_throw
from parts_in_a_line import crank_throw

pytestmark = pytest.mark.slow

SUPPORTS = ("pinned", "guided", Neighbors(120, 90))
TOLERANCE = 1e-2
TOLERANCE_OF_PIN_LOADS = 5e-3


def superelement(throw, part):
    mesh = mesh_throw(throw, 1.2, part=part)
    assert mesh.part == part
    matrix = assemble_stiffness(mesh.points, mesh.elements, STEEL)
    pins = unit_pin_loads(mesh)
    classes = [condense(mesh, matrix, pins, symmetry) for symmetry in symmetry_classes(part)]
    return combine_classes(classes, radial_directions(throw))


@pytest.fixture(scope="module")
def parts():
    """A throw with bores, whose webs are equal."""
    throw = crank_throw(
        0.170,
        0.220,
        0.180,
        0.120,
        0.139,
        0.300,
        0.068,
        fillet_radius=0.012,
        main_journal_bore=0.09,
        pin_bore=0.07,
    )
    return {part: superelement(throw, part) for part in ("quarter", "half", "full")}


@pytest.fixture(scope="module", params=["half", "full"])
def pair(request, parts):
    return parts[request.param], parts["quarter"]


@pytest.mark.further
def test_stiffness(pair, figure):
    found, expected = (part.stiffness for part in pair)
    size = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    figure(
        "stiffness 12 x 12, by its diagonal", found / size, expected / size, TOLERANCE, scale=1.0
    )
    # They are three meshes and not one.
    assert np.abs((found - expected) / size).max() > 1e-6


def test_pin_loads(pair, figure):
    """Forces and moments on the ends per force and per moment on the pin, each beside its like."""
    found, expected = (part.pin_loads[0].reshape(2, 2, 3, 2, 3) for part in pair)
    size = np.abs(expected).max(axis=(2, 4), keepdims=True)
    bound = TOLERANCE_OF_PIN_LOADS
    figure("pin loads on the ends", found / size, expected / size, bound, scale=1.0)


@pytest.mark.parametrize("support", SUPPORTS, ids=str)
def test_compliances(pair, support, figure):
    found, expected = (support_throw(part, support) for part in pair)
    figure("axial compliance", found.axial, expected.axial, TOLERANCE, "m/N")
    figure("torsional compliance", found.torsional, expected.torsional, TOLERANCE, "rad/(N m)")
    figure("influence coefficient", found.influence, expected.influence, TOLERANCE, "m/N")


def test_a_cantilever_of_one_throw(pair):
    """Flexibility of the right end, the left one held: bending in and across the crank plane too."""
    found, expected = (np.linalg.inv(part.stiffness[6:, 6:]) for part in pair)
    assert np.diag(found) == close(np.diag(expected), rel=TOLERANCE)
    size = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs((found - expected) / size).max() < TOLERANCE
