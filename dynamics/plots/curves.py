"""Curves over an angle, over time and over the speed; names and units of what vibrates."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, ComplexArray, Flags, finite_array
from crankbase.choices import check_choice
from crankbase.diagrams import (
    BLUE,
    COLORS,
    GRAY,
    ORANGE,
    Band,
    Diagram,
    Mark,
    Series,
    curve_diagram,
    draw_diagram,
    legend_above,
    legend_inside,
    new_axes,
    with_gaps,
    write_title,
)
from crankbase.errors import InputError
from crankbase.frames import Axes
from crankbase.quantity import RPM, UNITS, VIBRATING, factor_of, unit_symbol
from dynamics.indices import within

Coordinate: TypeAlias = tuple[Any, str, str]


def orders_and_speeds(orders: Array, speeds: Array) -> dict[str, Coordinate]:
    """Return the coordinates "order" and "speed"."""
    return {
        "order": (orders, "1", "order, in cycles per crankshaft revolution"),
        "speed": (speeds, "rad/s", "crankshaft speed"),
    }


def angle_axis(angles: Array) -> Coordinate:
    """Return the coordinate of shaft angles [deg]."""
    return angles, "deg", "shaft angle"


def time_axis(time: Array) -> Coordinate:
    """Return the coordinate of the time [s]."""
    return time, "s", "time"


def name_axis(names: Sequence[str], words: str) -> Coordinate:
    """Return a coordinate of names."""
    return np.array(list(names), dtype=str), "", words


def number_axis(count: int, words: str) -> Coordinate:
    """Return a coordinate of numbers from 1."""
    return np.arange(1, count + 1), "1", words


def infinite_where_unbounded(values: ComplexArray, unbounded: Flags) -> ComplexArray:
    """Return phasors (K, S, ...), infinite where the response is unbounded (K, S)."""
    where = unbounded.reshape(unbounded.shape + (1,) * (values.ndim - unbounded.ndim))
    return np.where(where, complex(np.inf), values)


# What values in SI are multiplied by to be shown in thousands, thousandths and so on.
KILO, MEGA, MILLI = factor_of("kN"), factor_of("MPa"), factor_of("mm")
SPEED_LABEL = "crankshaft speed [1/min]"

Quantity: TypeAlias = Literal["twist", "displacement", "torque", "force", "stress"]


def _labelled(quantity: str, words: str) -> tuple[str, float]:
    unit = VIBRATING[quantity]
    return f"{words} [{unit_symbol(unit)}]", factor_of(unit)


# Label of the axis, and what a value in SI is multiplied by.
QUANTITIES: dict[str, tuple[str, float]] = {
    **{name: _labelled(name, "amplitude") for name in ("twist", "displacement")},
    **{name: _labelled(name, f"alternating {name}") for name in ("torque", "force", "stress")},
}
SI_UNITS: dict[str, str] = {quantity: UNITS[unit][0] for quantity, unit in VIBRATING.items()}


class QuantityDisplay(NamedTuple):
    """Display of a quantity in diagrams.

    Parameters
    ----------
    label : str
        Of the axis, with its unit.
    factor : float
        Factor from SI to the displayed unit.
    unit : str
        The unit in SI.
    """

    label: str
    factor: float
    unit: str


def quantity_display(
    quantity: Quantity | None, either: str, words: str = "amplitude"
) -> QuantityDisplay:
    """Return the display of a quantity in diagrams.

    Parameters
    ----------
    quantity : {"twist", "displacement", "torque", "force", "stress"}, optional
        Quantity of the values; a chain may be torsional or axial and does not determine it.
    either : str
        SI unit if the quantity is None, such as "rad or m".
    words : str, optional
        Label of the axis in this case.

    Examples
    --------
    >>> quantity_display("twist", "rad or m").label, quantity_display(None, "rad or m").label
    ('amplitude [mrad]', 'amplitude [rad or m]')
    """
    if quantity is None:
        return QuantityDisplay(f"{words} [{either}]", 1.0, either)
    check_choice("quantity", quantity, QUANTITIES, "the axis has the unit of one of them")
    return QuantityDisplay(*QUANTITIES[quantity], SI_UNITS[quantity])


# Of what is drawn as it moves, not by its amplitude.
MOVING: dict[str, tuple[str, float]] = {
    quantity: _labelled(quantity, quantity)
    for quantity in ("twist", "displacement", "torque", "force")
}


def in_unit(unit: str) -> QuantityDisplay:
    """Return the display of amplitudes in an SI unit.

    Examples
    --------
    >>> in_unit("Pa").label
    'alternating stress [MPa]'
    """
    for quantity, si_unit in SI_UNITS.items():
        if si_unit == unit:
            return QuantityDisplay(*QUANTITIES[quantity], unit)
    return QuantityDisplay(f"amplitude [{unit}]", 1.0, unit)


# Ticks stand this far apart over a turn, over a cycle of two, and over longer spans [deg].
TICKS = ((360.0, 60.0), (720.0, 90.0))
LINE = 1.4
# Room for the round-off of an angle.
SAME = 1.0 + 1e-9
FROM_TOP = "crank angle from the top [deg]"


def from_top(strokes: int) -> str:
    """Label crank angles from a cylinder's top: of two in a cycle of four strokes the firing one."""
    return FROM_TOP if strokes == 2 else "crank angle from the firing top [deg]"


def draw_over_angle(
    axes: Axes | None,
    angles: Array,
    curves: Mapping[str, Array],
    label: str,
    *,
    angle_label: str = "shaft angle [deg]",
    cyclic: bool = True,
    colors: Sequence[Any] = COLORS,
) -> Axes:
    """Draw curves over an angle, with gaps where values are not finite.

    Parameters
    ----------
    axes : matplotlib.axes.Axes or None
        Those of a new figure if None.
    angles : ndarray of shape (m,)
        Ascending [rad].
    curves : mapping of str to ndarray of shape (m,)
        In the unit of the axis.
    label, angle_label : str
        Of the axes, with their units.
    cyclic : bool, optional
        Whether the even angles are a cycle without its closing sample, which is added.
    colors : sequence of colors, optional
        Of the curves in turn.
    """
    degrees = np.degrees(angles)
    if cyclic:
        degrees = np.append(degrees, 2.0 * degrees[-1] - degrees[-2])
        curves = {name: np.append(values, values[0]) for name, values in curves.items()}
    axes = new_axes(axes)
    _draw_curves(axes, degrees, curves, label, colors)
    first, last = float(degrees[0]), float(degrees[-1])
    step = next((step for longest, step in TICKS if last - first <= SAME * longest), None)
    if step is not None and last - first > step:
        axes.set_xticks(np.arange(np.floor(first / step) * step, last + step, step))
    if last > first:
        axes.set_xlim(first, last)
    axes.set_xlabel(angle_label)
    return axes


def draw_over_time(axes: Axes | None, time: Array, curves: Mapping[str, Array], label: str) -> Axes:
    """Draw curves over the time [s], with gaps where values are not finite. See `draw_over_angle`."""
    axes = new_axes(axes)
    _draw_curves(axes, time, curves, label, COLORS)
    if time[-1] > time[0]:
        axes.set_xlim(time[0], time[-1])
    axes.set_xlabel("time [s]")
    return axes


def _draw_curves(
    axes: Axes,
    along: Array,
    curves: Mapping[str, Array],
    label: str,
    colors: Sequence[Any],
) -> None:
    for place, (name, values) in enumerate(curves.items()):
        color = colors[place % len(colors)]
        axes.plot(along, with_gaps(values), color=color, linewidth=LINE, label=name)
    axes.set_ylabel(label)
    if len(curves) > 1:
        legend_inside(axes)


# Columns of the band between extremes: more cannot be told apart in print.
COLUMNS = 600


class SelectedCurve(NamedTuple):
    """The motion of a node or the load of an element over time or angle, for a diagram.

    Parameters
    ----------
    values : ndarray of shape (m,)
        In the unit of the axis.
    number : int
        Of the element or node.
    name : str
        Of the element or node.
    label : str
        Of the axis, with its unit.
    factor : float
        Factor from SI to the unit of the axis.
    of_element : bool
        Whether it is the load of an element.
    """

    values: Array
    number: int
    name: str
    label: str
    factor: float
    of_element: bool


def plot_run(
    axes: Axes | None,
    time: Array,
    speed: Array,
    curve: SelectedCurve,
    windows: tuple[Array, Array, int],
    steady: tuple[ArrayLike, ArrayLike] | None,
) -> Axes:
    """Draw the motion or load of one element or node over time, on new axes by default.

    Parameters
    ----------
    time, speed : ndarray of shape (m,)
        [s, rad/s]
    windows : (times [s], amplitudes in SI, turns)
        Amplitudes within windows of so many turns of the shaft.
    steady : (speeds [rad/s], amplitudes in SI) or None
        At constant speeds, ascending, drawn where the run passes these speeds.
    """
    if steady is not None and (not isinstance(steady, tuple | list) or len(steady) != 2):
        raise InputError(
            f"steady: given {steady!r}; allowed is a pair of speeds and amplitudes, because these are drawn "
            "over the speeds of the run."
        )
    known = [finite_array("steady", values) for values in steady or ()]
    if known and (
        known[0].ndim != 1 or known[0].shape != known[1].shape or np.any(np.diff(known[0]) <= 0.0)
    ):
        raise InputError(
            f"steady: given arrays of shapes {known[0].shape} and {known[1].shape}; allowed are ascending "
            "speeds and an amplitude for each, because they are drawn over the speeds of the run."
        )
    axes = new_axes(axes)
    # The extremes in columns, few enough for a small file.
    columns = min(COLUMNS, time.size)
    starts = np.unique(np.linspace(0, time.size, columns, endpoint=False).astype(int))
    low, high = np.minimum.reduceat(curve.values, starts), np.maximum.reduceat(curve.values, starts)
    label = "extremes"
    axes.fill_between(time[starts], low, high, color=BLUE, alpha=0.3, linewidth=0.0, label=label)
    middles, amplitude, turns = windows
    label = f"amplitude over {'each turn' if turns == 1 else f'{turns} turns'}"
    axes.plot(middles, curve.factor * amplitude, color=BLUE, linewidth=1.6, label=label)
    if known:
        # Not a number outside of what is known: a gap.
        steadily = curve.factor * np.interp(speed, known[0], known[1], left=np.nan, right=np.nan)
        label = "steady amplitude at this speed"
        axes.plot(time, steadily, color=ORANGE, linestyle="--", linewidth=1.3, label=label)
    axes.set_xlim(time[0], time[-1])
    axes.set_xlabel("time [s]")
    axes.set_ylabel(curve.label)
    write_title(axes, curve.name, 9)
    legend_above(axes)
    return axes


def draw_speed(axes: Axes, time: Array, speed: Array) -> None:
    """Draw the speed [rad/s] over the time [s]."""
    places = np.linspace(0, time.size - 1, COLUMNS).astype(int)
    axes.plot(time[places], speed[places] * RPM, color=GRAY, linewidth=1.6)
    axes.set_ylabel("speed [1/min]")
    axes.set_xlabel("time [s]")
    axes.set_xlim(time[0], time[-1])


BARRED, OUTSIDE = "#f6dcd9", "#ececec"
PLAIN_SUM = "plain sum"  # of amplitudes, in a legend
# Orders that get a line of their own in a diagram over speed.
MAIN_ORDERS = 5
# Height of a diagram with unbounded speeds in medians of the plain sum.
BESIDE_UNBOUNDED = 4.0
HEADROOM = 1.08
LEGEND_COLUMNS = 4


def main_orders_of(amplitudes: Array, count: int) -> list[int]:
    """Return which orders have the largest peaks over the speeds, in ascending order.

    Parameters
    ----------
    amplitudes : ndarray of shape (K, S)
        Values that are not finite are ignored.
    count : int
        Largest number of orders.
    """
    peaks = np.max(np.where(np.isfinite(amplitudes), amplitudes, 0.0), axis=1, initial=0.0)
    return [int(place) for place in np.sort(np.argsort(peaks)[::-1][: max(0, count)])]


def order_series(
    orders: Array, amplitudes: Array, count: int, counted: Flags | None = None
) -> list[Series]:
    """Return all orders; those that are not main ones are hidden at first.

    Parameters
    ----------
    orders : ndarray of shape (K,)
    amplitudes : ndarray of shape (K, S)
        In the unit of the axis; gaps where not finite.
    count : int
        Number of main orders: those with the largest peaks.
    counted : ndarray of shape (S,), bool, optional
        Speeds whose peaks count; all by default.
    """
    main = main_orders_of(amplitudes if counted is None else amplitudes[:, counted], count)
    others = [place for place in range(len(orders)) if place not in main]
    # Those that are seen first have the colors first.
    ranks = {place: rank for rank, place in enumerate([*main, *others])}
    return [
        Series(
            f"order {order:g}", with_gaps(amplitudes[place]), "order", ranks[place], place in main
        )
        for place, order in enumerate(orders.tolist())
    ]


def barred_bands(barred: Sequence[tuple[float, float]]) -> tuple[Band, ...]:
    """Return ranges of speed to be barred [rad/s] as shaded areas."""
    return tuple(Band(low * RPM, high * RPM, BARRED, "to be barred") for low, high in barred)


def outside_bands(speeds: Array, running: tuple[float, float] | None) -> tuple[Band, ...]:
    """Return the speeds outside the running range [rad/s], if one is given, as shaded areas."""
    if running is None or speeds.size < 2:
        return ()
    ends = ((speeds[0], running[0]), (running[1], speeds[-1]))
    return tuple(
        Band(float(low) * RPM, float(high) * RPM, OUTSIDE, "outside the running range")
        for low, high in ends
        if low < high
    )


class OrdersOverSpeed(NamedTuple):
    """Amplitudes of one location over the speed.

    Attributes
    ----------
    speeds : ndarray of shape (S,)
        [rad/s]
    orders : ndarray of shape (K,)
    by_order : ndarray of shape (K, S)
        Amplitudes in SI; inf where unbounded.
    total, plain : ndarray of shape (S,)
        Of all orders together, and the sum of their amplitudes, in SI.
    unbounded : ndarray of shape (S,), bool
    """

    speeds: Array
    orders: Array
    by_order: Array
    total: Array
    plain: Array
    unbounded: Flags


def over_speed(
    amplitudes: OrdersOverSpeed,
    quantity: QuantityDisplay,
    *,
    limits: Mapping[str, ArrayLike] | None = None,
    passing: Mapping[str, ArrayLike] | None = None,
    barred: Sequence[tuple[float, float]] = (),
    main_orders: int = MAIN_ORDERS,
    running: tuple[float, float] | None = None,
) -> Diagram:
    """Describe orders, synthesis and plain sum of one location over the speed, with limits.

    Parameters
    ----------
    limits, passing : mapping of str to float or array_like of shape (S,), optional
        In SI; inf where none is stated. The latter, for passing a range, are not main curves.
    barred : sequence of pairs of floats, optional
        Ranges of speed [rad/s], shaded.
    main_orders : int, optional
        Number of main orders, those with the largest peaks.
    running : tuple of two floats, optional
        Lowest and highest running speed [rad/s]: speeds outside are shaded, and determine neither the main
        orders nor the height.
    """
    speeds, orders, by_order, total, plain, unbounded = amplitudes
    inside = np.ones(speeds.shape, dtype=bool) if running is None else within(speeds, *running)
    rpm, factor = speeds * RPM, quantity.factor
    plain_sum = with_gaps(factor * plain)
    series = [
        Series(
            name,
            with_gaps(factor * np.broadcast_to(np.asarray(limit, dtype=float), rpm.shape)),
            "limit",
            number,
            main,
        )
        for some, main in ((limits, True), (passing, False))
        for number, (name, limit) in enumerate((some or {}).items())
    ]
    finite = plain_sum[inside & ~unbounded]
    highest = float(np.max(finite, initial=0.0))
    if np.any(inside & unbounded):
        # Beside what has no bounds all else would be flat: let the curves leave at the top.
        highest = min(highest, BESIDE_UNBOUNDED * float(np.median(finite)) if finite.size else 0.0)
    highest = max(
        [highest, *(float(np.nanmax(curve.values, initial=0.0)) for curve in series if curve.main)]
    )
    return curve_diagram(
        x=rpm,
        series=(
            *order_series(orders, factor * by_order, main_orders, inside),
            Series("all orders (synthesis)", with_gaps(factor * total), "total"),
            Series(PLAIN_SUM, plain_sum, "plain sum"),
            *series,
        ),
        x_label=SPEED_LABEL,
        y_label=quantity.label,
        top=HEADROOM * highest if highest > 0.0 else 1.0,
        bands=(*outside_bands(speeds, running), *barred_bands(barred)),
        marks=tuple(Mark(speed, "unbounded") for speed in rpm[unbounded].tolist()),
    )


def draw_named_curves(
    axes: Axes | None,
    speeds: Array,
    curves: Mapping[str, Array],
    label: str,
    *,
    title: str = "",
    dashed: bool = False,
) -> Axes:
    """Draw curves over the speed, with gaps where values are not finite.

    Parameters
    ----------
    axes : matplotlib.axes.Axes or None
        Those of a new figure if None.
    speeds : ndarray of shape (S,)
        [rad/s]
    curves : mapping of str to ndarray of shape (S,)
        In the unit of the axis, none below zero.
    label : str
        Of the upright axis, with its unit.
    dashed : bool, optional
        Whether all but the first are.
    """
    axes = new_axes(axes, height=3.8)
    series = tuple(
        Series(
            name,
            with_gaps(np.asarray(values, dtype=np.float64)),
            color=COLORS[place % len(COLORS)],
            dash="dash" if dashed and place else "solid",
        )
        for place, (name, values) in enumerate(curves.items())
    )
    draw_diagram(axes, curve_diagram(speeds * RPM, series, SPEED_LABEL, label))
    if title:
        write_title(axes, title)
    legend_inside(axes)
    return axes


def set_speed_axis(axes: Axes, speeds: Array) -> None:
    """Label the axis of the speed and end it with the speeds [rad/s], if there are several."""
    axes.set_xlabel(SPEED_LABEL)
    if len(speeds) > 1:
        axes.set_xlim(speeds[0] * RPM, speeds[-1] * RPM)
