"""Modes of straight bars and of a shaft of four throws.

Source: free bars: n c/(2 L), corrected for contraction (A. E. H. Love 1927, art. 278); Timoshenko's beam
(J. R. Hutchinson, J. Appl. Mech. 68, 2001, 87-92); four throws with natural modes to 8000 Hz.

Tolerance: twice the measured values: torsion 3e-5 (first mode) to 1.6e-4 (fourth), tension 5e-5, bending
2e-5 to 2.5e-4.

Bars: n c/(2 L) with the wave speed sqrt(E/rho) along the bar, divided by sqrt(1 + (n pi nu r/L)^2) for the
inertia of contraction (r the polar radius of gyration), and sqrt(G/rho) in torsion. Bending by matrix
exponential, with the shear coefficient 6 (1 + nu)^2/(7 + 12 nu + 4 nu^2). Guyan's mass of a twisted bar is
that of the linear bar element, with frequencies sqrt(6 (1 - cos t)/(2 + cos t)) c/(2 pi h), t = n pi h/L,
in elements of length h.

Shaft: four throws with cranks at 0, 180, 180, 0 degrees in bearings that hold the main journals' centers
laterally. The reference is the same mesh's superelement with natural modes to 8000 Hz and corrections;
modes above 6000 Hz change frequencies up to 800 Hz by 1e-9.
"""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from comparing import close
from condensed_parts import of_modes
from dynamic_shaft import assemble_dynamic_shaft, natural_modes
from fem.material import STEEL
from fem.modes import dynamic_superelement, free_modes
from fem.solver import assemble_stiffness
from fem.superelement import RZ, UX, UY, condense
from fem.symmetry import symmetry_classes, unit_pin_loads
from geometry.mesh import mesh_throw
from geometry.throw import CrankThrow
from straight_bars import DIAMETER, no_pin, shaft_quarter

pytestmark = pytest.mark.slow

LENGTH = 1.0
AREA = np.pi / 4.0 * DIAMETER**2
SECOND_MOMENT = np.pi / 64.0 * DIAMETER**4
E, G, NU, RHO = STEEL.youngs_modulus, STEEL.shear_modulus, STEEL.poisson_ratio, STEEL.density
CRANKS = np.radians([0.0, 180.0, 180.0, 0.0])
HIGHEST = 800.0
ROOTS = (4.730041, 7.853205, 10.995608)


def condensed(mesh, pins):
    matrix = assemble_stiffness(mesh.points, mesh.elements, STEEL)
    return [condense(mesh, matrix, pins, each) for each in symmetry_classes(mesh.part)]


@pytest.fixture(scope="module")
def bar_modes():
    return free_modes(shaft_quarter(LENGTH), STEEL, highest_frequency=5300.0)


@pytest.fixture(scope="module")
def pieces():
    """Two halves of the bar in a row, as exact as asked for or by Guyan alone."""
    mesh = shaft_quarter(LENGTH / 2.0)
    classes = condensed(mesh, [no_pin(mesh)])
    return {
        highest: dynamic_superelement(mesh, STEEL, classes, highest) for highest in (0.0, 6500.0)
    }


def of_kind(modes, kind):
    return np.array(
        [
            each
            for each, name in zip(modes.frequencies, modes.names, strict=True)
            if name.startswith(kind)
        ]
    )


def euler_frequency(root):
    """Of a free beam in bending; `root` of cos x cosh x = 1."""
    return root**2 / (2.0 * np.pi * LENGTH**2) * np.sqrt(E * SECOND_MOMENT / (RHO * AREA))


def timoshenko_frequency(highest):
    """Of the free beam, up to 20 % below that of Euler's and Bernoulli's beam [Hz]."""
    shear = 6.0 * (1.0 + NU) ** 2 / (7.0 + 12.0 * NU + 4.0 * NU**2) * G * AREA

    def end_loads(frequency):
        inertia = RHO * (2.0 * np.pi * frequency) ** 2
        # Rates of deflection, rotation, moment and force, the latter two divided by E I.
        unit = E * SECOND_MOMENT
        rates = np.array(
            [
                [0.0, 1.0, 0.0, unit / shear],
                [0.0, 0.0, 1.0, 0.0],
                [0.0, -inertia * SECOND_MOMENT / unit, 0.0, -1.0],
                [-inertia * AREA / unit, 0.0, 0.0, 0.0],
            ]
        )
        return np.linalg.det(expm(LENGTH * rates)[2:, :2])

    return brentq(end_loads, 0.8 * highest, highest)


@pytest.mark.further
def test_bar_in_tension(bar_modes, figure):
    found = of_kind(bar_modes, "axial")
    n = np.array([1, 2])
    plain = n * np.sqrt(E / RHO) / (2.0 * LENGTH)
    contraction = n * np.pi * NU / LENGTH * DIAMETER / np.sqrt(8.0)
    expected = plain / np.sqrt(1.0 + contraction**2)
    figure("bar, axial frequencies 1 and 2", found, expected, 1e-4, "Hz")
    # Of which contraction makes 0.06 and 0.23 %.
    assert 1.0 - found / plain == close(0.5 * contraction**2, rel=0.05)


def test_bar_in_torsion(bar_modes, figure):
    found = of_kind(bar_modes, "torsion")
    expected = np.arange(1, 4) * np.sqrt(G / RHO) / (2.0 * LENGTH)
    figure("bar, torsional frequencies 1 to 3", found, expected, 2e-4, "Hz")


def test_bar_in_bending(bar_modes, figure):
    found = of_kind(bar_modes, "bending")[:6].reshape(3, 2)
    euler = np.array([euler_frequency(root) for root in ROOTS])
    for number, bound in enumerate((6e-5, 2e-4, 5e-4)):
        expected = timoshenko_frequency(euler[number])
        # In both planes alike, though the mesh is not the same in them.
        figure(f"bar, bending frequency {number + 1}", found[number], expected, bound, "Hz")
    # Shear and rotary inertia take 2.5 % from the first mode of a bar ten diameters long.
    assert 1.0 - found[0, 0] / euler[0] == close(0.025, abs=0.001)


def torsional(superelements, held):
    """Frequencies of a row of bars that may only twist."""
    stiffness, mass = assemble_dynamic_shaft(superelements)
    ends = 6 * (len(superelements) + 1)
    others = [unknown for unknown in range(ends) if unknown % 6 != RZ]
    return natural_modes(stiffness, mass, [*others, *held])[0]


@pytest.mark.further
def test_two_pieces_of_a_bar_in_torsion(pieces, figure):
    """Rigid sections do not hinder torsion, so the pieces are the bar."""
    speed = np.sqrt(G / RHO)
    n = np.arange(1, 5)
    free = torsional([pieces[6500.0]] * 2, [])
    assert free[0] < 1e-3
    twisting = free[1:]
    for expected in n * speed / (2.0 * LENGTH):
        assert np.abs(twisting / expected - 1.0).min() < 3e-4
    # One end held; the rigid motion is gone.
    fixed = torsional([pieces[6500.0]] * 2, [RZ])
    for expected in (n - 0.5) * speed / (2.0 * LENGTH):
        assert np.abs(fixed / expected - 1.0).min() < 3e-4
    guyan = torsional([pieces[0.0]] * 2, [])
    angle = np.pi / 2.0 * n[:2]
    linear = np.sqrt(6.0 * (1.0 - np.cos(angle)) / (2.0 + np.cos(angle)))
    expected = linear * speed / (np.pi * LENGTH)
    figure("two pieces with Guyan's mass, torsion", guyan[1:], expected, 6e-5, "Hz")


@pytest.fixture(scope="module")
def throws(dimensions):
    """The limit, what is built for 800 Hz, the same without corrections, and Guyan's."""
    mesh = mesh_throw(CrankThrow(**dimensions), 3.0)
    classes = condensed(mesh, unit_pin_loads(mesh))
    limit = dynamic_superelement(mesh, STEEL, classes, 4000.0, cutoff_factor=2.0)
    return {
        "limit": limit,
        "asked": dynamic_superelement(mesh, STEEL, classes, HIGHEST),
        "guyan": of_modes(limit, 0),
        "twelve modes": of_modes(limit, 12),
    }


def in_bearings(throw):
    """Frequencies above zero, and each mode's share of twist in the motions of the main journals."""
    stiffness, mass = assemble_dynamic_shaft(
        [throw.turned(angle_deg=np.degrees(angle)) for angle in CRANKS]
    )
    sections = len(CRANKS) + 1
    held = [6 * section + unknown for section in range(sections) for unknown in (UX, UY)]
    frequencies, shapes = natural_modes(stiffness, mass, held)
    # Rotations count at the radius of the crank circle, or nearly.
    squares = shapes[: 6 * sections].reshape(sections, 6, -1) ** 2
    squares[:, 3:] *= 0.15**2
    return frequencies[2:], (squares[:, RZ].sum(axis=0) / squares.sum(axis=(0, 1)))[2:]


@pytest.mark.further
def test_four_throws_in_bearings(throws, figure):
    """Guyan's mass alone: 2.7 % and 13.7 % high in the first two torsional modes."""
    exact, twist = in_bearings(throws["limit"])
    frequencies = {name: in_bearings(throw)[0] for name, throw in throws.items()}
    first, second = np.flatnonzero(twist > 0.8)[:2]
    assert [first, second] == [0, 3]
    error = {
        name: found[: len(exact)] / exact[: len(found)] - 1.0 for name, found in frequencies.items()
    }
    by_guyan = error["guyan"]
    figure("Guyan alone, first torsional mode", by_guyan[first], 0.027, 0.002, "", "absolute")
    figure("Guyan alone, second torsional mode", by_guyan[second], 0.137, 0.005, "", "absolute")
    below = np.flatnonzero(exact <= HIGHEST)
    assert len(below) == 4
    # The first natural mode, at 1278 Hz, lies above 1.5 x 800 Hz: corrections alone.
    assert throws["asked"].natural == 0
    figure("four throws: error up to 800 Hz", error["asked"][below], 0.0, 2e-5, "", "absolute")
    assert 5e-4 < error["twelve modes"][below].max() < 1e-3
    for found in error.values():
        assert found.min() > -1e-9
