"""Equations over one factor, and the sizes of their terms and factors."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crankbase.diagrams import (
    BLUE,
    GRAY,
    GREEN,
    ORANGE,
    PALE,
    display_unit,
    draw_rows,
    legend_inside,
    math_symbol,
    write_title,
)
from regression.throw_values import factor_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes


Array = NDArray[np.float64]
POINTS = 80


def factor_size(unit: str, labels: Sequence[str]) -> float:
    """Size of the unit that a factor is shown in; of a choice 1."""
    return 1.0 if labels else display_unit(unit)[1]


def sweep(lowest: float, highest: float, labels: Sequence[str]) -> Array:
    """Values over a factor's range [SI]; of a choice its labels' numbers over and over."""
    if labels:
        return np.resize(np.arange(len(labels), dtype=np.float64), POINTS)
    return np.linspace(lowest, highest, POINTS)


def label_factor_axis(axes: "Axes", name: str, unit: str, labels: Sequence[str]) -> None:
    """Label the horizontal axis with a factor and its unit; for a choice with its labels."""
    if labels:
        axes.set_xticks(range(len(labels)), list(labels), fontsize=8)
        axes.set_xlim(-0.5, len(labels) - 0.5)
        axes.set_xlabel(factor_text(name))
        return
    shown = display_unit(unit)[0] if unit else ""
    axes.set_xlabel(f"{factor_text(name)} [{shown}]" if shown else factor_text(name))


def response_text(symbol: str, unit: str) -> str:
    """Write a response with the unit that it is shown in."""
    return f"{math_symbol(symbol)} [{display_unit(unit)[0]}]"


Mask = NDArray[np.bool_]

KINDS = ((False, BLUE, "o", "fitted runs"), (True, ORANGE, "D", "held out"))


def draw_runs(axes: "Axes", x: Array, y: Array, held_out: Mask) -> None:
    """Draw a dot for each design, in the units of the axes."""
    for held, color, marker, label in KINDS:
        chosen = held_out == held
        axes.plot(
            x[chosen], y[chosen], marker, color=color, markersize=3.5, alpha=0.75, label=label
        )


def draw_parity(axes: "Axes", by_fe: Array, by_equation: Array, held_out: Mask) -> None:
    """Draw values by an equation over those by finite elements, in the units of the axes."""
    ends = np.array([by_fe.min(), by_fe.max()])
    axes.plot(ends, ends, color=GRAY, linewidth=1.0)
    draw_runs(axes, by_fe, by_equation, held_out)


def draw_errors(axes: "Axes", x: Array, errors: Array, held_out: Mask) -> None:
    """Draw errors of an equation [%] over anything, with the line of no error."""
    axes.axhline(0.0, color=GRAY, linewidth=1.0)
    draw_runs(axes, x, errors, held_out)


def draw_section(axes: "Axes", x: Array, y: Array, on_line: Mask) -> None:
    """Draw finite element results on a section's line filled, those shifted to it open."""
    for those, filling, alpha, label in (
        (~on_line, "none", 0.45, "others, moved to this line"),
        (on_line, ORANGE, 1.0, "finite elements"),
    ):
        axes.plot(
            x[those],
            y[those],
            "o",
            color=ORANGE,
            markerfacecolor=filling,
            markersize=3.5,
            alpha=alpha,
            label=label if those.any() else None,
        )


def draw_formula_bars(
    axes: "Axes",
    names: Sequence[str],
    values: Array,
    valid: Sequence[bool],
    label: str,
    beside: float | None,
) -> None:
    """Draw a bar for each formula, pale where it does not apply, and a line for finite elements.

    Parameters
    ----------
    values : (n,) array
        In the unit of the axis.
    label : str
        Of the lying axis, with its unit.
    beside : float or None
        By finite elements, in the unit of the axis.
    """
    from matplotlib.patches import Patch

    draw_rows(axes, names, values, label, colors=[BLUE if usable else PALE for usable in valid])
    handles: list[Any] = [Patch(color=BLUE, label="applies to the throw")]
    if not all(valid):
        handles.append(Patch(color=PALE, label="does not apply"))
    if beside is not None:
        handles.append(axes.axvline(beside, color="black", linewidth=1.8, label="finite elements"))
    axes.legend(
        frameon=False, handles=handles, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0)
    )


# Bars of a Pareto diagram: what comes after them is hardly seen.
BARS = 16
PALE_BLUE = "#b9cfe4"


class Curve(NamedTuple):
    """Values of a form over a factor, in the unit of the axis."""

    form: str
    values: Array
    chosen: bool


def draw_curves(axes: "Axes", x: Array, curves: Sequence[Curve], at_labels: bool) -> None:
    """Draw forms over a factor, the chosen one in front; over the labels of a choice as dashes."""
    styles = iter(("--", ":", "-."))
    for form, values, chosen in curves:
        if chosen:
            look: dict[str, Any] = {"color": BLUE, "linewidth": 1.8, "label": f"{form} (chosen)"}
        else:
            look = {"color": GRAY, "linestyle": next(styles), "label": form}
        if at_labels:
            look |= {"linestyle": "none", "marker": "_", "markersize": 22, "label": None}
        axes.plot(x, values, **look)


def draw_effects(axes: "Axes", names: Sequence[str], values: Array, label: str, form: str) -> None:
    """Draw the coded coefficients of a form in the order of their size (Pareto).

    Parameters
    ----------
    names : sequence of n str
        Terms, the largest first, as written on the axis.
    values : (n,) array
        In the unit of the axis.
    label : str
        Of the axis, with its unit.
    form : str
        For the title.
    """
    from matplotlib.patches import Patch

    shown = values[:BARS]
    draw_rows(
        axes,
        names[:BARS],
        np.abs(shown),
        label,
        colors=[BLUE if value >= 0.0 else ORANGE for value in shown],
        texts=[f"{value:+.3g}" for value in shown],
    )
    kinds = (("positive", BLUE, shown >= 0.0), ("negative", ORANGE, shown < 0.0))
    handles = [Patch(color=color, label=text) for text, color, those in kinds if those.any()]
    axes.legend(handles=handles, frameon=False, fontsize=8, loc="lower right")
    rest = len(values) - len(shown)
    more = f", {rest} smaller ones left out" if rest > 0 else ""
    write_title(axes, f"{form}: effects{more}", 10)


def draw_elasticities(
    axes: "Axes", names: Sequence[str], slopes: Sequence[float | None], response: str
) -> None:
    """Draw elasticities as bars; a factor that is a choice has none.

    Parameters
    ----------
    names : sequence of n str
        Of the factors, as written on the axis.
    response : str
        Symbol of the response in mathematics.
    """
    sizes = [0.0 if slope is None else slope for slope in slopes]
    draw_rows(
        axes,
        names,
        sizes,
        f"elasticity: % of {response} per % of the factor",
        colors=[BLUE if size >= 0.0 else ORANGE for size in sizes],
        texts=[
            "a choice" if slope is None else f"{round(slope, 2) + 0.0:+.2f}" for slope in slopes
        ],
    )
    axes.axvline(0.0, color=GRAY, linewidth=1.0)
    axes.margins(x=0.22)


def draw_sobol(
    axes: "Axes", names: Sequence[str], first: Sequence[float], total: Sequence[float]
) -> None:
    """Draw Sobol indices of factors: their share of the variance alone, and with others."""
    places = np.arange(len(names))
    if len(total):
        axes.barh(places - 0.18, total, height=0.34, color=PALE_BLUE, label="with others")
        axes.barh(places + 0.18, first, height=0.34, color=GREEN, label="alone")
        legend_inside(axes)
        axes.set_xlim(0.0, max(1.0, 1.05 * max(total)))
    axes.set_xlabel("Sobol index: share of the variance")
    axes.set_yticks(places, list(names), fontsize=8)
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)


def draw_shapley(axes: "Axes", names: Sequence[str], shares: Sequence[float]) -> None:
    """Draw the Shapley effects of factors, shares of the variance that add up to 1."""
    label = "Shapley effect: share of the variance"
    draw_rows(axes, names, shares, label, texts=[f"{share:.2f}" for share in shares])
    axes.set_xlim(0.0, 1.15 * max(shares))
