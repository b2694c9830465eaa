"""Equal throws of a crankshaft, and the symmetry of one, told by its faces under turns and mirrors."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from crankbase.array_checks import Array
from geometry.faces import Face, measured_face
from geometry.gmsh_session import curvature_radius

# Surfaces are the same to this share of the throw's length, and of its square; volumes to their own one.
SAME, SAME_VOLUME = 1e-4, 1e-5
# How a throw becomes another one: the signs of x and z in its frame. Turning end for end changes both.
EQUAL, MIRRORED, REVERSED, BOTH = "equal", "mirrored", "reversed", "mirrored and reversed"
CHANGES = {EQUAL: (1.0, 1.0), REVERSED: (-1.0, -1.0), MIRRORED: (-1.0, 1.0), BOTH: (1.0, -1.0)}


@dataclass(frozen=True)
class Signature:
    """A throw's surfaces without those of its end sections, each perhaps of several faces.

    Attributes
    ----------
    volume, low, high : float
        Of the throw, and its reach along z.
    areas, centers : arrays (n,), (n, 3)
        Of its surfaces.
    angles : tuple of float
        Of its pins, about +z from +y [rad].
    """

    volume: float
    low: float
    high: float
    areas: Array
    centers: Array
    angles: tuple[float, ...]

    def change_to(self, other: "Signature") -> str | None:
        """Return the first of `CHANGES` by which it becomes another throw, or None."""
        length = self.high - self.low
        alike = (
            abs(self.volume / other.volume - 1.0) < SAME_VOLUME
            and abs((other.high - other.low) / length - 1.0) < SAME
            and len(self.areas) == len(other.areas)
        )
        if not alike:
            return None
        for way, (across, along) in CHANGES.items():
            back = _turned(-self.angles[0 if along > 0.0 else -1])
            if self._becomes(
                other, _turned(other.angles[0]) @ np.diag([across, 1.0, along]) @ back
            ):
                return way
        return None

    def _becomes(self, other: "Signature", change: Array) -> bool:
        """Whether a rotation or mirror about the middle puts each surface where the other one has one."""
        length = self.high - self.low
        there = KDTree(np.column_stack([other.local / length, other.areas / length**2]))
        here = np.column_stack([self.local @ change.T / length, self.areas / length**2])
        apart, places = map(np.asarray, there.query(here))
        return len(np.unique(places)) == len(here) and bool(apart.max() < SAME)

    @property
    def local(self) -> Array:
        """Centers of the surfaces, z from the throw's middle."""
        middle = 0.5 * (self.low + self.high)
        return np.asarray(self.centers - np.array([0.0, 0.0, middle]))

    @property
    def symmetry(self) -> str:
        """The part of the throw that is enough: quarter, half or full."""
        # Mirrors alone: with several pins a throw may become itself by a mirror and a turn, and has no part.
        turn = _turned(self.angles[0])
        mirrored, both = (
            self._becomes(self, turn @ np.diag([across, 1.0, along]) @ turn.T)
            for across, along in (CHANGES[MIRRORED], CHANGES[BOTH])
        )
        return "full" if not mirrored else "quarter" if both else "half"


def _turned(angle: float) -> Array:
    """The rotation by an angle about z."""
    sine, cosine = np.sin(angle), np.cos(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def signature(gmsh: Any, solid: int, low: float, high: float, angles: Sequence[float]) -> Signature:
    """Measure a solid between two end planes; parameters as the attributes of `Signature`."""
    occ, length = gmsh.model.occ, high - low
    surfaces: list[tuple[str, Array]] = []
    areas: list[float] = []
    moments: list[Array] = []
    for _, tag in gmsh.model.getBoundary([(3, solid)], combined=False, oriented=False):
        area, center = occ.getMass(2, tag), np.array(occ.getCenterOfMass(2, tag))
        face = measured_face(gmsh, tag)
        end = min(abs(center[2] - low), abs(center[2] - high)) < SAME * length
        if end and face.kind == "Plane":
            continue
        # Programs divide surfaces as they like.
        key = _surface(gmsh, face, length)
        for place, (kind, other) in enumerate(surfaces):
            if kind == face.kind and float(np.abs(key - other).max()) < SAME * length:
                areas[place] += area
                moments[place] = moments[place] + area * center
                break
        else:
            surfaces.append((face.kind, key))
            areas.append(area)
            moments.append(area * center)
    volume = float(occ.getMass(3, solid))
    centers = np.array(moments) / np.array(areas)[:, None]
    return Signature(volume, low, high, np.array(areas), centers, tuple(angles))


def _surface(gmsh: Any, face: Face, length: float) -> Array:
    """Numbers by which faces of one surface are known, lengths in the model's unit."""
    if face.kind == "Plane":
        return np.array([*(length * face.axis), face.point @ face.axis])
    if face.kind == "Cylinder":
        axis = face.axis * np.sign(face.axis[np.argmax(np.abs(face.axis))])
        foot = face.point - axis * float(face.point @ axis)
        return np.array([*(length * axis), *foot, face.radius])
    return np.array([face.low, face.high, min(curvature_radius(gmsh, face.tag), length)])
