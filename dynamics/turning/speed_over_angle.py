"""The speed of a shaft of varying inertia as it turns: its energy equation over the angle."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from dynamics.checks import FloatArray, finite_array, positive_number, read_only
from geometry.errors import InputError

# Inertia and its derivative by the angle [kg m^2, kg m^2/rad] at one angle [rad].
Inertia = Callable[[float], tuple[float, float]]
# Moment [N m] at an angle [rad] and a speed [rad/s], positive when it drives.
Moment = Callable[[float, float], float]

# Steps are no longer than this [rad], so that none passes over a peak unseen.
LONGEST_STEP = math.radians(1.0)
# Rounds in which the speeds within a step settle, and when they have: relative change of energy.
ROUNDS, SETTLED = 50, 1e-15
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
# Results per turn while a steady speed is sought.
SEARCH_SAMPLES = 360
# Steady: the energy changes over a cycle by this share at most, and the mean speed is met so well.
STEADY = 1e-9


@dataclass(frozen=True, eq=False)
class SpeedOverAngle:
    """How a shaft turned over given angles.

    Parameters
    ----------
    angle : ndarray of shape (m,)
        [rad]
    speed : ndarray of shape (m,)
        [rad/s]
    time : ndarray of shape (m,)
        From the first angle [s].
    energy : ndarray of shape (m,)
        Kinetic energy I w^2 / 2 [J].
    stopped_at : float or None
        Angle at which the shaft stopped [rad]; the arrays then end before it.
    """

    angle: FloatArray
    speed: FloatArray
    time: FloatArray
    energy: FloatArray
    stopped_at: float | None = None

    @property
    def mean_speed(self) -> float:
        """Angle turned divided by the time that it took [rad/s]."""
        return float((self.angle[-1] - self.angle[0]) / self.time[-1])

    @property
    def fluctuation(self) -> float:
        """Coefficient of speed fluctuation: (highest - lowest speed) / mean speed."""
        return float((self.speed.max() - self.speed.min()) / self.mean_speed)


@dataclass(frozen=True, eq=False)
class SteadyTurning:
    """Turning whose speed repeats, under a constant load.

    Parameters
    ----------
    load : float
        Constant moment that brakes [N m].
    turning : SpeedOverAngle
        Over one period.
    """

    load: float
    turning: SpeedOverAngle


def speed_over_angle(
    inertia: Inertia,
    moment: Moment,
    start_angle: float,
    start_speed: float,
    turns: float,
    samples: int = 720,
) -> SpeedOverAngle:
    """Integrate d(I w^2 / 2)/dphi = Q(phi, w).

    Parameters
    ----------
    inertia : callable
        angle [rad] -> (I [kg m^2], dI/dphi [kg m^2/rad]); the derivative is not used.
    moment : callable
        (angle [rad], speed [rad/s]) -> Q [N m], all moments reduced to the shaft, positive when
        they drive; the inertia's own part is not among them.
    start_angle : float
        [rad]
    start_speed : float
        Above zero [rad/s].
    turns : float
        How far to go, in turns of the shaft.
    samples : int, optional
        Steps per turn at which the result is given, both ends included.

    Returns
    -------
    SpeedOverAngle
        If the shaft stops on the way, it ends there and says so.

    Raises
    ------
    InputError
        If a number is not finite or not above zero.

    Notes
    -----
    I phi'' + I' phi'^2 / 2 = Q is d(I phi'^2 / 2)/dphi = Q. With the energy as the unknown, I' is
    not needed and no energy is lost to the integration: it changes by the integral of Q alone.
    Gauss's collocation of order 6 in even steps of 1 deg or less: results depend smoothly on
    what is given, and a moment that bends sharply does its harm in one step.
    """
    first = float(finite_array("start_angle", start_angle))
    speed = positive_number("start_speed", start_speed, "rad/s", "the angle must grow")
    length = 2.0 * math.pi * positive_number("turns", turns, "", "the shaft turns forward")
    if samples < 1:
        raise InputError(f"samples: given {samples}; allowed are 1 or more per turn.")
    count = max(1, round(samples * turns))
    angles = np.linspace(first, first + length, count + 1)
    states, stopped = _marched(inertia, moment, angles, speed)
    return SpeedOverAngle(
        angle=read_only(angles[: len(states)].copy()),
        speed=read_only(np.array([speed for speed, _, _ in states])),
        time=read_only(np.array([time for _, time, _ in states])),
        energy=read_only(np.array([energy for _, _, energy in states])),
        stopped_at=stopped,
    )


def _marched(
    inertia: Inertia, moment: Moment, angles: FloatArray, start_speed: float
) -> tuple[list[tuple[float, float, float]], float | None]:
    """Return speed, time and energy at the angles, and where the shaft stopped."""
    energy = 0.5 * inertia(float(angles[0]))[0] * start_speed**2
    least, time = STOPPED_SHARE * energy, 0.0
    states = [(start_speed, time, energy)]
    step = float(angles[1] - angles[0])
    parts = math.ceil(step / LONGEST_STEP * (1.0 - 1e-12))
    for angle in angles[:-1].tolist():
        for part in range(parts):
            begin = angle + part * step / parts
            found = _step(inertia, moment, begin, step / parts, energy, least)
            if found is None:
                return states, begin
            energy, time = found[0], time + found[1]
        states.append((math.sqrt(2.0 * energy / inertia(angle + step)[0]), time, energy))
    return states, None


def _step(
    inertia: Inertia, moment: Moment, begin: float, step: float, energy: float, least: float
) -> tuple[float, float] | None:
    """Return the energy after a step and the time it takes, None if the shaft stops in it."""
    angles = [begin + stage * step for stage in STAGES]
    inertias = [inertia(angle)[0] for angle in angles]
    energies = [energy] * len(STAGES)
    for _ in range(ROUNDS):
        if min(energies) <= least:
            return None
        speeds = [math.sqrt(2.0 * e / i) for e, i in zip(energies, inertias, strict=True)]
        moments = [moment(angle, speed) for angle, speed in zip(angles, speeds, strict=True)]
        before = energies
        energies = [energy + step * _weighted(weights, moments) for weights in INNER]
        change = max(abs(new - old) for new, old in zip(energies, before, strict=True))
        if change <= SETTLED * energy:
            break
    after = energy + step * _weighted(OUTER, moments)
    if min(after, *energies) <= least:
        return None
    return after, step * _weighted(OUTER, [1.0 / speed for speed in speeds])


def _weighted(weights: tuple[float, ...], values: list[float]) -> float:
    return math.fsum(weight * value for weight, value in zip(weights, values, strict=True))


def steady_turning(
    inertia: Inertia,
    moment: Moment,
    mean_speed: float,
    turns: float,
    *,
    start_angle: float = 0.0,
    samples: int = 720,
) -> SteadyTurning:
    """Find the constant load under which the shaft turns steadily at a mean speed.

    Parameters
    ----------
    inertia, moment : callable
        As `speed_over_angle` takes them; the load sought is not among the moments.
    mean_speed : float
        Angle of the period by its time [rad/s].
    turns : float
        Period of inertia and moment, in turns of the shaft: 2 for a four-stroke engine.
    start_angle : float, optional
        [rad]
    samples : int, optional
        Per turn.

    Returns
    -------
    SteadyTurning

    Raises
    ------
    InputError
        If the shaft does not turn steadily at so low a speed, or a number is out of its range.

    Notes
    -----
    Two unknowns, load and speed at the start, from two conditions: the energy repeats, and the mean
    speed is met.
    """
    from scipy.optimize import root

    wanted = positive_number("mean_speed", mean_speed, "rad/s", "the shaft turns")
    period = 2.0 * math.pi * positive_number("turns", turns, "", "the shaft turns forward")
    grid = start_angle + np.linspace(0.0, period, max(1, round(360 * turns)), endpoint=False)
    moments = np.array([moment(angle, wanted) for angle in grid.tolist()])
    guess = float(np.mean(moments))
    energy = 0.5 * float(np.mean([inertia(angle)[0] for angle in grid.tolist()])) * wanted**2
    # What the varying part of the moment adds to the energy since the start of the period.
    added = np.cumsum(moments - guess) * (period / grid.size)
    first_energy = energy - float(np.mean(added))
    if first_energy + float(np.min(added)) <= 0.0:
        raise _too_slow(wanted)
    first_speed = math.sqrt(2.0 * first_energy / inertia(start_angle)[0])
    # The load changes the energy over a period by load times period.
    load_scale = energy / period

    def turned(unknowns: FloatArray, told: int = SEARCH_SAMPLES) -> tuple[float, SpeedOverAngle]:
        load = guess + load_scale * float(unknowns[0])
        first = first_speed * max(float(unknowns[1]), 1e-3)
        found = speed_over_angle(
            inertia,
            lambda angle, speed: moment(angle, speed) - load,
            start_angle,
            first,
            turns,
            told,
        )
        return load, found

    def misses(unknowns: FloatArray) -> list[float]:
        _, found = turned(unknowns)
        if found.stopped_at is not None:
            raise _too_slow(wanted)
        gained = (found.energy[-1] - found.energy[0]) / energy
        return [float(gained), found.mean_speed / wanted - 1.0]

    solved = np.asarray(root(misses, [0.0, 1.0], tol=1e-12).x)
    worst = max(abs(miss) for miss in misses(solved))
    if worst > STEADY:
        raise InputError(
            f"mean_speed: given {wanted:g} rad/s; allowed is a speed at which the shaft turns "
            "steadily, because none was found here."
        )
    return SteadyTurning(*turned(solved, samples))


def _too_slow(speed: float) -> InputError:
    return InputError(
        f"mean_speed: given {speed:g} rad/s; allowed is more, because the shaft would stop within "
        "the period."
    )
