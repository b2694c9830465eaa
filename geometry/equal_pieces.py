"""Equal throws of a crankshaft, and the symmetry of one, told by its faces under turns and mirrors."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from crankbase.array_checks import Array, Integers
from geometry.faces import Face, measured_face, neighbors, normal_at
from geometry.gmsh_session import middle_point

# Surfaces are the same to this share of the throw's length, and of its square; volumes to their own one.
SAME, SAME_VOLUME = 1e-4, 1e-5
# An edge divides one surface where normals differ by no more than this cosine, and curvatures by this share.
SAME_NORMAL, SAME_CURVATURE = 1.0 - 1e-6, 1e-3
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
    faces: dict[int, Face] = {}
    for _, tag in gmsh.model.getBoundary([(3, solid)], combined=False, oriented=False):
        face, height = measured_face(gmsh, tag), float(occ.getCenterOfMass(2, tag)[2])
        end = min(abs(height - low), abs(height - high)) < SAME * length
        # Slivers beside a cut have next to no area, and perhaps no center.
        sliver = occ.getMass(2, tag) < (SAME * length) ** 2
        if not (sliver or (end and face.kind == "Plane")):
            faces[tag] = face
    surfaces = _surfaces(gmsh, faces, length)
    areas = np.array([occ.getMass(2, tag) for tag in faces])
    moments = areas[:, None] * np.array([occ.getCenterOfMass(2, tag) for tag in faces])
    of_surface = np.bincount(surfaces, areas).astype(float)
    centers = np.column_stack([np.bincount(surfaces, moments[:, k]) for k in range(3)])
    volume = float(occ.getMass(3, solid))
    return Signature(volume, low, high, of_surface, centers / of_surface[:, None], tuple(angles))


def _surfaces(gmsh: Any, faces: Mapping[int, Face], length: float) -> Integers:
    """Number the surface of each face: programs divide surfaces as they like.

    Faces are of one plane or cylinder wherever they are, of any other surface if an edge between them is
    none: normals and curvatures are the same on both sides.
    """
    places = {tag: place for place, tag in enumerate(faces)}
    joined: list[tuple[int, int]] = []
    known: list[tuple[str, Array, int]] = []
    for tag, face in faces.items():
        key = _plain_surface(face, length)
        if key is None:
            beyond = neighbors(gmsh, tag, {tag})
            joined += [
                (places[tag], places[other])
                for curve, other in beyond
                if other in faces
                and faces[other].kind == face.kind
                and _goes_on(gmsh, curve, tag, other)
            ]
            continue
        for kind, other_key, place in known:
            if kind == face.kind and float(np.abs(key - other_key).max()) < SAME * length:
                joined.append((places[tag], place))
                break
        else:
            known.append((face.kind, key, places[tag]))
    pairs = np.array(joined, dtype=np.int64).reshape(-1, 2).T
    graph = coo_array((np.ones(pairs.shape[1]), tuple(pairs)), shape=(len(faces), len(faces)))
    return np.asarray(connected_components(graph, directed=False)[1])


def _plain_surface(face: Face, length: float) -> Array | None:
    """Numbers by which a plane or cylinder is known, lengths in the model's unit."""
    if face.kind == "Plane":
        return np.array([*(length * face.axis), face.point @ face.axis])
    if face.kind == "Cylinder":
        axis = face.axis * np.sign(face.axis[np.argmax(np.abs(face.axis))])
        foot = face.point - axis * float(face.point @ axis)
        return np.array([*(length * axis), *foot, face.radius])
    return None


def _goes_on(gmsh: Any, curve: int, tag: int, other: int) -> bool:
    """Whether a surface goes on across the middle of an edge."""
    point = middle_point(gmsh, 1, curve)
    if float(normal_at(gmsh, tag, point) @ normal_at(gmsh, other, point)) < SAME_NORMAL:
        return False
    first, second = (
        np.sort(np.abs(np.ravel(gmsh.model.getPrincipalCurvatures(face, where)[:2])))
        for face in (tag, other)
        for where in [gmsh.model.getParametrization(2, face, point.tolist())]
    )
    return bool(np.abs(first - second).max() < SAME_CURVATURE * first.max())
