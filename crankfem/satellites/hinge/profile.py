"""The guides of an elastic hinge that give its moment, and whether they can be made."""

import math
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    ComplexArray,
    nonnegative_number,
    positive_number,
    radians_of,
    read_only,
)
from crankbase.choices import check_choice
from crankbase.diagrams import BLUE, GRAY, RED, legend_inside, new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, Row, table
from crankbase.quantity import format_quantity
from crankbase.results import Internal, Part, Quantity, Result, result
from crankbase.sentences import amount, angle, in_si, kept
from crankfem.satellites.hinge.crosshead import (
    periodic_spline,
)
from crankfem.satellites.hinge.moment import Degrees, HingeMoment
from crankfem.satellites.hinge.spring import LEAST_COLUMN, Force, GasSpring, Length, Pressure
from dynamics.cycle import even_angles
from dynamics.plots.curves import FROM_TOP, KILO, MILLI, draw_over_angle

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline


def polar_curvature(radius: Array, first: Array, second: Array) -> Array:
    """Return the curvature of a curve rho(phi).

    Parameters
    ----------
    radius, first, second : ndarray of shape (m,)
        rho [m] and its derivatives by the angle [m/rad, m/rad^2].

    Returns
    -------
    ndarray of shape (m,)
        (rho^2 + 2 rho'^2 - rho rho'') / (rho^2 + rho'^2)^(3/2) [1/m], positive where the curve
        bends around the origin, like a circle about it.
    """
    square = radius**2 + first**2
    return np.asarray((square + first**2 - radius * second) / square**1.5)


def outer_parallel(angles: Array, radius: Array, first: Array, distance: float) -> ComplexArray:
    """Return the points outside a curve rho(phi) at a distance from it along its normals.

    Parameters
    ----------
    angles, radius, first : ndarray of shape (m,)
        phi [rad], rho [m] and its derivative [m/rad].
    distance : float
        Radius of a roller whose center runs along the curve [m].

    Returns
    -------
    complex ndarray of shape (m,)
        Points x + i y [m].

    Notes
    -----
    The tangent of rho exp(i phi) is (rho' + i rho) exp(i phi); the outer normal is -i times it.
    """
    direction = np.exp(1j * angles)
    normal = (radius - 1j * first) / np.hypot(radius, first)
    return np.asarray((radius + distance * normal) * direction)


def smallest_hollow(curvature: Array) -> float:
    """Return the smallest radius of curvature where a curve bends away from the origin [m].

    Infinite if it does so nowhere. A larger roller outside the curve would undercut it.
    """
    least = float(np.min(curvature))
    return -1.0 / least if least < 0.0 else float("inf")


def check_roller(roller_radius: float, curvature: Array) -> None:
    """Refuse a roller whose guide would have a cusp."""
    hollow = smallest_hollow(curvature)
    if roller_radius >= hollow:
        raise InputError(
            f"roller_radius: given {in_si(roller_radius, 'm')}; allowed is less than "
            f"{in_si(hollow, 'm', 4)}, because there the roller's path bends away from the axis with that "
            "radius, and the guide of a larger roller has a cusp."
        )


# [rad] Steeper guides press a sliding follower hard to the side; 30 deg is the usual limit of cams.
STEEP_DEG = 30.0
# What must hold of a guide that can be made, and why.
MUST_BE = {
    "smallest radius": "above the roller's radius, or the two rollers would meet",
    "shortest gas column": (f"above {100.0 * LEAST_COLUMN:g} % of the height, or the pistons meet"),
    "lowest spring pressure": "above ambient, or the rollers would leave the guides",
    "smallest hollow": "above the roller's radius, or its guide would have a cusp",
}


@result("name", "met", "value", "limit", "unit", eq=True)
class ProfileCheck(Result):
    """One condition for a guide that can be made.

    Parameters
    ----------
    value, limit : float
        The value and its limit, in `unit`; inf where a path has no hollow.
    reason : str
        The condition, and why.
    """

    name: str
    met: bool
    value: Annotated[float, Quantity(".unit")]
    limit: Annotated[float, Quantity(".unit")]
    unit: str
    reason: Annotated[str, Quantity(key="meaning")]

    @property
    def shown(self) -> str:
        """The value with its unit; "none" where there is nothing to measure."""
        return amount(self.value, self.unit, 4) if np.isfinite(self.value) else "none"

    @property
    def sentence(self) -> str:
        """The value, whether the condition holds, and why it must."""
        outcome = "met" if self.met else "not met"
        return f"{self.name.capitalize()}: {kept(self.shown)}, {outcome}; it must be {self.reason}."

    def row(self) -> Row:
        """Return the columns of a table of checks, each value with its unit; see `table_of`.

        Value and limit are in the unit named in the row.
        """
        return {
            "name": (self.name, ""),
            "met": (self.met, ""),
            "value": (self.value, "SI, see the column unit"),
            "limit": (self.limit, "SI, see the column unit"),
            "unit": (self.unit, ""),
            "sentence": (self.sentence, ""),
        }


@result("radius [m]", "speed [rad/s]", "checks", "remarks")
class HingeProfile(Result):
    """Path of the rollers' centers in the rotating guides; arrays of shape (m,) over one revolution.

    Made by `hinge_profile`. Between the angles the radius is the periodic cubic spline; all
    slopes, forces and moments of the hinge are those of this curve.

    Parameters
    ----------
    start_radius : float
        rho_0, radius at the top dead center, where the spring has its initial height and pressure [m].
    roller_radius : float
        Of each roller [m].
    angles_deg : ndarray
        Even crank angles [deg]. In axes of the guides that turn with the crank the polar angle is
        its negative, as the spring does not rotate.
    radius : ndarray
        rho [m].
    speed : float
        Speed for which the guides were designed [rad/s].
    """

    spring: Internal[GasSpring]
    start_radius: Internal[float]
    roller_radius: Internal[float]
    angles_deg: Internal[Array]
    radius: Internal[Array]
    speed: Internal[float]

    @cached_property
    def curve(self) -> "CubicSpline":
        """The radius [m] as a function of the crank angle [rad]; `curve(angle, 1)` is its slope."""
        return periodic_spline(self.radius)

    @property
    def _angles(self) -> Array:
        return np.radians(self.angles_deg)

    @cached_property
    def slope(self) -> Array:
        """Derivative of the radius by the crank angle [m/rad]."""
        return read_only(np.asarray(self.curve(self._angles, 1)))

    @property
    def compression(self) -> Array:
        """Shortening of the gas column from the start, z = 2 (rho_0 - rho) [m]."""
        return 2.0 * (self.start_radius - self.radius)

    @property
    def pressure(self) -> Array:
        """Pressure of the gas above ambient [Pa]."""
        return self.spring.gas_pressure(self.compression)

    @property
    def spring_force(self) -> Array:
        """F_pn, of the gas on each roller, outwards [N]."""
        return self.spring.force(self.compression)

    @property
    def force_angle_deg(self) -> Array:
        """Angle between the force of the guide on a roller and the spring's axis [deg]."""
        return np.degrees(np.arctan2(self.slope, self.radius))

    @property
    def normal_force(self) -> Array:
        """Force of the guide on each roller, along the guide's normal, without friction [N]."""
        return self.spring_force / np.cos(np.radians(self.force_angle_deg))

    @cached_property
    def curvature(self) -> Array:
        """Curvature of the path of the rollers' centers [1/m], positive where it bends around the axis."""
        second = np.asarray(self.curve(self._angles, 2))
        return read_only(polar_curvature(self.radius, self.slope, second))

    @property
    def moment(self) -> Array:
        """Moment of both rollers on the crank at the angles, positive when it drives [N m]."""
        return 2.0 * self.spring_force * self.slope

    def moment_at(self, pressure: float | None = None, *, angles_deg: ArrayLike) -> Array:
        """Return the hinge's moment on the crank, 2 F_pn d rho/d phi [N m]."""
        spring = self.spring if pressure is None else replace(self.spring, pressure=pressure)
        angles = radians_of("angles_deg", angles_deg)
        compression = 2.0 * (self.start_radius - self.curve(angles))
        return np.asarray(2.0 * spring.force(compression) * self.curve(angles, 1))

    def with_pressure(self, pressure: float) -> "HingeProfile":
        """Return the same guides with another initial pressure of the spring [Pa]."""
        return replace(self, spring=replace(self.spring, pressure=pressure))

    def guide(self) -> ComplexArray:
        """Return the surface that the rollers run on, outside their path, x + i y [m], (m,).

        At the polar angle of the crank; in the guides' own axes it is the mirror image.

        Raises
        ------
        InputError
            If the roller is so large that the surface would have a cusp.
        """
        check_roller(self.roller_radius, self.curvature)
        return outer_parallel(self._angles, self.radius, self.slope, self.roller_radius)

    @property
    def smallest_radius(self) -> Length:
        """Of the rollers' path."""
        return float(self.radius.min())

    @property
    def largest_radius(self) -> Length:
        """Of the rollers' path."""
        return float(self.radius.max())

    @property
    def largest_compression(self) -> Length:
        """Of the gas column, from the start."""
        return float(self.compression.max())

    @property
    def least_compression(self) -> Length:
        """Negative where the column gets longer."""
        return float(self.compression.min())

    @property
    def largest_pressure(self) -> Pressure:
        """Of the gas above ambient."""
        return float(self.pressure.max())

    @property
    def lowest_pressure(self) -> Pressure:
        """Of the gas above ambient."""
        return float(self.pressure.min())

    @property
    def largest_spring_force(self) -> Force:
        """Of the gas on each roller."""
        return float(self.spring_force.max())

    @property
    def largest_normal_force(self) -> Force:
        """Of the guide on each roller."""
        return float(self.normal_force.max())

    @property
    def largest_force_angle_deg(self) -> Degrees:
        """Of the force on a roller, off the spring's axis."""
        return float(np.abs(self.force_angle_deg).max())

    @property
    def checks(self) -> Part[tuple[ProfileCheck, ...]]:
        """Conditions for guides that can be made, each met or not.

        `hinge_profile` makes no guides with less than the least gas column; this states the
        remaining column, and other guides may leave less.
        """
        height, rollers = self.spring.height, self.roller_radius
        conditions = {
            "smallest radius": (self.smallest_radius, rollers, "m"),
            "shortest gas column": (height - self.largest_compression, LEAST_COLUMN * height, "m"),
            "lowest spring pressure": (self.lowest_pressure, 0.0, "Pa"),
            "smallest hollow": (smallest_hollow(self.curvature), rollers, "m"),
        }
        return tuple(
            ProfileCheck(name, value > limit, value, limit, unit, MUST_BE[name])
            for name, (value, limit, unit) in conditions.items()
        )

    @property
    def remarks(self) -> Part[tuple[str, ...]]:
        """Remarks on conditions that are met."""
        sentences = []
        longest = -self.least_compression
        if longest > 1e-6 * self.spring.height:
            sentences.append(
                f"The spring gets {amount(longest, 'm', 3)} longer than at the top dead center: its "
                "cylinder needs room for that."
            )
        if self.largest_force_angle_deg > STEEP_DEG:
            sentences.append(
                f"The guides are steep: the roller force is up to "
                f"{amount(math.radians(self.largest_force_angle_deg), 'rad', decimals=0)} off the "
                f"spring's axis (cams are kept below {angle(30.0)}), so friction matters."
            )
        half = np.roll(self.radius, -(self.radius.size // 2))
        apart = float(np.max(np.abs(half - self.radius)))
        if apart > 1e-6 * self.start_radius:
            sentences.append(
                f"Radii half a turn apart differ by up to {amount(apart, 'm', 3)}: each of the two rollers "
                f"needs a guide of its own, one turned by {angle(180.0)} against the other."
            )
        return tuple(sentences)

    def plot(
        self, axes: Axes | None = None, *, show: Literal["guide", "moment", "radius"] = "guide"
    ) -> Axes:
        """Draw the guide and the path of the rollers, or moment or radius over the crank angle."""
        check_choice("show", show, ("guide", "moment", "radius"), "these are known over the turn")
        title = f"Guides for {format_quantity(self.speed, 'rad/s', 5)}"
        if show != "guide":
            values, label = (
                (KILO * self.moment, "moment on the crank [kN m]")
                if show == "moment"
                else (MILLI * self.radius, "radius [mm]")
            )
            axes = new_axes(axes)
            draw_over_angle(axes, self._angles, {show: values}, label, angle_label=FROM_TOP)
            write_title(axes, title)
            return axes
        axes = new_axes(axes, width=6.0, height=6.0)
        path = self.radius * np.exp(1j * self._angles)
        for curve, color, name in (
            (path, BLUE, "path of the rollers"),
            (self.guide(), RED, "guide"),
        ):
            closed = MILLI * np.append(curve, curve[0])
            axes.plot(closed.real, closed.imag, color=color, linewidth=1.4, label=name)
        if self.roller_radius > 0.0:
            circle = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 181))
            roller = MILLI * (path[0] + self.roller_radius * circle)
            axes.plot(roller.real, roller.imag, color=GRAY, linewidth=1.0, label="roller")
        axes.plot([0.0], [0.0], "+", color=GRAY)
        axes.set_aspect("equal")
        axes.set_xlabel("$\\rho\\,\\cos\\,\\varphi$ [mm]")
        axes.set_ylabel("$\\rho\\,\\sin\\,\\varphi$ [mm]")
        legend_inside(axes)
        write_title(axes, title)
        return axes

    def to_pandas(self) -> DataFrame:
        """Return a row for each crank angle: radius, spring, forces, moment."""
        guide = self.guide()
        return table(
            {
                "crank_angle": (self.angles_deg, "deg"),
                "radius": (self.radius, "m"),
                "slope": (self.slope, "m/rad"),
                "curvature": (self.curvature, "1/m"),
                "compression": (self.compression, "m"),
                "pressure": (self.pressure, "Pa"),
                "spring_force": (self.spring_force, "N"),
                "force_angle": (self.force_angle_deg, "deg"),
                "normal_force": (self.normal_force, "N"),
                "moment": (self.moment, "N m"),
                "guide_x": (guide.real, "m"),
                "guide_y": (guide.imag, "m"),
            }
        )


@result("height", "start_radius", "pressure", "refused")
class ComparedGuides(Result):
    """Guides for one spring and start radius, or the reason why there are none."""

    height: Length
    pressure: Pressure
    start_radius: Length
    guides: Annotated[HingeProfile | None, Quantity(flat=True, left_out=True)] = None
    refused: Annotated[str | None, Quantity(left_out=True)] = None


def hinge_profile(
    moment: HingeMoment, spring: GasSpring, start_radius: float, *, roller_radius: float = 0.0
) -> HingeProfile:
    """Find the shape of the guides for a required moment.

    Parameters
    ----------
    start_radius : float
        rho_0 at the top dead center [m].

    Returns
    -------
    HingeProfile
        With `checks` on whether it can be made.

    Raises
    ------
    InputError
        If the gas column does not fit between the rollers, the gas cannot store or release the energy,
        or a radius would not be above zero.

    Notes
    -----
    The spring stores the work W of the crank on the hinge, minus the integral of M_h from the top:
    (H - z)^(1-n) = H^(1-n) - (n - 1) / (A p_0 H^n) int M_h dphi, and
    rho = rho_0 - H/2 + (H - z)/2, equation (11) of Zotov, Imaeva 2024, doi
    10.24412/0131-4270-2024-1-2-50-55. Their (9), the integral of F_pn dz equal to that of M_h dphi,
    lacks a minus with their z = 2 rho_0 - 2 rho; (11) is right.
    """
    positive_number("start_radius", start_radius, "m", "it is a length")
    nonnegative_number("roller_radius", roller_radius, "m", "it is a length")
    if not spring.height < 2.0 * start_radius:
        raise InputError(
            f"height: given {in_si(spring.height, 'm')} with a start radius of {in_si(start_radius, 'm')}; "
            f"allowed is less than twice that, {in_si(2.0 * start_radius, 'm')}, because the gas column "
            "stands between the rollers."
        )
    compression = spring.compression(moment.stored_energy)
    return HingeProfile(
        spring=spring,
        start_radius=float(start_radius),
        roller_radius=float(roller_radius),
        angles_deg=read_only(even_angles(360.0, moment.angles_deg.size)),
        radius=read_only(start_radius - 0.5 * compression),
        speed=moment.speed,
    )
