"""A throw's superelement a second time, from the forces on its end sections alone.

The superelement is made of strain energies and of the pins' mean motions, which gives a symmetric
stiffness even where a solution is poor. What has to hold the end sections, under motions of them and
under loads on the pins, follows from the same displacements without that symmetry: how far the two
differ is how far the displacements are out of equilibrium. Work and its reverse are equal (E. Betti,
Il Nuovo Cimento 7-8, 1872), for the two are solutions under different loads.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fem.condensation import CondensedClass
from fem.superelement import Superelement, combine_classes


def superelement_of_end_forces(
    classes: Sequence[CondensedClass], radials: NDArray[np.float64]
) -> Superelement:
    """Build the superelement of a throw from the forces on its end sections.

    Parameters
    ----------
    classes : sequence of CondensedClass
        All symmetry classes of the meshed part.
    radials : (pins, 3) array
        Direction of a radial force on each pin.

    Returns
    -------
    Superelement
        Its stiffness is symmetric, and its pin loads are those of `combine_classes`, only as far as
        the solutions are in equilibrium.
    """
    return combine_classes(
        [replace(one, stiffness=one.end_forces, pin_loads=one.pin_reactions) for one in classes],
        radials,
    )
