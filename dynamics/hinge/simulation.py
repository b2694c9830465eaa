"""Rotation of a crank with a hinge, without it, and with a flywheel."""

import math
from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import FloatArray, nonnegative_number, positive_number, read_only
from crankbase.errors import InputError
from crankbase.library_types import Axes, DataFrame
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from crankbase.units.quantity import format_quantity
from crankbase.units.units import RPM
from dynamics.cycle import even_angles
from dynamics.hinge.moment import HingeMoment
from dynamics.hinge.periodic import TURN, periodic_spline
from dynamics.hinge.profile import HingeProfile
from dynamics.hinge.reduced_crank import ReducedCrank
from dynamics.plots.curves import FROM_TOP, draw_over_angle
from dynamics.turning.speed_over_angle import SpeedOverAngle, speed_over_angle
from dynamics.turning.steady_energy import energy_for_mean_speed, mean_speed, slowest_mean_speed

# Angles over a turn of the energy equation, twice those of a hinge moment by default.
STEPS = 2880


@summarized("mean_speed [rad/s]", "fluctuation", "flywheel [kg m^2]", "gain", "angles_deg")
@dataclass(frozen=True, eq=False)
class SteadyHingeTurn:
    """One periodic revolution of a crank.

    Parameters
    ----------
    angles_deg : ndarray of shape (m,)
        Even crank angles from the top dead center [deg].
    speed : ndarray of shape (m,)
        [rad/s]
    mean_speed : float
        Mean speed over time [rad/s].
    gain : float
        Energy surplus of the revolution [J]; zero except for integration error.
    flywheel : float
        Added inertia [kg m^2].
    """

    angles_deg: FloatArray
    speed: FloatArray
    mean_speed: float
    gain: float
    flywheel: float

    @property
    def fluctuation(self) -> float:
        """Coefficient of speed fluctuation, (highest - lowest) / mean."""
        return float((self.speed.max() - self.speed.min()) / self.mean_speed)

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the speed over the crank angle.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.

        Returns
        -------
        matplotlib.axes.Axes
        """
        curves = {"speed": RPM * self.speed}
        title = f"Speed over a turn, fluctuation {self.fluctuation:.2g}"
        return draw_over_angle(
            axes,
            np.radians(self.angles_deg),
            curves,
            "crank speed [1/min]",
            title=title,
            angle_label=FROM_TOP,
        )

    def to_pandas(self) -> DataFrame:
        """Return crank angles and speeds.

        Returns
        -------
        pandas.DataFrame
            Units of the columns in ``attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
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
    hinge : HingeProfile, optional
        Guides whose spring acts on the crank; none by default.
    pressure : float, optional
        Initial pressure of the spring [Pa], by default that of the design.
    flywheel : float, optional
        Inertia added [kg m^2].
    speed : float, optional
        Mean speed of the revolution [rad/s], by default that of `point`.
    top_speed : float, optional
        Speed at the top dead center [rad/s], instead of the mean speed.

    Returns
    -------
    SteadyHingeTurn

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
    point, hinge, pressure, flywheel
        As for `steady_hinge_turn`.
    start_speed : float, optional
        At the top [rad/s]; by default that of the periodic revolution at the speed of `point`.
    turns : float, optional
        Angle to integrate over.
    samples : int, optional
        Steps per revolution of the result.

    Returns
    -------
    SpeedOverAngle

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
