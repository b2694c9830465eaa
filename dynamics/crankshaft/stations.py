"""Slices of a crankshaft that separate axial, torsional and bending motion."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from crankbase.checks.arrays import FloatArray
from dynamics.crankshaft.shaft_throw import RX, RY, RZ, UX, UY, UZ, ShaftThrow
from dynamics.crankshaft.surroundings import ShaftSurroundings

CLASSES = ("axial", "torsional", "bending")
# Of a throw's mass and inertia, the share of either end section; the pins have the rest. By Simpson's
# rule, which integrates the square of a motion that grows linearly from end to end exactly.
END_SHARE = 1.0 / 6.0


@dataclass(frozen=True, eq=False)
class Stations:
    """Slices at sections, pins and end bodies, each moving as a rigid disc.

    Attributes
    ----------
    motions : (s, 6, u) array
        Of each slice at the point where the shaft axis passes through it (of an end body: of its center),
        per unknown, in the shaft's frame.
    axial_mass, lateral_mass : (s,) array
        [kg]
    polar, diametral : (s,) array
        Moments of inertia about the shaft axis and about a diameter [kg m^2].
    positions : (s,) array
        Along the shaft, from main bearing 1 [m].
    """

    motions: FloatArray
    axial_mass: FloatArray
    lateral_mass: FloatArray
    polar: FloatArray
    diametral: FloatArray
    positions: FloatArray

    def of(self, kept: FloatArray) -> "Stations":
        """Return the stations for some of the unknowns."""
        return replace(self, motions=self.motions[:, :, kept])

    def energy_shares(self, shapes: FloatArray, added_mass: FloatArray) -> FloatArray:
        """Split the energy of motions into axial, torsional and bending shares.

        Parameters
        ----------
        shapes : ndarray of shape (u, k)
            Motions of the unknowns, such as modes.
        added_mass : ndarray of shape (2, u, u)
            Mass matrices of bodies that only move along the shaft, and of those that only turn about it
            (damper ring, driven machine, shaft line).

        Returns
        -------
        ndarray of shape (3, k)
            Axial, torsional, bending; each 0 to 1, their sum 1.

        Notes
        -----
        The kinetic energy of an eccentric throw has products of rotation and translation, which belong
        to neither. Therefore each slice is referred to the point where the shaft axis passes through it, u,
        with the rotation r, and its energy is that of the three uncoupled systems:

            axial      m u_z^2
            torsional  J r_z^2            J about the shaft axis
            bending    m (u_x^2 + u_y^2) + D (r_x^2 + r_y^2)

        A sixth of a throw's m and J is at either end, the rest at its pins, with their mean motion
        (u = u_pin - r x r_pin, so that rotation of a pin about the shaft is no lateral
        motion); D = J / 2 as of a disc, end bodies have their own. Rods add to m of lateral motion
        and to J. The terms are squares, and turning the frame about the shaft axis changes none, so
        the shares are nonnegative, independent of the frame, and sum to 1. Without coupling
        they are the shares of the kinetic energy itself.
        """
        moved = np.einsum("siu,uk->sik", self.motions, shapes) ** 2
        along, about = np.sum(shapes * (added_mass @ shapes), axis=1)
        axial = self.axial_mass @ moved[:, UZ] + along
        torsional = self.polar @ moved[:, RZ] + about
        bending = self.lateral_mass @ (moved[:, UX] + moved[:, UY])
        bending = bending + self.diametral @ (moved[:, RX] + moved[:, RY])
        energies = np.vstack((axial, torsional, bending))
        return np.asarray(energies / energies.sum(axis=0))


def shaft_stations(
    throws: Sequence[ShaftThrow],
    around: ShaftSurroundings,
    pin_masses: FloatArray,
    starts: FloatArray,
    section_motions: FloatArray,
    pin_slices: Sequence[FloatArray],
) -> Stations:
    """Build the stations of an assembled shaft.

    Parameters
    ----------
    throws : sequence of n ShaftThrow
    around : ShaftSurroundings
    pin_masses : ndarray of shape (p,)
        Rods' and pistons' mass at each pin [kg].
    starts : ndarray of shape (n + 1,)
        Positions of the sections [m].
    section_motions : ndarray of shape (6 (n + 1), u)
    pin_slices : sequence of p ndarrays of shape (6, u)
        Motion of each pin's slice at the shaft axis, in the shaft's frame.

    Returns
    -------
    Stations
    """
    count = len(starts)
    sections, pins, pin_places = np.zeros((count, 2)), [], []
    for number, throw in enumerate(throws):
        own = np.array(throw.rigid_inertia())
        sections[number : number + 2] += END_SHARE * own
        share = (1.0 - 2.0 * END_SHARE) / len(throw.pins)
        pins += [share * own] * len(throw.pins)
        pin_places += [float(starts[number] + center[2]) for center in throw.pins]
    axial, polar = np.vstack((sections, *pins)).T
    diametral = 0.5 * polar
    radii = np.concatenate([np.hypot(*throw.pins[:, :2].T) for throw in throws])
    rods = np.concatenate((np.zeros(count), pin_masses))
    turning_rods = np.concatenate((np.zeros(count), pin_masses * radii**2))
    motions = np.concatenate((section_motions.reshape(count, 6, -1), pin_slices))
    bodies = around.bodies(count)
    of_bodies = np.array([[each.mass, each.polar_inertia, each.diametral] for each, _, _ in bodies])
    mass, turning, tilting = of_bodies.reshape(-1, 3).T
    centers = [body.center_motion(outward) @ motions[section] for body, section, outward in bodies]
    places = [float(starts[section]) + outward * body.overhang for body, section, outward in bodies]
    return Stations(
        motions=np.concatenate((motions, centers)) if centers else motions,
        axial_mass=np.concatenate((axial, mass)),
        lateral_mass=np.concatenate((axial + rods, mass)),
        polar=np.concatenate((polar + turning_rods, turning)),
        diametral=np.concatenate((diametral, tilting)),
        positions=np.concatenate((starts, pin_places, places)),
    )


def on_axis(center: FloatArray) -> FloatArray:
    """Return the matrix (6, 6) from a pin's motion to that of its slice where the shaft axis passes.

    Parameters
    ----------
    center : ndarray of shape (3,)
        Of the pin in the throw frame [m].
    """
    x, y = center[:2]
    moved = np.eye(6)
    # u - phi x r with r = (x, y, 0).
    moved[:3, 3:] = -np.array([[0.0, 0.0, -y], [0.0, 0.0, x], [y, -x, 0.0]])
    return moved
