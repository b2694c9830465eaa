"""Any quantity that vibrates by orders: motions, loads, stresses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.checks.angles import radians_of
from crankbase.checks.arrays import ComplexArray, FloatArray, checked_range
from crankbase.checks.scalars import whole_number, whole_within
from crankbase.drawing.curves import Curves
from crankbase.drawing.diagram_style import new_axes
from crankbase.drawing.legends import write_title
from crankbase.errors import InputError
from crankbase.library_types import Axes, Dataset
from crankbase.summaries import summarized
from crankbase.tables.frames import grid
from dynamics.indices import index_of_name
from dynamics.plots.coordinates import infinite_where_unbounded, name_axis, orders_and_speeds
from dynamics.plots.quantities import Quantity, QuantityDisplay, quantity_display
from dynamics.plots.speed_curves import MAIN_ORDERS, draw_over_speed, over_speed
from dynamics.response.drawn_limits import checked_barred, checked_limits
from dynamics.response.order_excitation import at_angles, checked_speed_index
from dynamics.response.synthesis import Synthesis, synthesis


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


@summarized("orders", "speeds [rad/s]", "amplitude", "names")
@dataclass(frozen=True, eq=False)
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

    orders: FloatArray
    speeds: FloatArray
    values: ComplexArray
    unbounded: NDArray[np.bool_]
    names: tuple[str, ...]

    @cached_property
    def amplitude(self) -> FloatArray:
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

    def at_angle(self, speed_index: int, *, shaft_angle_deg: ArrayLike) -> FloatArray:
        """Return the values over shaft angles, all orders together, without their mean.

        Parameters
        ----------
        speed_index : int
            Which of the speeds, from 0.
        shaft_angle_deg : array_like of shape (m,)
            [deg].

        Returns
        -------
        ndarray of shape (m, p)

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
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.
        place : int or str, optional
            The location, by number from 0 or name.
        quantity : {"twist", "displacement", "torque", "force", "stress"}, optional
            What the values are, for the unit of the axis; SI if it is not told.
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
        *,
        limits: Mapping[str, ArrayLike] | None = None,
        barred: Sequence[tuple[float, float]] = (),
        main_orders: int = MAIN_ORDERS,
        running: tuple[float, float] | None = None,
    ) -> Axes:
        """Draw one location as `plot` does, with its quantity's unit; `field` names the argument."""
        number = index_of_name(
            field, place, self.names, "the series", "one curve is that of one place"
        )
        stated = checked_limits(limits, len(self.speeds))
        why = "so many orders get a line of their own"
        count = whole_number("main_orders", main_orders, 0, why)
        curves = self.over_speed(
            number, quantity, limits=stated, barred=barred, main_orders=count, running=running
        )
        axes = new_axes(axes, height=4.4)
        draw_over_speed(axes, curves)
        write_title(axes, self.names[number], 10)
        return axes

    def over_speed(self, place: int, quantity: QuantityDisplay, **more: Any) -> Curves:
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
        return over_speed(
            self.speeds,
            self.orders,
            self.amplitude[:, :, place],
            both.amplitude[:, place],
            both.plain_sum[:, place],
            both.unbounded,
            quantity,
            **more,
        )

    def to_xarray(self, quantity: Quantity | None = None) -> Dataset:
        """Return complex ``values`` and ``unbounded`` over order, speed and location.

        Parameters
        ----------
        quantity : {"twist", "displacement", "torque", "force", "stress"}, optional
            What the values are, for the unit of the axis; SI if it is not told.

        Returns
        -------
        xarray.Dataset
            Units in the ``attrs["units"]`` of each array and coordinate.

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


def with_unbounded(values: FloatArray, unbounded: NDArray[np.bool_]) -> FloatArray:
    """Return values (K, S, ...) with inf where the response is unbounded (K, S)."""
    where = unbounded.reshape(unbounded.shape + (1,) * (values.ndim - unbounded.ndim))
    return np.where(where, np.inf, values)
