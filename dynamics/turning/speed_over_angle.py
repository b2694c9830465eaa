"""The speed of a shaft of varying inertia over its angle, by the energy equation."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import FloatArray, finite_array, positive_number, read_only
from crankbase.checks.scalars import whole_number
from crankbase.drawing.diagram_style import new_axes
from crankbase.drawing.legends import write_title
from crankbase.errors import InputError
from crankbase.library_types import Axes, DataFrame
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from crankbase.units.units import RPM
from dynamics.plots.curves import draw_over_angle
from dynamics.running_limits import turns_followed, work_counter
from dynamics.turning.function_checks import checked_inertia, checked_moment

TURN = 2.0 * math.pi
# Inertia [kg m^2] at an angle [rad].
Inertia = Callable[[float], float]
# Moment [N m] at a speed [rad/s] and an angle [rad], positive when it drives.
Moment = Callable[[float, float], float]

# Steps are no longer than this [rad], so that none passes over a peak unseen.
LONGEST_STEP = math.radians(1.0)
# Rounds in which the speeds within a step settle, and when they have: relative change of energy. A
# step that takes more rounds is too long to be accurate, too. A change that does not become smaller
# any more is due to round-off in the moment if it is below the second bound.
ROUNDS, SETTLED, ROUGH = 25, 1e-15, 1e-11
# A step whose speeds do not settle, or in which no energy is left, is halved so often at most.
HALVINGS = 8
# Most evaluations of the moment, which takes one to ten microseconds.
MOST_CALLS = 600_000
# Gauss's collocation with three stages, of order 6: places in the step, weights of the stages for
# the energy at the stages and at the end.
_ROOT = math.sqrt(15.0)
STAGES = (0.5 - _ROOT / 10.0, 0.5, 0.5 + _ROOT / 10.0)
INNER = (
    (5.0 / 36.0, 2.0 / 9.0 - _ROOT / 15.0, 5.0 / 36.0 - _ROOT / 30.0),
    (5.0 / 36.0 + _ROOT / 24.0, 2.0 / 9.0, 5.0 / 36.0 - _ROOT / 24.0),
    (5.0 / 36.0 + _ROOT / 30.0, 2.0 / 9.0 + _ROOT / 15.0, 5.0 / 36.0),
)
OUTER = (5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0)
# The shaft counts as stopped when this share of its first kinetic energy is left.
STOPPED_SHARE = 1e-9


@summarized("mean_speed [rad/s]", "fluctuation", "speed [rad/s]", "stopped_at_deg [deg]")
@dataclass(frozen=True, eq=False)
class SpeedOverAngle:
    """Rotation of a shaft over given angles.

    Parameters
    ----------
    angle_deg : ndarray of shape (m,)
        [deg]
    speed : ndarray of shape (m,)
        [rad/s]
    time : ndarray of shape (m,)
        From the first angle [s].
    energy : ndarray of shape (m,)
        Kinetic energy I w^2 / 2 [J].
    stopped_at_deg : float or None
        Angle at which the shaft stopped [deg]; the arrays then end before it.
    """

    angle_deg: FloatArray
    speed: FloatArray
    time: FloatArray
    energy: FloatArray
    stopped_at_deg: float | None = None

    @property
    def mean_speed(self) -> float:
        """Angle turned divided by the time that it took [rad/s]."""
        if self.time[-1] == 0.0:  # stopped within the first step
            return float(self.speed[0])
        return float(math.radians(self.angle_deg[-1] - self.angle_deg[0]) / self.time[-1])

    @property
    def fluctuation(self) -> float:
        """Coefficient of speed fluctuation: (highest - lowest speed) / mean speed."""
        return float((self.speed.max() - self.speed.min()) / self.mean_speed)

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the speed over the shaft angle.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.

        Returns
        -------
        matplotlib.axes.Axes
        """
        axes = new_axes(axes)
        draw_over_angle(
            axes,
            np.radians(self.angle_deg),
            {"speed": RPM * self.speed},
            "speed [1/min]",
            cyclic=False,
        )
        write_title(axes, "Speed over the shaft angle")
        return axes

    def to_pandas(self) -> DataFrame:
        """Return a row for each angle: speed, time, kinetic energy.

        Returns
        -------
        pandas.DataFrame
            Units of the columns in ``attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return table(
            {
                "angle": (self.angle_deg, "deg"),
                "speed": (self.speed, "rad/s"),
                "time": (self.time, "s"),
                "kinetic_energy": (self.energy, "J"),
            }
        )


def speed_over_angle(
    inertia: Inertia,
    moment: Moment,
    *,
    start_angle_deg: float,
    start_speed: float,
    turns: float,
    samples: int = 720,
) -> SpeedOverAngle:
    """Integrate d(I w^2 / 2)/dphi = Q(phi, w).

    Parameters
    ----------
    inertia : callable
        angle [rad] -> I [kg m^2].
    moment : callable
        (speed [rad/s], angle [rad]) -> Q [N m], all moments reduced to the shaft, positive when
        they drive, without the part of the inertia. It may jump with the angle, not with
        the speed.
    start_angle_deg : float
        [deg]
    start_speed : float
        Above zero [rad/s].
    turns : float
        Length of the integration, in revolutions of the shaft.
    samples : int, optional
        Steps per revolution of the result, both ends included.

    Returns
    -------
    SpeedOverAngle
        If the shaft stops on the way, the result ends there and states it.

    Raises
    ------
    InputError
        If a number is not finite or not above zero, the moment is not finite, the inertia is not
        above zero, the moment changes so steeply with the speed that steps of 1/256 deg are too
        long, or it is evaluated more than 600,000 times, as in some 300 turns.

    Notes
    -----
    I phi'' + I' phi'^2 / 2 = Q is d(I phi'^2 / 2)/dphi = Q. With the energy as the unknown, I' is
    not needed and no energy is lost in the integration: it changes by the integral of Q alone.
    Gauss collocation of order 6 in even steps of 1 deg or less: results depend smoothly on
    the inputs, and a kink of the moment affects only one step. The equations are
    solved by iteration, and a step in which it does not converge is halved, so that a moment that
    is steep in the speed takes more and shorter steps.
    """
    first = math.radians(float(finite_array("start_angle_deg", start_angle_deg)))
    speed = positive_number("start_speed", start_speed, "rad/s", "the angle must grow")
    length = 2.0 * math.pi * turns_followed("turns", turns)
    per_turn = whole_number(
        "samples", samples, 1, "results are given at this many angles per revolution"
    )
    count = max(1, round(per_turn * turns))
    angles = np.linspace(first, first + length, count + 1)
    states, stopped = _integrate_speed(inertia, moment, angles, speed)
    return SpeedOverAngle(
        angle_deg=read_only(np.degrees(angles[: len(states)])),
        speed=read_only(np.array([speed for speed, _, _ in states])),
        time=read_only(np.array([time for _, time, _ in states])),
        energy=read_only(np.array([energy for _, _, energy in states])),
        stopped_at_deg=None if stopped is None else math.degrees(stopped),
    )


@dataclass(frozen=True)
class _Shaft:
    """Inertia and moment as given, and the energy [J] below which the shaft counts as stopped."""

    inertia: Inertia
    moment: Moment
    least: float
    evaluated: Callable[[float], None]

    def speed(self, energy: float, angle: float) -> float:
        return math.sqrt(2.0 * energy / checked_inertia(self.inertia(angle), angle))

    def moment_at(self, speed: float, angle: float) -> float:
        self.evaluated(angle)
        return checked_moment("moment", self.moment(speed, angle), speed, angle)

    def stays_at_rest(self, angles: list[float]) -> bool:
        """Return whether the shaft, almost at rest, is not driven on at one of the angles."""
        return any(self.moment_at(self.speed(self.least, angle), angle) <= 0.0 for angle in angles)


class UnsettledError(InputError):
    """The moment is so steep in the speed that the iteration fails in the shortest steps."""


class _StoppedError(Exception):
    """The shaft has stopped, at an angle [rad]."""

    def __init__(self, angle: float) -> None:
        super().__init__(angle)
        self.angle = angle


def _integrate_speed(
    inertia: Inertia, moment: Moment, angles: FloatArray, start_speed: float
) -> tuple[list[tuple[float, float, float]], float | None]:
    """Return speed, time and energy at the angles, and where the shaft stopped."""
    first = float(angles[0])
    energy, time = 0.5 * checked_inertia(inertia(first), first) * start_speed**2, 0.0
    count = work_counter("turns", float(angles[-1] - first) / TURN, "", MOST_CALLS)
    shaft = _Shaft(
        inertia, moment, STOPPED_SHARE * energy, lambda angle: count((angle - first) / TURN)
    )
    states = [(start_speed, time, energy)]
    step = float(angles[1] - angles[0])
    parts = math.ceil(step / LONGEST_STEP * (1.0 - 1e-12))
    for angle in angles[:-1].tolist():
        for part in range(parts):
            begin = angle + part * step / parts
            try:
                energy, taken = _energy_after_step(shaft, begin, step / parts, energy, HALVINGS)
            except _StoppedError as stop:
                return states, stop.angle
            time += taken
        states.append((shaft.speed(energy, angle + step), time, energy))
    return states, None


def _energy_after_step(
    shaft: _Shaft, begin: float, step: float, energy: float, halvings: int
) -> tuple[float, float]:
    """Return the energy after a step and its duration, halving the step if necessary.

    An energy that falls to zero does not prove that the shaft stops: too long a step with a
    steep moment does the same. Near a true stop the steps become short, and at rest this remains.
    """
    found = _collocated(shaft, begin, step, energy)
    if found is not None:
        return found
    if halvings > 0:
        middle, first = _energy_after_step(shaft, begin, 0.5 * step, energy, halvings - 1)
        end, second = _energy_after_step(
            shaft, begin + 0.5 * step, 0.5 * step, middle, halvings - 1
        )
        return end, first + second
    if shaft.stays_at_rest([begin + stage * step for stage in STAGES]):
        raise _StoppedError(begin)
    raise UnsettledError(
        f"moment: given one with which the speed does not settle at {math.degrees(begin):.6g} deg and "
        f"{shaft.speed(energy, begin):.6g} rad/s in steps of {math.degrees(step):.2g} deg; allowed is "
        "one that changes less steeply with the speed, because either follows from the other."
    )


def _collocated(
    shaft: _Shaft, begin: float, step: float, energy: float
) -> tuple[float, float] | None:
    """Return energy and time of a single step, None if it does not converge or uses up all energy."""
    angles = [begin + stage * step for stage in STAGES]
    inertias = [checked_inertia(shaft.inertia(angle), angle) for angle in angles]
    energies = [energy] * len(STAGES)
    change = math.inf
    for _ in range(ROUNDS):
        if min(energies) <= shaft.least:
            return None
        speeds = [math.sqrt(2.0 * e / i) for e, i in zip(energies, inertias, strict=True)]
        moments = [
            shaft.moment_at(speed, angle) for speed, angle in zip(speeds, angles, strict=True)
        ]
        earlier, before = change, energies
        energies = [energy + step * _weighted(weights, moments) for weights in INNER]
        change = max(abs(new - old) for new, old in zip(energies, before, strict=True))
        if change <= SETTLED * energy:
            break
        if change >= earlier:
            if change > ROUGH * energy:
                return None
            break
    else:
        return None
    after = energy + step * _weighted(OUTER, moments)
    if min(after, *energies) <= shaft.least:
        return None
    return after, step * _weighted(OUTER, [1.0 / speed for speed in speeds])


def _weighted(weights: tuple[float, ...], values: list[float]) -> float:
    return math.fsum(weight * value for weight, value in zip(weights, values, strict=True))
