"""The heat of a cycle from what is wished: itself, its peak or its mean pressure."""

from collections.abc import Callable

import numpy as np

from crankbase.checks.arrays import nonnegative_number
from crankbase.checks.scalars import is_number
from crankbase.errors import InputError
from dynamics.gas.pressure import HIGHEST_PEAK
from dynamics.gas.sampled_cycle import CycleSamples


def allowed_heat(state: CycleSamples, heat: float) -> float:
    """Return a heat [J] that drives the peak no higher than engines stand.

    Raises
    ------
    InputError
    """
    nonnegative_number("heat", heat, "J", "combustion releases heat")
    most = state.heat_for_peak(HIGHEST_PEAK)
    if heat > most:
        raise InputError(
            f"heat: given {heat:g} J; allowed are 0 to {most:.6g} J, because more drives the peak "
            f"above {format_mpa(HIGHEST_PEAK)}, which no piston engine stands."
        )
    return float(heat)


def heat_for_peak(state: CycleSamples, peak_pressure: float) -> float:
    """Return the heat [J] that gives a peak pressure [Pa].

    Raises
    ------
    InputError
    """
    peak = checked_peak(peak_pressure, state.peak(0.0))
    return max(state.heat_for_peak(peak), 0.0)


def checked_peak(peak: float, lowest: float) -> float:
    """Return a peak [Pa] from the lowest, that of compression alone, to what engines stand.

    Raises
    ------
    InputError
    """
    # The lowest peak is found to round-off, and it may be what is asked for.
    if not is_number(peak) or not lowest * (1.0 - 1e-12) <= peak <= HIGHEST_PEAK:
        raise InputError(
            f"peak_pressure: given {format_mpa(peak)}; allowed are {mpa_rounded_up(lowest)} to "
            f"{format_mpa(HIGHEST_PEAK)}, because compression alone gives the lowest and no piston engine "
            "stands more than the highest."
        )
    return max(float(peak), lowest)


def heat_for_mean_pressure(state: CycleSamples, mean_pressure: float) -> float:
    """Return the heat [J] that gives an indicated mean effective pressure [Pa].

    Raises
    ------
    InputError
    """
    lowest = state.mean_pressure(0.0)
    if state.work_per_heat <= 0.0:
        raise no_work_error(mean_pressure)
    highest = state.mean_pressure(state.heat_for_peak(HIGHEST_PEAK))
    inside = is_number(mean_pressure) and mean_pressure <= highest
    if not inside or mean_pressure < lowest - 1e-12 * abs(lowest):
        raise InputError(
            f"mean_effective_pressure: given {format_mpa(mean_pressure)}; allowed are "
            f"{mpa_rounded_up(lowest)} to "
            f"{mpa_rounded_down(highest)}, because no heat gives the lowest and the highest "
            "drives the peak to "
            f"{format_mpa(HIGHEST_PEAK)}."
        )
    return max(state.heat_for_mean_pressure(mean_pressure), 0.0)


def no_work_error(mean_pressure: float) -> InputError:
    """Make the error of a combustion whose heat does no work."""
    return InputError(
        f"mean_effective_pressure: given {format_mpa(mean_pressure)}; allowed is what a later combustion "
        "gives, because the heat of this one is all released too early to do work."
    )


def mpa_rounded_up(pressure: float) -> str:
    """Return a least pressure in MPa with four digits, rounded up: what stands there is allowed."""
    return format_mpa(_rounded(pressure, np.ceil))


def mpa_rounded_down(pressure: float) -> str:
    """Return a largest pressure in MPa with four digits, rounded down."""
    return format_mpa(_rounded(pressure, np.floor))


def _rounded(pressure: float, to_whole: Callable[[float], float]) -> float:
    if not pressure or not np.isfinite(pressure):
        return pressure
    step = 10.0 ** (np.floor(np.log10(abs(pressure))) - 3)
    return float(to_whole(pressure / step) * step)


def format_mpa(pressure: float) -> str:
    """Return a pressure in MPa for a message, or what was given in its place."""
    return f"{pressure / 1e6:.6g} MPa" if is_number(pressure) else repr(pressure)
