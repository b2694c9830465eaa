"""Smoothing of a crank's speed: the required flywheel, and the best pressure of a hinge."""

import math
from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import positive_number
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.hinge.moment import HingeMoment
from dynamics.hinge.profile import HingeProfile
from dynamics.hinge.simulation import integrated, moments_on_crank, steady_at, turn_energy

LARGEST_FLYWHEEL = 1e9
# Of the logarithm of the pressure: values tried at first, and where the search ends.
TRIED_PRESSURES, PRESSURE_STEP = 41, 1e-10
# Stands for the fluctuation of a crank that does not come round; no turning one reaches it.
STANDING = 100.0


@summarized(
    "pressure [Pa]", "ratio", "fluctuation", "unchanged", "moment_residual", "largest_residual"
)
@dataclass(frozen=True)
class BestPressure:
    """The initial pressure of a spring that smooths a crank's speed most, for given guides.

    Parameters
    ----------
    pressure : float
        [Pa]
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

    pressure: float
    ratio: float
    fluctuation: float
    unchanged: float | None
    moment_residual: float
    largest_residual: float
    fitted_ratio: float


def flywheel_for(
    point: HingeMoment, fluctuation: float, hinge: HingeProfile | None = None
) -> float:
    """Return the inertia of the flywheel that reaches a coefficient of speed fluctuation.

    Parameters
    ----------
    point : HingeMoment
        Operating point, whose mean speed is kept.
    fluctuation : float
        Required coefficient, above zero.
    hinge : HingeProfile, optional
        A hinge that assists.

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
            found = steady_at(energy, inertia, point.speed).fluctuation
        except InputError:
            found = STANDING
        return math.log(found / fluctuation)

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
    hinge : HingeProfile
        Given guides.
    bounds : tuple of two float, optional
        Smallest and largest pressure considered, as multiples of the design's.
    flywheel : float, optional
        Inertia added [kg m^2].

    Returns
    -------
    BestPressure

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
    found = minimize_scalar(
        fluctuation,
        bounds=(tried[max(place - 1, 0)], tried[min(place + 1, tried.size - 1)]),
        method="bounded",
        options={"xatol": PRESSURE_STEP},
    )
    if not found.fun < STANDING:
        raise InputError(
            f"bounds: given {low:g} to {high:g}; allowed are bounds between which the crank completes "
            f"revolutions at {point.speed:g} rad/s, because there is nothing to compare otherwise."
        )
    unchanged = fluctuation(0.0)
    ratio = math.exp(float(found.x))
    wanted, given = point.moment, hinge.moment_at(angles_deg=point.angles_deg)
    residual = wanted - hinge.moment_at(ratio * hinge.spring.pressure, angles_deg=point.angles_deg)
    return BestPressure(
        pressure=ratio * hinge.spring.pressure,
        ratio=ratio,
        fluctuation=float(found.fun),
        unchanged=unchanged if unchanged < STANDING else None,
        moment_residual=math.sqrt(float(np.mean(residual**2) / np.mean(wanted**2))),
        largest_residual=float(np.max(np.abs(residual)) / np.max(np.abs(wanted))),
        fitted_ratio=float(np.dot(wanted, given) / np.dot(given, given)),
    )
