"""Mass, center of mass and inertia of a throw, from the mesh of its quarter."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.mesh import ThrowMesh, element_quadrature
from geometry.throw import CrankThrow


@dataclass(frozen=True)
class MassProperties:
    """Mass properties of a throw in the throw frame.

    Attributes
    ----------
    mass : float
        [kg]
    center : (3,) array
        Center of mass [m].
    inertia : (3, 3) array
        Inertia tensor about the center of mass [kg m^2].
    """

    mass: float
    center: NDArray[np.float64]
    inertia: NDArray[np.float64]

    @property
    def inertia_about_shaft(self) -> float:
        """Moment of inertia about the shaft axis [kg m^2]."""
        return float(self.inertia[2, 2] + self.mass * (self.center[0] ** 2 + self.center[1] ** 2))


def mass_properties(throw: CrankThrow, mesh: ThrowMesh, density: float) -> MassProperties:
    """Integrate mass, center and inertia over the quarter and mirror them.

    Parameters
    ----------
    throw : CrankThrow
        The throw that was meshed.
    mesh : ThrowMesh
        Its quarter.
    density : float
        [kg/m^3]

    Returns
    -------
    MassProperties
    """
    where, volumes = element_quadrature(mesh.points, mesh.elements)
    # Distances from the crank plane and from the middle plane are mirrored: products with them vanish.
    where = where - np.array([0.0, 0.0, throw.length / 2.0])
    masses = 4.0 * density * volumes
    mass = float(masses.sum())
    height = float(masses @ where[:, 1]) / mass
    second = np.einsum("p,pi,pj->ij", masses, where, where)
    second[0, 1] = second[1, 0] = second[0, 2] = second[2, 0] = second[1, 2] = second[2, 1] = 0.0
    second[1, 1] -= mass * height**2
    inertia = np.trace(second) * np.eye(3) - second
    return MassProperties(mass, np.array([0.0, height, throw.length / 2.0]), inertia)
