"""Mass, center of mass, inertia and unbalance of a throw."""

import math
from collections.abc import Sequence
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array
from crankbase.choices import is_number
from crankbase.errors import InputError
from crankbase.results import Internal, Quantity, Result, result
from geometry.mesh import SolidProperties, ThrowMesh

# [kg/m^3] No body is denser by far.
LARGEST_DENSITY = 1e6


@result("mass", "center", "inertia", eq=True)
class MassProperties(Result):
    """Mass properties of a throw in the throw frame."""

    mass: Annotated[float, Quantity("kg")]
    center: Annotated[Array, Quantity("m", "center of mass (3,)")]
    inertia: Annotated[Array, Quantity("kg m^2", "about the center of mass (3, 3)")]

    @property
    def inertia_about_shaft(self) -> float:
        """Moment of inertia about the shaft axis [kg m^2]."""
        return float(self.inertia[2, 2] + self.mass * (self.center[0] ** 2 + self.center[1] ** 2))

    def moved(self, *, angle_deg: float, along: float) -> "MassProperties":
        """Return those of the part turned by an angle [deg] about +z and moved along the shaft [m]."""
        angle = np.radians(angle_deg)
        cosine, sine = np.cos(angle), np.sin(angle)
        turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        center = turn @ self.center + np.array([0.0, 0.0, along])
        return MassProperties(self.mass, center, turn @ self.inertia @ turn.T)


def check_density(density: object) -> None:
    """Refuse an impossible density."""
    if not is_number(density) or not 0.0 < density <= LARGEST_DENSITY:
        raise InputError(
            f"density: given {density!r}; allowed are numbers above 0 and up to {LARGEST_DENSITY:g} in "
            "kg/m^3, because every body has mass."
        )


def combined_mass(parts: Sequence[MassProperties]) -> MassProperties:
    """Combined mass properties of several parts as one rigid body."""
    mass = sum(part.mass for part in parts)
    center = sum((part.mass * part.center for part in parts), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for part in parts:
        arm = part.center - center
        inertia += part.inertia + part.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return MassProperties(mass, center, inertia)


def cylinder_mass_properties(
    diameter: float, start: float, end: float, density: float
) -> MassProperties:
    """Mass properties of a solid cylinder about the shaft axis from `start` to `end` [m]."""
    check_density(density)
    length = end - start
    mass = density * np.pi / 4.0 * diameter**2 * length
    across = mass * (diameter**2 / 16.0 + length**2 / 12.0)
    inertia = np.diag([across, across, mass * diameter**2 / 8.0])
    return MassProperties(mass, np.array([0.0, 0.0, 0.5 * (start + end)]), inertia)


def mass_properties(mesh: ThrowMesh, density: float) -> MassProperties:
    """Mass, center and inertia of the whole throw, from the solid that was meshed.

    Parameters
    ----------
    mesh : ThrowMesh
        Of the throw or of a part of it, which is mirrored.
    density : float
        [kg/m^3]

    Raises
    ------
    InputError
        If the density is not a number above zero.
    """
    return solid_mass_properties(mesh.solid, mesh.part, mesh.length, density)


def solid_mass_properties(
    solid: SolidProperties, part: str, length: float, density: float
) -> MassProperties:
    """Mass properties of the whole throw from the solid of a part of it, by mirroring."""
    check_density(density)
    # About a point on the planes of symmetry, so that mirrored products cancel.
    origin = np.array([0.0, 0.0, length / 2.0])
    center = solid.center - origin
    second = solid.second_moments + solid.volume * np.outer(center, center)
    copies = np.ones(3)
    if part in ("quarter", "half"):
        copies[0] = 0.0
    if part == "quarter":
        copies[2] = 0.0
    number = {"quarter": 4.0, "half": 2.0, "full": 1.0}[part]
    mirrored = np.outer(copies, copies) + np.diag(1.0 - copies)
    mass = number * solid.volume * density
    second = number * density * second * mirrored
    center = center * copies
    second -= mass * np.outer(center, center)
    return MassProperties(mass, center + origin, np.trace(second) * np.eye(3) - second)


@result("static", "dynamic", "about", eq=True)
class Unbalance(Result):
    """Effect of a rotating part on its bearings: at the angular speed w, force w^2 `static`.

    The force that rotates with the part has the moments w^2 (-dynamic[1], dynamic[0]) about the x
    and y axes, at the point `about` of the shaft [m].
    """

    static: Annotated[Array, Quantity("kg m", "integral of (x, y) over the mass (2,)")]
    dynamic: Annotated[
        Array, Quantity("kg m^2", "integral of (x, y) (z - about) over the mass (2,)")
    ]
    about: Internal[float] = math.nan


def unbalance(masses: MassProperties, about: float) -> Unbalance:
    """Unbalance about the shaft axis.

    Parameters
    ----------
    masses : MassProperties
        Of a throw, or of a shaft.
    about : float
        Point of the shaft about which moments are taken, usually the middle [m].
    """
    static = masses.mass * masses.center[:2]
    # The off-diagonal terms of the inertia tensor are the negative products about the center.
    products = -masses.inertia[:2, 2]
    return Unbalance(static, products + static * (masses.center[2] - about), about)
