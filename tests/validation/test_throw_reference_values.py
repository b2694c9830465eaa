"""Compliances of throws by independent finite elements.

Source: design calculations by independent finite elements, refined until they settled; CalculiX 2.20; a
study of the angle between cranks on coarse meshes.

Tolerance: fillets 1 %, the requested accuracy; sharp corners 2 %, still rising with refinement; coarse
meshes, too stiff, 6 %.

All throws: crank radius 170 mm, journals 220 and 180 mm, journal lengths 120 and 139 mm, obround webs
300 mm wide, E = 2.1e11 Pa, nu = 0.3, end sections rigid.

- Project design calculations: second-order tetrahedra, refined until they settled, web 68 mm thick. Sharp
  corners: e_n 1.41e-9 m/N pinned and 2.63e-10 m/N guided, still rising with refinement: 2 %. Fillets of
  12 mm: e_n 1.281e-9 m/N pinned, 2.505e-10 m/N guided; torsional compliance 3.96e-8 rad/(N m) pinned,
  2.43e-8 guided: 1 %, the requested accuracy.
- CalculiX 2.20, whole throw with sharp corners: e_n pinned 1.3288e-9 m/N on a coarse mesh and 1.3654e-9 m/N
  at 77,000 unknowns. Displacement elements are too stiff, so the converged value is above both.
- Study of the angle between cranks: sharp corners, 23,000 to 38,000 unknowns, helical boundary conditions;
  e_n at 180, 120, 90 and 0 deg, and rho. These are up to 6 % too stiff, and compared with uncorrected
  results of an equally coarse mesh.
"""

import numpy as np
import pytest

from fem.analysis import analyze_axial, analyze_throw
from fem.superelement import RX, RY, RZ, UZ
from fem.supports import Neighbors
from parts_in_a_line import crank_throw

pytestmark = pytest.mark.slow

ANGLE_STUDY = {
    # web thickness [mm]: e_180, e_120, e_90, e_0 [1e-9 m/N], rho
    50: (2.007, 1.091, 0.668, 0.267, 3.34),
    68: (1.339, 0.831, 0.552, 0.256, 2.65),
    90: (0.997, 0.678, 0.481, 0.250, 2.24),
}


def reference_throw(web_thickness=0.068, fillet_radius=0.0):
    return crank_throw(
        0.170, 0.220, 0.180, 0.120, 0.139, 0.300, web_thickness, fillet_radius=fillet_radius
    )


@pytest.fixture(scope="module")
def sharp():
    return analyze_axial(reference_throw(), accuracy=0.01)


def test_sharp_corners(sharp, figure):
    pinned, guided = sharp.axial_compliance("pinned"), sharp.axial_compliance("guided")
    figure("sharp corners: e_n pinned", pinned, 1.41e-9, 0.02, "m/N")
    figure("sharp corners: e_n guided", guided, 2.63e-10, 0.02, "m/N")


@pytest.mark.parametrize("bound", [1.3288e-9, 1.3654e-9])
def test_calculix_is_a_lower_bound(sharp, bound):
    assert bound < sharp.axial_compliance("pinned") < 1.08 * bound


def test_fillets(figure):
    found = analyze_throw(reference_throw(fillet_radius=0.012), accuracy=0.01)
    for support, axial, torsional in (
        ("pinned", 1.281e-9, 3.96e-8),
        ("guided", 2.505e-10, 2.43e-8),
    ):
        what, value = f"fillets: e_n {support}", found.axial_compliance(support)
        figure(what, value, axial, 0.01, "m/N")
        what, value = f"fillets: torsion, {support}", found.torsional_compliance(support)
        figure(what, value, torsional, 0.01, "rad/(N m)")


@pytest.mark.parametrize("thickness", ANGLE_STUDY)
def test_angles_between_cranks(thickness, figure):
    *published, rho = ANGLE_STUDY[thickness]
    throw = reference_throw(web_thickness=thickness / 1000.0)
    found = analyze_throw(throw, accuracy=0.05).discrete
    for gamma, value in zip((180, 120, 90, 0), published, strict=True):
        compliance = found.axial_compliance(Neighbors(gamma, gamma))
        what = f"coarse sharp throws: e_n, cranks at {gamma} deg"
        figure(what, compliance, 1e-9 * value, 0.06, "m/N")
        assert compliance > 0.99e-9 * value
    # rho from the superelement: tilts with lengthening and twist free.
    motions = np.zeros((12, 4))
    motions[[UZ, 6 + UZ], 0] = -1.0, 1.0
    motions[[RX, 6 + RX], 1] = 1.0, -1.0
    motions[[RY, 6 + RY], 2] = 1.0, 1.0
    motions[[RZ, 6 + RZ], 3] = -1.0, 1.0
    matrix = motions.T @ found.stiffness @ motions
    in_plane = matrix[1, 1] - matrix[0, 1] ** 2 / matrix[0, 0]
    across = matrix[2, 2] - matrix[2, 3] ** 2 / matrix[3, 3]
    figure("coarse sharp throws: ratio of tilt stiffnesses", across / in_plane, rho, 0.06)
