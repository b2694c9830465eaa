"""Pinned and guided compliances of a throw from one symmetry class each, without the whole 12 x 12.

Under these supports an axial force and radial pin forces in the crank plane excite only one class, a
torque another. Refinement needs only the first, and so saves more than half of the solving.
"""

import numpy as np
from numpy.typing import NDArray

from fem.condensation import CondensedClass
from fem.loads import RADIAL
from fem.supports import STRETCH, TWIST, free_motions


def class_axial_compliances(part: CondensedClass, support: str) -> tuple[float, float]:
    """Axial compliance e_n and influence coefficient c of the first pin, both [m/N].

    Parameters
    ----------
    part : CondensedClass
        The meshed part's `fem.symmetry.axial_class`.
    support : {"pinned", "guided"}
    """
    pull = STRETCH @ part.symmetry.ends
    lengthening = axial_motion(part, support)
    return float(lengthening @ pull), float(lengthening @ part.pin_loads[0, :, :3] @ RADIAL)


def axial_motion(part: CondensedClass, support: str) -> NDArray[np.float64]:
    """Amplitudes (k,) of the class under a unit axial force; arguments as for `class_axial_compliances`."""
    return unit_response(part, support, STRETCH @ part.symmetry.ends)


def class_torsional_compliance(part: CondensedClass, support: str) -> float:
    """Torsional compliance [rad/(N m)] from the meshed part's `fem.symmetry.torsional_class`."""
    torque = TWIST @ part.symmetry.ends
    return float(unit_response(part, support, torque) @ torque)


def unit_response(
    part: CondensedClass, support: str, load: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Amplitudes (k,) of the supported class under a load (k,) that does work on its unit motions.

    Multiplied with a second load they are, by reciprocity, also the motion of the first one under that.
    """
    free = free_motions(part.symmetry.ends, support)
    stiffness = part.symmetry.copies * part.stiffness[np.ix_(free, free)]
    amplitudes = np.zeros(len(load))
    amplitudes[free] = np.linalg.solve(stiffness, load[free])
    return amplitudes
