"""Convergence of the axial compliance with the mesh.

Source: Williams's exponents (J. Appl. Mech. 19, 1952), solved in the test: s = 0.545 at free corners of 270
deg, 0.711 at a rigid end; the energy's error has order 2 s (Strang and Fix 1973, chapter 8).

Tolerance: twice the scatter of 0.2 of own meshes, which are not nested; the error estimate assumes orders
1.0 (sharp) and 1.6 (fillets).

Where stresses grow like r^(s - 1) at an edge, the energy has an error of order 2 s on evenly refined
meshes; smooth parts leave order 4 with ten-node tetrahedra. The exponents s are roots of

    free re-entrant corner of 270 deg: sin(3 pi s / 2) = s, s = 0.545, order 1.09;
    corner of 90 deg, one face held, the other free, in plane strain with nu = 0.3: s = 0.711, order 1.42.

A throw with sharp corners has the first round journals and pin, every throw the second round its rigid
ends.

Nested meshes divide each element into eight on its own curved shape, so the compliance must rise. Measured
orders are 1.25 with sharp corners and 1.56 with fillets; the upper bounds leave 0.2 and 0.35 for another
first mesh (other sizes gave 1.12 to 1.34, and 1.56 to 1.86).

The program's own meshes, at factors halved twice, are not nested; each has a scatter of about 0.15 % with
sharp corners and 0.03 % with fillets. The error estimate assumes orders of 1.0 and 1.6. With sharp corners
means over two factors are used; the bounds are twice the remaining scatter of 0.2.
"""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from comparing import close
from fem.material import STEEL
from fem.solver import assemble_stiffness
from fem.superelement import condense
from fem.supports import class_axial_compliances
from fem.symmetry import axial_class, unit_pin_loads
from geometry.mesh import mesh_throw
from geometry.shapes import element_volumes
from parts_in_a_line import crank_throw
from refined_mesh import refined


def throw(fillet_radius):
    return crank_throw(0.170, 0.220, 0.180, 0.120, 0.139, 0.300, 0.068, fillet_radius=fillet_radius)


def axial_compliance(mesh):
    """e_n, pinned."""
    matrix = assemble_stiffness(mesh.points, mesh.elements, STEEL)
    part = condense(mesh, matrix, unit_pin_loads(mesh), axial_class(mesh.part))
    return class_axial_compliances(part, "pinned")[0]


def first_mesh(fillet_radius):
    """A very coarse one; with fillets the first that has no mended elements."""
    if fillet_radius == 0.0:
        return mesh_throw(throw(fillet_radius), 8.0)
    meshes = (mesh_throw(throw(fillet_radius), factor) for factor in (6.0, 6.5, 5.5, 4.5, 3.5))
    return next(mesh for mesh in meshes if mesh.mended_elements == 0)


def order(values):
    """Observed order of three values, each of meshes twice as fine as the one before."""
    coarse, middle, fine = values
    return math.log2((middle - coarse) / (fine - middle))


@pytest.fixture(scope="module")
def exponents():
    """Williams's s of the re-entrant corner and of the corner at a rigid end section."""
    reentrant = brentq(lambda s: math.sin(1.5 * math.pi * s) - s, 0.5, 0.6)
    kolosov = 3.0 - 4.0 * STEEL.poisson_ratio
    held = brentq(
        lambda s: math.sin(0.5 * math.pi * s) ** 2 - ((1.0 + kolosov) ** 2 / 4.0 - s**2) / kolosov,
        0.5,
        0.9,
    )
    return reentrant, held


def test_exponents(exponents, figure):
    """The first is in every textbook."""
    figure("exponents of the two corners", exponents, (0.5445, 0.711), 5e-4, "", "absolute")


@pytest.mark.slow
def test_refined_mesh_is_the_same_solid():
    mesh = mesh_throw(throw(0.012), 6.0)
    fine, _ = refined(mesh)
    assert len(fine.elements) == 8 * len(mesh.elements)
    assert len(np.unique(fine.points.round(9), axis=0)) == len(fine.points)
    before, after = (element_volumes(part.points, part.elements) for part in (mesh, fine))
    assert after.min() > 0.0
    assert after.reshape(-1, 8).sum(axis=1) == close(before, rel=1e-12)
    before, after = (unit_pin_loads(part)[0].values.sum(axis=(0, 1)) for part in (mesh, fine))
    assert after == close(before, abs=1e-6)


@pytest.mark.further
@pytest.mark.parametrize(
    ("fillet_radius", "corner", "highest"),
    [(0.0, 0, 1.45), (0.012, 1, 1.9)],
    ids=["sharp", "filleted"],
)
def test_nested_meshes(exponents, fillet_radius, corner, highest, figure):
    mesh = first_mesh(fillet_radius)
    values = [axial_compliance(mesh)]
    for _ in range(2):
        mesh, _ = refined(mesh)
        values.append(axial_compliance(mesh))
    assert values[0] < values[1] < values[2]
    # Below the least order only by the little that quadrature and the last two terms' signs may do.
    assert 2.0 * exponents[corner] - 0.05 < order(values) < highest
    # What the order leads to is what the program's own meshes lead to.
    steps = np.diff(values)
    limit = values[2] + steps[1] ** 2 / (steps[0] - steps[1])
    own = {0.0: 1.416e-9, 0.012: 1.281e-9}[fillet_radius]
    corners = "filleted" if fillet_radius else "sharp"
    figure(f"e_n, limit of nested meshes, {corners}", limit, own, 5e-3, "m/N")


@pytest.mark.further
@pytest.mark.parametrize(
    ("fillet_radius", "factors", "expected"),
    [(0.0, (2.4, 2.0), 1.0), (0.012, (1.5,), 1.6)],
    ids=["sharp", "filleted"],
)
def test_meshes_of_the_own_sizes(fillet_radius, factors, expected, figure):
    values = [
        np.mean([axial_compliance(mesh_throw(throw(fillet_radius), share * f)) for f in factors])
        for share in (1.0, 0.5, 0.25)
    ]
    assert values[0] < values[1] < values[2]
    corners = "filleted" if fillet_radius else "sharp"
    found = order(values)
    figure(f"order of convergence, own meshes, {corners}", found, expected, 0.4, "", "absolute")
