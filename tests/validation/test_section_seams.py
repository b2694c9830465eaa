"""A uniform shaft cut and joined again by section motions.

Source: the uncut shaft, same mesh, same rigid ends; two pieces of one diameter's length share a section.

Tolerance: 1e-5 where the degree is sufficient (tension 1, bending 2; measured 2e-6). A rigid seam stiffens
by 2.8 % in tension, 2.2 % in bending, within a fifth.

In torsion a section turns rigidly, so no choice has a seam; under a pull it contracts uniformly, degree 1;
in pure bending u_x = nu x y / rho and u_y = nu (y^2 - x^2) / (2 rho) for a curvature 1 / rho in the plane
of y, degree 2. A rigid seam is as stiff as two rigid ends (0.028 diameters each in tension, 0.022 in
bending, see `test_straight_shaft`).
"""

from dataclasses import replace

import numpy as np
import pytest

from fem.material import STEEL
from fem.solver import assemble_stiffness
from fem.superelement import RX, RZ, UZ, assemble_shaft, combine_classes, condense, hold_ends
from fem.symmetry import SECTIONS, degree_of, symmetry_classes
from mirrored_mesh import add_mirror_image
from straight_bars import DIAMETER, no_pin, shaft_quarter

LOADS = {"tension": (UZ, -1.0), "torsion": (RZ, -1.0), "bending": (RX, -1.0)}
# From which degree on a section does under a load what a section of a shaft does.
FROM = {"tension": 1, "torsion": 0, "bending": 2}
RIGID_SEAM = {"tension": 0.028, "torsion": 0.0, "bending": 0.022}
SEAMLESS, OF_THE_SEAM = 1e-5, 0.2


def superelement(mesh, degree=0):
    matrix = assemble_stiffness(mesh.points, mesh.elements, STEEL)
    held = hold_ends(mesh, matrix, degree)
    return combine_classes(
        [
            condense(mesh, matrix, [no_pin(mesh)], part, held=held)
            for part in symmetry_classes(mesh.part)
        ]
    )


def compliances(stiffness, last):
    """Compliances under equal and opposite loads on the first section and the one at unknown `last`."""
    found = {}
    for name, (unknown, sign) in LOADS.items():
        load = np.zeros(len(stiffness))
        load[[unknown, last + unknown]] = sign, 1.0
        free = np.arange(6, len(stiffness))  # the first section is held
        found[name] = load[free] @ np.linalg.solve(stiffness[np.ix_(free, free)], load[free])
    return found


@pytest.fixture(scope="module", params=[0.0, 0.5 * DIAMETER], ids=["solid", "hollow"])
def piece(request):
    return shaft_quarter(DIAMETER, request.param)


@pytest.fixture(scope="module")
def uncut(piece):
    """The piece's half is a quarter of the shaft twice as long."""
    half = add_mirror_image(piece)
    return compliances(
        superelement(replace(half, part="quarter", length=2.0 * piece.length)).stiffness, 6
    )


@pytest.mark.slow
@pytest.mark.parametrize("sections", SECTIONS)
def test_two_pieces_are_the_shaft(piece, uncut, sections, figure):
    throw = superelement(piece, degree_of(sections)).joined
    bending = throw.sections.bending
    whole = assemble_shaft([throw, throw])
    # The ends of both shafts are rigid.
    kept = np.r_[:18, 18 + bending : 18 + 2 * bending]
    found = compliances(whole[np.ix_(kept, kept)], 12)
    for name, expected in uncut.items():
        share = 1.0 - found[name] / expected
        assert share > -1e-9  # a seam stiffens
        what = f"sections {sections}, {name}: seam"
        if degree_of(sections) >= FROM[name]:
            figure(what, share, 0.0, SEAMLESS, "", "absolute")
        elif sections == "rigid":
            figure(what, share, RIGID_SEAM[name], OF_THE_SEAM)
        else:
            assert share > 0.005
