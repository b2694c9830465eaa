"""Findley's criterion of fatigue on a critical plane, for the stress history of a point on a free surface."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull, QhullError

from crankbase.checks.arrays import FloatArray, finite_array, nonnegative_number, positive_number
from crankbase.errors import InputError
from crankbase.summaries import summarized

FINDLEY_SOURCE = (
    "W. N. Findley, A theory for the effect of mean stress on fatigue of metals under combined torsion and "
    "axial load or bending, Journal of Engineering for Industry 81, 1959, 301-306"
)
# Of the fatigue strengths in torsion and in bending, both fully reversed: that of von Mises, as UR M53 has
# it at fillets.
TORSION_SHARE = 1.0 / math.sqrt(3.0)
# Planes first looked at, and how much closer each further look is [deg].
FIRST_STEP, CLOSER, LOOKS = 10.0, 5.0, 2
# A circle holds points that are outside by less than this share of its radius.
HELD, MOST_STEPS = 1e-9, 60
# A path of stress has no extent in a direction where it is smaller than this share of its largest.
FLAT = 1e-9


@summarized("value [Pa]", "shear_amplitude [Pa]", "normal_stress [Pa]", "moment", "normal")
@dataclass(frozen=True, eq=False)
class CriticalPlane:
    """The plane through a point on which the criterion is largest.

    Attributes
    ----------
    value : float
        shear_amplitude + k normal_stress [Pa].
    shear_amplitude : float
        Radius of the smallest circle around the path of the shear stress [Pa].
    normal_stress : float
        The largest over the history [Pa].
    moment : int
        Its index in the history.
    normal : (3,) array
        Of the plane: along both directions of the surface, and out of it.
    """

    value: float
    shear_amplitude: float
    normal_stress: float
    moment: int
    normal: FloatArray


def findley_factor(torsion_share: float = TORSION_SHARE) -> float:
    """Return k, the weight of the normal stress, of a steel.

    Parameters
    ----------
    torsion_share : float, optional
        Fatigue strength in torsion over that in bending, both fully reversed: above 1/2, below 1.

    Raises
    ------
    InputError
        If it is not.

    Notes
    -----
    Fully reversed, tau_a + k sigma_max is largest with t sqrt(1 + k^2) in torsion and with
    f/2 (k + sqrt(1 + k^2)) in bending. Both are one limit if k / sqrt(1 + k^2) = 2 t/f - 1; with
    t/f = 1/sqrt(3) k is 0.1566.
    """
    share = positive_number("torsion_share", torsion_share, "", "strengths are above zero")
    if not 0.5 < share < 1.0:
        raise InputError(
            f"torsion_share: given {share:g}; allowed is above 0.5 and below 1, because normal stress is of "
            "no use to a plane, and shear decides."
        )
    sine = 2.0 * share - 1.0
    return sine / math.sqrt(1.0 - sine**2)


def findley_limit(bending_strength: float, factor: float) -> float:
    """Return the limit of the criterion [Pa]: f/2 (k + sqrt(1 + k^2)).

    Parameters
    ----------
    bending_strength : float
        f, fully reversed [Pa].
    factor : float
        k, from `findley_factor`.

    Raises
    ------
    InputError
        If the strength is not above zero, or the factor below it.
    """
    factor = nonnegative_number("factor", factor, "", "it weighs the normal stress")
    strength = positive_number("bending_strength", bending_strength, "Pa", "it is that of a steel")
    return 0.5 * strength * (factor + math.hypot(1.0, factor))


def critical_plane(history: ArrayLike, factor: float) -> CriticalPlane:
    """Find the plane with the worst combination of shear amplitude and largest normal stress.

    Parameters
    ----------
    history : (m, 3) array_like
        Stresses of a free surface over one cycle, along two directions of it and between them [Pa].
    factor : float
        k, from `findley_factor`.

    Returns
    -------
    CriticalPlane

    Raises
    ------
    InputError
        If the history is not such an array, or the factor below zero.

    Notes
    -----
    Planes are searched over all directions in steps of 10 degrees, then near the worst in steps of 2 and 0.4.
    Stresses on a plane are linear in those of the history, so the corners of its path are sufficient.
    """
    given = finite_array("history", history)
    factor = nonnegative_number("factor", factor, "", "it weighs the normal stress")
    if given.ndim != 2 or given.shape[1] != 3 or not len(given):
        raise InputError(
            f"history: given an array of shape {given.shape}; allowed is (m, 3), because a free surface has "
            "three stresses at each moment."
        )
    corners = _corners(given)
    path = given[corners]
    step = math.radians(FIRST_STEP)
    around = np.arange(0.0, math.pi - 1e-9, step)
    down = np.arange(0.0, 0.5 * math.pi + 1e-9, step)
    for _ in range(LOOKS + 1):
        angles = np.stack(np.meshgrid(around, down, indexing="ij"), axis=-1).reshape(-1, 2)
        values, shear, normal = _on_planes(path, angles, factor)
        worst = int(np.argmax(values))
        best = angles[worst]
        near = np.arange(-CLOSER, CLOSER + 0.5) * step / CLOSER
        around, down, step = best[0] + near, best[1] + near, step / CLOSER
    stress = normal[worst]
    return CriticalPlane(
        value=float(values[worst]),
        shear_amplitude=float(shear[worst]),
        normal_stress=float(stress.max()),
        moment=int(corners[np.argmax(stress)]),
        normal=_normals(best[None])[0],
    )


def _corners(history: FloatArray) -> NDArray[np.int64]:
    """Return the moments at which the path turns outwards: only they determine circle and largest stress."""
    centered = history - history.mean(axis=0)
    _, sizes, axes = np.linalg.svd(centered, full_matrices=False)
    # In a plane, or along a line, where the path has no extent besides.
    path = centered @ axes[sizes > FLAT * sizes[0]].T
    if path.shape[1] < 2:
        along = path.sum(axis=1)
        return np.unique([along.argmin(), along.argmax()])
    try:
        return np.sort(ConvexHull(path).vertices)
    except QhullError:  # too few moments
        return np.arange(len(history))


def findley_bound(histories: ArrayLike, factor: float) -> FloatArray:
    """Return an upper bound of the criterion on any plane, (...), of histories (..., m, 3) [Pa].

    Notes
    -----
    No shear stress on any plane is farther from its middle than half the largest principal difference of
    the stress less that in the middle of its range; no normal stress is above the largest principal one.
    """
    stress = np.asarray(histories, dtype=np.float64)
    middle = 0.5 * (stress.max(axis=-2, keepdims=True) + stress.min(axis=-2, keepdims=True))
    mean, radius = _circle(stress - middle)
    shear = np.maximum(radius, 0.5 * (np.abs(mean) + radius)).max(axis=-1)
    mean, radius = _circle(stress)
    return np.asarray(shear + factor * np.maximum((mean + radius).max(axis=-1), 0.0))


def _circle(stress: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Center and radius of Mohr's circle in the surface."""
    first, second, between = np.moveaxis(stress, -1, 0)
    return 0.5 * (first + second), np.hypot(0.5 * (first - second), between)


def _normals(angles: FloatArray) -> FloatArray:
    """Unit normals (p, 3) of planes by angle in the surface and angle from its normal (p, 2)."""
    around, down = angles.T
    return np.stack(
        [np.sin(down) * np.cos(around), np.sin(down) * np.sin(around), np.cos(down)], axis=1
    )


def _on_planes(
    history: FloatArray, angles: FloatArray, factor: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return criterion (p,), shear amplitude (p,) and normal stress (p, m) on planes."""
    around, normals = angles[:, 0], _normals(angles)
    along = np.stack([-np.sin(around), np.cos(around), np.zeros_like(around)], axis=1)
    across = np.cross(normals, along)

    def acting(direction: FloatArray) -> FloatArray:
        """Stress (p, m) on the planes in a direction."""
        a, b = normals[:, 0], normals[:, 1]
        x, y = direction[:, 0], direction[:, 1]
        return np.asarray(np.stack([a * x, b * y, a * y + b * x], axis=1) @ history.T)

    normal = acting(normals)
    shear = enclosing_radius(np.stack([acting(along), acting(across)], axis=-1))
    return shear + factor * normal.max(axis=1), shear, normal


def enclosing_radius(paths: ArrayLike) -> FloatArray:
    """Return the radius (b,) of the smallest circle around each path (b, m, 2).

    Notes
    -----
    A circle through two or three points is enlarged by the point farthest outside until none is: each step
    is the smallest circle around four points, with the farthest on it.
    """
    points = np.asarray(paths, dtype=np.float64)
    count = np.arange(len(points))

    def farthest(center: FloatArray) -> tuple[FloatArray, FloatArray]:
        distance = np.linalg.norm(points - center[:, None], axis=2)
        place = distance.argmax(axis=1)
        return points[count, place], distance[count, place]

    start, _ = farthest(points.mean(axis=1))
    other, _ = farthest(start)
    held = np.stack([start, other, other], axis=1)
    center, radius = 0.5 * (start + other), 0.5 * np.linalg.norm(start - other, axis=1)
    for _ in range(MOST_STEPS):
        new, distance = farthest(center)
        outside = distance > radius * (1.0 + HELD)
        if not outside.any():
            break
        changed = _round_four(held[outside], new[outside])
        held[outside], center[outside], radius[outside] = changed
    return np.asarray(radius)


def _round_four(held: FloatArray, new: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the smallest circle through `new` (b, 2) around it and three points (b, 3, 2).

    Gives the points that determine it (b, 3, 2), its center and its radius.
    """
    four = np.concatenate([held, new[:, None]], axis=1)
    sets, centers = [], []
    for one in range(3):
        sets.append(np.stack([new, held[:, one], held[:, one]], axis=1))
        centers.append(0.5 * (new + held[:, one]))
    for one, two in ((0, 1), (0, 2), (1, 2)):
        sets.append(np.stack([new, held[:, one], held[:, two]], axis=1))
        centers.append(_center(new, held[:, one], held[:, two]))
    center = np.stack(centers, axis=1)
    reach = np.linalg.norm(four[:, None] - center[:, :, None], axis=3)
    radius = np.linalg.norm(new[:, None] - center, axis=2)
    with np.errstate(invalid="ignore"):
        holds = np.all(reach <= radius[..., None] * (1.0 + HELD), axis=2)
    choice = np.where(holds, radius, np.inf).argmin(axis=1)
    count = np.arange(len(new))
    return np.stack(sets, axis=1)[count, choice], center[count, choice], radius[count, choice]


def _center(one: FloatArray, two: FloatArray, three: FloatArray) -> FloatArray:
    """Center (b, 2) of the circle through three points; inf where they are in line."""
    a, b = two - one, three - one
    twice = 2.0 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    squares = np.sum(a * a, axis=1), np.sum(b * b, axis=1)
    x = b[:, 1] * squares[0] - a[:, 1] * squares[1]
    y = a[:, 0] * squares[1] - b[:, 0] * squares[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = np.stack([x, y], axis=1) / twice[:, None]
    return np.where(np.isfinite(offset), one + offset, np.inf)
