"""A throw of a whole crankshaft by its matrices."""

import math
from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from crankbase.checks.arrays import FloatArray, finite_array, positive_number, read_only
from crankbase.checks.scalars import whole_number
from crankbase.errors import InputError
from crankbase.summaries import summarized

# Motions of a section: displacements, then rotations.
UX, UY, UZ, RX, RY, RZ = range(6)
# Largest difference of a matrix from its transpose, relative to its largest entry.
SYMMETRIC = 1e-8


@summarized("length [m]", "crank_angle_deg [deg]", "stiffness", "pins")
@dataclass(frozen=True, eq=False)
class ShaftThrow:
    """A throw by its matrices, in its own frame, and its position.

    Parameters
    ----------
    stiffness, mass : array_like of shape (12 + 2 b + m, 12 + 2 b + m)
        Unknowns ux uy uz rx ry rz of the left, then of the right end section (the middles of its
        main journals), then b amplitudes each of the bending of the left and the right section,
        then m amplitudes of internal shapes.
    pin_loads : array_like of shape (p, 12 + 2 b + m, 6)
        Loads on these unknowns equivalent to unit forces along x, y, z on each pin, and unit moments.
        Transposed, they give the pin's mean motion.
    pins : array_like of shape (p, 3)
        Center of each pin in the throw frame [m].
    length : float
        From section to section [m].
    crank_angle_deg : float
        Angle of the throw's first pin about +z, counted from +y [deg].
    bending : int
        b: number of motions of a section beyond its mean motions; 0 for rigid sections. Adjacent throws
        share them, so they are in the shaft's frame, whatever the crank angle.

    Raises
    ------
    InputError
        If shapes do not fit, a matrix is not symmetric, or a number is not finite.
    """

    stiffness: FloatArray
    mass: FloatArray
    pin_loads: FloatArray = field(repr=False)
    pins: FloatArray
    length: float
    _: KW_ONLY
    crank_angle_deg: float = 0.0
    bending: int = 0

    def __post_init__(self) -> None:
        for name in ("stiffness", "mass", "pin_loads", "pins"):
            object.__setattr__(self, name, read_only(finite_array(name, getattr(self, name))))
        finite_array("crank_angle_deg", self.crank_angle_deg)
        positive_number("length", self.length, "m", "a throw has a length")
        whole_number("bending", self.bending, 0, "a section has these motions beside its mean ones")
        size = len(self.stiffness)
        for name in ("stiffness", "mass"):
            _check_symmetric(name, getattr(self, name), size, 12 + 2 * self.bending)
        if self.pins.ndim != 2 or self.pins.shape[1] != 3 or not len(self.pins):
            raise InputError(
                f"pins: given an array of shape {self.pins.shape}; allowed is (pins, 3), because a "
                "throw has one pin or more."
            )
        if np.any(np.hypot(self.pins[:, 0], self.pins[:, 1]) == 0.0):
            raise InputError(
                "pins: given one on the shaft axis; allowed are pins aside of it, because radial and "
                "tangential directions need the pin's radius."
            )
        expected = (len(self.pins), size, 6)
        if self.pin_loads.shape != expected:
            raise InputError(
                f"pin_loads: given an array of shape {self.pin_loads.shape}; allowed is {expected}, "
                "because each pin takes three forces and three moments."
            )

    @property
    def shapes(self) -> int:
        """Number of internal shapes, m."""
        return len(self.stiffness) - 12 - 2 * self.bending

    @property
    def turn(self) -> FloatArray:
        """Matrix (12 + 2 b + m, ...) from motions in the throw frame to those in the shaft frame."""
        turn = np.eye(len(self.stiffness))
        turn[:12, :12] = np.kron(np.eye(4), rotation(math.radians(self.crank_angle_deg)))
        return turn

    def rigid_inertia(self) -> tuple[float, float]:
        """Mass [kg], and moment of inertia about the shaft axis [kg m^2], from rigid-body motion."""
        along, about = np.zeros((2, len(self.mass)))
        along[[UZ, 6 + UZ]] = 1.0
        about[[RZ, 6 + RZ]] = 1.0
        return float(along @ self.mass @ along), float(about @ self.mass @ about)


def rotation(angle: float) -> FloatArray:
    """Return the matrix (3, 3) that turns a vector by an angle [rad] about z."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def _check_symmetric(name: str, matrix: FloatArray, size: int, least: int) -> None:
    if matrix.ndim != 2 or matrix.shape != (size, size) or size < least:
        raise InputError(
            f"{name}: given an array of shape {matrix.shape}; allowed are square ones of {least} rows or "
            f"more, stiffness and mass alike, because two end sections have {least} motions."
        )
    if np.max(np.abs(matrix - matrix.T)) > SYMMETRIC * np.max(np.abs(matrix)):
        raise InputError(
            f"{name}: given a matrix that is not symmetric; allowed are symmetric ones, because they "
            "belong to an energy."
        )
