"""Bars side by side: values of several things, of one or more kinds."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from crankbase.drawing.diagram_style import COLORS, GRAY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FILLED = 0.8  # share of the distance of two groups that their bars take
ROOM = 70  # letters that stand side by side under the axis
PALE = "#c9d2db"


def draw_groups(
    axes: "Axes", names: Sequence[str], series: Mapping[str, ArrayLike], label: str
) -> None:
    """Draw upright bars in groups.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    names : sequence of n str
        Of the groups, under the axis.
    series : mapping of str to (n,) array_like
        Values by kind, in the unit of the axis; one bar of each kind in every group.
    label : str
        Label of the vertical axis, with its unit.
    """
    places, width = np.arange(len(names)), FILLED / len(series)
    for number, (kind, values) in enumerate(series.items()):
        shift = (number - 0.5 * (len(series) - 1)) * width
        color = COLORS[number % len(COLORS)]
        axes.bar(places + shift, np.asarray(values), width=width, color=color, label=kind)
    crowded = sum(map(len, names)) > ROOM
    axes.set_xticks(
        places,
        list(names),
        fontsize=8,
        rotation=30 if crowded else 0,
        ha="right" if crowded else "center",
    )
    axes.axhline(0.0, color=GRAY, linewidth=0.8)
    axes.grid(axis="x", visible=False)
    axes.set_ylabel(label)
    if len(series) > 1:
        axes.legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))


def draw_rows(
    axes: "Axes",
    names: Sequence[str],
    values: ArrayLike,
    label: str,
    *,
    colors: Sequence[str] | str = COLORS[0],
    texts: Sequence[str] | None = None,
) -> None:
    """Draw horizontal bars from the top down, each with its value.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    names : sequence of n str
    values : (n,) array_like
        In the unit of the axis.
    label : str
        Label of the horizontal axis, with its unit.
    colors : str or sequence of n str
    texts : sequence of n str, optional
        Written at the bars' ends; the values to three digits by default.
    """
    sizes, places = np.asarray(values, dtype=float), np.arange(len(names))
    axes.barh(places, sizes, color=colors)
    for place, size in enumerate(sizes.tolist()):
        axes.annotate(
            f"{size:.3g}" if texts is None else texts[place],
            (size, place),
            xytext=(4 if size >= 0.0 else -4, 0),
            textcoords="offset points",
            va="center",
            ha="left" if size >= 0.0 else "right",
            fontsize=8,
        )
    axes.set_yticks(places, list(names), fontsize=8)
    axes.invert_yaxis()
    axes.margins(x=0.15)
    axes.grid(axis="y", visible=False)
    axes.set_xlabel(label)


def draw_matrix(
    axes: "Axes", values: ArrayLike, rows: Sequence[str], columns: Sequence[str]
) -> None:
    """Draw a table of numbers, each cell colored by its value, blue below zero and orange above.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    values : (n, m) array_like
        In the unit stated in the title.
    rows, columns : sequences of n and m str
    """
    from matplotlib.colors import LinearSegmentedColormap

    numbers = np.asarray(values, dtype=float)
    largest = float(np.max(np.abs(numbers))) or 1.0
    decimals = max(0, 2 - math.floor(math.log10(largest)))
    colors = LinearSegmentedColormap.from_list("signed", ("#7fa8cf", "white", "#eab676"))
    axes.imshow(numbers, cmap=colors, vmin=-largest, vmax=largest, aspect="auto")
    for row, column in np.ndindex(numbers.shape):
        text = f"{round(float(numbers[row, column]), decimals) + 0.0:.{decimals}f}"
        axes.text(column, row, text, ha="center", va="center", fontsize=8)
    axes.set_xticks(range(len(columns)), list(columns), fontsize=8)
    axes.set_yticks(range(len(rows)), list(rows), fontsize=8)
    axes.grid(visible=False)
