"""Faces of a CAD part, measured through gmsh: planes, cylinders, their curvature."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from geometry.gmsh_session import gmsh_session
from geometry.step_file import PLANE, StepFace

Array = NDArray[np.float64]
# The unit in which the kernel reads files, and the scale that gmsh applies then.
UNIT_OPTION, SCALE_OPTION = "Geometry.OCCTargetUnit", "Geometry.OCCScaling"
DIRECTION_TOLERANCE = 1e-5


@dataclass(frozen=True)
class Face:
    """A face in gmsh, in the file's frame.

    For planes, `axis` is the normal out of the solid; for cylinders, `point` is on the axis, `radius`
    is negative for holes, and `turn` is the angle that the face covers [rad].
    """

    tag: int
    kind: str
    point: Array
    axis: Array
    radius: float
    turn: float
    low: float
    high: float

    @property
    def along(self) -> bool:
        """Whether normal or axis is parallel to the shaft."""
        return math.hypot(self.axis[0], self.axis[1]) < DIRECTION_TOLERANCE


@dataclass(frozen=True)
class Round:
    """A cylinder along the shaft, of one face or more; radius negative for holes."""

    axis: tuple[float, float]
    radius: float
    low: float
    high: float
    turn: float
    tags: tuple[int, ...]

    @property
    def whole(self) -> bool:
        """Whether it covers the whole circle."""
        return self.turn > 2.0 * math.pi * (1.0 - 1e-6)


@contextmanager
def opened_part(path: str) -> Iterator[tuple[Any, int]]:
    """A gmsh session with the file's solid in meters, not yet synchronized.

    The kernel reads it in mm and gmsh scales it: a unit set in the kernel persists for the
    rest of the process, and would change files written later.
    """
    with gmsh_session("throw") as gmsh:
        option = gmsh.option
        before = option.getString(UNIT_OPTION), option.getNumber(SCALE_OPTION)
        try:
            option.setString(UNIT_OPTION, "MM")
            option.setNumber(SCALE_OPTION, 1e-3)
            made = gmsh.model.occ.importShapes(path, highestDimOnly=True)
        except Exception as error:
            if (
                type(error) is not Exception
            ):  # which gmsh raises; any other kind is not the file's fault
                raise
            raise InputError(f"{path}: given a file that cannot be read: {error}.") from None
        finally:
            option.setString(UNIT_OPTION, before[0])
            option.setNumber(SCALE_OPTION, before[1])
        solids = [tag for dimension, tag in made if dimension == 3]
        if len(solids) != 1:
            raise InputError(f"{path}: given {len(solids)} solids; allowed is one.")
        yield gmsh, solids[0]


def measured_face(gmsh: Any, tag: int) -> Face:
    """Measure a face through points and normals on it, which every version of gmsh gives."""
    model = gmsh.model
    kind = str(model.getType(2, tag))
    (u_low, v_low), (u_high, v_high) = model.getParametrizationBounds(2, tag)
    # A third of the way, not half: normals of a whole cylinder are then neither equal nor opposite.
    u_steps = u_low + (u_high - u_low) * np.array([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0])
    v_steps = np.linspace(v_low, v_high, 5)
    where = np.array([(u, v) for u in u_steps for v in v_steps])
    points = np.asarray(model.getValue(2, tag, where.ravel().tolist())).reshape(4, 5, 3)
    low, high = float(points[..., 2].min()), float(points[..., 2].max())
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
    return Face(tag, kind, point, axis, radius, float(turn), low, high)


def same_surface(face: Face, wanted: StepFace, tolerance: float) -> bool:
    """Whether a face lies on the plane or cylinder that the file's text gives."""
    apart = face.point - np.array(wanted.point)
    axis = np.array(wanted.axis)
    if np.linalg.norm(np.cross(face.axis, axis)) > DIRECTION_TOLERANCE:
        return False
    if wanted.kind == PLANE:
        return abs(float(apart @ axis)) < tolerance
    off = float(np.linalg.norm(np.cross(apart, axis)))
    return off < tolerance and abs(abs(face.radius) - wanted.radius) < tolerance


def rounds_along(faces: list[Face], tolerance: float) -> list[Round]:
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
    return [_round(group) for group in groups]


def _round(group: list[Face]) -> Round:
    low, high = min(face.low for face in group), max(face.high for face in group)
    # Of faces side by side along the shaft, each counts by its length.
    turn = sum(face.turn * (face.high - face.low) for face in group) / (high - low)
    x, y = (float(value) for value in group[0].point[:2])
    return Round((x, y), group[0].radius, low, high, turn, tuple(face.tag for face in group))


def curvature_radius(gmsh: Any, tag: int) -> float:
    """Smallest radius of curvature in the middle of a face."""
    low, high = gmsh.model.getParametrizationBounds(2, tag)
    middle = 0.5 * (np.asarray(low) + np.asarray(high))
    largest, smallest, *_ = gmsh.model.getPrincipalCurvatures(tag, middle.tolist())
    curvature = max(abs(float(largest[0])), abs(float(smallest[0])))
    return 1.0 / curvature if curvature > 0.0 else math.inf
