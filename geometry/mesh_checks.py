"""The solid to be meshed, by the kernel, and the requirements on it and its mesh."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError, MeshError
from crankbase.memory import check_memory
from geometry.parts import ThrowParts
from geometry.shapes import corner_quality, element_volumes
from geometry.sizes import SHARES
from geometry.volume import throw_volume

# More unknowns than this are not tried: their factorization needs 20 GiB and minutes.
MOST_UNKNOWNS = 1_500_000
# That the mesher takes for each unknown, beside the solid [byte].
MESHING_MEMORY = 1e3
# The mesh may differ from the solid by this share of the volume, the solid from its description.
MESH_VOLUME_TOLERANCE = 1e-3
SOLID_VOLUME_TOLERANCE = 1e-5
# The kernel's roundings of exits of oil holes are off by up to 2 % of what they take.
ROUNDING_TOLERANCE = 0.05
# Mean ratio of the flattest tetrahedron.
SMALLEST_QUALITY = 1e-3


@dataclass(frozen=True)
class SolidProperties:
    """Properties of the meshed solid by the kernel.

    Attributes
    ----------
    volume : float
        [m^3]
    center : (3,) array
        Center of volume [m].
    second_moments : (3, 3) array
        Integral of x_i x_j over the volume about its center [m^5].
    """

    volume: float
    center: NDArray[np.float64]
    second_moments: NDArray[np.float64]

    def scaled(self, factor: float) -> "SolidProperties":
        """Return those of a solid scaled by a factor."""
        return SolidProperties(
            self.volume * factor**3, self.center * factor, self.second_moments * factor**5
        )


def check_budget(expected: int, size_factor: float) -> None:
    """Refuse a mesh of too many expected unknowns, for any computer or for the free memory.

    Raises
    ------
    InputError
    """
    check_memory(
        MESHING_MEMORY * expected,
        f"size_factor: given {size_factor:.3g}, whose mesh of about {expected:,} unknowns takes",
        "ask for a larger one",
    )
    if expected > MOST_UNKNOWNS:
        raise InputError(
            f"size_factor: given {size_factor:.3g}, which would make about {expected:,} unknowns; allowed "
            f"are {MOST_UNKNOWNS:,}, because solving more takes minutes and 20 GB."
        )


def solid_properties(gmsh: Any) -> SolidProperties:
    """Volume, center and second moments of all volumes in the model, which should be one."""
    tags = [tag for _, tag in gmsh.model.getEntities(3)]
    if len(tags) != 1:
        raise MeshError(f"the parts of the throw did not unite to one solid but to {len(tags)}.")
    volume = float(gmsh.model.occ.getMass(3, tags[0]))
    center = np.array(gmsh.model.occ.getCenterOfMass(3, tags[0]))
    inertia = np.array(gmsh.model.occ.getMatrixOfInertia(3, tags[0])).reshape(3, 3)
    return SolidProperties(volume, center, 0.5 * np.trace(inertia) * np.eye(3) - inertia)


def check_solid(parts: ThrowParts, part: str, solid: SolidProperties) -> None:
    """Refuse a solid that differs from its description: boolean operations may lose a part silently.

    Raises
    ------
    MeshError
    """
    expected = SHARES[part] * throw_volume(parts)
    rounded = sum(outlet.rounding_volume for hole in parts.drillings for outlet in hole.exits)
    off = SOLID_VOLUME_TOLERANCE * expected + ROUNDING_TOLERANCE * SHARES[part] * rounded
    if abs(solid.volume - expected) > off:
        raise MeshError(
            f"the solid has a volume of {solid.volume:.8g} m^3, its parts {expected:.8g} m^3."
        )


def check_quality(points: NDArray[np.float64], elements: NDArray[np.int64]) -> None:
    """Refuse a mesh with an element so flat that solving loses digits.

    Raises
    ------
    MeshError
    """
    worst = float(corner_quality(points, elements).min())
    if worst < SMALLEST_QUALITY:
        raise MeshError(
            f"an element is flat: its mean ratio is {worst:.1e}, below {SMALLEST_QUALITY:g}."
        )


def check_volume(
    points: NDArray[np.float64], elements: NDArray[np.int64], solid: SolidProperties
) -> None:
    """Refuse a mesh that does not have the solid's volume.

    Raises
    ------
    MeshError
    """
    volume = float(element_volumes(points, elements).sum())
    if not math.isclose(volume, solid.volume, rel_tol=MESH_VOLUME_TOLERANCE):
        raise MeshError(
            f"the mesh has a volume of {volume:.6g} m^3, the solid {solid.volume:.6g} m^3: "
            "they differ by more than 0.1 %."
        )
