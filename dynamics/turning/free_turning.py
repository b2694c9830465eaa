"""A free-running engine: its crank angle over time under gas, load, friction and weight."""

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    LARGEST,
    Array,
    ComplexArray,
    finite_array,
    finite_vector,
    nonnegative_number,
    read_only,
)
from crankbase.choices import check_choice, whole_number
from crankbase.diagrams import new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, table
from crankbase.quantity import RPM
from crankbase.summaries import frozen
from dynamics.cycle import cycle_radians, even_angles
from dynamics.engine import RodModelName
from dynamics.engine.forces import (
    Pressure,
    parts_motion,
    piston_ends,
    pressure_of_each,
    reduced_inertia,
    rod_models,
    turn_spectrum,
)
from dynamics.engine.layout import EngineLayout
from dynamics.engine.rods import RodModel
from dynamics.gas.pressure import ATMOSPHERE
from dynamics.plots.curves import KILO, draw_over_time
from dynamics.turning.speed_over_angle import (
    MOST_MOMENTS,
    MOST_TURNS,
    SteadyTurning,
    checked_inertia,
    checked_moment,
    run_time,
    steady_turning,
    too_many_turns,
    work_counter,
)

# Samples that show how large a curve is, and the share of that which counts as nothing.
SIZE_SAMPLES = 64
NEGLIGIBLE = 1e-17


@dataclass(frozen=True, eq=False)
class TurnCurves:
    """Several periodic curves as Fourier series, with derivatives.

    Parameters
    ----------
    coefficients : complex ndarray of shape (c, K)
        a_k of Re sum a_k exp(i k phi), k from 1.
    """

    mean: Array
    coefficients: ComplexArray

    def at(self, angle: float) -> tuple[Array, Array]:
        """Return values and derivatives by the angle [rad] of all curves, each of shape (c,)."""
        numbers = np.arange(1, self.coefficients.shape[1] + 1)
        terms = np.exp(1j * angle * numbers)
        values = self.mean + (self.coefficients @ terms).real
        return values, -(self.coefficients @ (numbers * terms)).imag


def turn_curves(function: Callable[[Array], Array]) -> TurnCurves:
    """Return the series of curves over a revolution.

    Parameters
    ----------
    function : callable
        Takes angles (m,) [rad] and returns the curves' values (c, m).
    """
    largest = np.max(
        np.abs(function(even_angles(2.0 * np.pi, SIZE_SAMPLES))), axis=1, keepdims=True
    )
    # Each curve by its own size: inertias and lengths are not to be compared.
    scale = np.where(largest > 0.0, largest, 1.0)
    spectrum = scale * turn_spectrum(lambda angles: function(angles) / scale, 1)
    half = spectrum.shape[1] // 2
    terms = 2.0 * spectrum[:, 1:half]
    above = np.flatnonzero(np.max(np.abs(terms) / scale, axis=0) > NEGLIGIBLE)
    needed = int(above[-1]) + 1 if above.size else 0
    return TurnCurves(spectrum[:, 0].real.copy(), terms[:, :needed].copy())


def engine_curves(engine: EngineLayout, models: tuple[RodModel, ...]) -> TurnCurves:
    """Return the curves of an engine: positions of the n pistons, inertia, static moment upwards.

    Returns
    -------
    TurnCurves
        c = n + 2: s of each piston pin [m]; inertia reduced to the shaft [kg m^2]; sum of masses
        times heights [kg m], which determines the work of gravity.
    """

    def samples(angles: Array) -> Array:
        places = []
        height = np.zeros(angles.shape)
        pairs = zip(engine.cylinders, models, strict=True)
        for number, (cylinder, model) in enumerate(pairs, start=1):
            motion = parts_motion(engine, number, angles)
            upwards = np.exp(1j * math.radians(cylinder.bank_angle_deg))
            places.append(motion.piston.place.real)
            height += cylinder.piston_mass * (upwards * motion.piston.place).real
            height += model.mass * (upwards * motion.rod_point(model.center).place).real
        for mass in engine.rotating:
            height += mass.static_moment * np.cos(math.radians(mass.angle_deg) + angles)
        inertia, _ = reduced_inertia(engine, models, shaft_angles_deg=np.degrees(angles))
        return np.array([*places, inertia, height])

    return turn_curves(samples)


# Force on a piston towards the shaft [N]: of the cylinder's number, the piston's place (0 lowest to
# 1 highest), its direction (1 away from the shaft, -1 towards it), and the angle from the
# cylinder's firing top [rad].
PistonForce = Callable[[int, float, Literal[-1, 1], float], float]
Gas = Pressure | Sequence[Pressure] | PistonForce | None


@dataclass(frozen=True, eq=False)
class PistonGas:
    """The gas in all cylinders.

    Parameters
    ----------
    forces : callable
        (shaft angle [rad], pistons' s (n,) [m], directions (n,)) -> forces towards the shaft (n,)
        [N].
    """

    forces: Callable[[float, Array, Array], Array]
    turns_at_ends: bool


def piston_gas(engine: EngineLayout, gas: Gas, crankcase_pressure: float) -> PistonGas:
    """Return the gas forces from pressures, or from a function of the piston's position and direction."""
    if gas is None:
        return PistonGas(lambda _angle, places, _directions: np.zeros(places.shape), False)
    firing = np.radians(engine.firing_deg)
    if callable(gas):
        force, cycle = gas, cycle_radians(engine.strokes)
        count = len(engine.cylinders)
        lowest, highest = np.array([piston_ends(engine, number + 1) for number in range(count)]).T

        def by_places(angle: float, places: Array, directions: Array) -> Array:
            positions = np.clip((places - lowest) / (highest - lowest), 0.0, 1.0).tolist()
            since_firing = ((angle - firing) % cycle).tolist()
            return np.array(
                [
                    force(place + 1, positions[place], 1 if way > 0.0 else -1, since_firing[place])
                    for place, way in enumerate(directions.tolist())
                ],
                dtype=np.float64,
            )

        return PistonGas(by_places, True)
    under = nonnegative_number("crankcase_pressure", crankcase_pressure, "Pa", "it is absolute")
    areas = np.array([cylinder.area for cylinder in engine.cylinders])
    # Cylinders with the same pressure are asked for together.
    groups: dict[int, tuple[Pressure, list[int]]] = {}
    for place, diagram in enumerate(pressure_of_each("pressure", gas, engine)):
        groups.setdefault(id(diagram), (diagram, []))[1].append(place)

    def by_pressures(angle: float, _places: Array, _directions: Array) -> Array:
        absolute = np.empty(areas.size)
        for pressure, members in groups.values():
            absolute[members] = pressure.at(angle_deg=np.degrees(angle - firing[members]))
        return np.asarray(areas * (absolute - under))

    return PistonGas(by_pressures, False)


# Moment that brakes [N m], of speed [rad/s] and shaft angle [rad].
Resistance = Callable[[float, float], float]

# Angles at which a piston's change of direction is looked for over a turn.
SEARCH_ANGLES = 720
# Ends of stroke closer than this are one [rad].
SAME_ANGLE = 1e-9
# An inertia below this share of its mean is none: what is left at a dead center of massless parts.
LEAST_INERTIA = 1e-9


@dataclass(frozen=True, eq=False)
class ShaftMoments:
    """The moments on the shaft.

    Parameters
    ----------
    load, friction : callable
        (speed [rad/s], angle [rad]) -> braking moment [N m].
    gravity : float
        Along -y [m/s^2].
    """

    curves: TurnCurves
    gas: PistonGas
    load: Resistance
    friction: Resistance
    gravity: float

    def at(
        self, angle: float, speed: float, directions: Array | None = None
    ) -> tuple[tuple[float, ...], float, float]:
        """Return the moments of gas, load, friction and gravity; inertia and its derivative.

        Parameters
        ----------
        directions : ndarray of shape (n,), optional
            Of the pistons, positive away from the shaft, if known better than from the
            angle: at the end of a stroke.
        """
        values, slopes = self.curves.at(angle)
        ways = slopes[:-2] if directions is None else directions
        forces = self.gas.forces(angle, values[:-2], ways).tolist()
        # Number by number: arrays would warn of what is not finite before it can be told clearly.
        gas = sum(force * slope for force, slope in zip(forces, slopes[:-2].tolist(), strict=True))
        # An integration tries a speed below zero where the shaft stops; resistances may have no
        # value there, and what they were does not matter.
        forward = max(speed, 0.0)
        moments = (
            -checked_moment("gas", gas, speed, angle, LARGEST),
            -checked_moment("load", self.load(forward, angle), speed, angle, LARGEST),
            -checked_moment("friction", self.friction(forward, angle), speed, angle, LARGEST),
            -self.gravity * float(slopes[-1]),
        )
        return moments, self._checked_inertia(values, angle), float(slopes[-2])

    def inertia(self, angle: float) -> float:
        """Return the reduced inertia [kg m^2]."""
        return self._checked_inertia(self.curves.at(angle)[0], angle)

    def _checked_inertia(self, values: Array, angle: float) -> float:
        return checked_inertia(values[-2], angle, LEAST_INERTIA * float(self.curves.mean[-2]))

    def directions(self, angle: float) -> Array:
        """Return the pistons' directions (n,) at an angle, positive away from the shaft."""
        return np.sign(self.curves.at(angle)[1][:-2])

    def stroke_ends(self) -> Array:
        """Return the shaft angles of one revolution at which a piston changes its direction (k,)."""
        from scipy.optimize import brentq

        # Not at round angles, where strokes end.
        grid = np.linspace(0.0, 2.0 * math.pi, SEARCH_ANGLES + 1) - 0.001
        ways = np.array([self.directions(angle) for angle in grid.tolist()])
        ends = []
        for place, cylinder in np.argwhere(ways[1:] != ways[:-1]).tolist():
            slope = functools.partial(self._slope, cylinder)
            reversal = brentq(slope, grid[place], grid[place + 1], xtol=1e-15)
            ends.append(float(reversal) % (2.0 * math.pi))
        ordered = np.sort(ends)
        return ordered[np.diff(ordered, prepend=-1.0) > SAME_ANGLE]

    def _slope(self, cylinder: int, angle: float) -> float:
        return float(self.curves.at(angle)[1][cylinder])


class Acting(TypedDict, total=False):
    """What acts on an engine's shaft besides its load; see `turn_freely`."""

    gas: Gas
    friction: Resistance | float
    gravity: float
    model: RodModelName
    crankcase_pressure: float


def shaft_moments(
    engine: EngineLayout,
    gas: Gas = None,
    load: Resistance | float = 0.0,
    friction: Resistance | float = 0.0,
    gravity: float = 0.0,
    model: RodModelName = "rigid",
    crankcase_pressure: float = ATMOSPHERE,
) -> ShaftMoments:
    """Collect the moments on an engine's shaft; arguments as for `turn_freely`."""
    return ShaftMoments(
        curves=engine_curves(engine, rod_models(engine, model)),
        gas=piston_gas(engine, gas, crankcase_pressure),
        load=_resistance("load", load),
        friction=_resistance("friction", friction),
        gravity=float(finite_array("gravity", gravity)),
    )


def _resistance(field: str, resistance: Resistance | float) -> Resistance:
    if callable(resistance):
        return resistance
    constant = float(finite_array(field, resistance))

    def always(_speed: float, _angle: float) -> float:
        return constant

    return always


# Of the integration, relative; absolute ones are this share of a radian, start speed and energy.
TOLERANCE = 1e-11
SHARES = ("gas", "load", "friction", "gravity")
# Times the most turns that can be followed: what is refused before it is tried.
UNSTOPPED = 5.0
# A stroke's end closer ahead than this is behind [rad].
PASSED = 1e-9


@dataclass(frozen=True, eq=False)
class WorkShare:
    """Moment and work of one cause on the shaft.

    Parameters
    ----------
    moment : ndarray of shape (m,)
        Reduced to the shaft, positive when it drives [N m].
    work : ndarray of shape (m,)
        Since the start, positive for driving work [J].
    """

    moment: Array
    work: Array


@frozen(
    "time [s]", "angle_deg [deg]", "speed [rad/s]", "energy_error", "stopped", "remark", eq=False
)
class FreeTurning:
    """Free rotation of an engine over time.

    Parameters
    ----------
    angle_deg : ndarray of shape (m,)
        Of the shaft [deg].
    acceleration : ndarray of shape (m,)
        [rad/s^2]
    kinetic_energy : ndarray of shape (m,)
        Of shaft, rods and pistons [J].
    gas, load, friction, gravity : WorkShare
        Moments and work of each; load and friction are negative when they brake.
    remark : str
        Empty, or a sentence with the angle and time at which the engine stopped; the arrays end there.
    """

    time: Array
    angle_deg: Array
    speed: Array
    acceleration: Array
    kinetic_energy: Array
    gas: WorkShare
    load: WorkShare
    friction: WorkShare
    gravity: WorkShare
    remark: str = ""

    @property
    def stopped(self) -> bool:
        """Whether the engine stopped within the requested time."""
        return bool(self.remark)

    @property
    def energy_error(self) -> float:
        """Largest difference of energy gained and work done, relative to the largest of them."""
        works = np.array([getattr(self, name).work for name in SHARES])
        gained = self.kinetic_energy - self.kinetic_energy[0]
        done = works - works[:, :1]
        largest = float(max(np.max(self.kinetic_energy), np.max(np.abs(done))))
        worst = float(np.max(np.abs(gained - done.sum(axis=0))))
        return worst / largest if largest > 0.0 else 0.0

    def plot(
        self, axes: Axes | None = None, *, show: Literal["speed", "moment", "work"] = "speed"
    ) -> Axes:
        """Draw the speed over the time, or the moments or works of all causes."""
        check_choice("show", show, ("speed", "moment", "work"), "these are known over the time")
        axes = new_axes(axes)
        if show == "speed":
            draw_over_time(axes, self.time, {"speed": RPM * self.speed}, "speed [1/min]")
            write_title(axes, "Speed of the engine left to itself")
            return axes
        curves = {name: KILO * getattr(getattr(self, name), show) for name in SHARES}
        label = "moment [kN m]" if show == "moment" else "work since the start [kJ]"
        draw_over_time(axes, self.time, curves, label)
        write_title(axes, "What drives and brakes the shaft")
        return axes

    def to_pandas(self) -> DataFrame:
        """Return a row for each time: angle, speed, energy, moments and works."""
        columns = {
            "time": (self.time, "s"),
            "angle": (self.angle_deg, "deg"),
            "speed": (self.speed, "rad/s"),
            "acceleration": (self.acceleration, "rad/s^2"),
            "kinetic_energy": (self.kinetic_energy, "J"),
        }
        for name in SHARES:
            share: WorkShare = getattr(self, name)
            columns[f"{name}_moment"] = (share.moment, "N m")
            columns[f"{name}_work"] = (share.work, "J")
        return table(columns)


def turn_freely(
    engine: EngineLayout,
    *,
    start_angle_deg: float,
    start_speed: float,
    duration: float,
    load: Resistance | float = 0.0,
    times: ArrayLike | None = None,
    samples: int = 1001,
    **acting: Unpack[Acting],
) -> FreeTurning:
    """Integrate the crank angle of an engine from a given start.

    Parameters
    ----------
    engine : EngineLayout
        Its shaft_inertia includes the flywheel and the driven parts.
    start_speed : float
        Zero or above [rad/s].
    duration : float
        At most a day [s], 20,000 turns, and 500,000 evaluations of the moments.
    load : float or callable, optional
        Braking moment on the shaft [N m], or a callable (speed [rad/s], angle [rad]) -> moment.
    times : array_like of shape (m,), optional
        Output times [s], from zero or later to the duration, ascending.
    samples : int, optional
        Without `times`: number of evenly spaced times, both ends included.
    gas : GasPressure, sequence of n GasPressure, or callable, optional
        Pressures as for `gas_forces`, or a callable (number, position, direction, angle) ->
        force on that cylinder's piston towards the shaft [N]: number from 1, position from 0 at the
        piston's lowest position to 1 at its highest, direction 1 when it moves away from the shaft and
        -1 when it moves towards it, angle from the cylinder's firing top [rad], from zero to one
        cycle. It need not be continuous. None: no gas force.
    friction : float or callable, optional
        As `load`.
    gravity : float, optional
        Acceleration of gravity along -y [m/s^2].
    model : str, optional
        Of the rods, one of `ROD_MODELS`.
    crankcase_pressure : float, optional
        Absolute pressure under the pistons [Pa]; for pressures only.

    Returns
    -------
    FreeTurning
        If the engine stops before the time is over, the result ends there and the remark states it.

    Raises
    ------
    InputError
        If a number is out of its range, times do not ascend, pressures do not fit the engine, gas,
        load or friction are not finite moments, or the inertia vanishes at a dead center.

    Notes
    -----
    I phi'' + I' phi'^2 / 2 = Q, with I(phi) from `reduced_inertia`, and Q the sum of the forces
    times the derivatives of the pistons' positions by the angle, minus load and friction. Positions and
    inertia are Fourier series over a revolution, exact to round-off. The works are integrated
    independently of the speed, so `energy_error` compares two results.
    Runge-Kutta of order 8 (scipy's DOP853), stroke by stroke where the gas forces depend on the
    direction. Pressures from tables bend at every sample, which limits the accuracy of the speed to
    about 1e-6. The energies do not show that, for they are integrated in the same steps.

    Examples
    --------
    >>> from dynamics.engine.layout import EngineCylinder
    >>> from dynamics.engine.rods import ConnectingRod
    >>> rod = ConnectingRod(length=0.2, mass=1.0, center_distance=0.07, inertia=0.006)
    >>> cylinder = EngineCylinder(bore=0.1, piston_mass=1.0, rod=rod)
    >>> engine = EngineLayout(0.05, [cylinder], [1], shaft_inertia=0.5)
    >>> coasting = turn_freely(
    ...     engine, start_angle_deg=0.0, start_speed=100.0, duration=1.0, friction=5.0
    ... )
    >>> round(float(coasting.speed[-1]), 1), coasting.energy_error < 1e-9
    (89.9, True)
    """
    first = math.radians(float(finite_array("start_angle_deg", start_angle_deg)))
    speed = nonnegative_number("start_speed", start_speed, "rad/s", "the engine turns forward")
    end = run_time(duration)
    # It may stop long before; but no friction stops it from there.
    if speed * end > 2.0 * math.pi * UNSTOPPED * MOST_TURNS:
        raise too_many_turns(end, speed * end / (2.0 * math.pi))
    moments = shaft_moments(engine, load=load, **acting)
    if times is None:
        count = whole_number("samples", samples, 2, "start and end are included")
        shown = np.linspace(0.0, end, count)
    else:
        shown = finite_vector("times", times)
        if shown.size == 0 or shown[0] < 0.0 or shown[-1] > end or np.any(np.diff(shown) <= 0.0):
            raise InputError(
                f"times: given {shown.size} of them; allowed are times that ascend from 0 s or later to "
                f"the duration of {end:g} s or less, because the motion is known there."
            )
    states, stop_time = _integrated(moments, (first, speed), end, shown)
    angle, speeds, *works = states
    time, remark = shown, ""
    if stop_time is not None:
        time = np.append(shown[: angle.size - 1], stop_time)
        place = f"at a shaft angle of {math.degrees(angle[-1]):.6g} deg"
        remark = (
            f"The engine stops after {stop_time:.6g} s {place}, because what brakes it outweighs what "
            "drives it."
        )
        if stop_time == 0.0:
            remark = f"The engine does not start {place}, because nothing drives it enough."
    at_times = [moments.at(*both) for both in zip(angle.tolist(), speeds.tolist(), strict=True)]
    shares = np.array([each for each, _, _ in at_times]).T
    inertia, inertia_slope = np.array([rest for _, *rest in at_times]).T
    accounts = [WorkShare(read_only(m), read_only(w)) for m, w in zip(shares, works, strict=True)]
    acceleration = (shares.sum(axis=0) - 0.5 * inertia_slope * speeds**2) / inertia
    return FreeTurning(
        time=read_only(time),
        angle_deg=read_only(np.degrees(angle)),
        speed=read_only(speeds),
        acceleration=read_only(acceleration),
        kinetic_energy=read_only(0.5 * inertia * speeds**2),
        **dict(zip(SHARES, accounts, strict=True)),
        remark=remark,
    )


def _integrated(
    moments: ShaftMoments, start: tuple[float, float], end: float, shown: Array
) -> tuple[Array, float | None]:
    """Return angle, speed and works at the output times (6, m), and when the engine stopped."""
    # If gas forces jump at the ends of strokes, each stroke is integrated separately with the
    # pistons' directions held: no step passes over a jump, and none is hidden from the error control.
    time, state = 0.0, np.array([*start, *[0.0] * len(SHARES)])
    speed = max(start[1], 1.0)
    energy = 0.5 * moments.inertia(start[0]) * speed**2
    strokes = _Strokes(
        moments,
        end,
        start[0] + 2.0 * math.pi * MOST_TURNS,
        np.array([1.0, speed, *[energy] * len(SHARES)]),
        work_counter("duration", end, "s", MOST_MOMENTS),
    )
    ends = moments.stroke_ends() if moments.gas.turns_at_ends else np.zeros(0)
    kept = [state[:, np.newaxis][:, : int(shown[0] == 0.0)]]
    while True:
        angle, turn, limit = float(state[0]), 2.0 * math.pi, math.inf
        if ends.size:
            ahead = (ends - angle) % turn
            ahead = np.where(ahead < PASSED, ahead + turn, ahead)
            limit = angle + float(np.min(np.where(ahead > turn - PASSED, turn, ahead)))
        ways = moments.directions(0.5 * (angle + min(limit, angle + turn)))
        stroke = strokes.from_state(time, state, limit, ways)
        reached = float(stroke.t[-1])
        asked = shown[(shown > time) & (shown <= reached)]  # the next stroke begins after its end
        if asked.size:
            kept.append(stroke.sol(asked))
        if stroke.t_events[0].size:
            stopped = np.array(stroke.y_events[0][0])
            # Where it stops is told even if nobody asked for that time, and only once.
            if reached in shown:
                kept[-1] = kept[-1][:, :-1]
            return np.column_stack([*kept, stopped]), reached
        if reached >= end:
            return np.column_stack(kept), None
        time, state = reached, np.array(stroke.y_events[1][0])
        state[0] = limit


@dataclass(frozen=True)
class _Strokes:
    """Integrates angle, speed and the four works stroke by stroke.

    Attributes
    ----------
    end : float
        Time at which the engine is followed no longer [s].
    last_angle : float
        Beyond it there are too many turns [rad].
    scales : (6,) array
        Sizes of the unknowns, of which their errors are a share.
    evaluated : callable
        Told of each time at which the moments are evaluated.
    """

    moments: ShaftMoments
    end: float
    last_angle: float
    scales: Array
    evaluated: Callable[[float], None]

    def from_state(self, time: float, state: Array, limit: float, directions: Array) -> Any:
        """Integrate from a time until the end, or until an angle is reached."""
        from scipy.integrate import solve_ivp

        def slope(now: float, state: Array) -> list[float]:
            self.evaluated(now)
            angle, speed = float(state[0]), float(state[1])
            if not angle <= self.last_angle:
                raise too_many_turns(self.end, MOST_TURNS)
            shares, inertia, inertia_slope = self.moments.at(angle, speed, directions)
            acceleration = (math.fsum(shares) - 0.5 * inertia_slope * speed**2) / inertia
            return [speed, acceleration, *(share * speed for share in shares)]

        def stops(_: float, state: Array) -> float:
            return float(state[1])

        def reaches_end(_: float, state: Array) -> float:
            return float(state[0]) - limit if math.isfinite(limit) else -1.0

        events: list[Any] = [stops, reaches_end]
        for event, direction in zip(events, (-1.0, 1.0), strict=True):
            event.terminal, event.direction = True, direction
        motion = solve_ivp(
            slope,
            (time, self.end),
            state,
            method="DOP853",
            dense_output=True,
            events=events,
            rtol=TOLERANCE,
            atol=TOLERANCE * self.scales,
        )
        if motion.status < 0:
            reached, reason = float(motion.t[-1]), str(motion.message).rstrip(".")
            raise InputError(
                f"duration: given {self.end:g} s; allowed is {reached:.6g} s or less, because the angle "
                f"cannot be followed any longer ({reason})."
            )
        return motion


def turn_steadily(
    engine: EngineLayout,
    mean_speed: float,
    *,
    samples: int = 720,
    **acting: Unpack[Acting],
) -> SteadyTurning:
    """Find the constant load under which an engine turns steadily, and its speed over a cycle.

    Parameters
    ----------
    mean_speed : float
        Angle of one cycle divided by its time [rad/s].
    engine, **acting
        As for `turn_freely`.

    Returns
    -------
    SteadyTurning
        With the load [N m] and the rotation over one cycle, whose `fluctuation` is the coefficient
        of speed fluctuation, (highest - lowest speed) / mean speed.

    Raises
    ------
    InputError
        As `turn_freely`, and if the engine would stop within the cycle.
    """
    moments = shaft_moments(engine, **acting)
    return steady_turning(
        moments.inertia,
        lambda speed, angle: math.fsum(moments.at(angle, speed)[0]),
        mean_speed,
        cycle_radians(engine.strokes) / (2.0 * math.pi),
        samples=samples,
    )
