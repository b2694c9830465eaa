"""Sum of the orders of a vibration over its cycle, and the plain sum of their amplitudes."""

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import gcd, lcm

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import ComplexArray, FloatArray
from crankbase.errors import InputError
from crankbase.summaries import summarized

# Largest denominator of an order: 1/2 in a four-stroke engine, teeth of a gear behind it.
LARGEST_DENOMINATOR = 1000
# Orders count as fractions within this share.
SAME_ORDER = 1e-9
# Most cycles of the highest order in one period of the sum.
MOST_CYCLES = 20_000
# Samples to each cycle of the highest order; the bound on the error follows from it.
SAMPLES_PER_CYCLE = 32
# No sampled peak is lower than its true one by more than this share: see `synthesis`.
PEAK_ERROR_BOUND = 1.0 - float(np.cos(np.pi / SAMPLES_PER_CYCLE))
# Newton steps from a sample to the peak beside it, each within one step of the samples.
NEWTON_STEPS = 6
# A step of less than this share of the samples' changes no digit of a peak.
SETTLED = 1e-7
# Peaks of a sum whose amplitudes add up to one are the same within this.
SAME_PEAK = 1e-9
# Values sampled at once; bounds the memory and stays near the processor.
BATCH = 2**19


@summarized("speeds [rad/s]", "amplitude", "plain_sum", "period [rad]")
@dataclass(frozen=True, eq=False)
class Synthesis:
    """Vibration with all orders together, at each speed and location.

    Parameters
    ----------
    speeds : ndarray of shape (S,)
        [rad/s].
    amplitude : ndarray of shape (S, ...)
        Half of the distance from lowest to highest value over the cycle; inf where unbounded.
    highest, lowest : ndarray of shape (S, ...)
        Extreme values, without the mean; inf and -inf where unbounded.
    plain_sum : ndarray of shape (S, ...)
        Sum of the amplitudes of all orders, as if their peaks coincided: an upper bound of the amplitude.
    unbounded : ndarray of shape (S,), bool
        Where any order is unbounded.
    period : float
        Shaft angle after which the vibration repeats [rad].
    """

    speeds: FloatArray
    amplitude: FloatArray
    highest: FloatArray
    lowest: FloatArray
    plain_sum: FloatArray
    unbounded: NDArray[np.bool_]
    period: float


def synthesis(
    orders: FloatArray,
    speeds: FloatArray,
    phasors: ComplexArray,
    unbounded: NDArray[np.bool_] | None = None,
) -> Synthesis:
    """Sum the orders over their cycle, and find the extremes.

    Parameters
    ----------
    orders : ndarray of shape (K,)
        In cycles per crankshaft revolution.
    speeds : ndarray of shape (S,)
        [rad/s].
    phasors : ndarray of shape (K, S, ...), complex
        y = Re sum_k Y_k exp(i k phi).
    unbounded : ndarray of shape (K, S), bool, optional
        Where there is no steady vibration.

    Returns
    -------
    Synthesis

    Raises
    ------
    InputError
        If the orders have no common period.

    Notes
    -----
    A sum of orders up to N times the lowest common one is a trigonometric polynomial of degree N.
    From m > 2 N even samples its largest absolute value is known within the factor cos(pi N / m)
    (Ehlich, Zeller, Mathematische Zeitschrift 86, 1964, 41-44). After subtracting the middle of the extreme
    samples, the same holds for half the distance of the extremes, as no other constant gives a
    smaller largest value than the true middle: the error of the sampled amplitude is below
    1 - cos(pi N / m), 0.48 % with the 32 samples to a cycle of the highest order used here. Every
    sample that may be next to the true extreme is then followed to the peak by Newton's method,
    which leaves only round-off.
    """
    multiples, common = common_order(orders)
    count, places = orders.size, phasors.shape[1:]
    flat = phasors.reshape(count, -1)
    degree = int(multiples[-1])
    size = 2 ** int(np.ceil(np.log2(SAMPLES_PER_CYCLE * degree)))
    highest, lowest = np.empty(flat.shape[1]), np.empty(flat.shape[1])
    step = max(1, BATCH // size)
    for start in range(0, flat.shape[1], step):
        part = slice(start, start + step)
        # Scaled, so that neither vibrations of 1e-300 nor of 1e300 leave the range of numbers.
        scale = np.sum(np.abs(flat[:, part]), axis=0)
        unit = flat[:, part] / np.where(scale > 0.0, scale, 1.0)
        spectrum = np.zeros((unit.shape[1], size // 2 + 1), dtype=np.complex128)
        spectrum[:, multiples] = 0.5 * size * unit.T
        samples = np.fft.irfft(spectrum, n=size, axis=1)
        highest[part] = scale * _peaks(multiples, unit, samples)[0]
        lowest[part] = -scale * _peaks(multiples, -unit, -samples)[0]
    endless = np.zeros(speeds.size, dtype=bool) if unbounded is None else np.any(unbounded, axis=0)
    where = endless.reshape(endless.shape + (1,) * (len(places) - 1))
    top, bottom = highest.reshape(places), lowest.reshape(places)
    return Synthesis(
        speeds=speeds,
        amplitude=np.where(where, np.inf, 0.5 * (top - bottom)),
        highest=np.where(where, np.inf, top),
        lowest=np.where(where, -np.inf, bottom),
        plain_sum=np.where(where, np.inf, np.sum(np.abs(phasors), axis=0)),
        unbounded=endless,
        period=2.0 * np.pi / common,
    )


def common_order(orders: FloatArray) -> tuple[NDArray[np.int64], float]:
    """Find the highest order of which all are integer multiples.

    Returns
    -------
    multiples : ndarray of shape (K,), int
    common : float
        The vibration repeats after 1/common revolutions.

    Raises
    ------
    InputError
        If there is none, or the highest order is too large a multiple of it.
    """
    multiples, common = _common_order(tuple(orders.tolist()))
    return multiples.copy(), common


@lru_cache(maxsize=8)
def _common_order(orders: tuple[float, ...]) -> tuple[NDArray[np.int64], float]:
    fractions = [Fraction(order).limit_denominator(LARGEST_DENOMINATOR) for order in orders]
    below = lcm(*(fraction.denominator for fraction in fractions))
    above = [fraction.numerator * (below // fraction.denominator) for fraction in fractions]
    share = gcd(*above)
    common = Fraction(share, below)
    for order, fraction in zip(orders, fractions, strict=True):
        if abs(float(fraction) - order) > SAME_ORDER * order:
            raise InputError(
                f"orders: given {order!r}; allowed are fractions with a denominator up to "
                f"{LARGEST_DENOMINATOR}, because the sum of others does not repeat."
            )
    if max(above) // share > MOST_CYCLES:
        raise InputError(
            f"orders: given ones that are multiples of {float(common):.3g} only, up to "
            f"{orders[-1]:g}; allowed are up to {MOST_CYCLES} times the highest common one, "
            "because the sum is sampled over its whole period."
        )
    return np.array([number // share for number in above]), float(common)


def extreme_angles(orders: FloatArray, phasors: ComplexArray) -> tuple[float, float]:
    """Return the shaft angles [rad] at which the sum of the orders (K,) is highest and lowest."""
    multiples, common = common_order(orders)
    size = 2 ** int(np.ceil(np.log2(SAMPLES_PER_CYCLE * int(multiples[-1]))))
    spectrum = np.zeros(size // 2 + 1, dtype=np.complex128)
    scale = float(np.sum(np.abs(phasors))) or 1.0
    spectrum[multiples] = 0.5 * size * phasors / scale
    samples = np.fft.irfft(spectrum, n=size)[np.newaxis]
    unit = phasors[:, np.newaxis] / scale
    highest, lowest = (
        float(_peaks(multiples, sign * unit, sign * samples)[1][0]) / common for sign in (1.0, -1.0)
    )
    return highest, lowest


def _peaks(
    multiples: NDArray[np.int64], phasors: ComplexArray, samples: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the highest value of each sum (p,) and its first angle, from phasors (K, p) and samples (p, m).

    The amplitudes of each sum add up to one.

    A true peak, measured from the middle of the extremes, exceeds an adjacent sample by a
    factor of at most 1/cos(pi N / m): samples further below the highest are skipped.
    """
    size = samples.shape[1]
    top = np.max(samples, axis=1)
    half = 0.5 * (top - np.min(samples, axis=1))
    margin = 2.0 * half * (1.0 / np.cos(np.pi * multiples[-1] / size) - 1.0)
    row, column = np.nonzero(samples >= (top - margin)[:, np.newaxis])
    own = samples[row, column]
    # A sum that is zero throughout has no peaks.
    summit = (own >= samples[row, column - 1]) & (own >= samples[row, (column + 1) % size])
    row, column = row[summit & (half[row] > 0.0)], column[summit & (half[row] > 0.0)]
    step = 2.0 * np.pi / size
    start = step * column
    angle = start.copy()
    waves = phasors[:, row]
    found = samples[row, column].copy()
    # Value, slope and bend of a sum are the real, imaginary and real part of its moments.
    powers = multiples.astype(np.complex128) ** np.arange(3)[:, np.newaxis]
    for _ in range(NEWTON_STEPS + 1):
        value, slope, bend = powers @ (waves * _turned(multiples, angle))
        found = np.maximum(found, value.real)
        move = np.divide(-slope.imag, bend.real, out=np.zeros_like(angle), where=bend.real > 0.0)
        before = angle
        angle = np.clip(angle + move, start - step, start + step)
        if np.all(np.abs(angle - before) <= SETTLED * step):
            break
    highest, angles = top.copy(), step * np.argmax(samples, axis=1)
    np.maximum.at(highest, row, found)
    equal = np.flatnonzero(found >= highest[row] - SAME_PEAK)
    backwards = equal[
        np.argsort(-angle[equal])
    ]  # so that the first of equal peaks is the one that stays
    angles[row[backwards]] = angle[backwards]
    return highest, angles


def _turned(multiples: NDArray[np.int64], angle: FloatArray) -> ComplexArray:
    """Return exp(i k phi) of multiples k (K,), ascending, and angles phi (p,), (K, p)."""
    steps, which = np.unique(np.diff(multiples, prepend=0), return_inverse=True)
    factors = np.exp(1j * np.outer(steps, angle))
    turned = np.empty((multiples.size, angle.size), dtype=np.complex128)
    turned[0] = factors[which[0]]
    for row in range(1, multiples.size):
        np.multiply(turned[row - 1], factors[which[row]], out=turned[row])
    return turned
