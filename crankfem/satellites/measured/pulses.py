"""Instants at which the teeth of a wheel pass a sensor, from the sensor's voltage."""

from collections.abc import Iterable, Iterator
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from crankbase.array_checks import Array, Flags
from crankbase.errors import InputError

Edge = Literal["rising", "falling"]
# Samples taken at once, each a few times: 16 MB.
PIECE = 2**21
# The level is that of ordinary teeth: of so many blocks, each long enough for two teeth, the median.
BLOCKS_OF_LEVEL, TEETH_OF_BLOCK = 15, 2
# A crossing counts where the signal passes this share of half of an ordinary tooth's range on either side.
HYSTERESIS = 0.25
# A piece whose ordinary range is below this share of the largest one has no teeth: the shaft stands still.
STILL = 0.02
# Swings at the end of a piece that the next one takes once more.
SWINGS_AGAIN = 40
# A change of sign that takes so many times as long as the neighboring ones holds a gap.
NEIGHBORS, LONG = 15, 2.5


def pulse_times(
    voltage: Iterable[NDArray[np.floating]], rate: float, start: float = 0.0, edge: Edge = "rising"
) -> Array:
    """Find when the voltage of a wheel's sensor crosses the middle of an ordinary tooth.

    Parameters
    ----------
    voltage : iterable of ndarray
        The samples in pieces, or an array of them.
    rate : float
        Samples in a second [1/s].
    start : float, optional
        Time of the first sample [s].
    edge : {"rising", "falling"}, optional

    Returns
    -------
    ndarray
        Times, ascending [s], between samples by a straight line.

    Raises
    ------
    InputError
        If no tooth is found.

    Notes
    -----
    The level follows the median of the highest and of the lowest values in blocks of a few teeth, so that one
    magnetic tooth moves it as little as a gap does; it is a line between the middles of the blocks. Crossings
    count from beyond the band on one side to beyond it on the other, and noise within it does not.
    """
    crossings: list[Array] = []
    carried = np.empty(0)
    first, largest, last = 0, 0.0, -np.inf
    for values in _pieces(voltage):
        samples = np.concatenate((carried, values))
        level, band = _levels(samples)
        largest = max(largest, float(np.median(band)))
        band = np.maximum(band, STILL * largest)
        places, rising, sure = _crossings(samples - level, HYSTERESIS * band)
        places = first + places[rising == (edge == "rising")]
        crossings.append(places[places > last + 1.0])
        last = float(places[-1]) if places.size else last
        first, carried = first + sure, samples[sure:]
        if carried.size > 4 * PIECE:  # nothing turns
            first, carried = first + carried.size - PIECE, carried[-PIECE:]
    crossed = np.concatenate([*crossings, np.empty(0)])
    if crossed.size < 2:
        raise InputError(
            "voltage: no teeth are found in it; allowed is the voltage of a sensor at a toothed wheel."
        )
    return np.asarray(start + crossed / rate)


def _pieces(voltage: Iterable[NDArray[np.floating]]) -> Iterator[Array]:
    """Yield samples, so many at once as fit well into memory."""
    for part in [voltage] if isinstance(voltage, np.ndarray) else voltage:
        for first in range(0, len(part), PIECE):
            yield np.asarray(part[first : first + PIECE], dtype=float)


def _levels(samples: Array) -> tuple[Array, Array]:
    """Return the middle of an ordinary tooth and half of its range, at each sample."""
    low, high = np.quantile(samples[:: max(1, samples.size // 20_000)], (0.02, 0.98))
    above = samples > 0.5 * (low + high)
    changes = max(int(np.count_nonzero(above[1:] != above[:-1])), 1)
    # Noise at the level makes more changes than teeth do, and shorter blocks; eight samples are the least.
    size = int(np.clip(2 * TEETH_OF_BLOCK * samples.size // changes, 8, max(samples.size, 8)))
    starts = np.arange(0, samples.size, size)
    top, bottom = np.maximum.reduceat(samples, starts), np.minimum.reduceat(samples, starts)
    if starts.size > 1 and samples.size - starts[-1] < size:
        top[-1], bottom[-1] = top[-2], bottom[-2]
    from scipy.ndimage import median_filter

    count = min(BLOCKS_OF_LEVEL, starts.size)
    top, bottom = (median_filter(ends, count, mode="mirror") for ends in (top, bottom))
    at, middles = np.arange(samples.size), starts + 0.5 * size
    return (
        np.interp(at, middles, 0.5 * (top + bottom)),
        np.interp(at, middles, 0.5 * (top - bottom)),
    )


def _crossings(samples: Array, band: Array) -> tuple[Array, Flags, int]:
    """Return crossings of zero in samples, whether each rises, and the first sample of the next piece."""
    from scipy.ndimage import median_filter

    positive, over = samples > 0.0, np.flatnonzero(np.abs(samples) > band)
    changes = np.flatnonzero(positive[1:] != positive[:-1])
    # The last sample over the band of one sign before the first one of the other.
    turns = np.flatnonzero(positive[over[1:]] != positive[over[:-1]])
    left, entered = over[turns], over[turns + 1]
    if not turns.size:
        return np.empty(0), np.empty(0, dtype=bool), 0
    # Where lines through the samples before and after a change are zero.
    crossed = changes[np.searchsorted(changes, entered) - 1]
    places = crossed + samples[crossed] / (samples[crossed] - samples[crossed + 1])
    # In a gap the signal stays near zero, on any side: there the next tooth begins as others do, before it
    # enters the band.
    for direction in (slice(0, None, 2), slice(1, None, 2)):
        duration = (entered - left)[direction]
        if not duration.size:
            continue
        count = min(NEIGHBORS, duration.size)
        through = duration > LONG * median_filter(duration, count, mode="nearest")
        delays = (entered - places)[direction]
        usual = median_filter(delays, count, mode="nearest")
        places[direction] = np.where(through, entered[direction] - usual, places[direction])
    sure = int(left[-min(SWINGS_AGAIN, left.size)])
    return places, positive[entered], sure
