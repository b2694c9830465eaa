"""The speed that results with an elastic hinge: steady turns, flywheels, and the best pressure."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from crankbase.array_checks import (
    Array,
    nonnegative_number,
    positive_number,
    read_only,
)
from crankbase.diagrams import new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, table
from crankbase.quantity import RPM
from crankbase.results import Internal, Number, Quantity, Result, Speed, result
from crankbase.sentences import amount, in_si
from crankfem.satellites.hinge.crosshead import (
    TURN,
    ReducedCrank,
    periodic_spline,
)
from crankfem.satellites.hinge.moment import HingeMoment
from crankfem.satellites.hinge.profile import HingeProfile
from dynamics.cycle import even_angles
from dynamics.plots.curves import FROM_TOP, draw_over_angle
from dynamics.turning.speed_over_angle import (
    SpeedOverAngle,
    energy_for_mean_speed,
    mean_speed,
    slowest_mean_speed,
    speed_over_angle,
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

    angles_deg: Internal[Array]
    speed: Internal[Array]
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

    angles: Array
    inertia: Array
    gained: Array
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
                f"top_speed: given {in_si(top_speed, 'rad/s')} beside a mean speed of "
                f"{in_si(speed, 'rad/s')}; allowed is one of the two, because either follows from the other."
            )
        top_speed = positive_number("top_speed", top_speed, "rad/s", "the crank turns forward")
        inertia = energy.inertia + flywheel
        at_top = 0.5 * float(inertia[0]) * top_speed**2
        lacking = -float(energy.gained.min())
        if not at_top > lacking:
            needed = math.sqrt(2.0 * lacking / float(inertia[0]))
            raise InputError(
                f"top_speed: given {in_si(top_speed, 'rad/s', 4)}; allowed is more than "
                f"{in_si(needed, 'rad/s', 4)}, because over a turn the crank loses "
                f"{amount(lacking, 'J', 4, shown='kJ')} and must complete a revolution."
            )
        return _turn(energy, inertia, at_top, flywheel)
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
) -> tuple[Array, ReducedCrank, Array]:
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


def integrated(angles: Array, inertia: Array, moment: Array) -> TurnEnergy:
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
            f"speed: given a mean of {amount(speed, 'rad/s', 4)}; allowed is "
            f"{amount(slowest, 'rad/s', 4)} or more with a flywheel of {amount(flywheel, 'kg m^2', 4)}, "
            "because a slower crank does not complete a revolution: over a turn its energy swings by "
            f"{amount(np.ptp(energy.gained), 'J', 4, shown='kJ')}."
        )
    return _turn(energy, inertia, at_top, flywheel)


def _turn(energy: TurnEnergy, inertia: Array, at_top: float, flywheel: float) -> SteadyHingeTurn:
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
                f"{amount(LARGEST_FLYWHEEL, 'kg m^2')} reaches, because larger ones are not built."
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
            f"revolutions at {in_si(point.speed, 'rad/s')}, because there is nothing to compare otherwise."
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
