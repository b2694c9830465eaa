"""The constant load under which a shaft turns steadily at a mean speed."""

import math
from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import FloatArray, finite_array, positive_number
from crankbase.checks.scalars import whole_number
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.cycle import even_angles
from dynamics.running_limits import turns_followed
from dynamics.turning.function_checks import checked_inertia, checked_moment
from dynamics.turning.speed_over_angle import (
    Inertia,
    Moment,
    SpeedOverAngle,
    UnsettledError,
    speed_over_angle,
)
from dynamics.turning.steady_energy import LEAST_ENERGY, energy_for_mean_speed

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


@summarized("load [N m]", "turning.mean_speed [rad/s]", "turning.fluctuation")
@dataclass(frozen=True, eq=False)
class SteadyTurning:
    """Rotation with a periodic speed under a constant load.

    Parameters
    ----------
    load : float
        Constant braking moment [N m].
    turning : SpeedOverAngle
        Over one period.
    """

    load: float
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
    start_angle_deg : float, optional
        [deg]
    samples : int, optional
        Per turn.

    Returns
    -------
    SteadyTurning

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
    period = 2.0 * math.pi * turns_followed("turns", turns)
    first = math.radians(float(finite_array("start_angle_deg", start_angle_deg)))
    told = whole_number(
        "samples", samples, 1, "results are given at this many angles per revolution"
    )
    guess, start_energy, comes_round = _beginning(inertia, moment, wanted, first, period)
    first_inertia = inertia(first)
    # Unknowns and misses by this energy; a load changes that over a period by load times period. The
    # unknowns count from one, as the search ends by the share to which it knows them.
    scale = 0.5 * first_inertia * wanted**2

    def turned(unknowns: FloatArray, samples: int = SEARCH_SAMPLES) -> SteadyTurning | None:
        load = guess + scale / period * (float(unknowns[0]) - 1.0)
        energy = start_energy + scale * (float(unknowns[1]) - 1.0)
        if energy <= 0.0:
            return None
        found = speed_over_angle(
            inertia,
            lambda speed, angle: moment(speed, angle) - load,
            start_angle_deg=math.degrees(first),
            start_speed=math.sqrt(2.0 * energy / first_inertia),
            turns=turns,
            samples=samples,
        )
        return SteadyTurning(load, found) if found.stopped_at_deg is None else None

    def residual(unknowns: FloatArray) -> list[float]:
        try:
            found = turned(unknowns)
        except UnsettledError:  # close to rest: a trial like those that stop
            found = None
        if found is None:
            return [STOPPED, STOPPED]
        turning = found.turning
        gained = float(turning.energy[-1] - turning.energy[0])
        return [gained / scale, turning.mean_speed / wanted - 1.0]

    # The full output, as otherwise a search that finds nothing warns.
    solved = fsolve(residual, [1.0, 1.0], xtol=1e-12, maxfev=TRIALS, full_output=True)[0]
    steady = max(abs(miss) for miss in residual(solved)) <= STEADY
    found = turned(solved, told) if steady else None
    if found is None:
        raise InputError(
            f"mean_speed: given {wanted:g} rad/s; allowed is a speed at which the shaft turns "
            "steadily, because none was found here."
            if comes_round
            else _too_slow(wanted)
        )
    if found.turning.energy.min() < LEAST_ENERGY * np.ptp(found.turning.energy):
        raise InputError(_too_slow(wanted))
    return found


def _beginning(
    inertia: Inertia, moment: Moment, speed: float, first: float, period: float
) -> tuple[float, float, bool]:
    """Return load and initial energy from the moments at the mean speed, and whether it can turn.

    Energies are sums over even angles, which is accurate for smooth curves.
    """
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
