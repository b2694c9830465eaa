"""Critical speeds of a whole crankshaft: maxima of single orders over the speed, at any place."""

from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.summaries import summarized
from dynamics.crankshaft.coupled_response import CoupledResponse
from dynamics.response.damped_criticals import BAND
from dynamics.response.series import OrderSeries
from dynamics.running_limits import within

# Maxima of one order at several places within this share of the speed are one critical speed.
TOGETHER = 0.03
# Maxima below this share of the largest one of their place are left out.
LEAST_PEAK = 0.05


@summarized("order", "speed [rad/s]", "place", "value", "frequency [Hz]", "damping_ratio")
@dataclass(frozen=True)
class ShaftCritical:
    """A speed at which an order alone makes a quantity largest.

    Attributes
    ----------
    order : float
        In cycles per revolution.
    speed : float
        [rad/s]
    place : str
        Where it is largest.
    value : float
        There, of this order alone [m or N m]; inf where unbounded.
    mode : int
        Number of the elastic mode of the whole crankshaft at resonance, 1 the lowest; 0 for none.
    frequency : float or None
        Natural frequency of the mode [Hz]; None for none.
    damping_ratio : float or None
        Of the mode, share of critical damping; None for none.
    share : float
        Of a place's largest maximum, at the place where that is most.
    """

    order: float
    speed: float
    place: str
    value: float
    mode: int
    frequency: float | None
    damping_ratio: float | None
    share: float = 1.0


def shaft_criticals(
    coupled: CoupledResponse, series: OrderSeries, speed_range: tuple[float, float]
) -> tuple[tuple[ShaftCritical, ...], int]:
    """Find the critical speeds of a whole crankshaft in a quantity at several places.

    Parameters
    ----------
    coupled : CoupledResponse
    series : OrderSeries
        Motions or torques of it, at its orders and speeds.
    speed_range : tuple of two floats
        [rad/s]

    Returns
    -------
    criticals : tuple of ShaftCritical
        In ascending speed, each at the place with the largest value.
    left_out : int
        Number of maxima that are below `LEAST_PEAK` of the largest one at every place.

    Notes
    -----
    Between the speeds of the series a maximum lies where a parabola through 1 / value^2 has its least,
    which is exact near a resonance. The mode is that with the largest amplitude among those whose magnifier
    is at least half of its largest there.
    """
    sizes = np.where(series.unbounded[:, :, np.newaxis], np.inf, np.abs(series.values))
    top = (sizes[:, 1:-1] > sizes[:, :-2]) & (sizes[:, 1:-1] >= sizes[:, 2:])
    orders, centers, places = np.nonzero(top)
    beside = (centers[:, np.newaxis] + np.arange(3)).T
    with np.errstate(divide="ignore", invalid="ignore"):
        speeds, values = _vertex(series.speeds[beside], sizes[orders, beside, places])
    inside = within(speeds, *speed_range)
    found = np.column_stack((orders, centers + 1, places))[inside]
    speeds, values = speeds[inside], values[inside]
    largest = np.zeros(len(series.names))
    finite = np.isfinite(values)
    np.maximum.at(largest, found[finite, 2], values[finite])
    shares = np.minimum(values / np.where(largest > 0.0, largest, 1.0)[found[:, 2]], 1.0)
    told: dict[int, float] = {}
    # What is worth a row first, the largest value first.
    for row in np.lexsort((-values, shares < LEAST_PEAK)).tolist():
        same = [
            one
            for one in told
            if found[one, 0] == found[row, 0]
            and abs(speeds[one] - speeds[row]) <= TOGETHER * speeds[row]
        ]
        told[(same or [row])[0]] = max(shares[row], told.get((same or [row])[0], 0.0))
    kept = {row: share for row, share in told.items() if share >= LEAST_PEAK}
    criticals = [
        ShaftCritical(
            float(series.orders[found[row, 0]]),
            float(speeds[row]),
            series.names[found[row, 2]],
            float(values[row]),
            *_mode(coupled, found[row, 0], found[row, 1], float(speeds[row])),
            float(share),
        )
        for row, share in kept.items()
    ]
    return tuple(sorted(criticals, key=lambda one: one.speed)), len(told) - len(kept)


def _vertex(speeds: FloatArray, sizes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return speed and size (m,) of maxima from three neighboring values (3, m), the middle one largest."""
    inverse = 1.0 / sizes**2
    before, after = speeds[0] - speeds[1], speeds[2] - speeds[1]
    left, right = (inverse[0] - inverse[1]) / before, (inverse[2] - inverse[1]) / after
    bend = (right - left) / (after - before)
    slope = left - bend * before
    shift = np.clip(np.where(bend > 0.0, -slope / (2.0 * bend), 0.0), before, after)
    lowest = inverse[1] + shift * (slope + bend * shift)
    known = np.isfinite(sizes[1]) & np.isfinite(shift) & (lowest > 0.0)
    return (
        speeds[1] + np.where(known, shift, 0.0),
        np.where(known, 1.0 / np.sqrt(np.where(known, lowest, 1.0)), sizes[1]),
    )


def _mode(
    coupled: CoupledResponse, order: int, index: int, speed: float
) -> tuple[int, float | None, float | None]:
    """Return number, frequency [Hz] and damping ratio of the mode at resonance."""
    system = coupled.tangential.system
    rigid, ratios = system.rigid.shape[1], system.damping_ratios()
    natural = system.natural[rigid:]
    moved = np.abs(np.sum([one.unknowns[order, index, rigid:] for one in coupled.parts], axis=0))
    share = float(coupled.orders[order]) * speed / natural
    with np.errstate(divide="ignore"):
        magnifiers = 1.0 / np.abs(1.0 - share**2 + 2j * ratios * share)
        highest = 0.5 / (ratios * np.sqrt(np.maximum(1.0 - ratios**2, 0.0)))
    own = (magnifiers >= BAND * highest) & (ratios < np.sqrt(0.5))
    if not np.any(own[: coupled.crankshaft.kept]):
        return 0, None, None
    best = int(np.argmax(np.where(own, moved, -1.0)[: coupled.crankshaft.kept]))
    return best + 1, float(natural[best] / (2.0 * np.pi)), float(ratios[best])
