"""Torque of an engine over its cycle, by cylinder and throw; stars of its orders."""

import cmath
import math
from collections.abc import Iterable, Sequence
from dataclasses import fields
from typing import Annotated, Literal, cast

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    finite_array,
    finite_vector,
    nonnegative_number,
    positive_vector,
    read_only,
)
from crankbase.choices import check_choice, check_some, is_whole, whole_number, whole_within
from crankbase.diagrams import BLUE, COLORS, ORANGE, legend_above, new_axes, write_title
from crankbase.errors import InputError, SolveError
from crankbase.frames import Axes, DataFrame, Dataset, grid, table
from crankbase.results import Flat, Internal, Number, Part, Quantity, Result, Speed, result
from dynamics.critical import FULL_SUM_TOLERANCE, engine_orders
from dynamics.cycle import checked_strokes, cycle_radians, even_angles, order_numbers
from dynamics.engine import RodModelName
from dynamics.engine.forces import (
    MechanismForces,
    Pressure,
    checked_cylinder,
    gas_forces,
    mechanism_forces,
    parts_motion,
    spread_array,
)
from dynamics.engine.layout import IN_LINE, EngineLayout
from dynamics.gas.pressure import ATMOSPHERE, indicated_work
from dynamics.harmonics import Harmonics, harmonics
from dynamics.indices import grouped
from dynamics.plots.curves import KILO, angle_axis, draw_over_angle, number_axis
from dynamics.plots.harmonics import draw_harmonics, draw_star, finish_stars

# Steps of 0.5 deg over 720 deg resolve orders up to 360, those over 360 deg of twice that.
DEFAULT_SAMPLES = 1440


def samples_and_gas(
    engine: EngineLayout,
    pressure: Pressure | Sequence[Pressure] | ArrayLike | None,
    samples: int,
    crankcase_pressure: float,
) -> tuple[Array, Array]:
    """Return shaft angles evenly over a cycle (m,) [rad], and forces on the pistons (n, m) [N]."""
    count = whole_number("samples", samples, 3, "fewer show no harmonic")
    angles = even_angles(cycle_radians(engine.strokes), count)
    shape = (len(engine.cylinders), count)
    if pressure is None:
        return angles, np.zeros(shape)
    first = pressure[0] if isinstance(pressure, Sequence) and pressure else pressure
    if hasattr(first, "at"):
        pressures = cast("Pressure | Sequence[Pressure]", pressure)
        degrees = np.degrees(angles)
        return angles, gas_forces(engine, pressures, crankcase_pressure, shaft_angles_deg=degrees)
    forces = finite_array("pressure", np.asarray(pressure))
    if forces.shape != shape:
        raise InputError(
            f"pressure: given forces of shape {forces.shape}; allowed is {shape}, because there is one "
            "for each cylinder and sample."
        )
    return angles, forces


def forces_by_cause(
    engine: EngineLayout, speed: float, angles: Array, gas: Array, model: RodModelName
) -> tuple[MechanismForces, MechanismForces]:
    """Return the forces in the mechanism of the gas alone, and of moving masses alone."""
    running = nonnegative_number("speed", speed, "rad/s", "the shaft turns forward")
    of_gas = mechanism_forces(engine, 0.0, gas, model=model, shaft_angles_deg=np.degrees(angles))
    return of_gas, mechanism_forces(
        engine, running, model=model, shaft_angles_deg=np.degrees(angles)
    )


def from_firing_top(
    engine: EngineLayout, place: int, angles: Array, values: Array, unit: str
) -> Harmonics:
    """Return the harmonics of a cylinder's values (m,), its index from 0, counted from its firing top."""
    since_firing = np.degrees(angles - np.radians(engine.firing_deg[place]))
    return harmonics(values, engine.strokes, angles_deg=since_firing, unit=unit)


# Rods on one throw stand closer than this share of the bore: cylinders of a bank cannot.
CLOSE = 0.75


def throws_along_shaft(engine: EngineLayout) -> tuple[tuple[int, ...], ...]:
    """Return the numbers of the cylinders on each throw, from the free end to the flywheel.

    Cylinders share a throw if a rod of one is hinged to that of the other, or if their crank angles
    are equal, their banks differ and they are closer along the shaft than a bank allows. Throws
    at one position are in the order of their cylinders' numbers.
    """
    numbers = range(1, len(engine.cylinders) + 1)
    along = sorted(numbers, key=lambda number: (engine.cylinders[number - 1].position, number))
    mains = (number for number in along if engine.main_of(number) == number)

    def shares(throw: list[int], number: int) -> bool:
        cylinder = engine.cylinders[number - 1]
        for other in (engine.cylinders[member - 1] for member in throw):
            turned = math.remainder(
                math.radians(cylinder.crank_angle_deg - other.crank_angle_deg), 2.0 * math.pi
            )
            leaning = math.remainder(
                math.radians(cylinder.bank_angle_deg - other.bank_angle_deg), 2.0 * math.pi
            )
            apart = abs(cylinder.position - other.position)
            if abs(turned) > IN_LINE or abs(leaning) <= IN_LINE or apart >= CLOSE * cylinder.bore:
                return False
        return True

    throws = grouped(mains, shares)
    for number in along:
        main = engine.main_of(number)
        if main != number:
            next(throw for throw in throws if main in throw).append(number)
    return tuple(tuple(sorted(throw)) for throw in throws)


def checked_throws(engine: EngineLayout, throws: Sequence[int]) -> tuple[tuple[int, ...], ...]:
    """Return the numbers of the cylinders on each throw from the throw of each cylinder, from 0."""
    of_cylinders = list(throws)
    if len(of_cylinders) != len(engine.cylinders):
        raise InputError(
            f"throws: given {len(of_cylinders)}; allowed are {len(engine.cylinders)}, because each cylinder "
            "works on one."
        )
    if not all(is_whole(throw) for throw in of_cylinders):
        raise InputError(
            f"throws: given {of_cylinders}; allowed are whole numbers from 0 on, because throws are counted "
            "from the free end."
        )
    if sorted(set(of_cylinders)) != list(range(max(of_cylinders) + 1)):
        raise InputError(
            f"throws: given {of_cylinders}; allowed are throws from 0 on without a gap, because each has a "
            "cylinder."
        )
    return tuple(
        tuple(place + 1 for place, number in enumerate(of_cylinders) if number == throw)
        for throw in range(max(of_cylinders) + 1)
    )


@result(
    "number",
    "firing_angle_deg",
    "tangential: tangential.amplitude [N]",
    "radial: radial.amplitude [N]",
)
class PinForceHarmonics(Result):
    """Harmonics of one cylinder's force on its crankpin, by its cause [N].

    Phases count from the cylinder's own firing top: a harmonic of order k is
    M_k sin(k (shaft angle - firing angle) + a_k).

    Parameters
    ----------
    tangential_gas, tangential_inertia, tangential : Harmonics
        T, in the sense of rotation: of the gas, of moving masses, of both. Crank radius times T is
        the torque.
    radial_gas, radial_inertia, radial : Harmonics
        Z, towards the shaft axis.
    """

    number: int
    firing_angle_deg: Annotated[float, Quantity("deg")]
    tangential_gas: Internal[Harmonics]
    tangential_inertia: Internal[Harmonics]
    tangential: Internal[Harmonics]
    radial_gas: Internal[Harmonics]
    radial_inertia: Internal[Harmonics]
    radial: Internal[Harmonics]

    @property
    def by_cause(self) -> Flat[dict[str, dict[str, Harmonics]]]:
        """Harmonics of the "tangential" and the "radial" force, each by its cause."""
        causes = {"gas": "_gas", "inertia": "_inertia", "gas and inertia": ""}
        return {
            force: {cause: getattr(self, force + ending) for cause, ending in causes.items()}
            for force in ("tangential", "radial")
        }

    def plot(
        self,
        axes: Axes | None = None,
        *,
        show: Literal["tangential", "radial"] = "tangential",
        highest_order: float | None = None,
    ) -> Axes:
        """Draw the amplitudes of T or Z by order: of the gas, of moving masses, of both."""
        check_choice("show", show, ("tangential", "radial"), "these are the forces on a crankpin")
        series = {
            name: getattr(self, show + ending)
            for name, ending in (("gas", "_gas"), ("inertia", "_inertia"), ("both", ""))
        }
        if highest_order is not None:
            series = {name: spectrum.up_to(highest_order) for name, spectrum in series.items()}
        bars = {name: KILO * spectrum.amplitude for name, spectrum in series.items()}
        title = f"Harmonics of the {show} force, cylinder {self.number}"
        return draw_harmonics(axes, series["both"].orders, bars, "amplitude [kN]", title=title)

    def to_pandas(self) -> DataFrame:
        """Return one row for each order: amplitude and phase of T and Z by cause."""
        columns: dict[str, tuple[Array, str]] = {"order": (self.tangential.orders, "1")}
        for cause in fields(self)[2:]:
            name = cause.name
            spectrum: Harmonics = getattr(self, name)
            columns[name] = (spectrum.amplitude, "N")
            columns[f"{name}_phase"] = (spectrum.phase, "rad")
        return table(columns)


def pin_force_harmonics(
    engine: EngineLayout,
    speed: float,
    pressure: Pressure | Sequence[Pressure] | ArrayLike | None = None,
    *,
    highest_order: float = 24.0,
    samples: int = DEFAULT_SAMPLES,
    model: RodModelName = "rigid",
    crankcase_pressure: float = ATMOSPHERE,
) -> tuple[PinForceHarmonics, ...]:
    """Find the harmonics of the tangential and the radial force on the crankpin, by cylinder.

    Parameters
    ----------
    engine, speed, pressure, samples, model, crankcase_pressure
        As for `engine_torque`.
    highest_order : float, optional
        Highest order; the samples must resolve it.

    Raises
    ------
    InputError
        As `engine_torque`, and if the samples do not resolve the highest order.
    """
    angles, gas = samples_and_gas(engine, pressure, samples, crankcase_pressure)
    of_gas, of_masses = forces_by_cause(engine, speed, angles, gas, model)
    parts: list[Array] = []
    for by_gas, by_masses in (
        (of_gas.tangential, of_masses.tangential),
        (of_gas.radial, of_masses.radial),
    ):
        parts += [by_gas, by_masses, by_gas + by_masses]
    by_cylinder = []
    for place, firing in enumerate(np.radians(engine.firing_deg)):
        split = [
            from_firing_top(engine, place, angles, part[place], "N").up_to(highest_order)
            for part in parts
        ]
        by_cylinder.append(PinForceHarmonics(place + 1, math.degrees(firing), *split))
    return tuple(by_cylinder)


# A mean torque below this share of the largest is round-off.
NO_MEAN = 1e-12

# Torque and work of the gas are sums over the same some thousand angles of a cycle, each of them true to
# 1e-16 of its terms; those of the masses, whose sum is zero, are up to a hundred times those of the gas.
LARGEST_ENERGY_ERROR = 1e-10


@result("speed", "mean", "total [N m]", "power", "nonuniformity", "energy_error")
class EngineTorque(Result):
    """Torque on the shaft over one working cycle, positive when it drives.

    Parameters
    ----------
    shaft_angles_deg : ndarray of shape (m,)
        Evenly over the cycle from zero, without the closing sample [deg].
    gas, inertia : ndarray of shape (n, m)
        Of each cylinder, from the gas and from moving masses [N m].
    throws : tuple of tuples of int
        Numbers of the cylinders on each throw, from the free end to the flywheel.
    indicated_work : ndarray of shape (n,)
        Work of the gas on each piston over the cycle, integral of p dV [J].
    """

    engine: Internal[EngineLayout]
    speed: Speed
    shaft_angles_deg: Internal[Array]
    gas: Internal[Array]
    inertia: Internal[Array]
    throws: Internal[tuple[tuple[int, ...], ...]]
    indicated_work: Annotated[Array, Quantity("J")]

    @property
    def per_cylinder(self) -> Array:
        """Torque of each cylinder (n, m) [N m]."""
        return self.gas + self.inertia

    @property
    def per_throw(self) -> Array:
        """Torque of each throw, along the shaft (k, m) [N m]."""
        torques = self.per_cylinder
        return np.array(
            [torques[[number - 1 for number in throw]].sum(axis=0) for throw in self.throws]
        )

    @property
    def passed_on(self) -> Array:
        """Torque in the main journal after each throw, towards the flywheel (k, m) [N m]."""
        return np.asarray(np.cumsum(self.per_throw, axis=0))

    @property
    def total(self) -> Array:
        """Torque of the engine (m,) [N m]."""
        return np.asarray(self.per_cylinder.sum(axis=0))

    @property
    def mean(self) -> Annotated[float, Quantity("N m")]:
        """Mean torque."""
        return float(np.mean(self.total))

    @property
    def power(self) -> Annotated[float, Quantity("W")]:
        """Indicated power, mean torque times speed."""
        return self.mean * self.speed

    @property
    def nonuniformity(self) -> Number | None:
        """Degree of nonuniformity, (largest - least) / size of the mean; None where that is round-off."""
        total, mean = self.total, self.mean
        if abs(mean) <= NO_MEAN * float(np.max(np.abs(self.per_cylinder))):
            return None
        return float(np.ptp(total)) / abs(mean)

    @property
    def energy_error(self) -> Number:
        """Mean torque times the cycle's angle minus indicated work, relative to the gas's exchange.

        The exchange is the work of the gas on all pistons, integrated as absolute value.
        """
        step = cycle_radians(self.engine.strokes) / self.shaft_angles_deg.size
        exchanged = float(np.sum(np.abs(self.gas))) * step
        difference = self.mean * cycle_radians(self.engine.strokes) - float(
            np.sum(self.indicated_work)
        )
        return difference / exchanged if exchanged > 0.0 else difference

    def harmonics(self, throw: int | None = None) -> Harmonics:
        """Return the harmonics of the engine's torque, or of one throw's, counted from 1."""
        torque = self.total if throw is None else self.per_throw[self._checked_throw(throw)]
        return harmonics(torque, self.engine.strokes, unit="N m")

    def cylinder_harmonics(self, number: int) -> Harmonics:
        """Return the harmonics of one cylinder's torque, phases counted from its own firing top."""
        place = checked_cylinder(self.engine, number) - 1
        return from_firing_top(
            self.engine, place, np.radians(self.shaft_angles_deg), self.per_cylinder[place], "N m"
        )

    def plot(self, axes: Axes | None = None, throw: int | None = None) -> Axes:
        """Draw the torque of the engine with its mean, or that of one throw by source, over the cycle."""
        colors: tuple[str, ...] = (BLUE, ORANGE)
        if throw is None:
            title = "Torque of the engine"
            mean = np.full(self.total.shape, self.mean)
            curves = {"engine": self.total, "mean": mean}
        else:
            title = f"Torque of throw {throw}"
            members = [number - 1 for number in self.throws[self._checked_throw(throw)]]
            parts = {"gas": self.gas, "inertia": self.inertia, "both": self.per_cylinder}
            curves = {name: values[members].sum(axis=0) for name, values in parts.items()}
            colors = (COLORS[1], COLORS[2], COLORS[0])
        shown = {name: KILO * values for name, values in curves.items()}
        axes = draw_over_angle(
            axes,
            np.radians(self.shaft_angles_deg),
            shown,
            "torque [kN m]",
            colors=colors,
        )
        write_title(axes, title)
        # Above the curves, which fill the axes.
        legend_above(axes)
        return axes

    def to_xarray(self) -> Dataset:
        """Return the torques over cylinder, throw and shaft angle."""
        by_cylinder, by_throw = ("cylinder", "shaft_angle"), ("throw", "shaft_angle")
        return grid(
            {
                "gas": (by_cylinder, self.gas, "N m", "torque of the gas"),
                "inertia": (by_cylinder, self.inertia, "N m", "torque of moving masses"),
                "per_throw": (by_throw, self.per_throw, "N m", "torque of the throw"),
                "passed_on": (by_throw, self.passed_on, "N m", "torque passed on behind the throw"),
                "total": (("shaft_angle",), self.total, "N m", "torque of the engine"),
            },
            {
                "cylinder": number_axis(len(self.gas), "cylinder"),
                "throw": number_axis(len(self.throws), "throw, from the free end"),
                "shaft_angle": angle_axis(self.shaft_angles_deg),
            },
        )

    def _checked_throw(self, throw: int) -> int:
        reason = "the shaft has that many throws"
        return whole_within("throw", throw, 1, len(self.throws), reason) - 1


def check_energy(torque: EngineTorque) -> None:
    """Refuse a torque whose work over a cycle differs from that of the gas."""
    if not abs(torque.energy_error) <= LARGEST_ENERGY_ERROR:
        raise SolveError(
            f"Work of the torque and work of the gas differ by a share of {abs(torque.energy_error):.1e} "
            f"(allowed {LARGEST_ENERGY_ERROR:.0e})."
        )


def engine_torque(
    engine: EngineLayout,
    speed: float,
    pressure: Pressure | Sequence[Pressure] | ArrayLike | None = None,
    *,
    samples: int = DEFAULT_SAMPLES,
    model: RodModelName = "rigid",
    throws: Sequence[int] | None = None,
    crankcase_pressure: float = ATMOSPHERE,
) -> EngineTorque:
    """Find the torque of every cylinder, every throw and the whole engine over a cycle.

    Parameters
    ----------
    pressure : GasPressure, sequence of n GasPressure, array_like or None
        Pressures as for `gas_forces`, or forces on the pistons towards the shaft at the
        samples (n, samples) [N]; None for no gas force.
    samples : int, optional
        Number of samples over one cycle; they resolve orders up to half their number per revolution.
    throws : sequence of n int, optional
        Throw of each cylinder, 0 next to the free end. Without it, cylinders of different banks
        with equal crank angles and nearly equal positions share one.
    crankcase_pressure : float, optional
        Absolute pressure under the pistons [Pa].

    Raises
    ------
    InputError
        If samples are too few, forces do not fit, or throws do not.

    Examples
    --------
    >>> from dynamics.engine.layout import EngineCylinder
    >>> from dynamics.engine.rods import ConnectingRod
    >>> rod = ConnectingRod(length=0.2, mass=1.0, center_distance=0.07, inertia=0.006)
    >>> engine = EngineLayout(0.05, [EngineCylinder(0.1, 1.0, rod)], [1])
    >>> motored = engine_torque(engine, 100.0)
    >>> motored.harmonics().orders[:4].tolist(), motored.nonuniformity
    ([0.5, 1.0, 1.5, 2.0], None)
    """
    angles, gas = samples_and_gas(engine, pressure, samples, crankcase_pressure)
    from_gas, from_masses = forces_by_cause(engine, speed, angles, gas, model)
    works = []
    for number, force in enumerate(gas, start=1):
        # A force towards the shaft on the piston's way there is a pressure on a growing volume.
        inwards = -parts_motion(engine, number, angles).piston.first.real
        works.append(indicated_work(force, inwards, engine.strokes))
    groups = throws_along_shaft(engine) if throws is None else checked_throws(engine, throws)
    return EngineTorque(
        engine=engine,
        speed=float(speed),
        shaft_angles_deg=read_only(np.degrees(angles)),
        gas=read_only(from_gas.torque),
        inertia=read_only(from_masses.torque),
        throws=groups,
        indicated_work=read_only(np.array(works)),
    )


Kind = Literal["major", "minor", "balanced"]
# Two directions are one within this angle [rad].
SAME_DIRECTION = 1e-6


@result("order", "kind", "share", "resultant")
class Star(Result):
    """The harmonics of one order of all cylinders as vectors.

    A cylinder that fires at f and whose harmonic is M sin(k (x - f) + a) has the direction k f - a:
    it is the phase at which its harmonic rises through zero, in terms of k x. The sum over the cylinders is
    resultant sin(k x - its direction).

    Parameters
    ----------
    order : float
        k, in cycles per crankshaft revolution.
    directions_deg : ndarray of shape (n,)
        Of the cylinders' vectors [deg], from 0 to below 360.
    weights : ndarray of shape (n,)
        Their lengths; negative where the mode shape reverses a vector.
    """

    order: Number
    directions_deg: Annotated[Array, Quantity("deg")]
    weights: Internal[Array]

    @property
    def vectors(self) -> "np.ndarray[tuple[int], np.dtype[np.complex128]]":
        """The cylinders' vectors (n,)."""
        return np.asarray(self.weights * np.exp(1j * np.radians(self.directions_deg)))

    @property
    def resultant(self) -> Number:
        """Length of their sum."""
        return float(abs(self.vectors.sum()))

    @property
    def resultant_direction_deg(self) -> float:
        """Direction of their sum [deg], from 0 to below 360; 0 for a balanced order."""
        if self.kind == "balanced":
            return 0.0
        return math.degrees(_turned(cmath.phase(complex(self.vectors.sum()))))

    @property
    def largest(self) -> float:
        """The resultant if all vectors had one direction."""
        return float(np.sum(np.abs(self.weights)))

    @property
    def share(self) -> Number:
        """Resultant as a share of the largest possible, 0 to 1."""
        return self.resultant / self.largest if self.largest > 0.0 else 0.0

    @property
    def kind(self) -> Part[Kind]:
        """Return "major" with all vectors in one direction, "balanced" with no resultant, else "minor"."""
        if self.share >= 1.0 - FULL_SUM_TOLERANCE:
            return "major"
        return "balanced" if self.share <= FULL_SUM_TOLERANCE else "minor"

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the star: firing at shaft angle zero points up, angles turn clockwise."""
        axes = new_axes(axes, width=3.2, height=3.6)
        draw_star(axes, self, f"order {self.order:g}")
        finish_stars(axes)
        write_title(axes, f"Star of order {self.order:g}")
        return axes

    def to_pandas(self) -> DataFrame:
        """Return one row for each cylinder: direction and length of its vector."""
        return table(
            {
                "cylinder": (np.arange(1, len(self.weights) + 1), "1"),
                "direction": (self.directions_deg, "deg"),
                "weight": (self.weights, "1"),
            }
        )


def star_diagram(
    engine: EngineLayout | None = None,
    orders: ArrayLike | float = 12.0,
    *,
    firing_angles_deg: ArrayLike | None = None,
    strokes: int | None = None,
    amplitudes: ArrayLike | None = None,
    phases_deg: ArrayLike | None = None,
    mode_shape: ArrayLike | None = None,
) -> tuple[Star, ...]:
    """Return the star of each order.

    Parameters
    ----------
    orders : array_like of shape (K,) or number, optional
        Orders, or the highest of all orders of the cycle.
    firing_angles_deg : array_like of shape (n,), optional
        Shaft angle at which each cylinder fires [deg], if no engine is given.
    amplitudes : array_like of shape (n,) or (K, n), optional
        Of the cylinders' harmonics, where they differ; 1 by default.
    phases_deg : array_like of shape (n,) or (K, n), optional
        a of M sin(k (x - f) + a), where they differ [deg].
    mode_shape : array_like of shape (n,), optional
        Displacement of the mode at each cylinder's throw, by which its vector is multiplied.

    Raises
    ------
    InputError
        If an array does not fit, the strokes are not 2 or 4 or not the engine's, or an order is not
        above zero or, if the strokes are known, not one of the cycle's.

    Examples
    --------
    >>> stars = star_diagram(firing_angles_deg=[0.0, 540.0, 180.0, 360.0], orders=4.0)
    >>> [(star.order, star.kind) for star in stars if star.kind != "balanced"]
    [(2.0, 'major'), (4.0, 'major')]
    """
    firing, known = _firing_and_strokes(engine, firing_angles_deg, strokes)
    if np.ndim(orders) == 0:
        highest = float(finite_array("orders", orders))
        asked = np.asarray(engine_orders(4 if known is None else known, highest))
    else:
        asked = positive_vector("orders", orders, "", "they count cycles per revolution")
        if known is not None:
            order_numbers(asked, known)
    shape = (asked.size, firing.size)
    reason = "each order's vector of each cylinder takes its own"
    lengths = spread_array("amplitudes", 1.0 if amplitudes is None else amplitudes, shape, reason)
    moved = spread_array("mode_shape", 1.0 if mode_shape is None else mode_shape, shape, reason)
    turns = spread_array("phases_deg", 0.0 if phases_deg is None else phases_deg, shape, reason)
    lengths = lengths * moved
    directions = np.outer(asked, firing) - np.radians(turns)
    return tuple(
        Star(
            order,
            read_only(np.degrees([_turned(angle) for angle in row.tolist()])),
            read_only(row_lengths.copy()),
        )
        for order, row, row_lengths in zip(asked.tolist(), directions, lengths, strict=True)
    )


def _firing_and_strokes(
    engine: EngineLayout | None, firing_angles_deg: ArrayLike | None, strokes: int | None
) -> tuple[Array, int | None]:
    """Return the firing angles [rad], and the strokes if known."""
    checked = None if strokes is None else checked_strokes(strokes)
    if engine is None and firing_angles_deg is not None:
        firing = np.radians(finite_vector("firing_angles_deg", firing_angles_deg))
    elif isinstance(engine, EngineLayout) and firing_angles_deg is None:
        if checked not in (None, engine.strokes):
            raise InputError(
                f"strokes: given {checked}; allowed is {engine.strokes} or nothing, because that is the "
                "engine's."
            )
        return np.radians(engine.firing_deg), engine.strokes
    else:
        raise InputError(
            f"engine: given {type(engine).__name__} with firing_angles_deg "
            f"{'left out' if firing_angles_deg is None else 'given'}; allowed is either an EngineLayout or "
            "firing_angles_deg, because each defines where the cylinders fire."
        )
    check_some("firing_angles_deg", firing, "the star has a vector of each")
    return firing, checked


def leading_stars(stars: Sequence[Star]) -> tuple[Star, ...]:
    """Return the major orders, or if there is none, as with uneven firing, the largest ones."""
    check_some("stars", stars, "one is to lead")
    majors = tuple(star for star in stars if star.kind == "major")
    strongest = max(star.share for star in stars)
    return majors or tuple(
        star
        for star in stars
        if star.share >= strongest - FULL_SUM_TOLERANCE and strongest > FULL_SUM_TOLERANCE
    )


def same_stars(stars: Iterable[Star]) -> tuple[tuple[Star, ...], ...]:
    """Return the stars in groups of equal shape, mirror images included.

    Two are equal if the lengths are equal and the directions, counted from the first cylinder's,
    are equal or opposite.
    """

    def alike(group: list[Star], reference: Star) -> bool:
        star = group[0]
        if star.weights.shape != reference.weights.shape or not np.allclose(
            star.weights, reference.weights, rtol=1e-9, atol=0.0
        ):
            return False
        first, second = (
            np.radians(each.directions_deg - each.directions_deg[0]) for each in (star, reference)
        )
        return _equal_directions(first, second) or _equal_directions(first, -second)

    groups = grouped(stars, alike)
    return tuple(tuple(group) for group in groups)


def _equal_directions(first: Array, second: Array) -> bool:
    return bool(np.max(np.abs(np.exp(1j * first) - np.exp(1j * second))) <= SAME_DIRECTION)


def _turned(angle: float) -> float:
    """Return an angle between 0 and 2 pi, with zero for what differs from it by round-off."""
    turn = 2.0 * math.pi
    folded = angle % turn
    return 0.0 if min(folded, turn - folded) < 1e-12 * max(1.0, abs(angle)) else folded
