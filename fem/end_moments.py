"""Dimensionless end moments that hold a throw against tilting.

With the throw's length L, from end section to end section, and loads of 1: Z on the pin towards the
shaft, T on it in the sense of rotation about +z, N through the throw along +z. A study fits equations to
these numbers; `regression.response_kinds` calculates all reactions from them.
"""

import numpy as np
from numpy.typing import NDArray

from fem.superelement import RX, RY, Superelement
from fem.supports import Neighbors, Support, all_end_motions

Array = NDArray[np.float64]

# Columns of loads: the axial force, the radial and the tangential one.
AXIAL, RADIAL, TANGENTIAL = 0, 2, 3


def end_moment_numbers(throw: Superelement, length: float, alike: bool) -> dict[str, float]:
    """Find the end moments of a throw per unit load and length, and rho_x.

    Parameters
    ----------
    throw : Superelement
    length : float
        Of the throw [m].
    alike : bool
        Whether its webs are equal: only then its results between neighbors follow from a few numbers.

    Returns
    -------
    dict
        By the names of `fem.responses.RESPONSES`. Radial and axial ones are moments about -x on the
        left, about +x on the right end; tangential ones are about y, half of the difference of left and
        right (opposed) or half of their sum (alike). The throw is free to lengthen.
    """
    guided = _end_moments(throw, "guided", length)
    found = {
        "radial_end_moment_left_guided": -guided[RX, RADIAL],
        "radial_end_moment_right_guided": guided[6 + RX, RADIAL],
        "axial_end_moment_left_guided": -guided[RX, AXIAL],
        "axial_end_moment_right_guided": guided[6 + RX, AXIAL],
        "tangential_end_moment_opposed_guided": _opposed(guided),
        "tangential_end_moment_alike_guided": _alike(guided),
    }
    if not alike:
        return found
    in_line, quarter, opposite = (
        _end_moments(throw, Neighbors(angle, angle), length) for angle in (0.0, 90.0, 180.0)
    )
    straight, turned = _opposed(in_line), _opposed(quarter)
    return found | {
        "radial_end_moment_in_line": -in_line[RX, RADIAL],
        "axial_end_moment_in_line": -in_line[RX, AXIAL],
        "tangential_end_moment_in_line": straight,
        "tangential_end_moment_opposite": _alike(opposite),
        "cross_tilt_stiffness_ratio": turned / (straight - turned),
    }


def _end_moments(throw: Superelement, support: Support, length: float) -> Array:
    """Reactions (12, 4) on the ends of the axially free throw under each load, divided by the length."""
    one = throw.joined if isinstance(support, Neighbors) else throw
    loads = np.hstack([one.radial_loads[:, :1], one.tangential_loads[:, :1]])
    reactions = one.stiffness @ all_end_motions(throw, support, loads)
    reactions[:, RADIAL:] -= loads
    return np.asarray(reactions[:12] / length)


def _opposed(moments: Array) -> float:
    return float(moments[RY, TANGENTIAL] - moments[6 + RY, TANGENTIAL]) / 2.0


def _alike(moments: Array) -> float:
    return float(moments[RY, TANGENTIAL] + moments[6 + RY, TANGENTIAL]) / 2.0
