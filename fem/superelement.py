"""The throw as a superelement: stiffness between its two end sections, and the pin's load."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem.condensation import CondensedClass
from fem.symmetry import MIRROR_X, MIRROR_Z

Array = NDArray[np.float64]

# Places of the unknowns of an end section.
UX, UY, UZ, RX, RY, RZ = range(6)


@dataclass(frozen=True)
class Superelement:
    """A throw condensed to the motions of its end sections.

    Attributes
    ----------
    stiffness : (12, 12) array
        Unknowns ux uy uz rx ry rz of the left, then of the right end section, in the throw frame.
    pin_load : (12, 3) array
        End loads that a unit force on the pin along x, y, z is equivalent to: with end forces F and
        pin force p the end motions q satisfy ``stiffness @ q = F + pin_load @ p``.
    """

    stiffness: Array
    pin_load: Array

    def turned(self, angle: float) -> "Superelement":
        """Return the superelement of the throw turned by an angle [rad] about the shaft, +z.

        The motions are then in the shaft frame; pin forces stay in the frame of the throw.
        """
        turn = section_rotation(angle)
        both = np.kron(np.eye(2), turn)
        return Superelement(both @ self.stiffness @ both.T, both @ self.pin_load)


def section_rotation(angle: float) -> Array:
    """Matrix (6, 6) that turns the motions of a section by an angle [rad] about z."""
    cosine, sine = np.cos(angle), np.sin(angle)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return np.kron(np.eye(2), turn)


def combine_classes(classes: Sequence[CondensedClass]) -> Superelement:
    """Build the superelement of a whole throw from the four symmetry classes of its quarter.

    Parameters
    ----------
    classes : sequence of CondensedClass

    Returns
    -------
    Superelement
    """
    stiffness = np.zeros((12, 12))
    pin_load = np.zeros((12, 3))
    for part in classes:
        ends = part.symmetry.ends
        # Four quarters; half the sum of both ends' motions is the class's share of a motion.
        stiffness += 4.0 * (0.5 * ends) @ part.stiffness @ (0.5 * ends).T
        moves = (MIRROR_X[:3] == part.symmetry.crank_plane) & (
            MIRROR_Z[:3] == part.symmetry.middle_plane
        )
        pin_load += 0.5 * ends @ (part.pin_load * moves)
    return Superelement(stiffness, pin_load)
