"""Static and dynamic unbalance of a throw or a shaft."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankbase.summaries import summarized
from geometry.mass import MassProperties


@summarized("static [kg m]", "dynamic [kg m^2]", "about [m]")
@dataclass(frozen=True)
class Unbalance:
    """What a turning part does to its bearings: at the angular speed w, force w^2 `static`.

    Attributes
    ----------
    static : (2,) array
        Static unbalance, the integral of (x, y) over the mass [kg m].
    dynamic : (2,) array
        Moment unbalance, the integral of (x, y) (z - `about`) over the mass [kg m^2]. The force that
        turns with the part has the moments w^2 (-dynamic[1], dynamic[0]) about the x and y axes.
    about : float
        Where along the shaft the moment is taken [m].
    """

    static: NDArray[np.float64]
    dynamic: NDArray[np.float64]
    about: float


def unbalance(masses: MassProperties, about: float) -> Unbalance:
    """Unbalance about the shaft axis.

    Parameters
    ----------
    masses : MassProperties
        Of a throw, or of a shaft.
    about : float
        Where along the shaft moments are taken, usually the middle [m].
    """
    static = masses.mass * masses.center[:2]
    # The off-diagonal terms of the inertia tensor are the negative products about the center.
    products = -masses.inertia[:2, 2]
    return Unbalance(static, products + static * (masses.center[2] - about), about)
