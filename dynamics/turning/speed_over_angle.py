"""The speed of a shaft of varying inertia over its angle, by the energy equation."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array, finite_array, positive_number, read_only
from crankbase.choices import number_within, whole_number
from crankbase.diagrams import new_axes, write_title
from crankbase.errors import InputError, quoted
from crankbase.frames import Axes, DataFrame, table
from crankbase.quantity import RPM
from crankbase.results import Internal, Number, Quantity, Result, Speed, result
from crankbase.sentences import in_si
from dynamics.cycle import even_angles
from dynamics.plots.curves import draw_over_angle

# Longest time that is followed, a day [s], and the most turns of a shaft: each takes milliseconds.
LONGEST_RUN, MOST_TURNS = 86_400.0, 20_000
# Most evaluations of a chain's equations in a search for its cycle or in a revolution, and of the moments
# on one shaft in a calculation: some ten seconds each.
MOST_EVALUATIONS, MOST_MOMENTS = 150_000, 500_000


def run_time(duration: float) -> float:
    """Return the duration of a motion [s], checked."""
    time = positive_number("duration", duration, "s", "time runs forward")
    reason = "a motion is followed turn by turn"
    return number_within("duration", time, 0.0, LONGEST_RUN, "s", reason)


def turns_followed(turns: float) -> float:
    """Return a number of revolutions of a motion, checked."""
    number = positive_number("turns", turns, "", "the shaft turns forward")
    return number_within("turns", number, 0.0, MOST_TURNS, "", "each is followed by itself")


def evaluation_counter(
    refusal: Callable[[float], InputError], most: int
) -> Callable[[float], None]:
    """Return what an integration calls at each evaluation, and what ends it after too many."""
    left = iter(range(most))

    def evaluated(reached: float) -> None:
        if next(left, None) is None:
            raise refusal(reached)

    return evaluated


def work_counter(field: str, reach: float, unit: str, most: int) -> Callable[[float], None]:
    """Return an `evaluation_counter` whose error is that a motion is followed too far."""

    def refusal(reached: float) -> InputError:
        allowed = f"{0.99 * reached:.4g} {unit}".strip()
        return InputError(
            f"{field}: given {f'{reach:g} {unit}'.strip()}; allowed is {allowed} or less here, because a "
            "calculation has a limit of evaluations; another one can continue from there."
        )

    return evaluation_counter(refusal, most)


def too_many_turns(time: float, turns: float) -> InputError:
    """Return the error for a duration with too many revolutions of the shaft."""
    return InputError(
        f"duration: given {time:g} s, in which the shaft turns {turns:g} times or more; allowed are "
        f"{MOST_TURNS} turns, because each is followed by itself."
    )


def checked_moment(
    field: str, returned: float, speed: float, angle: float, largest: float = math.inf
) -> float:
    """Return a moment [N m] that a given function has returned.

    Cheap enough for every step of an integration, which would never end with a value that is not
    finite.
    """
    moment = _number(returned)
    if not (math.isfinite(moment) and abs(moment) <= largest):
        raise InputError(
            f"{field}: given a moment of {quoted(returned)} N m at {in_si(speed, 'rad/s')} and a shaft angle "
            f"of {math.degrees(angle):.6g} deg; allowed are finite "
            f"numbers{'' if largest == math.inf else f' of up to {largest:g}'}, because the speed follows "
            "from the moments."
        )
    return moment


def checked_inertia(returned: float, angle: float, least: float = 0.0) -> float:
    """Return an inertia [kg m^2] at an angle [rad]."""
    inertia = _number(returned)
    if not least < inertia < math.inf:
        raise InputError(
            f"inertia: given {quoted(returned)} kg m^2 at a shaft angle of {math.degrees(angle):.6g} deg; "
            "allowed are finite numbers clearly above zero, because a shaft without inertia has no speed "
            "that follows from the moments."
        )
    return inertia


def _number(returned: float) -> float:
    """Return the value of a user function as a float, NaN if it is none."""
    try:
        return float(returned)
    except (TypeError, ValueError, OverflowError):
        return math.nan


# A shaft that has less than this share of the swing of energy left at its slowest is taken as not
# coming round.
LEAST_ENERGY = 1e-6
# Lowest energy that is tried at all, as a share of the highest.
TRIED_ENERGY = 1e-12


def mean_speed(energy: Array, inertia: Array) -> float:
    """Return the mean over time of the speed [rad/s].

    Parameters
    ----------
    energy, inertia : ndarray of shape (m,)
        Kinetic energy [J] and inertia [kg m^2] at even angles over a period.
    """
    return 1.0 / float(np.mean(np.sqrt(0.5 * inertia / energy)))


def slowest_mean_speed(gained: Array, inertia: Array) -> float:
    """Return the least mean speed at which a shaft completes a revolution [rad/s].

    Parameters
    ----------
    gained, inertia : ndarray of shape (m,)
        Energy gained since the first angle [J], not constant, and inertia [kg m^2], at
        even angles.
    """
    swing = float(np.ptp(gained))
    return mean_speed(gained - gained.min() + LEAST_ENERGY * swing, inertia)


def energy_for_mean_speed(gained: Array, inertia: Array, speed: float) -> float | None:
    """Return the kinetic energy at the first angle of a shaft with a given mean speed.

    Parameters
    ----------
    gained, inertia : ndarray of shape (m,)
        As for `slowest_mean_speed`; the energy gained may be constant.
    speed : float
        Required mean over time [rad/s].

    Returns
    -------
    float or None
        [J]; None if the shaft does not complete a revolution at this speed.

    Notes
    -----
    The mean speed grows with the energy: one root, between a shaft that barely completes the revolution
    and one whose least energy is that of the largest inertia at the required speed.
    """
    from scipy.optimize import brentq

    swing, lacking = float(np.ptp(gained)), -float(gained.min())

    def excess(above: float) -> float:
        return mean_speed(gained + (lacking + above), inertia) - speed

    # A little more, for the swing may be lost beside it in round-off.
    highest = (1.0 + 1e-9) * (0.5 * speed**2 * float(inertia.max()) + swing)
    lowest = max(LEAST_ENERGY * swing, TRIED_ENERGY * highest)
    if excess(lowest) > 0.0:
        return None
    return lacking + float(brentq(excess, lowest, highest, rtol=1e-14, xtol=1e-12))


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


@result("mean_speed", "fluctuation", "speed [rad/s]", "stopped_at_deg [deg]")
class SpeedOverAngle(Result):
    """Rotation of a shaft over given angles.

    Parameters
    ----------
    time : ndarray of shape (m,)
        From the first angle [s].
    energy : ndarray of shape (m,)
        Kinetic energy I w^2 / 2 [J].
    stopped_at_deg : float or None
        Angle at which the shaft stopped [deg]; the arrays then end before it.
    """

    angle_deg: Internal[Array]
    speed: Internal[Array]
    time: Internal[Array]
    energy: Internal[Array]
    stopped_at_deg: Internal[float | None] = None

    @property
    def lowest_speed(self) -> Speed:
        """Over the angles."""
        return float(self.speed.min())

    @property
    def highest_speed(self) -> Speed:
        """Over the angles."""
        return float(self.speed.max())

    @property
    def mean_speed(self) -> Speed:
        """Angle turned divided by the time that it took [rad/s]."""
        if self.time[-1] == 0.0:  # stopped within the first step
            return float(self.speed[0])
        return float(math.radians(self.angle_deg[-1] - self.angle_deg[0]) / self.time[-1])

    @property
    def fluctuation(self) -> Number:
        """Coefficient of speed fluctuation: (highest - lowest speed) / mean speed."""
        return (self.highest_speed - self.lowest_speed) / self.mean_speed

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the speed over the shaft angle."""
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
        """Return a row for each angle: speed, time, kinetic energy."""
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
    start_speed : float
        Above zero [rad/s].
    turns : float
        Length of the integration, in revolutions of the shaft.

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
    length = 2.0 * math.pi * turns_followed(turns)
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

    def collocated(self, begin: float, step: float, energy: float) -> tuple[float, float] | None:
        """Return energy and time of a single step, None if it does not converge or uses up all energy."""
        angles = [begin + stage * step for stage in STAGES]
        inertias = [checked_inertia(self.inertia(angle), angle) for angle in angles]
        energies = [energy] * len(STAGES)
        change = math.inf
        for _ in range(ROUNDS):
            if min(energies) <= self.least:
                return None
            speeds = [math.sqrt(2.0 * e / i) for e, i in zip(energies, inertias, strict=True)]
            moments = [
                self.moment_at(speed, angle) for speed, angle in zip(speeds, angles, strict=True)
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
        if min(after, *energies) <= self.least:
            return None
        return after, step * _weighted(OUTER, [1.0 / speed for speed in speeds])


class UnsettledError(InputError):
    """The moment is so steep in the speed that the iteration fails in the shortest steps."""


class _StoppedError(Exception):
    """The shaft has stopped, at an angle [rad]."""

    def __init__(self, angle: float) -> None:
        super().__init__(angle)
        self.angle = angle


def _integrate_speed(
    inertia: Inertia, moment: Moment, angles: Array, start_speed: float
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
    """Return the energy after a step and its duration, halving the step if necessary."""
    # An energy that falls to zero does not prove that the shaft stops: too long a step with a
    # steep moment does the same. Near a true stop the steps become short, and at rest this remains.
    after = shaft.collocated(begin, step, energy)
    if after is not None:
        return after
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


def _weighted(weights: tuple[float, ...], values: list[float]) -> float:
    return math.fsum(weight * value for weight, value in zip(weights, values, strict=True))


# Results per turn while a steady speed is sought.
SEARCH_SAMPLES = 360
# Steady: the energy changes over a cycle by this share at most, and the mean speed is met so well.
STEADY = 1e-9
# Left over at the slowest, as a share of the swing of energy, where the search begins if the
# moments at the mean speed would not let the shaft come round.
MARGIN = 0.05
# Most trials. The search takes about ten; where there is nothing to find it would go on.
TRIALS = 100
# Stands for what a trial misses in which the shaft stops: more than any in which it turns.
STOPPED = 1e3


@result("load", "turning.mean_speed", "turning.fluctuation")
class SteadyTurning(Result):
    """Rotation with a periodic speed under a constant load.

    Parameters
    ----------
    load : float
        Constant braking moment.
    turning : SpeedOverAngle
        Over one period.
    """

    load: Annotated[float, Quantity("N m")]
    turning: SpeedOverAngle


def steady_turning(
    inertia: Inertia,
    moment: Moment,
    mean_speed: float,
    turns: float,
    *,
    start_angle_deg: float = 0.0,
    samples: int = 720,
) -> SteadyTurning:
    """Find the constant load under which the shaft turns steadily at a mean speed.

    Parameters
    ----------
    inertia, moment : callable
        As for `speed_over_angle`, without the load to be found.
    mean_speed : float
        Angle of the period divided by its time [rad/s].
    turns : float
        Period of inertia and moment, in revolutions of the shaft: 2 for a four-stroke engine.

    Raises
    ------
    InputError
        As `speed_over_angle`, and if the shaft cannot turn steadily at so low a speed.

    Notes
    -----
    Two unknowns, load and initial speed, from two conditions: the energy is periodic, and the mean
    speed is as required. The search begins with the solution for the moments at the mean speed, which is
    exact if they do not depend on the speed. A trial in which the shaft stops counts as
    far off, so the search turns back from it.
    """
    from scipy.optimize import fsolve

    wanted = positive_number("mean_speed", mean_speed, "rad/s", "the shaft turns")
    period = 2.0 * math.pi * turns_followed(turns)
    first = math.radians(float(finite_array("start_angle_deg", start_angle_deg)))
    shown = whole_number(
        "samples", samples, 1, "results are given at this many angles per revolution"
    )
    guess, start_energy, comes_round = _beginning(inertia, moment, wanted, first, period)
    first_inertia = inertia(first)
    # Unknowns and misses by this energy; a load changes that over a period by load times period. The
    # unknowns count from one, as the search ends by the share to which it knows them.
    scale = 0.5 * first_inertia * wanted**2

    def turned(unknowns: Array, samples: int = SEARCH_SAMPLES) -> SteadyTurning | None:
        load = guess + scale / period * (float(unknowns[0]) - 1.0)
        energy = start_energy + scale * (float(unknowns[1]) - 1.0)
        if energy <= 0.0:
            return None
        trial = speed_over_angle(
            inertia,
            lambda speed, angle: moment(speed, angle) - load,
            start_angle_deg=math.degrees(first),
            start_speed=math.sqrt(2.0 * energy / first_inertia),
            turns=turns,
            samples=samples,
        )
        return SteadyTurning(load, trial) if trial.stopped_at_deg is None else None

    def residual(unknowns: Array) -> list[float]:
        try:
            trial = turned(unknowns)
        except UnsettledError:  # close to rest: a trial like those that stop
            trial = None
        if trial is None:
            return [STOPPED, STOPPED]
        turning = trial.turning
        gained = float(turning.energy[-1] - turning.energy[0])
        return [gained / scale, turning.mean_speed / wanted - 1.0]

    # The full output, as otherwise a search that finds nothing warns.
    solved = fsolve(residual, [1.0, 1.0], xtol=1e-12, maxfev=TRIALS, full_output=True)[0]
    steady = max(abs(miss) for miss in residual(solved)) <= STEADY
    trial = turned(solved, shown) if steady else None
    if trial is None:
        raise InputError(
            f"mean_speed: given {in_si(wanted, 'rad/s')}; allowed is a speed at which the shaft turns "
            "steadily, because none was found here."
            if comes_round
            else _too_slow(wanted)
        )
    if trial.turning.energy.min() < LEAST_ENERGY * np.ptp(trial.turning.energy):
        raise InputError(_too_slow(wanted))
    return trial


def _beginning(
    inertia: Inertia, moment: Moment, speed: float, first: float, period: float
) -> tuple[float, float, bool]:
    """Return load and initial energy from the moments at the mean speed, and whether it can turn."""
    # Energies are sums over even angles, which is accurate for smooth curves.
    count = max(1, round(SEARCH_SAMPLES * period / (2.0 * math.pi)))
    angles = (first + even_angles(period, count)).tolist()
    inertias = np.array([checked_inertia(inertia(angle), angle) for angle in angles])
    moments = np.array(
        [checked_moment("moment", moment(speed, angle), speed, angle) for angle in angles]
    )
    load = float(np.mean(moments))
    rest = moments - load
    gained = (np.cumsum(rest) - 0.5 * (rest + rest[0])) * (period / count)
    energy = energy_for_mean_speed(gained, inertias, speed)
    if energy is None:
        return load, float(MARGIN * np.ptp(gained) - gained.min()), False
    return load, energy, True


def _too_slow(speed: float) -> str:
    return (
        f"mean_speed: given {speed:g} rad/s; allowed is more, because the shaft would stop or all but "
        "stop within the period."
    )
