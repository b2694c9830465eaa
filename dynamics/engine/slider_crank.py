"""Kinematics of one crank, rod and piston; motion of a point or a body as the crank turns.

Plane vectors are complex numbers. In the frame of a cylinder the real part s runs along its axis
away from the shaft, the imaginary part n across it, to the side to which the crankpin moves as it
passes the top. Multiplication by exp(i a) turns a vector by a in the sense of rotation.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    ComplexArray,
    FloatArray,
    check_shape,
    finite_array,
    positive_number,
    radians_of,
)
from crankbase.errors import InputError
from crankbase.summaries import summarized


@summarized("place [m]", "first", "second")
@dataclass(frozen=True, eq=False)
class PointMotion:
    """A moving point.

    Parameters
    ----------
    place : complex ndarray of shape (m,)
        Position [m].
    first, second : complex ndarray of shape (m,)
        Its derivatives by the crank angle [m/rad, m/rad^2].
    """

    place: ComplexArray
    first: ComplexArray
    second: ComplexArray

    def velocity(self, speed: float | FloatArray) -> ComplexArray:
        """Return the velocity at a crank speed [rad/s], in m/s."""
        return _at_places("speed", speed, self.first) * self.first

    def acceleration(
        self, speed: float | FloatArray, crank_acceleration: float | FloatArray = 0.0
    ) -> ComplexArray:
        """Return the acceleration at a crank speed [rad/s] and acceleration [rad/s^2], in m/s^2.

        Both may be arrays of shape (m,), one value for each position.
        """
        return np.asarray(_acceleration(self, speed, crank_acceleration))

    def turned(self, *, angle_deg: float) -> "PointMotion":
        """Return the motion turned by an angle [deg] in the sense of rotation."""
        turn = np.exp(1j * np.radians(finite_array("angle_deg", angle_deg)))
        return PointMotion(turn * self.place, turn * self.first, turn * self.second)


@summarized("angle_deg [deg]", "first", "second")
@dataclass(frozen=True, eq=False)
class TurnMotion:
    """The angle through which a body rotates, in the sense of rotation of the crank.

    Parameters
    ----------
    angle_rad : ndarray of shape (m,)
        Angle [rad]; in degrees it is `angle_deg`.
    first, second : ndarray of shape (m,)
        Its derivatives by the crank angle, dimensionless.
    """

    angle_rad: FloatArray
    first: FloatArray
    second: FloatArray

    @property
    def angle_deg(self) -> FloatArray:
        """Angle [deg], shape (m,)."""
        return np.degrees(self.angle_rad)

    def acceleration(
        self, speed: float | FloatArray, crank_acceleration: float | FloatArray = 0.0
    ) -> FloatArray:
        """Return the angular acceleration [rad/s^2]; arguments and errors as of a point's."""
        return np.asarray(_acceleration(self, speed, crank_acceleration))


def _acceleration(
    motion: PointMotion | TurnMotion, speed: float | FloatArray, gaining: float | FloatArray
) -> Any:
    turning = _at_places("speed", speed, motion.first)
    gains = _at_places("crank_acceleration", gaining, motion.first)
    return turning**2 * motion.second + gains * motion.first


def _at_places(field: str, values: float | FloatArray, places: Any) -> FloatArray:
    """Check values that are one for all positions or one for each."""
    array = finite_array(field, values)
    check_shape(field, array, (), np.shape(places))
    return array


def crankpin_motion(crank_radius: float, angle: FloatArray) -> PointMotion:
    """Return the motion of the crankpin R exp(i alpha), angles [rad] from the cylinder axis."""
    place = crank_radius * np.exp(1j * angle)
    return PointMotion(place, 1j * place, -place)


def rod_turn(foot: PointMotion, length: float, pin_offset: float) -> TurnMotion:
    """Return the rotation of a rod with a guided foot and its other end on a line.

    Parameters
    ----------
    foot : PointMotion
        Center of the crankpin, or of the pin that hinges the rod to another rod, in the frame of
        the rod's own cylinder.
    length : float
        Distance L of the two pins [m].
    pin_offset : float
        The piston pin runs on n = e [m].

    Notes
    -----
    From L sin beta = n - e: beta' = n' / (L cos beta), beta'' = n'' / (L cos beta) + beta'^2 tan beta.
    """
    sine = (foot.place.imag - pin_offset) / length
    farthest = float(np.max(np.abs(sine), initial=0.0))
    if farthest >= 1.0:
        raise InputError(
            f"rod length: given {length:g} m for a pin that goes {farthest * length:g} m aside of the "
            "cylinder's line; allowed is more than that, because the mechanism must turn."
        )
    cosine = np.sqrt(1.0 - sine**2)
    first = foot.first.imag / (length * cosine)
    second = foot.second.imag / (length * cosine) + first**2 * sine / cosine
    return TurnMotion(-np.arcsin(sine), -first, -second)


def carried_point(foot: PointMotion, turn: TurnMotion, place: complex) -> PointMotion:
    """Return the motion of a point of a rod.

    Parameters
    ----------
    place : complex
        Position on the rod, u + i v: u from the foot towards the piston pin, v across [m].

    Notes
    -----
    D = A + (u + i v) exp(i t); D'' = A'' + (i t'' - t'^2)(u + i v) exp(i t). This replaces the
    accelerations printed in Yamanin, Zhukov, Baryshnikov 2018, doi
    10.21821/2309-5180-2018-10-1-191-200, whose signs and factors are wrong.
    """
    arm = place * np.exp(1j * turn.angle_rad)
    return PointMotion(
        foot.place + arm,
        foot.first + 1j * turn.first * arm,
        foot.second + (1j * turn.second - turn.first**2) * arm,
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

        Returns
        -------
        PointMotion
            s + i n with first and second derivatives by the crank angle.
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
    """Refuse a crank that cannot complete a revolution."""
    offset = abs(float(finite_array("pin_offset", pin_offset)))
    if not crank_radius < rod_length - offset:
        raise InputError(
            f"{field}: given {crank_radius:g} m with a rod of {rod_length:g} m and a pin offset of "
            f"{offset:g} m; allowed is less than rod length minus offset, {rod_length - offset:g} m, "
            "because the crank must complete a revolution."
        )
