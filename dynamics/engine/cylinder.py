"""A cylinder of an engine: its piston, rod and position."""

import cmath
import math
from dataclasses import KW_ONLY, dataclass

from crankbase.checks.arrays import FloatArray, finite_array, nonnegative_number, positive_number
from crankbase.checks.scalars import is_whole
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.mechanism.motion import PointMotion, carried_point, crankpin_motion, rod_turn
from dynamics.mechanism.rods import ConnectingRod


@dataclass(frozen=True)
class SlavePin:
    """The pin by which a rod is hinged to the rod of another cylinder on the same crankpin.

    Parameters
    ----------
    main_cylinder : int
        Number of the cylinder whose rod carries the pin, from 1.
    radius : float
        R_1 (r in some papers), from the crankpin's center [m].
    angle_deg : float
        From the main rod's axis, in the sense of rotation [deg]; equal to the angle between the
        cylinders' axes in most engines.
    """

    main_cylinder: int
    radius: float
    _: KW_ONLY
    angle_deg: float

    def __post_init__(self) -> None:
        if not is_whole(self.main_cylinder):
            raise InputError(
                f"slave pin main_cylinder: given {self.main_cylinder!r}; allowed is a whole number, "
                "because cylinders are counted from 1."
            )
        positive_number("slave pin radius", self.radius, "m", "it is a length")
        finite_array("slave pin angle_deg", self.angle_deg)

    @property
    def place(self) -> complex:
        """Position on the main rod, u + i v from the crankpin's center [m]."""
        return cmath.rect(self.radius, math.radians(self.angle_deg))


@summarized(
    "bore [m]",
    "piston_mass [kg]",
    "crank_angle_deg [deg]",
    "bank_angle_deg [deg]",
    "position [m]",
    "pin_offset [m]",
)
@dataclass(frozen=True)
class EngineCylinder:
    """One cylinder with its piston and rod, and its position.

    Parameters
    ----------
    bore : float
        [m]
    piston_mass : float
        Piston with rings and pin, and crosshead and piston rod if present [kg].
    rod : ConnectingRod
    crank_angle_deg : float, optional
        Angle of its crankpin about +z, counted from +y, when the shaft angle is zero [deg].
    bank_angle_deg : float, optional
        Angle of its axis about +z, counted from +y [deg].
    position : float, optional
        Of its axis along the shaft [m].
    pin_offset : float, optional
        e: offset of its axis from the shaft axis, positive to the side to which the crankpin
        moves as it passes the top [m].
    slave_pin : SlavePin, optional
        Hinge of its rod, if not at the crankpin.
    """

    bore: float
    piston_mass: float
    rod: ConnectingRod
    _: KW_ONLY
    crank_angle_deg: float = 0.0
    bank_angle_deg: float = 0.0
    position: float = 0.0
    pin_offset: float = 0.0
    slave_pin: SlavePin | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.rod, ConnectingRod):
            raise InputError(
                f"rod: given {self.rod!r}; allowed is a ConnectingRod, because its mass and length count."
            )
        positive_number("bore", self.bore, "m", "it is a length")
        positive_number("piston_mass", self.piston_mass, "kg", "it is a mass")
        for name in ("crank_angle_deg", "bank_angle_deg", "position", "pin_offset"):
            finite_array(name, getattr(self, name))

    @property
    def area(self) -> float:
        """Area of the piston [m^2]."""
        return 0.25 * math.pi * self.bore**2

    @property
    def top_shaft_angle_deg(self) -> float:
        """Shaft angle at which its crank is along its axis, away from the shaft [deg]."""
        return self.bank_angle_deg - self.crank_angle_deg


@dataclass(frozen=True)
class RotatingMass:
    """A mass that rotates with the shaft: a counterweight, or the unbalance of a throw.

    Parameters
    ----------
    static_moment : float
        Mass times radius [kg m].
    angle_deg : float
        Of its center of mass about +z, counted from +y, when the shaft angle is zero [deg].
    position : float
        Along the shaft [m].
    """

    static_moment: float
    _: KW_ONLY
    angle_deg: float
    position: float = 0.0

    def __post_init__(self) -> None:
        nonnegative_number("static_moment", self.static_moment, "kg m", "it is mass times radius")
        finite_array("angle_deg", self.angle_deg)
        finite_array("position", self.position)


def cylinder_crankpin(
    cylinder: EngineCylinder, crank_radius: float, shaft_angles: FloatArray
) -> PointMotion:
    """Return the motion of a crankpin in its cylinder's frame, shaft angles [rad] of shape (m,)."""
    return crankpin_motion(crank_radius, shaft_angles - math.radians(cylinder.top_shaft_angle_deg))


def hinged_foot(
    crank_radius: float, main: EngineCylinder, hinged: EngineCylinder, shaft_angles: FloatArray
) -> PointMotion:
    """Return the motion of a slave pin in the frame of the hinged rod's cylinder.

    Parameters
    ----------
    crank_radius : float
        R [m].
    main, hinged : EngineCylinder
        The cylinder whose rod is on the crankpin, and the one whose rod is hinged to that rod.
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
    crank = cylinder_crankpin(main, crank_radius, shaft_angles)
    turn = rod_turn(crank, main.rod.length, main.pin_offset)
    pin = carried_point(crank, turn, hinged.slave_pin.place)
    return pin.turned(angle_deg=main.bank_angle_deg - hinged.bank_angle_deg)
