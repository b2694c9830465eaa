"""How the foot of a cylinder's rod moves: with the crankpin, or on the rod that it is hinged to."""

from crankbase.checks.arrays import FloatArray

from dynamics.engine.cylinder import EngineCylinder
from dynamics.mechanism.motion import (
    PointMotion,
    carried_point,
    crankpin_motion,
    rod_turn,
)


def crank_angle_from_axis(cylinder: EngineCylinder, shaft_angles: FloatArray) -> FloatArray:
    """Return alpha, the crank's angle from the cylinder's axis [rad], for shaft angles [rad]."""
    return shaft_angles - cylinder.top_shaft_angle


def hinged_foot(
    crank_radius: float, main: EngineCylinder, hinged: EngineCylinder, shaft_angles: FloatArray
) -> PointMotion:
    """Return the motion of a slave pin in the frame of the hinged rod's cylinder.

    Parameters
    ----------
    crank_radius : float
        R [m].
    main, hinged : EngineCylinder
        The cylinder whose rod is on the crankpin, and the one whose rod hangs on that rod.
    shaft_angles : ndarray of shape (m,)
        [rad]

    Notes
    -----
    P = R exp(i alpha) + R_1 exp(i gamma) exp(-i beta) in the main cylinder's frame. Turned to the
    other cylinder's frame, with gamma equal to the angle between the banks, it gives (2) and (4) of
    Mikhina, Vyalkov 2024, Politekhnicheskiy molodezhnyy zhurnal no. 05 (94).
    """
    if hinged.slave_pin is None:
        raise ValueError("the rod is not hinged")
    crank = crankpin_motion(crank_radius, crank_angle_from_axis(main, shaft_angles))
    turn = rod_turn(crank, main.rod.length, main.pin_offset)
    pin = carried_point(crank, turn, hinged.slave_pin.place)
    return pin.turned(main.bank_angle - hinged.bank_angle)
