"""Kinematics of one crank, rod and piston."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.angles import radians_of
from crankbase.checks.arrays import finite_array, positive_number
from crankbase.errors import InputError
from dynamics.mechanism.motion import (
    PointMotion,
    TurnMotion,
    carried_point,
    crankpin_motion,
    rod_turn,
)


@dataclass(frozen=True)
class SliderCrank:
    """A crank, a connecting rod and a piston.

    Parameters
    ----------
    crank_radius : float
        R [m].
    rod_length : float
        L, between the centers of crankpin and piston pin [m].
    pin_offset : float, optional
        e: offset of the piston pin's line from the shaft axis, positive to the side to which
        the crankpin moves as it passes the top [m].

    Raises
    ------
    InputError
        If a length is not above zero, or the crank radius is not shorter than the rod less the
        offset.

    Notes
    -----
    Angles count from the position in which the crank is along the cylinder axis, in the sense of
    rotation. All derivatives are analytic.

    Examples
    --------
    >>> drive = SliderCrank(0.070, 0.265)
    >>> round(float(drive.travel(angle_deg=[180.0]).place[0].real), 9)
    0.14
    """

    crank_radius: float
    rod_length: float
    pin_offset: float = 0.0

    def __post_init__(self) -> None:
        positive_number("crank_radius", self.crank_radius, "m", "it is a length")
        positive_number("rod_length", self.rod_length, "m", "it is a length")
        check_reach("crank_radius", self.crank_radius, self.rod_length, self.pin_offset)

    @property
    def top_angle_deg(self) -> float:
        """Angle at which the piston is farthest from the shaft [deg]: sin = e / (L + R)."""
        return math.degrees(math.asin(self.pin_offset / (self.rod_length + self.crank_radius)))

    @property
    def bottom_angle_deg(self) -> float:
        """Angle at which the piston is nearest to the shaft [deg]: 180 + asin(e / (L - R))."""
        sine = self.pin_offset / (self.rod_length - self.crank_radius)
        return 180.0 + math.degrees(math.asin(sine))

    @property
    def top(self) -> float:
        """Greatest distance of the piston pin from the shaft, along the cylinder axis [m]."""
        return math.sqrt((self.rod_length + self.crank_radius) ** 2 - self.pin_offset**2)

    @property
    def stroke(self) -> float:
        """Travel of the piston from bottom to top [m]; more than 2 R with an offset."""
        lowest = math.sqrt((self.rod_length - self.crank_radius) ** 2 - self.pin_offset**2)
        return self.top - lowest

    def crankpin(self, *, angle_deg: ArrayLike) -> PointMotion:
        """Return the motion of the crankpin's center at angles [deg] of shape (m,)."""
        return crankpin_motion(self.crank_radius, radians_of("angle_deg", angle_deg, vector=True))

    def rod(self, *, angle_deg: ArrayLike) -> TurnMotion:
        """Return the rotation of the rod, -beta, at angles [deg] of shape (m,)."""
        return rod_turn(self.crankpin(angle_deg=angle_deg), self.rod_length, self.pin_offset)

    def rod_point(self, along: float, across: float = 0.0, *, angle_deg: ArrayLike) -> PointMotion:
        """Return the motion of a point of the rod.

        Parameters
        ----------
        along, across : float
            Distance from the crankpin's center towards the piston pin, and across the rod, positive
            to the side to which the crankpin moves as it passes the top [m].
        angle_deg : array_like of shape (m,)
            Crank angles [deg].

        Returns
        -------
        PointMotion
            s + i n with first and second derivatives by the crank angle.

        Raises
        ------
        InputError
            If a value is not a finite number.
        """
        place = finite_array("along, across", [along, across])
        return carried_point(
            self.crankpin(angle_deg=angle_deg),
            self.rod(angle_deg=angle_deg),
            complex(place[0], place[1]),
        )

    def piston(self, *, angle_deg: ArrayLike) -> PointMotion:
        """Return the motion of the piston pin, s + i e, at angles [deg] of shape (m,)."""
        return self.rod_point(self.rod_length, angle_deg=angle_deg)

    def travel(self, *, angle_deg: ArrayLike) -> PointMotion:
        """Return the distance of the piston from its top, real, and its derivatives by the angle [m]."""
        piston = self.piston(angle_deg=angle_deg)
        return PointMotion(
            (self.top - piston.place.real).astype(np.complex128),
            (-piston.first.real).astype(np.complex128),
            (-piston.second.real).astype(np.complex128),
        )


def check_reach(field: str, crank_radius: float, rod_length: float, pin_offset: float) -> None:
    """Refuse a crank that cannot complete a revolution.

    Raises
    ------
    InputError
        If the crank radius is not shorter than the rod less the offset.
    """
    offset = abs(float(finite_array("pin_offset", pin_offset)))
    if not crank_radius < rod_length - offset:
        raise InputError(
            f"{field}: given {crank_radius:g} m with a rod of {rod_length:g} m and a pin offset of "
            f"{offset:g} m; allowed is less than rod length minus offset, {rod_length - offset:g} m, "
            "because the crank must complete a revolution."
        )
