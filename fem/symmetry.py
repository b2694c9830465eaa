"""Symmetry classes: motions of a whole throw from its meshed part.

A throw whose pins lie in one plane is symmetric about that crank plane (x = 0); if its webs are equal
it is symmetric about the middle plane of its pin as well. Any motion is then a sum of parts, each
symmetric or antisymmetric about each of these planes: four for a throw cut to a quarter, two for a
half, and the motion itself for a throw that is not cut. Each part is one problem on what is meshed,
with displacements blocked on the cuts.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from geometry.mesh import ThrowMesh
from geometry.solid import CRANK_PLANE, MIDDLE_PLANE

# A mirror reverses the displacement across it, and the rotations about the axes along it.
MIRROR_X = np.array([-1.0, 1.0, 1.0, 1.0, -1.0, -1.0])
MIRROR_Z = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0])


@dataclass(frozen=True)
class MirrorImage:
    """The meshed part of a throw, or a mirror image of it.

    Attributes
    ----------
    across_crank, across_middle : bool
        Planes of reflection.
    length : float
        Length of the whole throw [m].
    """

    across_crank: bool
    across_middle: bool
    length: float

    @property
    def motion_signs(self) -> NDArray[np.float64]:
        """Signs (6,) of mirrored displacements and rotations."""
        signs = np.ones(6)
        if self.across_crank:
            signs = signs * MIRROR_X
        if self.across_middle:
            signs = signs * MIRROR_Z
        return signs

    @property
    def signs(self) -> NDArray[np.float64]:
        """Signs (3,) of mirrored displacements."""
        return self.motion_signs[:3]

    @property
    def inside_out(self) -> bool:
        """Whether a single mirror has inverted elements and facets."""
        return self.across_crank != self.across_middle

    def points(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Places (n, 3) of the image of points of the meshed part [m]."""
        shift = np.array([0.0, 0.0, self.length if self.across_middle else 0.0])
        return np.asarray(points * self.signs + shift)


def mirror_images(mesh: ThrowMesh) -> tuple[MirrorImage, ...]:
    """Return the images that make the whole throw, the meshed part itself first."""
    choices = [(False, True) if cut else (False,) for cut in CUTS[mesh.part]]
    return tuple(MirrorImage(crank, middle, mesh.length) for crank, middle in product(*choices))


@dataclass(frozen=True)
class SymmetryClass:
    """One of the parts of a motion.

    Attributes
    ----------
    crank_plane, middle_plane : int
        +1 symmetric, -1 antisymmetric about that plane, 0 where the throw is not cut there.
    """

    crank_plane: int
    middle_plane: int

    @property
    def copies(self) -> int:
        """Number of copies of the meshed part in the whole throw."""
        return int(2 ** (abs(self.crank_plane) + abs(self.middle_plane)))

    @property
    def end_unknowns(self) -> NDArray[np.int64]:
        """The unknowns (of ux uy uz rx ry rz) that an end section has in this class."""
        return np.flatnonzero(self.crank_plane * MIRROR_X >= 0.0)

    @property
    def ends(self) -> NDArray[np.float64]:
        """Motions (12, k) of both end sections for unit amplitudes of the class.

        The left end's unknowns, which the right end mirrors if the middle plane is a cut and has
        in addition otherwise.
        """
        return self.unit_motions(MIRROR_X, MIRROR_Z)

    def unit_motions(
        self, mirror_x: NDArray[np.float64], mirror_z: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Motions (2 n, k) of both end sections as of `ends`, for n motions of a section.

        Parameters
        ----------
        mirror_x, mirror_z : (n,) array
            Their signs when mirrored across the crank plane and across the section.
        """
        left = np.eye(len(mirror_x))[:, self.crank_plane * mirror_x >= 0.0]
        if self.middle_plane:
            return np.vstack([left, self.middle_plane * mirror_z[:, None] * left])
        return np.asarray(np.kron(np.eye(2), left), dtype=np.float64)

    @property
    def shares(self) -> NDArray[np.float64]:
        """Amplitudes (k, 12) of the class in unit motions of both end sections."""
        return amplitude_shares(self.ends)

    @property
    def central_motions(self) -> NDArray[np.bool_]:
        """Which motions (6,) of a point on all cuts the class has: along and about x, y, z."""
        return (self.crank_plane * MIRROR_X >= 0.0) & (self.middle_plane * MIRROR_Z >= 0.0)

    def parity(self, image: MirrorImage) -> float:
        """Return +1 if the class moves an image as the mirror image of the meshed part, or -1."""
        sign = self.crank_plane if image.across_crank else 1
        return float(sign * (self.middle_plane if image.across_middle else 1))

    def blocked_axes(self) -> dict[str, tuple[int, ...]]:
        """Displacements blocked on each cut."""
        blocked: dict[str, tuple[int, ...]] = {}
        if self.crank_plane:
            blocked[CRANK_PLANE] = (0,) if self.crank_plane > 0 else (1, 2)
        if self.middle_plane:
            blocked[MIDDLE_PLANE] = (2,) if self.middle_plane > 0 else (0, 1)
        return blocked


def amplitude_shares(ends: NDArray[np.float64]) -> NDArray[np.float64]:
    """Amplitudes (k, m) of unit motions `ends` (m, k), which are orthogonal, in motions of the ends."""
    return np.asarray(ends.T / np.sum(ends**2, axis=0)[:, None])


# Which planes each part of a throw is cut by: the crank plane, the middle plane.
CUTS = {"quarter": (1, 1), "half": (1, 0), "full": (0, 0)}


def symmetry_classes(part: str) -> tuple[SymmetryClass, ...]:
    """All classes of a "quarter", "half" or "full" throw."""
    signs = ((1, -1) if cut else (0,) for cut in CUTS[part])
    return tuple(SymmetryClass(*planes) for planes in product(*signs))


def axial_class(part: str) -> SymmetryClass:
    """Return the class that an axial force and a radial force on the pins excite."""
    return SymmetryClass(*CUTS[part])


def torsional_class(part: str) -> SymmetryClass:
    """Return the class that a torque excites; that of the axial force in a throw that is not cut."""
    crank_plane, middle_plane = CUTS[part]
    return SymmetryClass(-crank_plane, -middle_plane)
