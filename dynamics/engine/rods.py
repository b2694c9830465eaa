"""Connecting rods and four models of their mass."""

import math
from dataclasses import dataclass, replace

import numpy as np

from crankbase.array_checks import finite_array, positive_number
from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.summaries import summarized
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

    def __post_init__(self) -> None:
        positive_number("rod length", self.length, "m", "it is a length")
        positive_number("rod mass", self.mass, "kg", "it is a mass")
        positive_number("rod inertia", self.inertia, "kg m^2", "mass apart from its center has it")
        finite_array("rod center_distance", self.center_distance)
        finite_array("rod center_offset", self.center_offset)
        if not 0.0 < self.center_distance < self.length:
            raise InputError(
                f"rod center_distance: given {self.center_distance:g} m; allowed is above 0 and below "
                f"the rod's length of {self.length:g} m, because the center of mass lies between the pins."
            )
        side = REACH * self.length
        if not abs(self.center_offset) < side:
            raise InputError(
                f"rod center_offset: given {self.center_offset:g} m; allowed is less than {side:g} m "
                "either way, because the center of mass lies within the rod."
            )
        largest = self.largest_inertia
        if self.inertia > largest:
            raise InputError(
                f"rod inertia: given {self.inertia:g} kg m^2; allowed is {largest:g} kg m^2 or less, "
                f"because no mass of {self.mass:g} kg within half a length round the pins has more."
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


@summarized("name", "length [m]", "mass [kg]", "center", "inertia [kg m^2]")
@dataclass(frozen=True)
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
