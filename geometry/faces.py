"""Faces of a solid in gmsh, measured through points on them, and the cylinders that they make up."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from crankbase.array_checks import Array
from geometry.gmsh_session import curvature_radius, middle_point
from geometry.solid import Zone

DIRECTION_TOLERANCE = 1e-5
# Surfaces that are what their type says; all others are fitted, since CAD programs sweep cylinders, too.
PLAIN_KINDS = ("Plane", "Cylinder", "Cone", "Sphere", "Torus")
# Points across a face and along an edge to which a plane or cylinder is fitted, and the fewest of them.
ACROSS, ALONG_EDGE, FEWEST = 9, 9, 6
# Normals spread by less across their main directions are those of a plane, and of a cylinder.
FLAT, ROUND = 1e-8, 1e-4
# Points keep to a fitted surface by this share of the face's size.
FIT = 1e-4
# Faces that meet at less than this angle meet smoothly [rad].
SMOOTH = math.radians(20.0)
# A gap in the angles of points round a cylinder, wider than this, is none of the face [rad].
WIDEST_GAP = math.pi / 3.0


@dataclass(frozen=True)
class Face:
    """A face in gmsh, in the model's frame.

    For planes, `axis` is the normal out of the solid; for cylinders, `point` is on the axis, `radius`
    is negative for holes, and `turn` is the angle that the face covers [rad].
    `deviation` is the largest distance of `points`, which are on the face, from the plane or cylinder.
    """

    tag: int
    kind: str
    point: Array
    axis: Array
    radius: float
    turn: float
    points: Array
    deviation: float = 0.0

    @property
    def low(self) -> float:
        """Smallest z of its points."""
        return float(self.points[:, 2].min())

    @property
    def high(self) -> float:
        """Largest z of its points."""
        return float(self.points[:, 2].max())

    @property
    def along(self) -> bool:
        """Whether normal or axis is parallel to the shaft, as far as the face's deviation lets it tell."""
        doubt = 3.0 * self.deviation / max(float(np.ptp(self.points @ self.axis)), 1e-300)
        return math.hypot(self.axis[0], self.axis[1]) < DIRECTION_TOLERANCE + doubt

    def placed(self, rotation: Array, origin: Array) -> "Face":
        """Return it in a frame whose axes are the rows of `rotation` and whose origin is `origin`."""
        return Face(
            self.tag,
            self.kind,
            rotation @ (self.point - origin),
            rotation @ self.axis,
            self.radius,
            self.turn,
            (self.points - origin) @ rotation.T,
            self.deviation,
        )


@dataclass(frozen=True)
class Round:
    """A cylinder along the shaft, of one face or more; radius negative for holes."""

    axis: tuple[float, float]
    radius: float
    low: float
    high: float
    turn: float
    tags: tuple[int, ...]
    deviation: float = 0.0

    @property
    def whole(self) -> bool:
        """Whether it covers the whole circle."""
        return self.turn > 2.0 * math.pi * (1.0 - 1e-6)

    @property
    def offset(self) -> float:
        """Distance of its axis from the z axis."""
        return math.hypot(*self.axis)

    @property
    def middle(self) -> float:
        """Place of its middle along the shaft."""
        return 0.5 * (self.low + self.high)


def measured_face(gmsh: Any, tag: int) -> Face:
    """Measure a face through points and normals on it, which every version of gmsh gives."""
    model = gmsh.model
    kind = str(model.getType(2, tag))
    if kind not in PLAIN_KINDS:
        return _fitted(gmsh, tag, kind)
    (u_low, v_low), (u_high, v_high) = model.getParametrizationBounds(2, tag)
    # A third of the way, not half: normals of a whole cylinder are then neither equal nor opposite.
    u_steps = u_low + (u_high - u_low) * np.array([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0])
    v_steps = np.linspace(v_low, v_high, 5)
    where = np.array([(u, v) for u in u_steps for v in v_steps])
    points = np.asarray(model.getValue(2, tag, where.ravel().tolist())).reshape(4, 5, 3)
    normal = np.asarray(model.getNormal(tag, where[7].tolist()), dtype=float)
    point, axis, radius, turn = points[1, 2], normal, 0.0, 0.0
    if kind == "Cylinder":
        other = np.asarray(model.getNormal(tag, where[12].tolist()), dtype=float)
        apart = normal - other
        radius = float((points[1, 2] - points[2, 2]) @ apart / (apart @ apart))
        point = points[1, 2] - radius * normal
        axis = points[1, 4] - points[1, 0]
        axis = axis / np.linalg.norm(axis)
        turn = u_high - u_low
    return Face(tag, kind, point, axis, radius, float(turn), points.reshape(-1, 3))


def _fitted(gmsh: Any, tag: int, kind: str) -> Face:
    """Measure the plane or cylinder that a swept or spline face is, through points within its edges."""
    model = gmsh.model
    (u_low, v_low), (u_high, v_high) = model.getParametrizationBounds(2, tag)
    steps = (np.arange(ACROSS) + 0.5) / ACROSS
    where = np.array(
        [(u_low + (u_high - u_low) * u, v_low + (v_high - v_low) * v) for u in steps for v in steps]
    )
    where = where[[bool(model.isInside(2, tag, pair.tolist(), True)) for pair in where]]
    edges = [np.zeros((0, 3))]
    for _, curve in model.getBoundary([(2, tag)], combined=False, oriented=False):
        (first,), (last,) = model.getParametrizationBounds(1, curve)
        along = np.linspace(first, last, ALONG_EDGE).tolist()
        edges.append(np.asarray(model.getValue(1, curve, along)).reshape(-1, 3))
    edge = np.concatenate(edges)
    middle = middle_point(gmsh, 2, tag)
    if len(where) < FEWEST:
        every = np.concatenate([edge, middle[None]])
        return Face(tag, kind, middle, np.array([1.0, 0.0, 0.0]), 0.0, 0.0, every)
    points = np.asarray(model.getValue(2, tag, where.ravel().tolist())).reshape(-1, 3)
    normals = np.asarray(model.getNormal(tag, where.ravel().tolist())).reshape(-1, 3)
    every = np.concatenate([points, edge])
    size = float(np.ptp(every, axis=0).max())
    spread, directions = np.linalg.eigh(normals.T @ normals / len(normals))
    if spread[1] < FLAT:
        off = float(np.abs((every - points[0]) @ directions[:, 2]).max())
        if off < FIT * size:
            return Face(tag, "Plane", points[0], normals[0], 0.0, 0.0, every, off)
    elif spread[0] < ROUND:
        # The axis is across all normals; every point is a radius along its normal from it.
        axis = directions[:, 0]
        across = np.eye(3) - np.outer(axis, axis)
        rows = [np.column_stack([across, across @ normal]) for normal in normals]
        solved = np.linalg.lstsq(np.concatenate(rows), (points @ across).ravel(), rcond=None)[0]
        center, radius = across @ solved[:3], float(solved[3])
        arms = (every - center) @ across
        off = float(np.abs(np.linalg.norm(arms, axis=1) - abs(radius)).max())
        if off < FIT * size:
            point = center + axis * float(points.mean(axis=0) @ axis)
            return Face(tag, "Cylinder", point, axis, radius, _turn(arms, axis), every, off)
    return Face(tag, kind, points[0], normals[0], 0.0, 0.0, every)


def _turn(arms: Array, axis: Array) -> float:
    """Angle that points round an axis cover, at distances `arms` from it [rad]."""
    first = arms[0] / np.linalg.norm(arms[0])
    angles = np.sort(np.arctan2(arms @ np.cross(axis, first), arms @ first))
    gap = float(np.diff(angles, append=angles[0] + 2.0 * math.pi).max())
    return 2.0 * math.pi - (gap if gap > WIDEST_GAP else 0.0)


def rounds_along(faces: Sequence[Face], tolerance: float) -> list[Round]:
    """Combine the faces of each cylinder along the shaft that touch or overlap along it."""
    groups: list[list[Face]] = []
    for face in sorted(faces, key=lambda face: face.low):
        if face.kind != "Cylinder" or not face.along:
            continue
        for group in groups:
            first = group[0]
            if (
                abs(first.radius - face.radius) < tolerance
                and math.dist(first.point[:2], face.point[:2]) < tolerance
                and face.low < max(item.high for item in group) + tolerance
            ):
                group.append(face)
                break
        else:
            groups.append([face])
    rounds = []
    for group in groups:
        low, high = min(face.low for face in group), max(face.high for face in group)
        # Of faces side by side along the shaft, each counts by its length.
        turn = sum(face.turn * (face.high - face.low) for face in group) / (high - low)
        x, y = (float(value) for value in group[0].point[:2])
        tags = tuple(face.tag for face in group)
        deviation = max(face.deviation for face in group)
        rounds.append(Round((x, y), group[0].radius, low, high, turn, tags, deviation))
    return rounds


@dataclass(frozen=True)
class Meetings:
    """How cylinders along the shaft, counted from 0, meet what is beside them.

    Attributes
    ----------
    fillets, corners : dict
        Faces of fillets, and curves of sharp inner corners, by number and end of the cylinder.
    radii : dict
        Smallest radius of the fillets there.
    """

    fillets: dict[Zone, list[int]]
    corners: dict[Zone, list[int]]
    radii: dict[Zone, float]

    def reach(self, number: int, item: Round, faces: Sequence[Face]) -> tuple[float, float]:
        """Start and end of a cylinder, fillets included."""
        tags = set(item.tags)
        tags.update(*(self.fillets.get((number, end), ()) for end in ("start", "end")))
        those = [face for face in faces if face.tag in tags]
        return min(face.low for face in those), max(face.high for face in those)


def meetings(
    gmsh: Any, solid: int, row: Sequence[Round], ends: set[int], tolerance: float
) -> Meetings:
    """Find fillets and sharp corners at the ends of cylinders along the shaft.

    Parameters
    ----------
    solid : int
        The solid's tag.
    row : sequence of Round
        The cylinders.
    ends : set of int
        Faces that end the solid, and are beside nothing.
    """
    found = Meetings({}, {}, {})
    for number, item in enumerate(row):
        for tag in item.tags:
            for curve, other in neighbors(gmsh, tag, {*item.tags, *ends}):
                point = middle_point(gmsh, 1, curve)
                first = point[2] - item.low < item.high - point[2]
                zone = (number, "start" if first else "end")
                out, normal = normal_at(gmsh, other, point), normal_at(gmsh, tag, point)
                if float(out @ normal) > math.cos(SMOOTH):
                    where = middle_point(gmsh, 2, other)
                    if math.dist(where[:2], item.axis) > item.radius + tolerance:
                        found.fillets.setdefault(zone, []).append(other)
                        radius = curvature_radius(gmsh, other)
                        found.radii[zone] = min(radius, found.radii.get(zone, math.inf))
                    continue
                # In an inner corner, the solid of the other face lies along the normal of this one.
                away = (normal - out) / np.linalg.norm(normal - out)
                probe = point + 1e-3 * item.radius * away
                if gmsh.model.isInside(3, solid, probe.tolist()):
                    found.corners.setdefault(zone, []).append(curve)
    unique = {zone: sorted(set(tags)) for zone, tags in found.fillets.items()}
    return Meetings(unique, found.corners, found.radii)


def neighbors(gmsh: Any, tag: int, besides: set[int]) -> Iterator[tuple[int, int]]:
    """Curves round a face, each with the face beyond it."""
    model = gmsh.model
    for _, curve in model.getBoundary([(2, tag)], combined=False, oriented=False):
        for other in model.getAdjacencies(1, curve)[0]:
            if other not in besides:
                yield int(curve), int(other)


def normal_at(gmsh: Any, tag: int, point: Array) -> Array:
    """Normal of a face out of the solid."""
    where = gmsh.model.getParametrization(2, tag, point.tolist())
    return np.asarray(gmsh.model.getNormal(tag, where), dtype=float)
