"""Diagrams of forced vibration: Campbell diagram, and amplitudes, loads, stresses over speed."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from crankbase.checks.arrays import finite_array
from numpy.typing import ArrayLike

from crankbase.drawing.diagram_style import figure
from crankfem.analyses.titles import add_title
from dynamics.plots.campbell import Meeting, draw_campbell
from dynamics.plots.quantities import Quantity
from dynamics.plots.speed_curves import MAIN_ORDERS
from dynamics.response.series import OrderSeries


def plot_response_campbell(
    path: Path,
    frequencies: ArrayLike,
    orders: ArrayLike,
    speed_range: tuple[float, float],
    found: Sequence[Meeting],
    *,
    title: str = "",
) -> None:
    """Plot natural frequencies and order lines over speed, with a dot at each resonance.

    Parameters
    ----------
    path : Path
        SVG file.
    frequencies : array_like of shape (n,)
        Natural frequencies of elastic modes [Hz]; those above the range of the orders are left out.
    orders : array_like of shape (K,)
        In cycles per crankshaft revolution.
    speed_range : tuple of two floats
        Running range [rad/s].
    found : sequence of Meeting
        Such as `Resonance`; dots grow with their severity.
    title : str, optional

    Raises
    ------
    InputError
        If the path is no SVG file in a folder that is there.
    """
    natural, lines = finite_array("frequencies", frequencies), finite_array("orders", orders)
    with figure(path, height=4.8) as axes:
        draw_campbell(axes, natural, lines, speed_range, found)
        add_title(axes, title)


def plot_over_speed(
    path: Path,
    series: OrderSeries,
    place: int | str,
    quantity: Quantity,
    *,
    limits: Mapping[str, ArrayLike] | None = None,
    barred: Sequence[tuple[float, float]] = (),
    main_orders: int = MAIN_ORDERS,
    title: str = "",
) -> None:
    """Plot one place's main orders, synthesis and plain sum over speed.

    Parameters
    ----------
    path : Path
        SVG file.
    series : OrderSeries
        Motion of nodes, loads or stresses of elements, at two speeds or more.
    place : int or str
        Which of them, by number from 0 or name.
    quantity : {"twist", "displacement", "torque", "force", "stress"}
        What the values are: it names the axis and gives the unit.
    limits : mapping of str to float or array_like of shape (S,), optional
        Limits by name, in SI, constant or over the speeds; inf where none is stated.
    barred : sequence of pairs of floats, optional
        Barred ranges of speed [rad/s], shaded.
    main_orders : int, optional
        How many orders, those with the largest peaks, get a line of their own.
    title : str, optional

    Raises
    ------
    InputError
        If the place or the quantity is unknown, or the path no SVG file in a folder that is there.
    """
    with figure(path, height=4.4) as axes:
        series.plot(
            axes,
            place,
            quantity=quantity,
            limits=limits,
            barred=barred,
            main_orders=main_orders,
        )
        add_title(axes, title)
