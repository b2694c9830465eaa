"""The volume of a cylinder from the travel of its piston, for any mechanism."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    FloatArray,
    finite_array,
    finite_vector,
    positive_number,
    radians_of,
)
from crankbase.errors import InputError
from dynamics.cycle import checked_strokes
from dynamics.gas.pressure import GasPressure, gas_pressure

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
    positions = finite_array("position", position(places))
    way = float(np.ptp(positions))
    if way <= 0.0 or abs(positions[-1] - positions[0]) > RETURN_TOLERANCE * way:
        raise InputError(
            f"position: given {positions[0]:g} m at 0 deg, {positions[-1]:g} m at 360 deg and a way of "
            f"{way:g} m between; allowed is a piston that moves and is back after one turn, because "
            "its volume repeats with the turn."
        )
    top_angle, highest = _extreme(position, places[int(np.argmax(positions[:-1]))], step, 1.0)
    bottom_angle, lowest = _extreme(position, places[int(np.argmin(positions[:-1]))], step, -1.0)
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
    """Return angle and value of the highest (sign 1) or lowest (-1) position near an angle."""
    # The vertex of the parabola through three points about the angle is the next angle. Four rounds,
    # each ten times closer, leave the angle within 1e-8 rad and the value within round-off.
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


def indicated_work(pressure: ArrayLike, volume_slope: ArrayLike, strokes: int = 4) -> float:
    """Return the work of the gas on the piston over one cycle.

    Parameters
    ----------
    pressure : array_like of shape (m,)
        Pressure at even crank angles over the whole cycle [Pa], without the closing sample. A
        constant pressure under the piston may be included or not: its work over a revolution is zero.
    volume_slope : array_like of shape (m,)
        Derivative of the volume by the crank angle there [m^3/rad]: piston area times the
        piston's travel towards the shaft per radian.

    Returns
    -------
    float
        Integral of p dV [J], by the trapezoidal rule, which on a periodic function is the mean.

    Raises
    ------
    InputError
        If lengths differ or a number is not finite.

    Examples
    --------
    >>> angle = np.radians(np.arange(0.0, 360.0, 1.0))
    >>> work = indicated_work(1e5 + 2e5 * np.sin(angle), 3e-3 * np.sin(angle), strokes=2)
    >>> round(work / math.pi, 9)
    600.0
    """
    pressing = finite_vector("pressure", pressure)
    slope = finite_vector("volume_slope", volume_slope)
    if pressing.size != slope.size or pressing.size == 0:
        raise InputError(
            f"volume_slope: given {slope.size} values for {pressing.size} of pressure; allowed is one "
            "for each and at least one, because they are multiplied at each angle."
        )
    return math.pi * checked_strokes(strokes) * float(pressing @ slope) / pressing.size


def indicated_mean_effective_pressure(work: float, swept: float) -> float:
    """Return the work of one cycle per swept volume.

    Returns
    -------
    float
        Mean effective pressure [Pa].
    """
    return work / positive_number("swept", swept, "m^3", "the work is taken per swept volume")


def periodic_slope(values: FloatArray, period: float) -> FloatArray:
    """Return the derivative of a smooth periodic function from even samples over its period.

    Parameters
    ----------
    values : ndarray of shape (m,)
        Samples over one period, without the closing one.

    Returns
    -------
    ndarray of shape (m,)
        The derivative of the Fourier series through the samples at the samples: exact up to
        round-off if the series has decayed before half the sampling rate, as that of a piston's
        travel.
    """
    transform = np.fft.rfft(values)
    orders = np.arange(transform.size, dtype=np.float64)
    # An order at half the sampling rate alternates in sign and has no slope at the samples; here it
    # is imaginary and left out by the inverse transform.
    slope = np.fft.irfft(2j * math.pi / period * orders * transform, n=values.size)
    return np.asarray(slope, dtype=np.float64)


# Where a diesel engine's compression is undisturbed: after valves close, before ignition [deg].
FIT_FROM, FIT_TO = -100.0, -40.0
FEWEST_SAMPLES = 4


def motored_from_compression(
    pressure: GasPressure,
    volume: CylinderVolume,
    *,
    fit_from_deg: float = FIT_FROM,
    fit_to_deg: float = FIT_TO,
) -> GasPressure:
    """Estimate the pressure in a cylinder that does not fire from the diagram of a fired one.

    Parameters
    ----------
    fit_from_deg, fit_to_deg : float, optional
        Crank angles [deg] before the top between which the diagram shows pure compression.

    Returns
    -------
    GasPressure
        The diagram itself up to `fit_to_deg`; from there to the bottom after the top the lower one of
        the diagram and of the polytrope through the compression; then the diagram again. A remark
        states the exponent.

    Raises
    ------
    InputError
        If the range is not before the top, has fewer than four samples, or the pressure does
        not rise there as in compression.

    Notes
    -----
    ln p = ln C - n ln V is fitted by least squares. The fitted n includes heat to the walls during
    compression, and the same is assumed for expansion; the lower of both curves passes to the
    blow-down without the valve timing.
    """
    low, high = (
        float(finite_array(name, value))
        for name, value in (("fit_from_deg", fit_from_deg), ("fit_to_deg", fit_to_deg))
    )
    if not -180.0 <= low < high < 0.0:
        raise InputError(
            f"fit_from_deg: given {low:g} deg to {high:g} deg; allowed is a range "
            "from -180 deg to below 0, because the gas is compressed there."
        )
    angles, cycle = pressure.angles_deg, pressure.cycle_deg
    angles = np.where(angles > cycle / 2.0, angles - cycle, angles)
    within = (angles >= low) & (angles <= high)
    if np.count_nonzero(within) < FEWEST_SAMPLES:
        raise InputError(
            f"fit_from_deg: given a range with {np.count_nonzero(within)} samples; allowed are "
            f"{FEWEST_SAMPLES} or more, because the exponent is fitted to them."
        )
    size = np.log(volume.at(angle_deg=angles))
    slope, level = np.polyfit(size[within], np.log(pressure.pressure[within]), 1)
    if not -2.0 < slope < -1.0:
        raise InputError(
            f"pressure: given a diagram with the polytropic exponent {-slope:.3g} between "
            f"{low:g} and {high:g} deg; allowed is one from 1 to 2, because "
            "compression of a gas has such."
        )
    polytrope = np.exp(level + slope * size)
    after = (angles > high) & (angles <= 180.0)
    motored = np.where(after, np.minimum(pressure.pressure, polytrope), pressure.pressure)
    remark = (
        f"Without combustion: compression with the exponent {-slope:.4g}, fitted from "
        f"{low:g} to {high:g} deg, and expansion along the same curve."
    )
    return gas_pressure(
        motored,
        pressure.strokes,
        angles_deg=pressure.angles_deg,
        source=pressure.source,
        remarks=(*pressure.remarks, remark),
    )
