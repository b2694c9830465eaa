"""A two-stroke crosshead engine of one cylinder for hinge calculations, and its gas force."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    checked_degrees,
    finite_array,
    nonnegative_number,
    positive_number,
)
from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.input_file import GivenFile
from crankbase.sentences import amount, in_si
from crankbase.summaries import frozen
from dynamics.cycle import even_angles
from dynamics.engine.forces import (
    Pressure,
    gas_forces,
    parts_motion,
    piston_position,
    reduced_inertia,
    rod_models,
)
from dynamics.engine.layout import EngineCylinder, EngineLayout
from dynamics.engine.rods import ConnectingRod, check_reach
from dynamics.gas.gas_cycle import GasCycleResult, gas_cycle, usual_gas_cycle
from dynamics.gas.pressure import ATMOSPHERE, CLOSING_TOLERANCE
from dynamics.sample_tables import (
    TableKind,
    TableReading,
    one_cycle,
    read_sample_rows,
)

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline


TURN = 2.0 * math.pi


def turn_integral(samples: Array) -> float:
    """Return the integral over a revolution of a function given at even angles.

    The plain sum is exact for all harmonics that the samples resolve.
    """
    return TURN * float(np.mean(samples))


def antiderivative(samples: Array) -> Array:
    """Return the integral from the first angle to each one, for samples of mean zero.

    Harmonic by harmonic. A mean is left out: its integral would not be periodic.
    """
    spectrum = np.fft.rfft(samples)
    spectrum[1:] /= 1j * np.arange(1, spectrum.size)
    spectrum[0] = 0.0
    integral = np.fft.irfft(spectrum, samples.size)
    return np.asarray(integral - integral[0])


def periodic_spline(samples: Array) -> "CubicSpline":
    """Return the cubic spline that repeats every turn through samples at even angles."""
    from scipy.interpolate import CubicSpline  # here: loading it takes a quarter second

    angles = np.append(even_angles(TURN, samples.size), TURN)
    return CubicSpline(angles, np.append(samples, samples[0]), bc_type="periodic")


# Force on the piston towards the shaft [N] at crank angles [rad] of shape (m,).
GasForce = Callable[[Array], Array]
STANDARD_GRAVITY = 9.81


@dataclass(frozen=True)
class CrossheadEngine:
    """A horizontal two-stroke engine of one cylinder with crosshead.

    Parameters
    ----------
    bore : float
        Diameter of the piston [m].
    crank_radius : float
        R, from shaft axis to crankpin [m].
    crank_mass : float
        Crank with the guides of the hinge [kg].
    crank_center_distance : float
        r_1, from the shaft axis to the crank's center of mass, on the side of the crankpin [m].
    crank_inertia : float
        Of crank and guides about the shaft axis [kg m^2].
    rod : ConnectingRod
        l_1 is its center distance.
    crosshead_mass, piston_rod_mass, piston_mass : float
        Mass that moves along the cylinder [kg].
    gravity : float, optional
        Acceleration of gravity across the cylinder axis, against the side to which the crankpin
        moves as it passes the top [m/s^2].

    Raises
    ------
    InputError
        If a length, mass or inertia is out of its range, the crank cannot complete a revolution, or no
        crank of that mass and center has that inertia.

    Examples
    --------
    >>> rod = ConnectingRod(1.55, 150.0, 0.8, 50.0)
    >>> engine = CrossheadEngine(0.3, 0.5, 80.0, 0.2, 30.0, rod, 150.0, 200.0, 110.0)
    >>> engine.sliding_mass, round(engine.crank_ratio, 4)
    (460.0, 0.3226)
    """

    bore: float
    crank_radius: float
    crank_mass: float
    crank_center_distance: float
    crank_inertia: float
    rod: ConnectingRod
    crosshead_mass: float
    piston_rod_mass: float
    piston_mass: float
    gravity: float = STANDARD_GRAVITY

    def __post_init__(self) -> None:
        positive_number("bore", self.bore, "m", "it is a length")
        positive_number("crank_radius", self.crank_radius, "m", "it is a length")
        check_reach("crank_radius", self.crank_radius, self.rod.length, 0.0)
        for name in ("crank_mass", "crosshead_mass", "piston_rod_mass"):
            nonnegative_number(name, getattr(self, name), "kg", "it is a mass")
        positive_number("piston_mass", self.piston_mass, "kg", "it is a mass")
        positive_number("crank_inertia", self.crank_inertia, "kg m^2", "the crank has mass")
        finite_array("crank_center_distance", self.crank_center_distance)
        finite_array("gravity", self.gravity)
        least = self.crank_mass * self.crank_center_distance**2
        if self.crank_inertia < least:
            raise InputError(
                f"crank_inertia: given {amount(self.crank_inertia, 'kg m^2')}; allowed is "
                f"{amount(least, 'kg m^2')} or more, because {amount(self.crank_mass, 'kg')} with the center "
                f"{in_si(self.crank_center_distance, 'm')} from the axis have no less."
            )

    @property
    def area(self) -> float:
        """Area of the piston [m^2]."""
        return 0.25 * math.pi * self.bore**2

    @property
    def crank_ratio(self) -> float:
        """R / L, the papers' lambda."""
        return self.crank_radius / self.rod.length

    @property
    def sliding_mass(self) -> float:
        """Crosshead, piston rod and piston [kg]."""
        return self.crosshead_mass + self.piston_rod_mass + self.piston_mass

    @property
    def layout(self) -> EngineLayout:
        """The engine as a layout of one cylinder, for general calculations."""
        cylinder = EngineCylinder(bore=self.bore, piston_mass=self.sliding_mass, rod=self.rod)
        return EngineLayout(
            crank_radius=self.crank_radius,
            cylinders=(cylinder,),
            firing_order=(1,),
            strokes=2,
            shaft_inertia=float(self.crank_inertia),
        )


def piston_gas_force(
    engine: CrossheadEngine, pressure: Pressure, pressure_below: float = ATMOSPHERE
) -> GasForce:
    """Return the gas force as a function of the crank angle.

    Parameters
    ----------
    pressure : GasPressure
        Two-stroke, over the angle from the top.
    pressure_below : float, optional
        Absolute pressure on the lower side of the piston [Pa].

    Returns
    -------
    callable
        Force towards the shaft [N] at crank angles [rad] of shape (m,).
    """
    layout = engine.layout
    return lambda angles: gas_forces(
        layout, pressure, pressure_below, shaft_angles_deg=np.degrees(angles)
    )[0]


def two_stroke_cycle(
    engine: CrossheadEngine,
    compression_ratio: float,
    *,
    peak_pressure: float,
    mean_effective_pressure: float,
    intake_pressure: float,
    **parameters: float,
) -> GasCycleResult:
    """Calculate the pressure over a two-stroke cycle from three pressures.

    Parameters
    ----------
    peak_pressure, mean_effective_pressure, intake_pressure : float
        Highest pressure, absolute; indicated mean pressure; and pressure of the charge, absolute
        [Pa]. They determine the duration of the combustion.
    **parameters : float
        Any other parameters of `GasCycle`.
    """
    cycle = usual_gas_cycle(
        compression_ratio, strokes=2, intake_pressure=intake_pressure, **parameters
    )
    return gas_cycle(
        cycle,
        piston_position(engine.layout, 1),
        engine.area,
        peak_pressure=peak_pressure,
        mean_effective_pressure=mean_effective_pressure,
        solve_for="combustion_duration_deg",
    )


CRANK_ANGLE = "crank_angle_deg"
UNITS = {"N": 1.0, "kN": 1e3, "MN": 1e6}
TURN_DEG = 360.0

TABLE = TableKind(
    name="gas force table",
    angle_names=(CRANK_ANGLE,),
    value_names=tuple(f"gas_force_{unit}" for unit in UNITS),
    units=UNITS,
    si="N",
    headers=f'"{CRANK_ANGLE},gas_force_N", or "kN" or "MN" for "N"',
    header_says="in which unit the force is given",
)


def read_gas_force(path: GivenFile, reading: TableReading | None = None) -> GasForce:
    """Read a gas force table.

    The file has comment lines that start with a number sign, the header
    ``crank_angle_deg,gas_force_N`` (or ``kN``, ``MN``), then one sample a line. Angles count from the top
    dead center and cover a revolution, wherever it starts, in steps of up to 10 deg; the force is positive
    towards the shaft. A closing sample that repeats the first is dropped.

    Parameters
    ----------
    reading : TableReading, optional
        Which columns are meant, where the header does not say so.

    Returns
    -------
    callable
        Force [N] at crank angles [rad] from the top: the periodic cubic spline through the
        samples.
    """
    _, rows = one_cycle(
        read_sample_rows(path, TABLE, reading),
        {2: TURN_DEG},
        tolerance=CLOSING_TOLERANCE,
        what="force",
    )
    force = rows.values * UNITS[rows.unit]
    angles = np.radians(rows.angles)
    from scipy.interpolate import CubicSpline  # here: loading it takes a quarter second

    closed = np.append(angles, angles[0] + TURN)
    curve = CubicSpline(closed, np.append(force, force[0]), bc_type="periodic")
    return lambda asked: np.asarray(curve(asked))


Kinematics = Literal["exact", "series", "printed"]
KINEMATICS: tuple[Kinematics, ...] = get_args(Kinematics)


@frozen("inertia [kg m^2]", "travel_rate [m]", "weight_moment [N m]", eq=False)
class ReducedCrank:
    """An engine of one degree of freedom reduced to its crank, arrays of shape (m,).

    Parameters
    ----------
    inertia : ndarray
        I, in T = I w^2 / 2 [kg m^2].
    inertia_rate : ndarray
        dI/dphi [kg m^2/rad].
    travel_rate : ndarray
        Travel of the piston towards the shaft per crank angle, dx/dphi [m/rad].
    weight_moment : ndarray
        Moment of the weights of crank and rod, positive when it drives [N m].
    """

    inertia: Array
    inertia_rate: Array
    travel_rate: Array
    weight_moment: Array


def reduced_crank(
    engine: CrossheadEngine, kinematics: Kinematics = "exact", *, angles_deg: ArrayLike
) -> ReducedCrank:
    """Reduce an engine to its crank.

    Parameters
    ----------
    kinematics : str, optional
        "exact"; "series", in which velocities end at the second harmonic; or "printed", the series
        with the sign of the rod's second harmonic as printed in the source.
    angles_deg : array_like of shape (m,)
        Crank angles from the top dead center [deg].

    Raises
    ------
    InputError
        If there are no such kinematics, an angle is not a finite number, or they are radians.

    Notes
    -----
    The series is that of A. N. Zotov, E. Sh. Imaeva, Transport i khranenie nefteproduktov i
    uglevodorodnogo syr'ya 2024 no. 1-2, pp. 50-55, doi 10.24412/0131-4270-2024-1-2-50-55: with
    lambda = R / L, dx = R (sin phi + lambda/2 sin 2 phi) dphi, and
    cos gamma = 1 - lambda^2/4 + lambda^2/4 cos 2 phi for the rod's angle gamma. Its equations (2),
    (6), (7), (8) give the rod's center of mass the velocity R (sin phi - lambda l_1/(2 L) sin 2 phi)
    along the cylinder. From s = R cos phi + l_1 cos gamma it is plus: with l_1 = L the center of
    mass is at the crosshead, whose velocity has a plus in the same papers.
    """
    check_choice(
        "kinematics", kinematics, KINEMATICS, "these are the ways to describe the mechanism"
    )
    places_deg = checked_degrees("angles_deg", angles_deg, vector=True)
    places = np.radians(places_deg)
    if kinematics != "exact":
        return _series(engine, places, 1.0 if kinematics == "series" else -1.0)
    layout = engine.layout
    motion = parts_motion(layout, 1, places)
    rod_rise = motion.rod_point(engine.rod.center).first.imag
    return ReducedCrank(
        *reduced_inertia(layout, rod_models(layout, "rigid"), shaft_angles_deg=places_deg),
        travel_rate=-motion.piston.first.real,
        weight_moment=_weight_moment(engine, places, rod_rise),
    )


def _series(engine: CrossheadEngine, angles: Array, sign: float) -> ReducedCrank:
    """Reduce with velocities up to the second harmonic; `sign` is that of the rod's own."""
    rod, radius, ratio = engine.rod, engine.crank_radius, engine.crank_ratio
    if rod.center_offset != 0.0:
        raise InputError(
            f"rod center_offset: given {in_si(rod.center_offset, 'm')}; allowed is 0 with the series, "
            "because it is for rods with the center of mass on their axis."
        )
    near = sign * rod.center_distance / rod.length
    far = 1.0 - rod.center_distance / rod.length
    sine, cosine = np.sin(angles), np.cos(angles)
    sine_2, cosine_2 = np.sin(2.0 * angles), np.cos(2.0 * angles)
    rod_cosine = 1.0 - 0.25 * ratio**2 + 0.25 * ratio**2 * cosine_2
    swing = ratio * cosine / rod_cosine
    swing_rate = ratio * (-sine / rod_cosine + 0.5 * ratio**2 * sine_2 * cosine / rod_cosine**2)
    travel_rate = radius * (sine + 0.5 * ratio * sine_2)
    travel_second = radius * (cosine + ratio * cosine_2)
    along = radius * (sine + 0.5 * ratio * near * sine_2)
    along_rate = radius * (cosine + ratio * near * cosine_2)
    across, across_rate = radius * far * cosine, -radius * far * sine
    inertia = (
        engine.crank_inertia
        + engine.sliding_mass * travel_rate**2
        + rod.mass * (along**2 + across**2)
        + rod.inertia * swing**2
    )
    rate = 2.0 * (
        engine.sliding_mass * travel_rate * travel_second
        + rod.mass * (along * along_rate + across * across_rate)
        + rod.inertia * swing * swing_rate
    )
    # The source joins the series of cos gamma to the exact derivative of gamma.
    exact_cosine = np.sqrt(1.0 - (ratio * sine) ** 2)
    rod_rise = (rod.length - rod.center_distance) * rod_cosine * ratio * cosine / exact_cosine
    return ReducedCrank(inertia, rate, travel_rate, _weight_moment(engine, angles, rod_rise))


def _weight_moment(engine: CrossheadEngine, angles: Array, rod_rise: Array) -> Array:
    """Return the weights' moment from the rise of the rod's center by angle [m/rad]."""
    crank_rise = engine.crank_center_distance * np.cos(angles)
    return -engine.gravity * (engine.crank_mass * crank_rise + engine.rod.mass * rod_rise)
