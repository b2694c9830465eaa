"""Shaft pieces of classical shape: axial and torsional compliance, mass, inertia by theory.

Cross sections stay plane: compliance is the integral of 1 / (E A) or 1 / (G I_p) along the piece.
This is exact for cylinders, good for slender cones, and too stiff next to steps of the diameter,
where the force spreads; a cone of one to two in place of a step is a usual correction.
"""

import math
from dataclasses import dataclass, replace
from typing import Literal, Protocol, get_args

from crankbase.checks.arrays import SMALLEST, nonnegative_number, positive_number
from crankbase.checks.choices import check_choice
from crankbase.checks.scalars import whole_within
from crankbase.errors import InputError

Motion = Literal["torsional", "axial"]
BoreShape = Literal["cylindrical", "proportional"]
# Below this share of the smaller diameter a bore's closed form for torsion loses digits to
# cancellation, and its series in the fourth power of the share is exact with three terms.
SMALL_BORE = 0.05


class ElasticMaterial(Protocol):
    """Material of a shaft: E [Pa], G [Pa], density [kg/m^3]."""

    @property
    def youngs_modulus(self) -> float:
        """E [Pa]."""
        ...

    @property
    def shear_modulus(self) -> float:
        """G [Pa]."""
        ...

    @property
    def density(self) -> float:
        """[kg/m^3]."""
        ...


MOST_PARTS = 10_000


@dataclass(frozen=True)
class ShaftMaterial:
    """Elastic constants and density of a shaft; the default is steel, 210 GPa and nu = 0.3.

    Parameters
    ----------
    youngs_modulus, shear_modulus : float
        E and G [Pa].
    density : float
        [kg/m^3]
    """

    youngs_modulus: float = 2.1e11
    shear_modulus: float = 2.1e11 / 2.6
    density: float = 7850.0

    def __post_init__(self) -> None:
        why = "the material resists"
        positive_number("material.youngs_modulus", self.youngs_modulus, "Pa", why)
        positive_number("material.shear_modulus", self.shear_modulus, "Pa", why)
        positive_number("material.density", self.density, "kg/m^3", "the material has mass")


SHAFT_STEEL = ShaftMaterial()


@dataclass(frozen=True)
class ShaftCone:
    """A conical piece of shaft, solid or bored; a cylinder where both diameters are equal.

    Parameters
    ----------
    length : float
        [m]
    left_diameter, right_diameter : float
        Outside, at either end [m].
    bore : float, optional
        Diameter of a cylindrical bore, or at the left end that of a proportional one [m].
    bore_shape : {"cylindrical", "proportional"}, optional
        A proportional bore is a constant share of the outer diameter.
    material : optional
        Anything with youngs_modulus, shear_modulus and density; steel by default.
    name : str, optional

    Raises
    ------
    InputError
        If a size is not above zero, or the bore leaves no wall.

    Notes
    -----
    With D linear from D_1 to D_2 over L, and a bore d, the integrals along the piece are

        solid: int dz / D^2 = L / (D_1 D_2),
               int dz / D^4 = L (D_1^2 + D_1 D_2 + D_2^2) / (3 D_1^3 D_2^3),
               int D^2 dz = L (D_1^2 + D_1 D_2 + D_2^2) / 3,
               int D^4 dz = L (D_1^4 + D_1^3 D_2 + ... + D_2^4) / 5,

    for a proportional bore the same, with D^2 - d^2 = (1 - s^2) D^2 and D^4 - d^4 = (1 - s^4) D^4. For
    a cylindrical bore, by partial fractions, with t = D_2 - D_1,

        int dz / (D^2 - d^2) = L / (2 d t) ln(1 + 2 d t / ((D_2 + d)(D_1 - d))),
        int dz / (D^4 - d^4) = (1 / (2 d^2)) (the former - L / (d t) atan(d t / (d^2 + D_1 D_2))).
    """

    length: float
    left_diameter: float
    right_diameter: float
    bore: float = 0.0
    bore_shape: BoreShape = "cylindrical"
    material: ElasticMaterial = SHAFT_STEEL
    name: str = ""

    def __post_init__(self) -> None:
        why = "a shaft has a cross section"
        positive_number("shaft.length", self.length, "m", "a piece of shaft has a length")
        left = positive_number("shaft.left_diameter", self.left_diameter, "m", why)
        right = positive_number("shaft.right_diameter", self.right_diameter, "m", why)
        bore = nonnegative_number("shaft.bore", self.bore, "m", "it is a diameter, or none")
        near = "closed forms exist for these; others are near to cones in a row"
        check_choice("shaft.bore_shape", self.bore_shape, get_args(BoreShape), near)
        wall = left if self.bore_shape == "proportional" else min(left, right)
        if bore >= wall:
            raise InputError(
                f"shaft.bore: given {bore:g} m; allowed is less than {wall:g} m, because a wall is left "
                "around it."
            )

    @property
    def torsional_compliance(self) -> float:
        """Twist per torque [rad/(N m)]."""
        return 32.0 / (math.pi * self.material.shear_modulus) * self._inverse_fourth_powers()

    @property
    def axial_compliance(self) -> float:
        """Lengthening per force [m/N]."""
        return 4.0 / (math.pi * self.material.youngs_modulus) * self._inverse_squares()

    @property
    def mass(self) -> float:
        """[kg]."""
        return 0.25 * math.pi * self.material.density * self._powers(2)

    @property
    def polar_inertia(self) -> float:
        """Moment of inertia about the shaft axis [kg m^2]."""
        return math.pi / 32.0 * self.material.density * self._powers(4)

    @property
    def section_modulus(self) -> float:
        """Smallest torsional section modulus I_p / (D / 2), without stress concentration [m^3]."""
        outer = min(self.left_diameter, self.right_diameter)
        inner = self._bore_at(outer)
        return math.pi / 16.0 * (outer**4 - inner**4) / outer

    def divided(self, parts: int) -> tuple["ShaftCone", ...]:
        """Return the piece divided into equally long ones, at most 10,000.

        Raises
        ------
        InputError
            If the number is not such a number.
        """
        why = "a piece of a shaft is cut into some parts"
        parts = whole_within("parts", parts, 1, MOST_PARTS, why)
        step = (self.right_diameter - self.left_diameter) / parts
        diameters = [self.left_diameter + step * number for number in range(parts)]
        return tuple(
            replace(
                self,
                length=self.length / parts,
                left_diameter=left,
                right_diameter=right,
                bore=self._bore_at(left),
            )
            for left, right in zip(diameters, [*diameters[1:], self.right_diameter], strict=True)
        )

    def _bore_at(self, diameter: float) -> float:
        if self.bore_shape == "cylindrical":
            return self.bore
        return self.bore * diameter / self.left_diameter

    def _powers(self, power: int) -> float:
        """Return the integral of D^p - d^p along the piece, p even."""
        first, last = self.left_diameter, self.right_diameter
        outer = _power_sum(first, last, power) / (power + 1)
        if self.bore_shape == "proportional":
            return self.length * outer * (1.0 - (self.bore / first) ** power)
        return self.length * (outer - self.bore**power)

    def _inverse_squares(self) -> float:
        """Return the integral of 1 / (D^2 - d^2) along the piece."""
        first, last, bore = self.left_diameter, self.right_diameter, self.bore
        if self.bore_shape == "proportional":
            return self.length / (first * last * (1.0 - (bore / first) ** 2))
        twice = 2.0 * bore * (last - first)
        if abs(twice) < SMALLEST:  # the logarithm's limit
            return self.length / (first * last - bore**2)
        return self.length / twice * math.log1p(twice / ((last + bore) * (first - bore)))

    def _inverse_fourth_powers(self) -> float:
        """Return the integral of 1 / (D^4 - d^4) along the piece."""
        first, last, bore = self.left_diameter, self.right_diameter, self.bore
        if self.bore_shape == "proportional":
            solid = self.length * _inverse_powers(first, last, 4)
            return solid / (1.0 - (bore / first) ** 4)
        widening = last - first
        if widening == 0.0:
            return self.length / (first**4 - bore**4)
        if bore < SMALL_BORE * min(first, last):
            terms = (bore**power * _inverse_powers(first, last, power + 4) for power in (0, 4, 8))
            return self.length * sum(terms)
        angle = math.atan(bore * widening / (bore**2 + first * last))
        rest = self._inverse_squares() - self.length / (bore * widening) * angle
        return rest / (2.0 * bore**2)


def _power_sum(first: float, last: float, power: int) -> float:
    """Return (b^(p+1) - a^(p+1)) / (b - a) = a^p + a^(p-1) b + ... + b^p."""
    return math.fsum(first ** (power - k) * last**k for k in range(power + 1))


def _inverse_powers(first: float, last: float, power: int) -> float:
    """Return the mean of 1 / D^p from D = a to b: (a^(1-p) - b^(1-p)) / ((p - 1)(b - a))."""
    size = (power - 1) * (first * last) ** (power - 1)
    return _power_sum(first, last, power - 2) / size


def shaft_cylinder(
    length: float,
    diameter: float,
    bore: float = 0.0,
    material: ElasticMaterial = SHAFT_STEEL,
    name: str = "",
) -> ShaftCone:
    """Return a cylindrical piece of shaft, solid or hollow.

    Parameters
    ----------
    length, diameter : float
        [m]
    bore : float, optional
        Diameter of the bore [m].
    material : optional
        Anything with youngs_modulus, shear_modulus and density; steel by default.
    name : str, optional

    Raises
    ------
    InputError
        If a size is not above zero, or the bore leaves no wall.
    """
    outer = positive_number("shaft.diameter", diameter, "m", "a shaft has a cross section")
    return ShaftCone(length, outer, outer, bore, "cylindrical", material, name)


def shaft_flange(
    thickness: float,
    diameter: float,
    bore: float = 0.0,
    material: ElasticMaterial = SHAFT_STEEL,
    name: str = "",
) -> ShaftCone:
    """Return a flange: a short cylinder of large diameter, with inertia and little compliance.

    Parameters
    ----------
    thickness, diameter : float
        [m]
    bore : float, optional
        Diameter of the bore [m].
    material : optional
        Anything with youngs_modulus, shear_modulus and density; steel by default.
    name : str, optional

    Raises
    ------
    InputError
        If a size is not above zero, or the bore leaves no wall.

    Notes
    -----
    The compliance is that of the whole cross section. As the shaft's torque does not reach the rim of
    a thin flange, this is a lower bound. Bolts and joint count as rigid.
    """
    positive_number("flange.thickness", thickness, "m", "a flange has a thickness")
    return shaft_cylinder(thickness, diameter, bore, material, name)
