"""The volume of a cylinder from the travel of its piston, for any mechanism."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.angles import radians_of
from crankbase.checks.arrays import FloatArray, finite_array, positive_number
from crankbase.errors import InputError

Position = Callable[[FloatArray], FloatArray]

# Places over one turn at which the highest and lowest position are looked for.
SEARCH_PLACES = 360
# A piston is back after one turn within this share of its stroke.
RETURN_TOLERANCE = 1e-9
# [deg] Offset pins and articulated rods move the highest position by a few degrees only.
FARTHEST_TOP = 30.0


@dataclass(frozen=True, eq=False)
class CylinderVolume:
    """Volume over a piston as a function of the crank angle from the nominal top.

    Made by `cylinder_volume`.

    Parameters
    ----------
    position : callable
        Position of the piston along the cylinder axis, away from the shaft [m], for an array of
        crank angles [rad].
    area : float
        Piston area [m^2].
    compression_ratio : float
        Largest over smallest volume.
    highest, lowest : float
        Highest and lowest position [m].
    top_angle_deg, bottom_angle_deg : float
        Crank angles of these, from -180 to 180 and from 0 to 360: 0 and 180 for a plain slider-crank,
        near them for an offset pin or an articulated rod.
    """

    position: Position
    area: float
    compression_ratio: float
    highest: float
    lowest: float
    top_angle_deg: float
    bottom_angle_deg: float

    @property
    def stroke(self) -> float:
        """Travel of the piston between its dead centers [m]."""
        return self.highest - self.lowest

    @property
    def swept(self) -> float:
        """Swept volume [m^3]."""
        return self.area * self.stroke

    @property
    def clearance(self) -> float:
        """Smallest volume [m^3]: swept volume over compression ratio less one."""
        return self.swept / (self.compression_ratio - 1.0)

    def at(self, *, angle_deg: ArrayLike) -> FloatArray:
        """Return the volume [m^3] at crank angles of any shape."""
        angles = radians_of("angle_deg", angle_deg)
        position = np.asarray(self.position(angles.ravel()), dtype=np.float64)
        return (self.clearance + self.area * (self.highest - position)).reshape(angles.shape)


def cylinder_volume(position: Position, area: float, compression_ratio: float) -> CylinderVolume:
    """Return the volume of a cylinder whose piston moves in a given way.

    Parameters
    ----------
    position : callable
        Position of the piston along the cylinder axis from any origin, growing away from the
        shaft [m], for an array of crank angles [rad] from the position of the crank along the cylinder
        axis. It is smooth and repeats every revolution.
    area : float
        Piston area [m^2].
    compression_ratio : float
        Largest over smallest volume, above 1.

    Returns
    -------
    CylinderVolume
        Its clearance follows from the highest and lowest position, wherever they are.

    Raises
    ------
    InputError
        If area or ratio is out of range, the position is not finite, does not repeat every
        revolution, does not move, or is highest more than 30 deg away from the angle zero.

    Examples
    --------
    >>> crank, rod, area = 0.06, 0.2, 0.01
    >>> def position(angle):
    ...     return crank * np.cos(angle) + np.sqrt(rod**2 - (crank * np.sin(angle)) ** 2)
    >>> volume = cylinder_volume(position, area, 16.0)
    >>> round(volume.stroke, 12), round(volume.clearance * 1e6, 9)
    (0.12, 80.0)
    """
    positive_number("area", area, "m^2", "gas presses on the piston")
    positive_number("compression_ratio", compression_ratio, "", "it is a ratio of volumes")
    if compression_ratio <= 1.0:
        raise InputError(
            f"compression_ratio: given {compression_ratio:g}; allowed is more than 1, because it "
            "is the largest over the smallest volume."
        )
    step = 2.0 * math.pi / SEARCH_PLACES
    places = step * np.arange(SEARCH_PLACES + 1, dtype=np.float64)
    found = finite_array("position", position(places))
    way = float(np.ptp(found))
    if way <= 0.0 or abs(found[-1] - found[0]) > RETURN_TOLERANCE * way:
        raise InputError(
            f"position: given {found[0]:g} m at 0 deg, {found[-1]:g} m at 360 deg and a way of "
            f"{way:g} m between; allowed is a piston that moves and is back after one turn, because "
            "its volume repeats with the turn."
        )
    top_angle, highest = _extreme(position, places[int(np.argmax(found[:-1]))], step, 1.0)
    bottom_angle, lowest = _extreme(position, places[int(np.argmin(found[:-1]))], step, -1.0)
    top_angle_deg = math.remainder(math.degrees(top_angle), 360.0)
    if abs(top_angle_deg) > FARTHEST_TOP:
        raise InputError(
            f"position: given one that is highest at {top_angle_deg:.4g} deg; allowed "
            f"are {-FARTHEST_TOP:g} to {FARTHEST_TOP:g} deg, because angles count from the nominal "
            "top dead center and the position away from the shaft."
        )
    return CylinderVolume(
        position=position,
        area=float(area),
        compression_ratio=float(compression_ratio),
        highest=highest,
        lowest=lowest,
        top_angle_deg=top_angle_deg,
        bottom_angle_deg=math.degrees(bottom_angle) % 360.0,
    )


def _extreme(position: Position, place: float, step: float, sign: float) -> tuple[float, float]:
    """Return angle and value of the highest (sign 1) or lowest (-1) position near an angle.

    The vertex of the parabola through three points about the angle is the next angle. Four rounds,
    each ten times closer, leave the angle within 1e-8 rad and the value within round-off.
    """
    angle = float(place)
    for _ in range(4):
        values = sign * position(np.array([angle - step, angle, angle + step]))
        curvature = float(values[0] - 2.0 * values[1] + values[2])
        if curvature >= 0.0:
            break
        move = 0.5 * float(values[0] - values[2]) / curvature
        angle += step * min(max(move, -1.0), 1.0)
        step /= 10.0
    return angle, float(position(np.array([angle]))[0])
