"""Curves over one axis: one description for paper here and for the screen."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.diagram_style import BLUE, GRAY, GREEN, ORANGE, RED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
Role: TypeAlias = Literal["total", "plain sum", "limit", "order", "curve"]
Dash: TypeAlias = Literal["solid", "dash", "dot", "dashdot"]

ALL_ORDERS = "#1c2733"
# Red is that of limits.
ORDER_COLORS = (BLUE, ORANGE, GREEN, "#7a5ba6", "#2a9d9d", "#8c6d1f")
# A second round of colors has other dashes, so that each curve has a look of its own.
DASHES: tuple[Dash, ...] = ("solid", "dash", "dot", "dashdot")
LIMIT_DASHES: tuple[Dash, ...] = ("dash", "dashdot")
ON_PAPER = {"solid": "-", "dash": "--", "dot": ":", "dashdot": "-."}


class LineStyle(NamedTuple):
    """Color, dashes, and width of a line [points]."""

    color: str
    dash: Dash
    width: float


def order_line_style(number: int) -> LineStyle:
    """Return the line style of one of many curves, from 0."""
    rounds, place = divmod(number, len(ORDER_COLORS))
    return LineStyle(ORDER_COLORS[place], DASHES[rounds % len(DASHES)], 1.1)


@dataclass(frozen=True, eq=False)
class Series:
    """One curve.

    Attributes
    ----------
    name : str
        In the legend.
    values : (m,) array
        In the unit of the axis; NaN leaves a gap.
    role : {"total", "plain sum", "limit", "order", "curve"}
        Its role, which determines its style.
    number : int
        From 0 among those of its role.
    main : bool
        Others are left out on paper, and hidden at first on a screen.
    color, dash : str
        Of a curve that has a role nowhere else.
    """

    name: str
    values: Array
    role: Role = "curve"
    number: int = 0
    main: bool = True
    color: str = ""
    dash: Dash = "solid"

    @property
    def line_style(self) -> LineStyle:
        """Color, dashes and width."""
        if self.role == "total":
            return LineStyle(ALL_ORDERS, "solid", 2.0)
        if self.role == "plain sum":
            return LineStyle(GRAY, "dot", 1.1)
        if self.role == "limit":
            return LineStyle(RED, LIMIT_DASHES[self.number % len(LIMIT_DASHES)], 1.4)
        if self.role == "order":
            return order_line_style(self.number)
        return LineStyle(self.color or order_line_style(self.number).color, self.dash, 1.5)


class Band(NamedTuple):
    """A shaded range of the horizontal axis."""

    low: float
    high: float
    color: str
    name: str


class Dots(NamedTuple):
    """Single points, such as those of a table."""

    x: Array
    y: Array
    name: str
    color: str


class Mark(NamedTuple):
    """A vertical line at a position of the horizontal axis."""

    place: float
    name: str
    color: str = RED


@dataclass(frozen=True, eq=False)
class Curves:
    """A diagram of curves over one axis.

    Attributes
    ----------
    x : (m,) array
        In the unit of the axis, ascending.
    series : tuple of Series
        Later ones cover earlier ones.
    x_label, y_label : str
        With their units in brackets.
    top : float or None
        Upper end of the vertical axis, which begins at zero; from the curves if None.
    signed : bool
        Whether the vertical axis extends below zero, with a line at zero.
    x_step : float or None
        Distance between the ticks of the horizontal axis.
    dots : tuple of Dots
    bands : tuple of Band
    marks : tuple of Mark
        Of bands and marks of the same name the first is in the legend.
    """

    x: Array
    series: tuple[Series, ...]
    x_label: str
    y_label: str
    top: float | None = None
    signed: bool = False
    x_step: float | None = None
    dots: tuple[Dots, ...] = ()
    bands: tuple[Band, ...] = ()
    marks: tuple[Mark, ...] = ()

    @property
    def x_range(self) -> tuple[float, float] | None:
        """Ends of the horizontal axis; None for a single position."""
        return (float(self.x[0]), float(self.x[-1])) if len(self.x) > 1 else None

    @property
    def units(self) -> tuple[str, str]:
        """Units of both axes."""
        return bracketed(self.x_label), bracketed(self.y_label)


def bracketed(label: str) -> str:
    """Return the unit in brackets at the end of a label.

    Examples
    --------
    >>> bracketed("alternating stress [MPa]")
    'MPa'
    """
    return label.rpartition("[")[2].removesuffix("]")


def draw_curves(axes: "Axes", curves: Curves) -> None:
    """Draw a diagram on axes; the legend is left to the caller."""
    draw_bands(axes, curves.bands)
    draw_lines(axes, curves.x, curves.series)
    for x, y, name, color in curves.dots:
        axes.plot(x, y, "o", color=color, markersize=4.0, label=name)
    named: set[str] = set()
    for place, name, color in curves.marks:
        label = None if name in named else name
        axes.axvline(place, color=color, linewidth=0.8, linestyle=":", label=label)
        named.add(name)
    axes.set_xlabel(curves.x_label)
    if curves.x_range is not None:
        axes.set_xlim(*curves.x_range)
    if curves.x_step is not None:
        first = np.ceil(curves.x[0] / curves.x_step)
        axes.set_xticks(np.arange(first * curves.x_step, curves.x[-1] + 1e-6, curves.x_step))
    if curves.signed:
        axes.axhline(0.0, color=GRAY, linewidth=0.8)
    elif curves.top is None:
        axes.set_ylim(bottom=0.0)
    else:
        axes.set_ylim(0.0, curves.top)
    axes.set_ylabel(curves.y_label)


def draw_lines(axes: "Axes", x: Array, series: Iterable[Series]) -> None:
    """Draw the main ones of some series."""
    for own in series:
        if own.main:
            color, dash, width = own.line_style
            axes.plot(
                x,
                own.values,
                color=color,
                linewidth=width,
                linestyle=ON_PAPER[dash],
                label=own.name,
            )


def draw_bands(axes: "Axes", bands: Iterable[Band]) -> None:
    """Shade ranges of the horizontal axis."""
    named: set[str] = set()
    for low, high, color, name in bands:
        axes.axvspan(low, high, color=color, zorder=0, label=None if name in named else name)
        named.add(name)
