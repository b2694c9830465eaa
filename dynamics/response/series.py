"""Any quantity that vibrates by orders, and the sum of its orders over the cycle."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cached_property, lru_cache
from math import gcd, lcm
from typing import Any, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.array_checks import (
    Array,
    ComplexArray,
    Flags,
    Integers,
    checked_range,
    radians_of,
    regular_array,
)
from crankbase.choices import check_kind, whole_number, whole_within
from crankbase.diagrams import Diagram, draw_diagram, legend_below, new_axes, write_title
from crankbase.errors import InputError, quoted
from crankbase.frames import Axes, Dataset, grid
from crankbase.results import result
from dynamics.indices import index_of_name
from dynamics.plots.curves import (
    LEGEND_COLUMNS,
    MAIN_ORDERS,
    OrdersOverSpeed,
    Quantity,
    QuantityDisplay,
    infinite_where_unbounded,
    name_axis,
    orders_and_speeds,
    over_speed,
    quantity_display,
)
from dynamics.response.order_excitation import at_angles, checked_speed_index


def checked_limits(limits: Mapping[str, ArrayLike] | None, speed_count: int) -> dict[str, Array]:
    """Return limits for a diagram over speeds, each with a value at every speed.

    Parameters
    ----------
    limits : mapping of str to float or array_like of shape (S,), or None
        In SI; inf where none is stated.
    speed_count : int
        S.
    """
    if limits is None:
        return {}
    check_kind("limits", limits, Mapping, "a mapping of names to limits")
    checked = {}
    for name, values in limits.items():
        field = f"limits[{name!r}]"
        array = np.array(regular_array(field, values, "iuf", "real numbers only"), dtype=float)
        if array.shape not in ((), (speed_count,)):
            raise InputError(
                f"{field}: given an array of shape {array.shape}; allowed is one number, or "
                f"{speed_count}, because a limit is constant or has a value at each speed."
            )
        if not np.all(array >= 0.0):
            worst = float(array[~(array >= 0.0)].flat[0])
            raise InputError(
                f"{field}: given {worst:g}; allowed are numbers of zero or more, inf where no limit is "
                "stated, because amplitudes are compared with it."
            )
        checked[str(name)] = np.array(np.broadcast_to(array, (speed_count,)))
    return checked


def checked_barred(barred: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return barred ranges of speed [rad/s]."""
    if isinstance(barred, str) or not isinstance(barred, Sequence | np.ndarray):
        raise InputError(
            f"barred: given {quoted(barred)}; allowed are pairs of speeds in rad/s, because each "
            "range is shaded."
        )
    reason = "a range from one to the other is shaded"
    return [
        checked_range(f"barred[{place}]", ends, "rad/s", reason)
        for place, ends in enumerate(barred)
    ]


# Largest denominator of an order: 1/2 in a four-stroke engine, teeth of a gear behind it.
LARGEST_DENOMINATOR = 1000
# Orders count as fractions within this share.
SAME_ORDER = 1e-9
# Most cycles of the highest order in one period of the sum.
MOST_CYCLES = 20_000
# Samples to each cycle of the highest order.
SAMPLES_PER_CYCLE = 8
# Newton steps from a sample to the peak beside it, each within one step of the samples.
NEWTON_STEPS = 6
# A step of less than this share of the samples' changes no digit of a peak.
SETTLED = 1e-7
# Peaks of a sum whose amplitudes add up to one are the same within this.
SAME_PEAK = 1e-9
# Values sampled at once; bounds the memory and stays near the processor.
BATCH = 2**19


@result("speeds [rad/s]", "amplitude", "plain_sum", "period [rad]")
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

    speeds: Array
    amplitude: Array
    highest: Array
    lowest: Array
    plain_sum: Array
    unbounded: Flags
    period: float


def synthesis(
    orders: Array,
    speeds: Array,
    phasors: ComplexArray,
    unbounded: Flags | None = None,
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

    Notes
    -----
    A sum of orders up to N times the lowest common one is a trigonometric polynomial of degree N.
    From m > 2 N even samples its largest absolute value is known within the factor cos(pi N / m)
    (Ehlich, Zeller, Mathematische Zeitschrift 86, 1964, 41-44). After subtracting the middle of the extreme
    samples, the same holds for half the distance of the extremes, as no other constant gives a
    smaller largest value than the true middle: the error of the sampled amplitude is below
    1 - cos(pi N / m), 8 % with the 8 samples to a cycle of the highest order used here. Every
    sample that may be next to the true extreme is then followed to the peak by Newton's method,
    which leaves only round-off.
    """
    multiples, common = common_order(orders)
    count, places = orders.size, phasors.shape[1:]
    flat = phasors.reshape(count, -1)
    degree = int(multiples[-1])
    size = 2 ** int(np.ceil(np.log2(SAMPLES_PER_CYCLE * degree)))
    highest, lowest = extremes = np.empty((2, flat.shape[1]))
    step = max(1, BATCH // size)
    for start in range(0, flat.shape[1], step):
        part = slice(start, start + step)
        # Scaled, so that neither vibrations of 1e-300 nor of 1e300 leave the range of numbers.
        scale = np.sum(np.abs(flat[:, part]), axis=0)
        unit = flat[:, part] / np.where(scale > 0.0, scale, 1.0)
        spectrum = np.zeros((unit.shape[1], size // 2 + 1), dtype=np.complex128)
        spectrum[:, multiples] = 0.5 * size * unit.T
        samples = np.fft.irfft(spectrum, n=size, axis=1)
        extremes[:, part] = scale * _extremes(multiples, unit, samples)[0]
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


def common_order(orders: Array) -> tuple[Integers, float]:
    """Find the highest order of which all are integer multiples.

    Returns
    -------
    multiples : ndarray of shape (K,), int
    common : float
        The vibration repeats after 1/common revolutions.
    """
    multiples, common = _common_order(tuple(orders.tolist()))
    return multiples.copy(), common


@lru_cache(maxsize=8)
def _common_order(orders: tuple[float, ...]) -> tuple[Integers, float]:
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


def extreme_angles(orders: Array, phasors: ComplexArray) -> tuple[float, float]:
    """Return the shaft angles [rad] at which the sum of the orders (K,) is highest and lowest."""
    multiples, common = common_order(orders)
    size = 2 ** int(np.ceil(np.log2(SAMPLES_PER_CYCLE * int(multiples[-1]))))
    spectrum = np.zeros(size // 2 + 1, dtype=np.complex128)
    scale = float(np.sum(np.abs(phasors))) or 1.0
    spectrum[multiples] = 0.5 * size * phasors / scale
    samples = np.fft.irfft(spectrum, n=size)[np.newaxis]
    unit = phasors[:, np.newaxis] / scale
    highest, lowest = (_extremes(multiples, unit, samples)[1][:, 0] / common).tolist()
    return highest, lowest


def _extremes(multiples: Integers, phasors: ComplexArray, samples: Array) -> tuple[Array, Array]:
    """Return the highest and the lowest value of each sum (2, p) and their first angles (2, p).

    The amplitudes of each sum, from phasors (K, p) and samples (p, m), add up to one.

    A true peak, measured from the middle of the extremes, exceeds an adjacent sample by a
    factor of at most 1/cos(pi N / m): samples further from the extreme one are skipped.
    """
    sums, size = samples.shape
    top, bottom = np.max(samples, axis=1), np.min(samples, axis=1)
    half = 0.5 * (top - bottom)
    margin = 2.0 * half * (1.0 / np.cos(np.pi * multiples[-1] / size) - 1.0)
    # Of the flat array: several times as fast as of rows and columns.
    above = np.flatnonzero(samples >= (top - margin)[:, np.newaxis])
    below = np.flatnonzero(samples <= (bottom + margin)[:, np.newaxis])
    row, column = np.divmod(np.concatenate((above, below)), size)
    # A lowest value is the highest one of the sum with the other sign.
    sign = np.repeat([1.0, -1.0], [above.size, below.size])
    heights = sign * samples[row, column]
    # A sum that is zero throughout has no peaks.
    summit = (
        (heights >= sign * samples[row, column - 1])
        & (heights >= sign * samples[row, (column + 1) % size])
        & (half[row] > 0.0)
    )
    row, column, sign, peaks = row[summit], column[summit], sign[summit], heights[summit]
    place = np.where(sign > 0.0, row, sums + row)
    step = 2.0 * np.pi / size
    start = step * column
    angle = start.copy()
    waves = sign * np.take(phasors, row, axis=1)
    # Value, slope and bend of a sum are the real, imaginary and real part of its moments.
    powers = multiples.astype(np.complex128) ** np.arange(3)[:, np.newaxis]
    rises = np.unique(np.diff(multiples, prepend=0), return_inverse=True)
    for _ in range(NEWTON_STEPS + 1):
        value, slope, bend = powers @ (waves * _turned(*rises, angle))
        peaks = np.maximum(peaks, value.real)
        move = np.divide(-slope.imag, bend.real, out=np.zeros_like(angle), where=bend.real > 0.0)
        before = angle
        angle = np.clip(angle + move, start - step, start + step)
        if np.all(np.abs(angle - before) <= SETTLED * step):
            break
    extremes = np.concatenate((top, -bottom))
    angles = np.zeros(2 * sums)
    np.maximum.at(extremes, place, peaks)
    equal = np.flatnonzero(peaks >= extremes[place] - SAME_PEAK)
    # So that the first of equal peaks is the one that stays.
    backwards = equal[np.argsort(-angle[equal])]
    angles[place[backwards]] = angle[backwards]
    return np.multiply([[1.0], [-1.0]], extremes.reshape(2, sums)), angles.reshape(2, sums)


def _turned(rises: Integers, which: NDArray[np.intp], angle: Array) -> ComplexArray:
    """Return exp(i k phi) at angles phi (p,) for k ascending from 0 by some of the rises, (K, p)."""
    factors = np.exp(1j * np.outer(rises, angle))
    turned = np.empty((which.size, angle.size), dtype=np.complex128)
    turned[0] = factors[which[0]]
    for row in range(1, which.size):
        np.multiply(turned[row - 1], factors[which[row]], out=turned[row])
    return turned


class DrawnBeside(TypedDict, total=False):
    """Additional contents of a diagram of orders over the speed.

    Parameters
    ----------
    limits : mapping of str to float or array_like of shape (S,), optional
        Limits by name, in SI, constant or over the speeds; inf where none is stated.
    barred : sequence of pairs of floats, optional
        Ranges of speed [rad/s], shaded.
    main_orders : int, optional
        Number of orders, those with the largest peaks, with a curve of their own.
    running : tuple of two floats, optional
        Lowest and highest running speed [rad/s]: speeds outside are shaded, and determine neither these
        orders nor the height.
    """

    limits: Mapping[str, ArrayLike] | None
    barred: Sequence[tuple[float, float]]
    main_orders: int
    running: tuple[float, float] | None


@result("orders", "speeds [rad/s]", "amplitude", "names")
class OrderSeries:
    """Values by order, speed and location: y = Re sum_k Y_k exp(i k phi) at the shaft angle phi.

    Parameters
    ----------
    orders : ndarray of shape (K,)
        In cycles per crankshaft revolution.
    speeds : ndarray of shape (S,)
        [rad/s].
    values : ndarray of shape (K, S, p), complex
        Zero where unbounded, so that sums stay finite.
    unbounded : ndarray of shape (K, S), bool
        Where there is no steady vibration.
    names : tuple of p str
        Names of the locations.
    """

    orders: Array
    speeds: Array
    values: ComplexArray
    unbounded: Flags
    names: tuple[str, ...]

    @cached_property
    def amplitude(self) -> Array:
        """Amplitude by order, speed and location, (K, S, p); inf where unbounded."""
        return with_unbounded(np.abs(self.values), self.unbounded)

    @cached_property
    def synthesis(self) -> Synthesis:
        """Sum of all orders over the cycle, and the plain sum of amplitudes, (S, p) each."""
        return synthesis(self.orders, self.speeds, self.values, self.unbounded)

    @property
    def largest_place(self) -> int:
        """Index of the location with the largest amplitude of all orders together, from 0."""
        return int(np.argmax(np.max(self.synthesis.amplitude, axis=0)))

    def at_angle(self, speed_index: int, *, shaft_angle_deg: ArrayLike) -> Array:
        """Return the values over shaft angles, all orders together, without their mean, (m, p).

        Parameters
        ----------
        speed_index : int
            Which of the speeds, from 0.
        shaft_angle_deg : array_like of shape (m,)
            [deg].

        Raises
        ------
        InputError
            If there is no such speed, an angle is not finite, or the vibration is unbounded there.
        """
        place = checked_speed_index(speed_index, self.speeds)
        angles = radians_of("shaft_angle_deg", shaft_angle_deg, vector=True)
        if np.any(self.unbounded[:, place]):
            order = self.orders[np.flatnonzero(self.unbounded[:, place])[0]]
            raise InputError(
                f"speed_index: given {place}, where order {order:g} excites an undamped mode at its "
                "own frequency; allowed are speeds with a steady vibration, because this one grows "
                "without bounds."
            )
        return at_angles(self.orders, self.values[:, place], angles)

    def plot(
        self,
        axes: Axes | None = None,
        place: int | str = 0,
        *,
        quantity: Quantity | None = None,
        **drawn: Unpack[DrawnBeside],
    ) -> Axes:
        """Draw one location's main orders, their synthesis and their plain sum over the speed.

        Parameters
        ----------
        place : int or str, optional
            The location, by number from 0 or name.
        quantity
            As for `quantity_display`.
        **drawn
            As `DrawnBeside` says: limits, barred, main_orders.

        Returns
        -------
        matplotlib.axes.Axes
            Curves have gaps where the vibration is unbounded, with a vertical line there.

        Raises
        ------
        InputError
            If the location or the quantity is unknown, or a limit, range or number is invalid.
        """
        return self.draw(axes, place, quantity_display(quantity, "SI"), **drawn)

    def draw(
        self,
        axes: Axes | None,
        place: int | str,
        quantity: QuantityDisplay,
        field: str = "place",
        **drawn: Unpack[DrawnBeside],
    ) -> Axes:
        """Draw one location as `plot` does, with its quantity's unit; `field` names the argument."""
        number = index_of_name(
            field, place, self.names, "the series", "one curve is that of one place"
        )
        drawn["limits"] = checked_limits(drawn.get("limits"), len(self.speeds))
        why = "so many orders get a line of their own"
        drawn["main_orders"] = whole_number(
            "main_orders", drawn.get("main_orders", MAIN_ORDERS), 0, why
        )
        curves = self.over_speed(number, quantity, **drawn)
        axes = new_axes(axes, height=4.4)
        draw_diagram(axes, curves)
        legend_below(axes, LEGEND_COLUMNS)
        write_title(axes, self.names[number], 10)
        return axes

    def over_speed(self, place: int, quantity: QuantityDisplay, **more: Any) -> Diagram:
        """Describe the diagram of `plot` for a location, from 0; further arguments as for `over_speed`.

        Raises
        ------
        InputError
            If there is no such location, or a range of speeds is none.
        """
        more["barred"] = checked_barred(more.get("barred", ()))
        if more.get("running") is not None:
            why = "speeds outside are shaded"
            more["running"] = checked_range("running", more["running"], "rad/s", why)
        why = "one curve is that of one place"
        place = whole_within("place", place, 0, self.amplitude.shape[2] - 1, why)
        both = self.synthesis
        amplitudes = OrdersOverSpeed(
            self.speeds,
            self.orders,
            self.amplitude[:, :, place],
            both.amplitude[:, place],
            both.plain_sum[:, place],
            both.unbounded,
        )
        return over_speed(amplitudes, quantity, **more)

    def to_xarray(self, quantity: Quantity | None = None) -> Dataset:
        """Return complex ``values`` and ``unbounded`` over order, speed and location.

        `quantity`, for the unit of the axis, is that of `quantity_display`.

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
            Values are infinite where the vibration is unbounded.
        """
        unit = quantity_display(quantity, "SI").unit
        return grid(
            {
                "values": (
                    ("order", "speed", "place"),
                    infinite_where_unbounded(self.values, self.unbounded),
                    unit,
                    "phasor by order",
                ),
                "unbounded": (("order", "speed"), self.unbounded, "1", "no steady vibration"),
            },
            {
                **orders_and_speeds(self.orders, self.speeds),
                "place": name_axis(self.names, "place"),
            },
        )


def with_unbounded(values: Array, unbounded: Flags) -> Array:
    """Return values (K, S, ...) with inf where the response is unbounded (K, S)."""
    where = unbounded.reshape(unbounded.shape + (1,) * (values.ndim - unbounded.ndim))
    return np.where(where, np.inf, values)
