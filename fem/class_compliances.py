"""Pinned and guided compliances of a throw from two symmetry classes, without the whole 12 x 12.

Under these supports an axial force, a torque and a radial pin force each excite one class only.
Studies, which need nothing else, save half of the solving that way.
"""

import numpy as np
from numpy.typing import NDArray

from fem.condensation import CondensedClass

# Places of the unknowns among a class's three: axial (uy, uz, rx), torsional (ux, ry, rz).
AXIAL_MOTION, TORSIONAL_MOTION = 1, 2
KEPT = {
    "axial": {"pinned": (1, 2), "guided": (1,)},
    "torsional": {"pinned": (1, 2), "guided": (2,)},
}


def axial_answers(part: CondensedClass, support: str) -> tuple[float, float]:
    """Axial compliance e_n and influence coefficient c, both [m/N].

    Parameters
    ----------
    part : CondensedClass
        The class symmetric about both planes.
    support : {"pinned", "guided"}
    """
    pull = np.array([0.0, -2.0, 0.0])  # both ends move out by one: the throw lengthens by two
    radial = -part.pin_load[:, 1]
    kept = KEPT["axial"][support]
    return _stretch(part, kept, pull, AXIAL_MOTION), _stretch(part, kept, radial, AXIAL_MOTION)


def torsional_answer(part: CondensedClass, support: str) -> float:
    """Torsional compliance [rad/(N m)] from the class antisymmetric about both planes."""
    torque = np.array([0.0, 0.0, -2.0])
    return _stretch(part, KEPT["torsional"][support], torque, TORSIONAL_MOTION)


def _stretch(
    part: CondensedClass, kept: tuple[int, ...], work: NDArray[np.float64], motion: int
) -> float:
    """Lengthening (or twist) of the throw under loads that do `work` on the class's motions."""
    unknowns = list(kept)
    solution = np.zeros(3)
    # Four quarters make the throw.
    stiffness = 4.0 * part.stiffness[np.ix_(unknowns, unknowns)]
    solution[unknowns] = np.linalg.solve(stiffness, work[unknowns])
    return float(-2.0 * solution[motion])
