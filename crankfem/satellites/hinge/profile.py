"""The elastic hinge: its moment for constant speed, the guides that give it, and the speed that results."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    ComplexArray,
    FloatArray,
    finite_array,
    finite_vector,
    nonnegative_number,
    positive_number,
    radians_of,
    read_only,
)
from crankbase.choices import check_choice, whole_number
from crankbase.diagrams import BLUE, GRAY, RED, legend_inside, new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, Row, table
from crankbase.quantity import RPM, format_quantity
from crankbase.results import Internal, Number, Part, Quantity, Result, Speed, result
from crankbase.sentences import amount, angle, kept
from crankfem.satellites.hinge.crosshead import (
    TURN,
    CrossheadEngine,
    GasForce,
    Kinematics,
    ReducedCrank,
    antiderivative,
    periodic_spline,
    reduced_crank,
    turn_integral,
)
from dynamics.cycle import even_angles
from dynamics.plots.curves import FROM_TOP, KILO, MILLI, draw_over_angle
from dynamics.turning.speed_over_angle import (
    SpeedOverAngle,
    energy_for_mean_speed,
    mean_speed,
    slowest_mean_speed,
    speed_over_angle,
)

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline


Length = Annotated[float, Quantity("m")]
Degrees = Annotated[float, Quantity("deg")]
Moment = Annotated[float, Quantity("N m")]
Force = Annotated[float, Quantity("N")]
Pressure = Annotated[float, Quantity("Pa")]
SAMPLES = 1440
# Fewer samples do not resolve a rise of pressure by combustion.
FEWEST_SAMPLES = 72


@result("speed [rad/s]", "load", "moment [N m]", "stored_energy [J]", "closing_error")
class HingeMoment(Result):
    """The hinge moment at one operating point of an engine; arrays of shape (m,) over one revolution.

    Made by `hinge_moment`.

    Parameters
    ----------
    speed : float
        Of the crank, held constant [rad/s].
    angles_deg : ndarray
        Even crank angles from the top dead center [deg], without the closing one.
    gas_force : callable
        Force on the piston towards the shaft [N] at any angles, a function of radians.
    gas : ndarray
        That force at the angles [N].
    load : float
        M_r, constant moment of the driven machine [N m]: the mean of the gas moment.
    moment : ndarray
        M_h, on the crank, positive when it drives [N m].
    """

    engine: Internal[CrossheadEngine]
    speed: Internal[float]
    kinematics: Internal[Kinematics]
    angles_deg: Internal[FloatArray]
    gas_force: Internal[GasForce]
    gas: Internal[FloatArray]
    reduced: Internal[ReducedCrank]
    load: Moment
    moment: Internal[FloatArray]

    @property
    def gas_moment(self) -> FloatArray:
        """Moment of the gas force [N m], shape (m,)."""
        return self.gas * self.reduced.travel_rate

    @cached_property
    def stored_energy(self) -> FloatArray:
        """Required stored energy of the hinge since the top, minus the integral of M_h [J], (m,)."""
        return read_only(-antiderivative(self.moment))

    @property
    def largest(self) -> Moment:
        """Of M_h."""
        return float(self.moment.max())

    @property
    def largest_at_deg(self) -> Degrees:
        """Crank angle of the largest M_h."""
        return float(self.angles_deg[np.argmax(self.moment)])

    @property
    def least(self) -> Moment:
        """Of M_h."""
        return float(self.moment.min())

    @property
    def least_at_deg(self) -> Degrees:
        """Crank angle of the least M_h."""
        return float(self.angles_deg[np.argmin(self.moment)])

    @property
    def closing_error(self) -> Number:
        """Integral of M_h over a revolution, relative to that of its absolute value."""
        return turn_integral(self.moment) / max(turn_integral(np.abs(self.moment)), 1e-300)

    @property
    def energy_swing(self) -> Annotated[float, Quantity("J")]:
        """Largest less least stored energy."""
        return float(np.ptp(self.stored_energy))

    @property
    def largest_gas_force(self) -> Force:
        """Over the revolution."""
        return float(self.gas.max())

    @property
    def reduced_inertia(self) -> Annotated[tuple[float, float], Quantity("kg m^2")]:
        """Least and largest over the revolution."""
        return float(self.reduced.inertia.min()), float(self.reduced.inertia.max())

    def at_angles(self, *, angles_deg: ArrayLike) -> tuple[ReducedCrank, FloatArray]:
        """Return the reduced crank, and the moment without the hinge [N m], at angles [deg], (k,)."""
        reduced = reduced_crank(self.engine, self.kinematics, angles_deg=angles_deg)
        gas = self.gas_force(np.radians(angles_deg)) * reduced.travel_rate
        return reduced, gas + reduced.weight_moment - self.load

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the moments of hinge, gas and driven machine over the crank angle."""
        curves = {
            "hinge": KILO * self.moment,
            "gas": KILO * self.gas_moment,
            "driven machine": np.full(self.angles_deg.shape, -KILO * self.load),
        }
        title = f"Moments at {format_quantity(self.speed, 'rad/s', 5)}"
        axes, label = new_axes(axes), "moment [kN m]"
        draw_over_angle(axes, np.radians(self.angles_deg), curves, label, angle_label=FROM_TOP)
        write_title(axes, title)
        return axes

    def to_pandas(self) -> DataFrame:
        """Return a row for each crank angle: gas force, moments, energy, the engine reduced to its crank."""
        return table(
            {
                "crank_angle": (self.angles_deg, "deg"),
                "gas_force": (self.gas, "N"),
                "gas_moment": (self.gas_moment, "N m"),
                "hinge_moment": (self.moment, "N m"),
                "stored_energy": (self.stored_energy, "J"),
                "inertia": (self.reduced.inertia, "kg m^2"),
                "inertia_rate": (self.reduced.inertia_rate, "kg m^2/rad"),
                "travel_rate": (self.reduced.travel_rate, "m/rad"),
                "weight_moment": (self.reduced.weight_moment, "N m"),
            }
        )


def hinge_moment(
    engine: CrossheadEngine,
    gas_force: GasForce | ArrayLike,
    speed: float,
    *,
    kinematics: Kinematics = "exact",
    samples: int = SAMPLES,
) -> HingeMoment:
    """Find the moment of a hinge that keeps the crank speed constant.

    Parameters
    ----------
    gas_force : callable or array_like of shape (k,)
        Force on the piston towards the shaft [N]: a function of an array of crank angles [rad] from
        the top dead center, or values at even angles over one revolution from the top, without the
        closing one.
    speed : float
        Of the crank [rad/s].
    samples : int, optional
        Number of angles over the revolution.

    Raises
    ------
    InputError
        If the speed is not above zero, there are too few samples, or the force is not finite.

    Notes
    -----
    Lagrange's equation of the crank is I phi'' + I' phi'^2 / 2 = F x' + M_w - M_r + M_h, with the
    moment M_w of the weights. For phi'' = 0 at phi' = w (equation (8) of Zotov, Imaeva 2024, doi
    10.24412/0131-4270-2024-1-2-50-55): M_h = w^2/2 I' - F x' - M_w + M_r, where
    M_r = 1/(2 pi) times the integral of F x' over a turn (5). I' and M_w have the mean zero, hence
    M_h has, and the hinge returns over a revolution all energy that it takes.

    Examples
    --------
    >>> from dynamics.engine.rods import ConnectingRod
    >>> rod = ConnectingRod(1.55, 150.0, 0.8, 50.0)
    >>> engine = CrossheadEngine(0.3, 0.5, 80.0, 0.2, 30.0, rod, 150.0, 200.0, 110.0)
    >>> found = hinge_moment(engine, lambda angle: 2e5 * (1.0 + np.sin(angle)), 9.3)
    >>> round(found.load, 6), abs(found.closing_error) < 1e-12
    (50000.0, True)
    """
    positive_number("speed", speed, "rad/s", "the crank turns forward")
    count = whole_number(
        "samples", samples, FEWEST_SAMPLES, "fewer over a turn do not show the rise of the pressure"
    )
    angles = even_angles(TURN, count)
    force = as_function(gas_force)
    gas = finite_vector("gas_force", force(angles))
    if gas.shape != angles.shape:
        raise InputError(
            f"gas_force: given {gas.size} values for {angles.size} angles; allowed is one for each, "
            "because the force is a function of the angle."
        )
    reduced = reduced_crank(engine, kinematics, angles_deg=np.degrees(angles))
    gas_moment = gas * reduced.travel_rate
    load = float(np.mean(gas_moment))
    moment = 0.5 * speed**2 * reduced.inertia_rate - gas_moment - reduced.weight_moment + load
    return HingeMoment(
        engine=engine,
        speed=float(speed),
        kinematics=kinematics,
        angles_deg=read_only(np.degrees(angles)),
        gas_force=force,
        gas=read_only(gas),
        reduced=reduced,
        load=load,
        moment=read_only(moment),
    )


def as_function(gas_force: GasForce | ArrayLike) -> GasForce:
    """Return a gas force as a function of angles [rad]; samples are interpolated by a periodic spline."""
    if callable(gas_force):
        return gas_force
    forces = finite_vector("gas_force", gas_force)
    if forces.size < FEWEST_SAMPLES:
        raise InputError(
            f"gas_force: given {forces.size} values; allowed are {FEWEST_SAMPLES} or more at even angles "
            "over a turn, because fewer do not show the rise of the pressure."
        )
    return periodic_spline(forces)


def polar_curvature(radius: FloatArray, first: FloatArray, second: FloatArray) -> FloatArray:
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


def outer_parallel(
    angles: FloatArray, radius: FloatArray, first: FloatArray, distance: float
) -> ComplexArray:
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


def smallest_hollow(curvature: FloatArray) -> float:
    """Return the smallest radius of curvature where a curve bends away from the origin [m].

    Infinite if it does so nowhere. A larger roller outside the curve would undercut it.
    """
    least = float(np.min(curvature))
    return -1.0 / least if least < 0.0 else float("inf")


def check_roller(roller_radius: float, curvature: FloatArray) -> None:
    """Refuse a roller whose guide would have a cusp."""
    hollow = smallest_hollow(curvature)
    if roller_radius >= hollow:
        raise InputError(
            f"roller_radius: given {roller_radius:g} m; allowed is less than {hollow:.4g} m, because "
            "there the roller's path bends away from the axis with that radius, and the guide of a "
            "larger roller has a cusp."
        )


# The gas column counts as gone when this share of its height is left.
LEAST_COLUMN = 0.01
# From isothermal to adiabatic gas of single atoms.
LOWEST_EXPONENT, HIGHEST_EXPONENT = 1.0, 5.0 / 3.0
NEWTON_STEPS = 60


@dataclass(frozen=True)
class GasSpring(Result):
    """A gas spring of two opposed pistons.

    Parameters
    ----------
    piston_area : float
        A [m^2].
    height : float
        H, height of the gas column with both rollers at the initial radius [m].
    pressure : float
        p_0, initial pressure of the gas [Pa]; above `ambient`.
    ambient : float, optional
        Pressure on the outer sides of the pistons [Pa]. The law of Zotov, Imaeva 2024 has none:
        they call p_0 an excess pressure and use it in the polytropic law, which holds for
        absolute pressure. With 0 the spring is theirs, p_0 being the absolute pressure without
        atmospheric pressure on the pistons; with 101325 Pa it is exact for p_0 in excess.

    Raises
    ------
    InputError
        If a value is out of its range.

    Examples
    --------
    >>> spring = GasSpring(piston_area=0.031, height=1.0, pressure=5e6)
    >>> round(float(spring.force(0.0)))
    155000
    >>> work = spring.work(0.2)
    >>> round(float(spring.compression(work)), 12)
    0.2
    """

    piston_area: Annotated[float, Quantity("m^2")]
    height: Length
    pressure: Pressure
    exponent: Number = 1.25
    ambient: Annotated[float, Quantity("Pa", key="ambient_pressure")] = 0.0

    def __post_init__(self) -> None:
        positive_number("piston_area", self.piston_area, "m^2", "the gas presses on it")
        positive_number("height", self.height, "m", "it is a length")
        positive_number("pressure", self.pressure, "Pa", "the spring presses the rollers out")
        nonnegative_number("ambient", self.ambient, "Pa", "it is absolute pressure")
        exponent = float(finite_array("exponent", self.exponent))
        if not LOWEST_EXPONENT <= exponent <= HIGHEST_EXPONENT:
            raise InputError(
                f"exponent: given {exponent:g}; allowed are {LOWEST_EXPONENT:g} to "
                f"{HIGHEST_EXPONENT:.4g}, because gas is between isothermal and adiabatic."
            )

    @property
    def absolute(self) -> float:
        """Absolute pressure at the start [Pa]."""
        return self.pressure + self.ambient

    def gas_pressure(self, compression: ArrayLike) -> FloatArray:
        """Return the pressure above ambient [Pa] when the column is z [m] shorter."""
        share = 1.0 - self._within(compression) / self.height
        return np.asarray(self.absolute * share**-self.exponent - self.ambient)

    def force(self, compression: ArrayLike) -> FloatArray:
        """Return the force on each piston, outwards [N], when the column is z [m] shorter."""
        return self.piston_area * self.gas_pressure(compression)

    def work(self, compression: ArrayLike) -> FloatArray:
        """Return the work that shortens the column by z [m], the integral of the force [J]."""
        shorter = self._within(compression)
        logarithm = -np.log1p(-shorter / self.height)
        less = self.exponent - 1.0
        scale = self.piston_area * self.absolute * self.height
        stretched = np.expm1(less * logarithm) / less if less > 0.0 else logarithm
        return np.asarray(scale * stretched - self.piston_area * self.ambient * shorter)

    def compression(self, work: ArrayLike) -> FloatArray:
        """Return the shortening of the column after a work.

        Parameters
        ----------
        work : array_like
            Work done on the gas since the start [J]; negative for released work.

        Returns
        -------
        ndarray of the same shape
            z [m], negative where the column is longer than at the start.

        Raises
        ------
        InputError
            If the gas cannot release so much, or almost nothing of the column would be left.

        Notes
        -----
        Without ambient pressure (H - z)^(1-n) = H^(1-n) + (n - 1) W / (A p_0 H^n). Otherwise
        Newton's method from above: the work is convex in z while the spring pushes outwards.
        """
        wanted = finite_array("work", work)
        self._check_energy(wanted)
        self._check_column(wanted)
        shortening = self._closed_form(wanted + self.piston_area * self.ambient * self.height)
        if self.ambient > 0.0:
            for _ in range(NEWTON_STEPS):
                shortening = shortening - (self.work(shortening) - wanted) / self.force(shortening)
        return np.asarray(shortening)

    def _within(self, compression: ArrayLike) -> FloatArray:
        """Return compressions that leave part of the column."""
        shorter = finite_array("compression", compression)
        largest = float(np.max(shorter, initial=0.0))
        if largest >= self.height:
            raise InputError(
                f"compression: given {largest:g} m of a gas column {self.height:g} m high; allowed is less "
                "than its height, because the gas takes up room."
            )
        return shorter

    def _closed_form(self, work: FloatArray) -> FloatArray:
        """Return z for the work of the gas alone."""
        less = self.exponent - 1.0
        share = work / (self.piston_area * self.absolute * self.height)
        logarithm = np.log1p(less * share) / less if less > 0.0 else share
        return np.asarray(-self.height * np.expm1(-logarithm))

    def _check_column(self, work: FloatArray) -> None:
        """Refuse works that leave almost nothing of the column."""
        largest = float(np.max(work, initial=0.0))
        most = float(self.work((1.0 - LEAST_COLUMN) * self.height))
        if largest > most:
            raise InputError(
                f"pressure: given {self.pressure / 1e6:g} MPa in a spring {self.height:g} m high that must "
                f"take {largest / 1e3:.4g} kJ; allowed is a pressure at which the gas takes more, here at "
                f"most {most / 1e3:.4g} kJ until {LEAST_COLUMN * self.height:.3g} m of the column are left, "
                "because the compression z must stay below the height H."
            )

    def _check_energy(self, work: FloatArray) -> None:
        """Refuse works below what the gas releases until it no longer pushes outwards."""
        asked = -float(np.min(work, initial=0.0))
        if self.ambient > 0.0:
            slack = self.height * (1.0 - (self.absolute / self.ambient) ** (1.0 / self.exponent))
            released = -float(self.work(slack))
        elif self.exponent > 1.0:
            scale = self.piston_area * self.absolute * self.height
            released = scale / (self.exponent - 1.0)
        else:
            return
        if asked >= released * (1.0 - 1e-9):
            raise InputError(
                f"pressure: given {self.pressure / 1e6:g} MPa in a spring that must give "
                f"{asked / 1e3:.4g} kJ; allowed is a pressure at which the gas gives more, here at most "
                f"{released / 1e3:.4g} kJ, because it does no more work when it has expanded."
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
    angles_deg: Internal[FloatArray]
    radius: Internal[FloatArray]
    speed: Internal[float]

    @cached_property
    def curve(self) -> "CubicSpline":
        """The radius [m] as a function of the crank angle [rad]; `curve(angle, 1)` is its slope."""
        return periodic_spline(self.radius)

    @property
    def _angles(self) -> FloatArray:
        return np.radians(self.angles_deg)

    @cached_property
    def slope(self) -> FloatArray:
        """Derivative of the radius by the crank angle [m/rad]."""
        return read_only(np.asarray(self.curve(self._angles, 1)))

    @property
    def compression(self) -> FloatArray:
        """Shortening of the gas column from the start, z = 2 (rho_0 - rho) [m]."""
        return 2.0 * (self.start_radius - self.radius)

    @property
    def pressure(self) -> FloatArray:
        """Pressure of the gas above ambient [Pa]."""
        return self.spring.gas_pressure(self.compression)

    @property
    def spring_force(self) -> FloatArray:
        """F_pn, of the gas on each roller, outwards [N]."""
        return self.spring.force(self.compression)

    @property
    def force_angle_deg(self) -> FloatArray:
        """Angle between the force of the guide on a roller and the spring's axis [deg]."""
        return np.degrees(np.arctan2(self.slope, self.radius))

    @property
    def normal_force(self) -> FloatArray:
        """Force of the guide on each roller, along the guide's normal, without friction [N]."""
        return self.spring_force / np.cos(np.radians(self.force_angle_deg))

    @cached_property
    def curvature(self) -> FloatArray:
        """Curvature of the path of the rollers' centers [1/m], positive where it bends around the axis."""
        second = np.asarray(self.curve(self._angles, 2))
        return read_only(polar_curvature(self.radius, self.slope, second))

    @property
    def moment(self) -> FloatArray:
        """Moment of both rollers on the crank at the angles, positive when it drives [N m]."""
        return 2.0 * self.spring_force * self.slope

    def moment_at(self, pressure: float | None = None, *, angles_deg: ArrayLike) -> FloatArray:
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
            f"height: given {spring.height:g} m with a start radius of {start_radius:g} m; allowed is less "
            f"than twice that, {2.0 * start_radius:g} m, because the gas column stands between the rollers."
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


# Angles over a turn of the energy equation, twice those of a hinge moment by default.
STEPS = 2880


@result("mean_speed", "fluctuation", "flywheel", "gain [J]", "angles_deg [deg]")
class SteadyHingeTurn(Result):
    """One periodic revolution of a crank.

    Parameters
    ----------
    angles_deg : ndarray of shape (m,)
        Even crank angles from the top dead center [deg].
    gain : float
        Energy surplus of the revolution [J]; zero except for integration error.
    """

    angles_deg: Internal[FloatArray]
    speed: Internal[FloatArray]
    mean_speed: Speed
    gain: Internal[float]
    flywheel: Annotated[float, Quantity("kg m^2", key="inertia")]

    @property
    def fluctuation(self) -> Number:
        """Coefficient of speed fluctuation, (highest - lowest) / mean."""
        return float((self.speed.max() - self.speed.min()) / self.mean_speed)

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the speed over the crank angle."""
        curves = {"speed": RPM * self.speed}
        title = f"Speed over a turn, fluctuation {self.fluctuation:.2g}"
        axes, label = new_axes(axes), "crank speed [1/min]"
        draw_over_angle(axes, np.radians(self.angles_deg), curves, label, angle_label=FROM_TOP)
        write_title(axes, title)
        return axes

    def to_pandas(self) -> DataFrame:
        """Return crank angles and speeds."""
        return table({"crank_angle": (self.angles_deg, "deg"), "speed": (self.speed, "rad/s")})


@dataclass(frozen=True, eq=False)
class TurnEnergy:
    """Inertia and the energy gained since the top at even angles, shapes (m,)."""

    angles: FloatArray
    inertia: FloatArray
    gained: FloatArray
    left_over: float


def steady_hinge_turn(
    point: HingeMoment,
    hinge: HingeProfile | None = None,
    *,
    pressure: float | None = None,
    flywheel: float = 0.0,
    speed: float | None = None,
    top_speed: float | None = None,
) -> SteadyHingeTurn:
    """Find a periodic revolution at constant load.

    Parameters
    ----------
    point : HingeMoment
        Engine, gas force, load and speed; its own hinge moment is not used.
    pressure : float, optional
        Initial pressure of the spring [Pa], by default that of the design.
    speed : float, optional
        Mean speed of the revolution [rad/s], by default that of `point`.
    top_speed : float, optional
        Speed at the top dead center [rad/s], instead of the mean speed.

    Raises
    ------
    InputError
        If a number is out of its range, both speeds are given, or the crank does not complete a revolution.

    Notes
    -----
    I phi'' + I' phi'^2 / 2 = Q is d(I phi'^2 / 2)/dphi = Q. As gas, weights, load and hinge depend
    on the angle alone, the energy is an integral of known functions, and a revolution is periodic
    from any initial speed. The mean speed grows with the energy at the top, which is solved for it.
    """
    nonnegative_number("flywheel", flywheel, "kg m^2", "it is an inertia")
    energy = turn_energy(point, hinge, pressure)
    if top_speed is not None:
        if speed is not None:
            raise InputError(
                f"top_speed: given {top_speed:g} rad/s beside a mean speed of {speed:g} rad/s; allowed is "
                "one of the two, because either follows from the other."
            )
        reason = "the crank turns forward"
        return _from_top(energy, flywheel, positive_number("top_speed", top_speed, "rad/s", reason))
    wanted = positive_number(
        "speed", point.speed if speed is None else speed, "rad/s", "the crank turns forward"
    )
    return steady_at(energy, flywheel, wanted)


def simulate_hinge(
    point: HingeMoment,
    hinge: HingeProfile | None = None,
    *,
    pressure: float | None = None,
    flywheel: float = 0.0,
    start_speed: float | None = None,
    turns: float = 1.0,
    samples: int = STEPS,
) -> SpeedOverAngle:
    """Integrate the equation of motion of a crank from the top dead center.

    Parameters
    ----------
    start_speed : float, optional
        At the top [rad/s]; by default that of the periodic revolution at the speed of `point`.

    Raises
    ------
    InputError
        As `steady_hinge_turn`.

    Notes
    -----
    Inertia and moments are splines over the angle. The hinge's moment is that of its
    guides and spring, 2 F_pn d rho/d phi.
    """
    if start_speed is None:
        turn = steady_hinge_turn(point, hinge, pressure=pressure, flywheel=flywheel)
        start_speed = float(turn.speed[0])
    _, reduced, moments = moments_on_crank(point, hinge, pressure)
    inertia, moment = periodic_spline(reduced.inertia + flywheel), periodic_spline(moments)
    return speed_over_angle(
        lambda angle: float(inertia(angle)),
        lambda _, angle: float(moment(angle)),
        start_angle_deg=0.0,
        start_speed=start_speed,
        turns=turns,
        samples=samples,
    )


def moments_on_crank(
    point: HingeMoment, hinge: HingeProfile | None, pressure: float | None
) -> tuple[FloatArray, ReducedCrank, FloatArray]:
    """Return even angles, the reduced crank and the sum of all moments on it at them."""
    angles = even_angles(TURN, STEPS)
    reduced, moment = point.at_angles(angles_deg=np.degrees(angles))
    if hinge is not None:
        moment = moment + hinge.moment_at(pressure, angles_deg=np.degrees(angles))
    return angles, reduced, moment


def turn_energy(
    point: HingeMoment, hinge: HingeProfile | None, pressure: float | None
) -> TurnEnergy:
    """Integrate all moments on the crank over a revolution."""
    angles, reduced, moment = moments_on_crank(point, hinge, pressure)
    return integrated(angles, reduced.inertia, moment)


def integrated(angles: FloatArray, inertia: FloatArray, moment: FloatArray) -> TurnEnergy:
    """Integrate the sum of the moments at even angles from the top."""
    gained = np.asarray(periodic_spline(moment).antiderivative()(np.append(angles, TURN)))
    return TurnEnergy(angles, inertia, gained[:-1], float(gained[-1]))


def steady_at(energy: TurnEnergy, flywheel: float, speed: float) -> SteadyHingeTurn:
    """Solve for the energy at the top that gives the required mean speed.

    The initial value of `steady_turning` is sufficient here: no moment depends on the speed, so
    the energy need not be integrated again for each trial.
    """
    inertia = energy.inertia + flywheel
    at_top = energy_for_mean_speed(energy.gained, inertia, speed)
    if at_top is None:
        slowest = slowest_mean_speed(energy.gained, inertia)
        raise InputError(
            f"speed: given a mean of {format_quantity(speed, 'rad/s', 4)}; allowed is "
            f"{format_quantity(slowest, 'rad/s', 4)} or more with a flywheel of {flywheel:.4g} kg m^2, "
            "because a slower crank does not complete a revolution: over a turn its energy swings by "
            f"{np.ptp(energy.gained) / 1e3:.4g} kJ."
        )
    return _turn(energy, inertia, at_top, flywheel)


def _from_top(energy: TurnEnergy, flywheel: float, top_speed: float) -> SteadyHingeTurn:
    """Return the revolution for a speed at the top."""
    inertia = energy.inertia + flywheel
    at_top = 0.5 * float(inertia[0]) * top_speed**2
    lacking = -float(energy.gained.min())
    if not at_top > lacking:
        needed = math.sqrt(2.0 * lacking / float(inertia[0]))
        raise InputError(
            f"top_speed: given {top_speed:.4g} rad/s; allowed is more than {needed:.4g} rad/s, because "
            f"over a turn the crank loses {lacking / 1e3:.4g} kJ and must complete a revolution."
        )
    return _turn(energy, inertia, at_top, flywheel)


def _turn(
    energy: TurnEnergy, inertia: FloatArray, at_top: float, flywheel: float
) -> SteadyHingeTurn:
    kinetic = energy.gained + at_top
    speed = np.sqrt(2.0 * kinetic / inertia)
    return SteadyHingeTurn(
        angles_deg=read_only(np.degrees(energy.angles)),
        speed=read_only(speed),
        mean_speed=mean_speed(kinetic, inertia),
        gain=energy.left_over,
        flywheel=flywheel,
    )


LARGEST_FLYWHEEL = 1e9
# Of the logarithm of the pressure: values tried at first, and where the search ends.
TRIED_PRESSURES, PRESSURE_STEP = 41, 1e-10
# Stands for the fluctuation of a crank that does not come round; no turning one reaches it.
STANDING = 100.0


@result(
    "pressure", "ratio", "fluctuation", "unchanged", "moment_residual", "largest_residual", eq=True
)
class BestPressure(Result):
    """The initial pressure of a spring that smooths a crank's speed most, for given guides.

    Parameters
    ----------
    ratio : float
        Relative to that for which the guides were designed.
    fluctuation : float
        Coefficient of speed fluctuation with it.
    unchanged : float or None
        With the pressure of the design; None if the crank does not complete a revolution with it.
    moment_residual : float
        Root mean square of the difference between the hinge's moment and that for constant speed,
        relative to the root mean square of the latter.
    largest_residual : float
        Largest difference, relative to the largest moment for constant speed.
    fitted_ratio : float
        Pressure ratio with the least residual.
    """

    pressure: Annotated[float, Quantity("Pa", key="best_pressure")]
    ratio: Annotated[float, Quantity("1", key="best_ratio")]
    fluctuation: Number
    unchanged: Annotated[float | None, Quantity("1", key="fluctuation_unchanged")]
    moment_residual: Number
    largest_residual: Number
    fitted_ratio: Number


def flywheel_for(
    point: HingeMoment, fluctuation: float, hinge: HingeProfile | None = None
) -> float:
    """Return the inertia of the flywheel that reaches a coefficient of speed fluctuation.

    Parameters
    ----------
    fluctuation : float
        Required coefficient, above zero.

    Returns
    -------
    float
        [kg m^2]; zero if the engine needs none.

    Raises
    ------
    InputError
        If no flywheel up to 1e9 kg m^2 is enough.
    """
    from scipy.optimize import brentq

    positive_number("fluctuation", fluctuation, "", "a speed that varies not at all needs no end")
    energy = turn_energy(point, hinge, None)

    def excess(inertia: float) -> float:
        try:
            reached = steady_at(energy, inertia, point.speed).fluctuation
        except InputError:
            reached = STANDING
        return math.log(reached / fluctuation)

    if excess(0.0) <= 0.0:
        return 0.0
    larger = 1.0
    while excess(larger) > 0.0:
        larger *= 10.0
        if larger > LARGEST_FLYWHEEL:
            raise InputError(
                f"fluctuation: given {fluctuation:g}; allowed is what a flywheel of "
                f"{LARGEST_FLYWHEEL:g} kg m^2 reaches, because larger ones are not built."
            )
    smaller = 0.0 if larger == 1.0 else larger / 10.0
    return float(brentq(excess, smaller, larger, rtol=1e-12))


def moment_residuals(point: HingeMoment, hinge: HingeProfile) -> tuple[float, float]:
    """Return what a hinge's moment lacks of that for constant speed, relative to it.

    Returns
    -------
    tuple of two float
        By root mean squares, and by largest values.
    """
    wanted = point.moment
    residual = wanted - hinge.moment_at(angles_deg=point.angles_deg)
    return (
        math.sqrt(float(np.mean(residual**2) / np.mean(wanted**2))),
        float(np.max(np.abs(residual)) / np.max(np.abs(wanted))),
    )


def best_pressure(
    point: HingeMoment,
    hinge: HingeProfile,
    *,
    bounds: tuple[float, float] = (0.1, 10.0),
    flywheel: float = 0.0,
) -> BestPressure:
    """Find the initial pressure that smooths the speed most at an operating point.

    Parameters
    ----------
    point : HingeMoment
        Operating point, in general not the one for which the guides were designed.
    bounds : tuple of two float, optional
        Smallest and largest pressure considered, as multiples of the design's.

    Raises
    ------
    InputError
        If the bounds are not above zero and ascending, or the crank comes round nowhere in them.

    Notes
    -----
    The guides fix z, so the gas force and hence the moment of the hinge are proportional to
    the initial pressure if there is no ambient pressure (equation (14) of Zotov, Imaeva 2024).
    """
    from scipy.optimize import minimize_scalar

    low, high = bounds
    if not 0.0 < low < high:
        raise InputError(
            f"bounds: given {low:g} to {high:g}; allowed are two ascending multiples above zero, because "
            "the best pressure is looked for between them."
        )
    angles, reduced, driving = moments_on_crank(point, None, None)

    def fluctuation(logarithm: float) -> float:
        pressure = math.exp(logarithm) * hinge.spring.pressure
        moment = driving + hinge.moment_at(pressure, angles_deg=np.degrees(angles))
        energy = integrated(angles, reduced.inertia, moment)
        try:
            return steady_at(energy, flywheel, point.speed).fluctuation
        except InputError:
            # The crank does not come round: worse than any that does, and the more so the more
            # energy it lacks.
            swing = float(np.ptp(energy.gained)) / float(np.mean(energy.inertia) + flywheel)
            return STANDING * (1.0 + swing / point.speed**2)

    tried = np.linspace(math.log(low), math.log(high), TRIED_PRESSURES)
    place = int(np.argmin([fluctuation(value) for value in tried]))
    minimum = minimize_scalar(
        fluctuation,
        bounds=(tried[max(place - 1, 0)], tried[min(place + 1, tried.size - 1)]),
        method="bounded",
        options={"xatol": PRESSURE_STEP},
    )
    if not minimum.fun < STANDING:
        raise InputError(
            f"bounds: given {low:g} to {high:g}; allowed are bounds between which the crank completes "
            f"revolutions at {point.speed:g} rad/s, because there is nothing to compare otherwise."
        )
    unchanged = fluctuation(0.0)
    ratio = math.exp(float(minimum.x))
    wanted, hinged = point.moment, hinge.moment_at(angles_deg=point.angles_deg)
    pressure = ratio * hinge.spring.pressure
    lacking = moment_residuals(point, hinge.with_pressure(pressure))
    return BestPressure(
        pressure=pressure,
        ratio=ratio,
        fluctuation=float(minimum.fun),
        unchanged=unchanged if unchanged < STANDING else None,
        moment_residual=lacking[0],
        largest_residual=lacking[1],
        fitted_ratio=float(np.dot(wanted, hinged) / np.dot(hinged, hinged)),
    )
