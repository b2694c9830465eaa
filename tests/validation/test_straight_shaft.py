"""Straight shafts, solid and hollow, by the throw's condensation.

Source: strength of materials: L/(E A), L/(G J), L/(E I), L^2/(2 E I); Timoshenko's L^3/(3 E I) + L/(kappa G
A) with G. R. Cowper's coefficient (J. Appl. Mech. 33, 1966).

Tolerance: 0.1 %, deflections 0.2 %; measured up to 0.02 % (mesh), deflections 0.1 % (shear at averaged
ends). Rigid ends shorten the shaft by 0.022 diameters each in bending, 0.028 in tension.

A tube with the ratio m of inner to outer diameter has kappa = 6 (1 + nu) (1 + m^2)^2/[(7 + 6 nu) (1 +
m^2)^2 + (20 + 12 nu) m^2].

Averaged end sections carry Saint-Venant's tractions, so the theory holds for any length. Rigid ones prevent
contraction. Differences of two lengths are free of this; for a force across it is corrected from the slope.
Wider bounds show the ends' effect itself.
"""

from dataclasses import dataclass

import numpy as np
import pytest

from comparing import close
from fem.material import STEEL
from fem.solver import assemble_stiffness
from fem.superelement import combine_classes, condense
from fem.symmetry import symmetry_classes
from geometry.shapes import element_volumes
from straight_bars import DIAMETER, no_pin, shaft_quarter

E, G, NU = STEEL.youngs_modulus, STEEL.shear_modulus, STEEL.poisson_ratio
BORES = (0.0, 0.05)
TOLERANCE = 1e-3
TOLERANCE_OF_DEFLECTIONS = 2e-3
SHORT, LONG = 0.6, 1.0
UX, UY, UZ, RX, RY, RZ = range(6)


@dataclass(frozen=True)
class Section:
    """A circular or annular section, all in SI units."""

    bore: float

    @property
    def area(self):
        return np.pi / 4.0 * (DIAMETER**2 - self.bore**2)

    @property
    def second_moment(self):
        return np.pi / 64.0 * (DIAMETER**4 - self.bore**4)

    @property
    def shear_coefficient(self):
        square = (self.bore / DIAMETER) ** 2
        both = (1.0 + square) ** 2
        return 6.0 * (1.0 + NU) * both / ((7.0 + 6.0 * NU) * both + (20.0 + 12.0 * NU) * square)

    def deflection(self, length):
        """Under a unit force across at the end."""
        bending = length**3 / (3.0 * E * self.second_moment)
        return bending + length / (self.shear_coefficient * G * self.area)


def flexibility(length, bore, end_sections):
    """Motions (6, 6) of the right end per unit force and moment there, the left end held."""
    mesh = shaft_quarter(length, bore)
    volume = element_volumes(mesh.points, mesh.elements).sum()
    assert volume == close(mesh.solid.volume, rel=1e-3)
    matrix = assemble_stiffness(mesh.points, mesh.elements, STEEL)
    parts = [
        condense(mesh, matrix, [no_pin(mesh)], part, end_sections=end_sections)
        for part in symmetry_classes(mesh.part)
    ]
    return np.linalg.inv(combine_classes(parts).stiffness[6:, 6:])


@pytest.fixture(scope="module", params=BORES, ids=["solid", "hollow"])
def section(request):
    return Section(request.param)


@pytest.fixture(scope="module")
def shafts(section):
    """Two lengths with rigid ends."""
    return {length: flexibility(length, section.bore, "rigid") for length in (SHORT, LONG)}


@pytest.fixture(scope="module")
def grown(shafts):
    """What the longer shaft has more."""
    return shafts[LONG] - shafts[SHORT]


@pytest.fixture(scope="module")
def averaged(section):
    """A shaft of only four diameters with averaged ends."""
    return flexibility(4.0 * DIAMETER, section.bore, "averaged")


def test_torsion(shafts, section, figure):
    for length, motions in shafts.items():
        expected = length / (2.0 * G * section.second_moment)
        figure("rigid ends: twist", motions[RZ, RZ], expected, TOLERANCE, "rad/(N m)")


def test_tension(shafts, grown, section, figure):
    expected = (LONG - SHORT) / (E * section.area)
    figure("rigid ends, two lengths: stretch", grown[UZ, UZ], expected, TOLERANCE, "m/N")
    expected = LONG / (E * section.area)
    assert 0.985 * expected < shafts[LONG][UZ, UZ] < expected


def test_slope_under_a_moment(shafts, grown, section, figure):
    expected = 1.0 / (E * section.second_moment)
    for tilt in (RX, RY):
        found, wanted = grown[tilt, tilt], (LONG - SHORT) * expected
        figure("rigid ends, two lengths: slope", found, wanted, TOLERANCE, "rad/(N m)")
        assert 0.985 * LONG * expected < shafts[LONG][tilt, tilt] < LONG * expected


def test_deflection(shafts, grown, section, figure):
    """Under a force with the pieces put back, under a moment half the length times the slope."""
    stiffness = E * section.second_moment
    for across, tilt in ((UX, RY), (UY, RX)):
        piece = 0.5 * (LONG - stiffness * shafts[LONG][tilt, tilt])
        assert 0.01 * DIAMETER < piece < 0.03 * DIAMETER
        found = grown[across, across] + piece * (LONG**2 - SHORT**2) / stiffness
        expected = section.deflection(LONG) - section.deflection(SHORT)
        what = "rigid ends, two lengths: deflection"
        figure(what, found, expected, TOLERANCE_OF_DEFLECTIONS, "m/N")
        for length, motions in shafts.items():
            # The two pieces, at equal distances from the middle, leave the lever as it is.
            assert abs(motions[across, tilt]) == close(0.5 * length * motions[tilt, tilt], rel=1e-6)
            assert motions[across, across] == close(section.deflection(length), rel=0.02)


def test_averaged_ends_leave_beam_theory_as_it_is(averaged, section, figure):
    length, second = 4.0 * DIAMETER, section.second_moment
    expected = {
        UZ: length / (E * section.area),
        RX: length / (E * second),
        RY: length / (E * second),
        RZ: length / (2.0 * G * second),
    }
    for motion, value in expected.items():
        what = {UZ: "stretch", RZ: "twist"}.get(motion, "slope")
        unit = "m/N" if motion == UZ else "rad/(N m)"
        figure(f"averaged ends: {what}", averaged[motion, motion], value, TOLERANCE, unit)
    for across, tilt in ((UX, RY), (UY, RX)):
        under_moment = length**2 / (2.0 * E * second)
        assert abs(averaged[across, tilt]) == close(under_moment, rel=TOLERANCE)
        expected = section.deflection(length)
        bound = TOLERANCE_OF_DEFLECTIONS
        figure("averaged ends: deflection", averaged[across, across], expected, bound, "m/N")


def test_a_round_shaft_has_no_preferred_plane(shafts, averaged):
    for motions in (*shafts.values(), averaged):
        assert motions[UX, UX] == close(motions[UY, UY], rel=1e-3)
        assert motions[RX, RX] == close(motions[RY, RY], rel=1e-3)
        # A force along y tilts the end about -x, one along x about +y.
        assert motions[RX, UY] < 0.0
        assert motions[RX, UY] == close(-motions[RY, UX], rel=1e-3)
        size = np.sqrt(np.diag(motions))
        coupling = np.abs(motions / np.outer(size, size))
        assert coupling[np.ix_([UZ, RZ], [UX, UY, RX, RY])].max() < 1e-3
        assert coupling[UZ, RZ] < 1e-3
