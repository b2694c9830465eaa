"""Separation of critical speeds from running speeds, and major critical speeds near the rated one."""

from collections.abc import Callable, Sequence
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, positive_vector
from crankbase.frames import Row
from crankbase.quantity import percent
from crankbase.results import Internal, Number, Quantity, Result, Speed, result
from crankbase.summaries import frozen
from dynamics.assessment.limits import checked_rated_speed, checked_running_range
from dynamics.assessment.uncertainty import Spread, frequency_bounds
from dynamics.chains.chain import Chain
from dynamics.critical import CriticalSpeed
from dynamics.indices import within
from dynamics.wording import at_speed, speed_range

# Share of the excitation's frequency by which a torsional natural frequency should differ from it: as
# recommended by API 617, quoted by Q. Wang, T. D. Feese, B. C. Pettinato, Torsional natural frequencies:
# measurement vs. prediction, 41st Turbomachinery Symposium, Houston 2012.
USUAL_MARGIN = 0.10


@result("mode", "order", "nominal", "low", "high", "margin", eq=True)
class CriticalRange(Result):
    """Possible range of the critical speed of one mode and order, and its distance from running speeds.

    Parameters
    ----------
    mode : int
        Elastic mode, from 1.
    order : float
        In cycles per crankshaft revolution.
    nominal, low, high : float
        Critical speed: nominal, and its least and largest possible value [rad/s].
    margin : float
        Distance of the nearest possible critical speed from the nearest running speed, as a share of
        the latter; 0 where they may coincide.
    nominal_margin : float
        The same for the nominal critical speed.
    """

    mode: int
    order: Number
    nominal: Annotated[float, Quantity("rad/s", exported="1/min", key="speed_rpm")]
    low: Speed
    high: Speed
    margin: Number
    nominal_margin: Internal[float]

    def kept(self, margin: float = USUAL_MARGIN) -> bool:
        """Return whether at least this margin is kept for all values within the ranges."""
        return self.margin >= margin

    @property
    def sentence(self) -> str:
        """For example "mode 1 with order 6: 1500 1/min (1450 to 1560 1/min), 12 % off running speeds"."""
        away = (
            f"{percent(self.margin, 3)} % off running speeds"
            if self.margin > 0.0
            else "may be met on running"
        )
        return (
            f"mode {self.mode} with order {self.order:g}: "
            f"{at_speed(self.nominal)} ({speed_range(self.low, self.high)}), {away}"
        )

    def row(self) -> Row:
        """Return the columns of a table of critical speeds, each value with its unit; see `table_of`."""
        return super().row() | {"nominal_margin": (self.nominal_margin, "1")}


def separation_margin(low: Array, high: Array, running_range: tuple[float, float]) -> Array:
    """Return the separation of critical speeds between two bounds from a running range.

    Parameters
    ----------
    low, high : ndarray of shape (m,)
        Least and largest possible critical speed [rad/s].
    running_range : tuple of two floats
        Lowest and highest running speed [rad/s].

    Returns
    -------
    ndarray of shape (m,)
        1 - high / lowest running speed below the range, low / highest running speed - 1 above it,
        0 where they overlap. At a given speed this is also the distance between natural frequency
        and excitation as a share of the latter.
    """
    first, last = running_range
    margins = np.maximum(1.0 - high / first, low / last - 1.0)
    return np.asarray(np.maximum(margins, 0.0))


def critical_ranges(
    chain: Chain,
    spreads: Sequence[Spread],
    orders: ArrayLike,
    running_range: tuple[float, float],
    *,
    within: float = 2.0 * USUAL_MARGIN,
    damped: Callable[[Chain, int, float], Sequence[float]] | None = None,
    others: Sequence[Chain] = (),
) -> tuple[CriticalRange, ...]:
    """Find the possible critical speeds near the speeds at which an engine runs.

    Parameters
    ----------
    spreads : sequence of Spread
        Uncertain values; none for the nominal critical speeds alone.
    orders : array_like of shape (K,)
        Of the excitation, in cycles per crankshaft revolution.
    running_range : tuple of two floats
        Lowest and highest running speed [rad/s].
    within : float
        Critical speeds with a larger margin are left out.
    damped : callable, optional
        Chain, mode (1 the lowest) and order to the critical speeds with damping over those without: one
        for each peak; empty where the order has no peak at the mode, which is then left out. It is called
        for the chain and for each of the others. By default undamped speeds are used.
    others : sequence of Chain, optional
        Other possible chains; see `frequency_bounds`.

    Returns
    -------
    tuple of CriticalRange
        Ascending by nominal speed, one for each peak.

    Raises
    ------
    InputError
        If orders are not above zero, the running range is reversed, or a node or element of a spread does
        not exist.

    Notes
    -----
    Without damping the bounds are exact: those of `frequency_bounds` over the order. With damping each
    chain has its own peaks, paired with the nominal ones where each is the other's nearest; a peak without
    a partner shifts with its mode's frequency alone. Each shifts with the spreads as the frequency does.
    """
    excited = positive_vector("orders", orders, "", "they count cycles per revolution")
    first, last = checked_running_range(running_range)
    modes = chain.modes()
    each = [(variant, *frequency_bounds(variant, spreads)) for variant in (chain, *others)]
    ranges = []
    for mode in range(modes.rigid, modes.frequencies.size):
        number = mode - modes.rigid + 1
        for order in excited.tolist():
            per_hertz = 2.0 * np.pi / order
            shifts = [
                (1.0,) if damped is None else damped(variant, number, order)
                for variant, _, _ in each
            ]
            for shift in shifts[0]:
                ends = []
                for (_, low, high), peaks in zip(each, shifts, strict=True):
                    # The peak that belongs to the nominal one, or that one's own shift if none does.
                    near = min(peaks, key=lambda peak: abs(peak - shift), default=shift)
                    mutual = min(shifts[0], key=lambda peak: abs(peak - near)) == shift
                    partner = near if mutual else shift
                    ends.append((partner * low[mode], partner * high[mode]))
                middle = per_hertz * shift * float(modes.frequencies[mode])
                least = per_hertz * float(min(low for low, _ in ends))
                most = per_hertz * float(max(high for _, high in ends))
                margin, nominal = separation_margin(
                    np.array([least, middle]), np.array([most, middle]), (first, last)
                ).tolist()
                if margin <= within:
                    ranges.append(
                        CriticalRange(number, order, middle, least, most, margin, nominal)
                    )
    return tuple(
        sorted(ranges, key=lambda critical: (critical.nominal, critical.mode, critical.order))
    )


MAJOR_SOURCE = "Korean Register, Rules for Steel Ships 2025, Part 5, Chapter 4, 204"
MAJOR_READING = "from the 2025 edition alone; no second source confirms it"
# Shares of the rated speed between which no major critical speed may lie, by what is driven.
CLEAR = {"propeller": (0.8, 1.1), "generator": (0.9, 1.1)}


@frozen("orders", "clear [rad/s]", "criticals", "passed")
class MajorCriticals:
    """Critical speeds of the orders that one class calls major, and the speeds they must avoid.

    Attributes
    ----------
    orders : tuple of float
    clear : tuple of two floats
        Speeds between which none may be [rad/s].
    criticals : tuple of CriticalSpeed
        Those within the range.
    """

    orders: tuple[float, ...]
    clear: tuple[float, float]
    criticals: tuple[CriticalSpeed, ...]

    @property
    def passed(self) -> bool:
        """Whether none is within the range."""
        return not self.criticals


def major_criticals(
    criticals: Sequence[CriticalSpeed],
    rated_speed: float,
    *,
    cylinders: int,
    strokes: int,
    drives: str = "propeller",
) -> MajorCriticals:
    """Find the major critical speeds that are too near to the rated speed.

    Parameters
    ----------
    criticals : sequence of CriticalSpeed
        Torsional, at least those up to 1.1 of the rated speed.
    rated_speed : float
        [rad/s].
    cylinders, strokes : int
        Of an engine in line.
    drives : {"propeller", "generator"}

    Notes
    -----
    With n cylinders in line the major orders are n / 2 and n of four-stroke engines and n of two-stroke
    engines. None of their critical speeds may be between 0.8 and 1.1 of the rated speed, 0.9 and 1.1 for
    generating sets (`MAJOR_SOURCE`).
    """
    rated = checked_rated_speed(rated_speed)
    share = CLEAR[drives]
    clear = (share[0] * rated, share[1] * rated)
    orders = (0.5 * cylinders, float(cylinders)) if strokes == 4 else (float(cylinders),)
    majors: Array = np.array(orders)
    near = tuple(
        critical
        for critical in criticals
        if np.any(np.isclose(critical.order, majors)) and within(critical.speed, *clear)
    )
    return MajorCriticals(orders, clear, near)
