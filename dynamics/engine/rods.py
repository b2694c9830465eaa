"""Connecting rods: the motion of crank, rod and piston, and four models of the rod's mass."""

import math
from dataclasses import InitVar, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    ComplexArray,
    check_shape,
    finite_array,
    positive_number,
    radians_of,
)
from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.sentences import amount, in_si
from crankbase.summaries import frozen
from dynamics.engine import ROD_MODELS, RodModelName

# A rod may reach beyond its pins, and to each side, by this share of its length: room for big ends.
REACH = 0.5


@dataclass(frozen=True)
class ConnectingRod:
    """A connecting rod with its mass.

    Parameters
    ----------
    length : float
        L, between the centers of its pins [m].
    mass : float
        M [kg].
    center_distance : float
        l_shk: distance of its center of mass along the rod from the crankpin's center [m].
    inertia : float
        J, about the center of mass [kg m^2].
    center_offset : float, optional
        l_d: distance of the center of mass across the rod, positive to the side to which the
        crankpin moves as it passes the top [m].
    before, of_inertia : str, optional
        What messages begin with, and what they say before a wrong inertia.

    Raises
    ------
    InputError
        If a length, mass or inertia is not above zero, the center of mass is not between the
        pins, or no body of that mass and length has that inertia.
    """

    length: float
    mass: float
    center_distance: float
    inertia: float
    center_offset: float = 0.0
    before: InitVar[str] = "rod "
    of_inertia: InitVar[str] = "inertia: given"

    def __post_init__(self, before: str, of_inertia: str) -> None:
        positive_number("rod length", self.length, "m", "it is a length")
        positive_number("rod mass", self.mass, "kg", "it is a mass")
        positive_number("rod inertia", self.inertia, "kg m^2", "mass apart from its center has it")
        finite_array("rod center_distance", self.center_distance)
        finite_array("rod center_offset", self.center_offset)
        if not 0.0 < self.center_distance < self.length:
            raise InputError(
                f"{before}center_distance: given {in_si(self.center_distance, 'm')}; allowed is above 0 and "
                f"below the rod's length of {in_si(self.length, 'm')}, because the center of mass lies "
                "between the pins."
            )
        side = REACH * self.length
        if not abs(self.center_offset) < side:
            raise InputError(
                f"{before}center_offset: given {in_si(self.center_offset, 'm')}; allowed is less than "
                f"{in_si(side, 'm')} either way, because the center of mass lies within the rod."
            )
        largest = self.largest_inertia
        if self.inertia > largest:
            raise InputError(
                f"{before}{of_inertia} {amount(self.inertia, 'kg m^2')}; allowed is "
                f"{amount(largest, 'kg m^2')} or less, because no mass of {amount(self.mass, 'kg')} within "
                "half a length round the pins has more."
            )

    @property
    def largest_inertia(self) -> float:
        """The inertia with all mass at the corners of the region that the rod may occupy.

        For a center of mass at u between a and b, the mean square distance is at most
        (b - u)(u - a).
        """
        side = REACH * self.length
        along = (self.center_distance + side) * (self.length + side - self.center_distance)
        return self.mass * (along + side**2 - self.center_offset**2)

    @property
    def center(self) -> complex:
        """Center of mass l_shk + i l_d in the rod's own axes, from the crankpin [m]."""
        return complex(self.center_distance, self.center_offset)

    def model(self, name: RodModelName = "rigid") -> "RodModel":
        """Return a model of the rod's mass, one of `ROD_MODELS`."""
        check_choice("rod model", name, ROD_MODELS, "these are the models of a rod's mass")
        return _MAKERS[name](self)


@frozen("name", "length [m]", "mass [kg]", "center", "inertia [kg m^2]")
class RodModel:
    """Point masses on a rod, with an additional inertia in some models.

    Parameters
    ----------
    masses : tuple of n float
        Point masses [kg]; in some models negative.
    places : tuple of n complex
        Their positions, u + i v from the crankpin's center [m].
    added_inertia : float
        Inertia beyond that of the point masses [kg m^2].
    """

    name: RodModelName
    length: float
    masses: tuple[float, ...]
    places: tuple[complex, ...]
    added_inertia: float

    @property
    def mass(self) -> float:
        """Whole mass [kg]."""
        return math.fsum(self.masses)

    @property
    def center(self) -> complex:
        """Center of mass, u + i v from the crankpin's center [m]."""
        moments = np.array(self.masses) * np.array(self.places)
        return complex(math.fsum(moments.real), math.fsum(moments.imag)) / self.mass

    @property
    def inertia(self) -> float:
        """Inertia about the model's own center of mass [kg m^2]."""
        distances = np.abs(np.array(self.places) - self.center)
        return math.fsum(np.array(self.masses) * distances**2) + self.added_inertia


def two_mass(rod: ConnectingRod) -> RodModel:
    """Return masses at the two pins with the rod's mass and axial static moment.

    m_shp = M l_shk / L at the piston pin, m_shk = M l_shp / L at the crankpin (Yamanin, Zhukov,
    Baryshnikov 2018, doi 10.21821/2309-5180-2018-10-1-191-200). Inertia and lateral static moment
    are in general not the rod's.
    """
    at_piston = rod.mass * rod.center_distance / rod.length
    ends = (0j, complex(rod.length))
    return RodModel("two-mass", rod.length, (rod.mass - at_piston, at_piston), ends, 0.0)


def two_mass_with_inertia(rod: ConnectingRod) -> RodModel:
    """Return the two masses with the missing inertia, J_dop = J - i.

    i = m_shp l_shp^2 + m_shk l_shk^2 is that of the two masses about the point of the axis next to
    the center of mass. The lateral static moment is not the rod's.
    """
    plain = two_mass(rod)
    return replace(plain, name="two-mass with inertia", added_inertia=rod.inertia - plain.inertia)


def three_mass(rod: ConnectingRod) -> RodModel:
    """Return masses at both pins and at the center of mass.

    Equation (1) of Yamanin, Zhukov, Baryshnikov 2018, doi 10.21821/2309-5180-2018-10-1-191-200,
    simplified: at the crankpin J l_shp / (L (l_shk l_shp + l_d^2)), at the piston pin
    J l_shk / (L (l_shk l_shp + l_d^2)), the rest at the center of mass. Mass, axial static moment
    and inertia about D are the rod's; the lateral static moment is not unless l_d = 0: the model's
    center of mass is off by (m_shk + m_shp) l_d / M.
    """
    near, far = rod.center_distance, rod.length - rod.center_distance
    share = rod.inertia / (rod.length * (near * far + rod.center_offset**2))
    at_crank, at_piston = share * far, share * near
    masses = (at_crank, at_piston, rod.mass - at_crank - at_piston)
    places = (0j, complex(rod.length), rod.center)
    return RodModel("three-mass", rod.length, masses, places, 0.0)


def rigid(rod: ConnectingRod) -> RodModel:
    """Return the rod exactly: its mass at its center, with its inertia."""
    return RodModel("rigid", rod.length, (rod.mass,), (rod.center,), rod.inertia)


_MAKERS = {
    "rigid": rigid,
    "three-mass": three_mass,
    "two-mass with inertia": two_mass_with_inertia,
    "two-mass": two_mass,
}


@frozen("place [m]", "first", "second", eq=False)
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

    def velocity(self, speed: float | Array) -> ComplexArray:
        """Return the velocity at a crank speed [rad/s], in m/s."""
        return _at_places("speed", speed, self.first) * self.first

    def acceleration(
        self, speed: float | Array, crank_acceleration: float | Array = 0.0
    ) -> ComplexArray:
        """Return the acceleration at a crank speed [rad/s] and acceleration [rad/s^2], in m/s^2.

        Both may be arrays of shape (m,), one value for each position.
        """
        return np.asarray(_acceleration(self, speed, crank_acceleration))

    def turned(self, *, angle_deg: float) -> "PointMotion":
        """Return the motion turned by an angle [deg] in the sense of rotation."""
        turn = np.exp(1j * np.radians(finite_array("angle_deg", angle_deg)))
        return PointMotion(turn * self.place, turn * self.first, turn * self.second)


@frozen("angle_deg [deg]", "first", "second", eq=False)
class TurnMotion:
    """The angle through which a body rotates, in the sense of rotation of the crank.

    Parameters
    ----------
    angle_rad : ndarray of shape (m,)
        Angle [rad]; in degrees it is `angle_deg`.
    first, second : ndarray of shape (m,)
        Its derivatives by the crank angle, dimensionless.
    """

    angle_rad: Array
    first: Array
    second: Array

    @property
    def angle_deg(self) -> Array:
        """Angle [deg], shape (m,)."""
        return np.degrees(self.angle_rad)

    def acceleration(self, speed: float | Array, crank_acceleration: float | Array = 0.0) -> Array:
        """Return the angular acceleration [rad/s^2]; arguments and errors as of a point's."""
        return np.asarray(_acceleration(self, speed, crank_acceleration))


def _acceleration(
    motion: PointMotion | TurnMotion, speed: float | Array, gaining: float | Array
) -> Any:
    turning = _at_places("speed", speed, motion.first)
    gains = _at_places("crank_acceleration", gaining, motion.first)
    return turning**2 * motion.second + gains * motion.first


def _at_places(field: str, values: float | Array, places: Any) -> Array:
    """Check values that are one for all positions or one for each."""
    array = finite_array(field, values)
    check_shape(field, array, (), np.shape(places))
    return array


def crankpin_motion(crank_radius: float, angle: Array) -> PointMotion:
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
            f"rod length: given {in_si(length, 'm')} for a pin that goes {in_si(farthest * length, 'm')} "
            "aside of the cylinder's line; allowed is more than that, because the mechanism must turn."
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
            f"{field}: given {in_si(crank_radius, 'm')} with a rod of {in_si(rod_length, 'm')} and a pin "
            f"offset of {in_si(offset, 'm')}; allowed is less than rod length minus offset, "
            f"{in_si(rod_length - offset, 'm')}, because the crank must complete a revolution."
        )
