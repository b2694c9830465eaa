"""Speeds for a calculation: an even grid, refined where orders meet natural frequencies."""

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray, nonnegative_vector, one_for_each
from crankbase.checks.scalars import whole_number
from dynamics.critical import critical_speeds

# Distances from a resonance in half bandwidths; then 1.5 times as far each, up to the even grid.
NEAR = (0.125, 0.25, 0.375, 0.5, 0.75, 1.0)
GROWTH = 1.5
# Half bandwidth taken where there is (almost) no damping, as a share of the speed.
LEAST_RATIO = 1e-4
# Speeds within this share of each other are one.
SAME_SPEED = 1e-12


def refined_speeds(
    frequencies: ArrayLike,
    damping_ratios: ArrayLike,
    orders: ArrayLike,
    speed_range: tuple[float, float],
    *,
    points: int = 200,
) -> FloatArray:
    """Return speeds that miss no peak of a lightly damped system.

    Parameters
    ----------
    frequencies : array_like of shape (n,)
        Natural frequencies [Hz]; zero for rigid-body modes.
    damping_ratios : float or array_like of shape (n,)
        Share of critical damping of each mode; 1 / (2 magnifier).
    orders : array_like of shape (K,)
        In cycles per crankshaft revolution.
    speed_range : tuple of two floats
        Lowest and highest speed [rad/s].
    points : int, optional
        Number of speeds of the even grid.

    Returns
    -------
    ndarray of shape (S,)
        Ascending [rad/s]: the even grid, each critical speed itself, and speeds about it.

    Raises
    ------
    InputError
        If a value is out of range, or the range is reversed.

    Notes
    -----
    The response of a mode of damping ratio d is 1 / sqrt(1 + (x / d)^2) of its peak at the relative
    distance x from resonance: half the bandwidth at half power is d. At magnifier 40 this is 1.25 %
    of the speed, so an even grid may give a peak far too low. Here the speeds are d/8 apart
    within d/2: wherever other modes shift the peak between them, at least
    1 - (1/16)^2 / 2 = 99.8 % of it is found. Further away the spacing grows to that of the even grid.
    """
    natural = nonnegative_vector("frequencies", frequencies, "Hz", "they count vibrations in time")
    ratios = one_for_each(
        "damping_ratios",
        damping_ratios,
        natural.size,
        "frequencies",
        "",
        "damping takes energy away",
    )
    count = whole_number("points", points, 2, "the range has two ends")
    critical = critical_speeds(natural, orders, speed_range)
    low, high = (float(limit) for limit in speed_range)
    even = np.linspace(low, high, count)
    spacing = (high - low) / (count - 1)
    found = [even]
    for own in critical:
        half = max(float(ratios[own.mode]), LEAST_RATIO) * own.speed
        offsets = list(NEAR)
        while offsets[-1] * (GROWTH - 1.0) * half < spacing and offsets[-1] * half < high - low:
            offsets.append(offsets[-1] * GROWTH)
        about = half * np.array(offsets)
        found += [own.speed - about, np.array([own.speed]), own.speed + about]
    speeds = np.sort(np.concatenate(found))
    speeds = speeds[(speeds >= low) & (speeds <= high)]
    # Of several alike the first stays; they differ by round-off.
    apart = np.diff(speeds, prepend=0.0) > SAME_SPEED * speeds
    return np.asarray(speeds[apart])
