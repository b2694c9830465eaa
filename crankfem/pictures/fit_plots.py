"""Diagrams of a study's equations, each from a study's table and the fits of one response to one file."""

import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankfem.fitting import (
    ResponseFits,
    nominal_points,
    predicted,
    sensitivities,
    surface,
)
from geometry.diagram_style import BLUE, GRAY, GREEN, ORANGE, figure, make_folder, math_symbol
from geometry.quantity import DISPLAY_UNITS
from regression.fits.equation_text import factor_label, term_symbols
from regression.fits.fits import Fit
from regression.plans.factors import Factor
from regression.runs.study_table import StudyTable

Array = NDArray[np.float64]

# Beside the chosen form these are drawn, as far as they were fitted, to compare it with.
COMPARED = ("linear", "quadratic", "power law", "log-quadratic", "log-cubic", "group quadratic")
FORMS_DRAWN = 4
# Bars of a Pareto diagram: what comes after them is hardly seen.
BARS = 16
PANELS_PER_ROW = 4
PAPER_SYMBOL = re.compile(r"[A-Za-z](_[a-z]+)?")
POINTS = 80


def plot_fits(
    folder: Path, table: StudyTable, found: ResponseFits, form: str | None = None
) -> list[Path]:
    """Write all diagrams of one response into a folder, which is made if it is not there.

    Parameters
    ----------
    folder : Path
    table : StudyTable
    found : ResponseFits
    form : str, optional
        Whose effects and residuals are drawn; the chosen one's otherwise.

    Returns
    -------
    list of Path

    Raises
    ------
    InputError
        If the folder cannot be made.
    """
    fit = found.chosen if form is None else found.fit_named(form)
    make_folder(folder)
    paths = {
        name: folder / f"{found.response}_{name}.svg"
        for name in ("response", "parity", "effects", "residuals", "sensitivities")
    }
    plot_response(paths["response"], table, found)
    plot_parity(paths["parity"], table, found)
    plot_effects(paths["effects"], found, fit)
    plot_residuals(paths["residuals"], table, found, fit)
    plot_sensitivities(paths["sensitivities"], table, found)
    return list(paths.values())


def plot_response(path: Path, table: StudyTable, found: ResponseFits) -> None:
    """Plot the chosen equation, and others beside it, over each factor in turn.

    The other factors stay at the nominal throw, or at the levels next to it. Filled dots are finite
    element results there; open ones are results elsewhere, moved there along the chosen equation: they
    keep their distance to it.
    """
    plan = table.plan
    unit, size = _display_unit(found.unit)
    section = _section(table)
    curves = [(fit, surface(plan, found, fit)) for fit in _forms_drawn(found)]
    chosen = surface(plan, found, found.chosen)
    off_curve = table.responses[found.column] / predicted(table, found, found.chosen)
    with _grid(path, len(plan.factors)) as panels:
        for place, (factor, panel) in enumerate(zip(plan.factors, panels, strict=True)):
            sweep = _moved(section, place, _sweep(factor))
            x, x_size = _shown_factor(factor, sweep[:, place])
            styles = iter(("--", ":", "-."))
            for fit, curve in curves:
                y = curve(sweep) / size
                if fit is found.chosen:
                    look = {"color": BLUE, "linewidth": 1.8, "label": f"{fit.form} (chosen)"}
                else:
                    look = {"color": GRAY, "linestyle": next(styles), "label": fit.form}
                if factor.labels:
                    look |= {"linestyle": "none", "marker": "_", "markersize": 22, "label": None}
                panel.plot(x, y, **look)
            here = _moved(section, place, table.values[:, place])
            on_line = _same_designs(table, here)
            dots = chosen(here) * off_curve / size
            own = table.values[:, place] / x_size
            for those, filling, alpha, label in (
                (~on_line, "none", 0.45, "others, moved to this line"),
                (on_line, ORANGE, 1.0, "finite elements"),
            ):
                panel.plot(
                    own[those],
                    dots[those],
                    "o",
                    color=ORANGE,
                    markerfacecolor=filling,
                    markersize=3.5,
                    alpha=alpha,
                    label=label if those.any() else None,
                )
            _factor_axis(panel, factor)
        for panel in panels[::PANELS_PER_ROW]:
            panel.set_ylabel(f"{math_symbol(found.symbol)} [{_unit_text(unit)}]")
        _legend(panels)


def _section(table: StudyTable) -> Array:
    """Return the values of the factors through which sections are drawn."""
    return np.array(
        [
            min(factor.levels, key=lambda level: abs(level - nominal))
            if factor.levels is not None
            else nominal
            for factor, nominal in zip(table.plan.factors, nominal_points(table.plan), strict=True)
        ]
    )


def _moved(section: Array, place: int, values: Array) -> Array:
    """Return points of the section in which one factor has other values."""
    points = np.tile(section, (len(values), 1))
    points[:, place] = values
    return points


def _same_designs(table: StudyTable, points: Array) -> NDArray[np.bool_]:
    spans = np.array([factor.highest - factor.lowest for factor in table.plan.factors])
    found: NDArray[np.bool_] = np.all(np.abs(table.values - points) <= 1e-6 * spans, axis=1)
    return found


def plot_parity(path: Path, table: StudyTable, found: ResponseFits) -> None:
    """Plot forms against finite elements: the values above, the errors in per cent below."""
    unit, size = _display_unit(found.unit)
    column = table.responses[found.column]
    shown = _forms_drawn(found)
    with _grid(path, 2 * len(shown), per_row=len(shown)) as panels:
        for fit, panel, below in zip(shown, panels, panels[len(shown) :], strict=False):
            values = predicted(table, found, fit)
            ends = np.array([column.min(), column.max()]) / size
            panel.plot(ends, ends, color=GRAY, linewidth=1.0)
            below.axhline(0.0, color=GRAY, linewidth=1.0)
            for held, color, marker, label in (
                (False, BLUE, "o", "fitted runs"),
                (True, ORANGE, "D", "held out"),
            ):
                chosen = table.held_out == held
                for axes, y in ((panel, values / size), (below, 100.0 * (values / column - 1.0))):
                    axes.plot(
                        column[chosen] / size,
                        y[chosen],
                        marker,
                        color=color,
                        label=label,
                        markersize=3.5,
                        alpha=0.75,
                    )
            worst = 100.0 * (fit.largest_heldout_error or 0.0)
            star = " (chosen)" if fit is found.chosen else ""
            panel.set_title(f"{fit.form}{star}:\nheld out within {worst:.2g} %", fontsize=9)
            below.set_xlabel(f"{math_symbol(found.symbol)} by FE [{_unit_text(unit)}]")
        panels[0].set_ylabel("by the equation")
        panels[len(shown)].set_ylabel("error of the equation [%]")
        panels[0].legend(fontsize=8)


def plot_effects(path: Path, found: ResponseFits, fit: Fit) -> None:
    """Plot the coded coefficients of a fit in the order of their size (Pareto)."""
    coefficients = dict(zip(term_symbols(fit.fitted), fit.fitted.coefficients, strict=True))
    order = sorted(coefficients, key=lambda name: -abs(coefficients[name]))
    order.remove("1")
    shown = order[:BARS]
    unit, size = ("%", 0.01) if fit.fitted.logarithmic else _effect_unit(found, fit)
    values = np.array([coefficients[name] for name in shown]) / size
    with figure(path, width=7.2, height=1.2 + 0.26 * len(shown)) as axes:
        places = np.arange(len(shown))
        for sign, color, label in ((1.0, BLUE, "positive"), (-1.0, ORANGE, "negative")):
            drawn = sign * values >= 0.0
            if drawn.any():
                axes.barh(places[drawn], np.abs(values[drawn]), color=color, label=label)
        axes.legend(fontsize=8, loc="lower right")
        for place, value in zip(places, values, strict=True):
            axes.annotate(
                f"{value:+.3g}",
                (abs(value), place),
                xytext=(4, 0),
                textcoords="offset points",
                va="center",
                fontsize=8,
            )
        axes.set_yticks(places, [_term_text(name) for name in shown], fontsize=8)
        axes.invert_yaxis()
        axes.margins(x=0.12)
        axes.grid(axis="y", visible=False)
        of = "ln " if fit.fitted.logarithmic else ""
        axes.set_xlabel(f"coded coefficient of {of}{math_symbol(found.symbol)} [{unit}]")
        rest = len(order) - len(shown)
        more = f", {rest} smaller ones left out" if rest > 0 else ""
        axes.set_title(f"{fit.form}: effects{more}", fontsize=10)


def _effect_unit(found: ResponseFits, fit: Fit) -> tuple[str, float]:
    if fit.basis == "groups":
        return "1", 1.0
    unit, size = _display_unit(found.unit)
    return _unit_text(unit), size


def plot_residuals(path: Path, table: StudyTable, found: ResponseFits, fit: Fit) -> None:
    """Plot the errors of a fit over its value, over each factor, and over the runs' leverage."""
    unit, size = _display_unit(found.unit)
    values = predicted(table, found, fit)
    error = 100.0 * (values / table.responses[found.column] - 1.0)
    factors = table.plan.factors
    kinds = (
        (~table.held_out, BLUE, "o", "fitted runs"),
        (table.held_out, ORANGE, "D", "held out"),
    )
    with _grid(path, len(factors) + 2) as panels:
        columns = [values / size] + [
            _shown_factor(factor, table.values[:, place])[0] for place, factor in enumerate(factors)
        ]
        for column, panel in zip(columns, panels, strict=False):
            panel.axhline(0.0, color=GRAY, linewidth=1.0)
            for chosen, color, marker, label in kinds:
                panel.plot(
                    column[chosen],
                    error[chosen],
                    marker,
                    color=color,
                    markersize=3.5,
                    alpha=0.75,
                    label=label,
                )
        panels[0].set_xlabel(f"{math_symbol(found.symbol)} by the equation [{_unit_text(unit)}]")
        for factor, panel in zip(factors, panels[1:], strict=False):
            _factor_axis(panel, factor)
        leverage = fit.statistics.leverage
        last = panels[len(factors) + 1]
        last.axhline(0.0, color=GRAY, linewidth=1.0)
        last.plot(leverage, error[~table.held_out], "o", color=BLUE, markersize=3.5, alpha=0.75)
        last.set_xlabel(f"leverage (mean {fit.coefficient_count / fit.runs:.2f})")
        last.set_xlim(0.0, 1.02)
        for panel in panels[::PANELS_PER_ROW]:
            panel.set_ylabel("error of the equation [%]")
        panels[0].legend(fontsize=8)


def plot_sensitivities(path: Path, table: StudyTable, found: ResponseFits) -> None:
    """Plot elasticities at the nominal throw, and Sobol indices over the ranges."""
    known = sensitivities(table, found)
    factors = table.plan.factors
    places = np.arange(len(factors))
    names = [_factor_text(factor) for factor in factors]
    with figure(path, 2, width=8.6, height=1.4 + 0.32 * len(factors)) as (left, right):
        slopes = [known.elasticity.get(factor.name, 0.0) for factor in factors]
        left.barh(places, slopes, color=[BLUE if slope >= 0.0 else ORANGE for slope in slopes])
        left.axvline(0.0, color=GRAY, linewidth=1.0)
        for place, slope in zip(places, slopes, strict=True):
            left.annotate(
                f"{round(slope, 2) + 0.0:+.2f}"
                if factors[place].name in known.elasticity
                else "a choice",
                (slope, place),
                xytext=(4 if slope >= 0.0 else -4, 0),
                textcoords="offset points",
                va="center",
                ha="left" if slope >= 0.0 else "right",
                fontsize=8,
            )
        left.margins(x=0.22)
        left.set_xlabel(f"elasticity: % of {math_symbol(found.symbol)} per % of the factor")
        if known.sobol is not None:
            right.barh(
                places - 0.18, known.sobol.total, height=0.34, color="#b9cfe4", label="with others"
            )
            right.barh(places + 0.18, known.sobol.first, height=0.34, color=GREEN, label="alone")
            right.legend(fontsize=8)
            right.set_xlim(0.0, max(1.0, 1.05 * max(known.sobol.total)))
        right.set_xlabel("Sobol index: share of the variance")
        for axes in (left, right):
            axes.set_yticks(places, names if axes is left else [""] * len(names), fontsize=8)
            axes.invert_yaxis()
            axes.grid(axis="y", visible=False)


# ---------------------------------------------------------------------------------- helpers


@contextmanager
def _grid(path: Path, panels: int, per_row: int = PANELS_PER_ROW) -> Iterator[Any]:
    """Yield the axes of a figure of several rows, as many as asked for."""
    columns = min(panels, per_row)
    rows = math.ceil(panels / columns)
    with figure(path, width=2.6 * columns + 0.6, height=2.5 * rows + 0.3) as axes:
        made = axes.figure
        axes.remove()
        grid = np.atleast_1d(made.subplots(rows, columns)).ravel()
        for empty in grid[panels:]:
            empty.set_visible(False)
        yield grid[:panels]


def _forms_drawn(found: ResponseFits) -> list[Fit]:
    """Return the chosen form and a few to compare it with, in the order in which they were fitted."""
    others = [fit for name in COMPARED for fit in found.fits if fit.form == name]
    kept = [fit for fit in others if fit is not found.chosen][: FORMS_DRAWN - 1]
    return [fit for fit in found.fits if fit is found.chosen or fit in kept]


def _display_unit(unit: str) -> tuple[str, float]:
    return DISPLAY_UNITS.get(unit, (unit, 1.0))


def _unit_text(unit: str) -> str:
    if not unit:
        return "1"
    return unit.replace("1e-9", r"$10^{-9}$")


def _shown_factor(factor: Factor, values: Array) -> tuple[Array, float]:
    """Return values in the factor's display unit, and that unit's size."""
    size = 1.0 if factor.labels else _display_unit(factor.unit)[1]
    return values / size, size


def _sweep(factor: Factor) -> Array:
    if factor.labels:
        return np.resize(np.arange(len(factor.labels), dtype=np.float64), POINTS)
    return np.linspace(factor.lowest, factor.highest, POINTS)


def _factor_axis(panel: Any, factor: Factor) -> None:
    if factor.labels:
        panel.set_xticks(range(len(factor.labels)), factor.labels, fontsize=8)
        panel.set_xlim(-0.5, len(factor.labels) - 0.5)
        panel.set_xlabel(_factor_text(factor))
        return
    unit = _display_unit(factor.unit)[0]
    panel.set_xlabel(f"{_factor_text(factor)} [{unit}]" if unit else _factor_text(factor))


def _factor_text(factor: Factor) -> str:
    """Write "web width B", in mathematics where the factor has a symbol."""
    symbol = factor_label(factor.name).symbol
    words = factor.name.replace("_", " ")
    return words if symbol == factor.name else f"{words} {math_symbol(symbol)}"


def _term_text(name: str) -> str:
    """Write the papers' symbols in a term such as "ln(L_shm)^2 h" in mathematics, free names in words."""

    def word(found: re.Match[str]) -> str:
        text = found[0]
        return math_symbol(text) if PAPER_SYMBOL.fullmatch(text) else text.replace("_", " ")

    return re.sub(r"[A-Za-z][\w.]*", word, name)


def _legend(panels: Any) -> None:
    """One legend for all panels, below them."""
    handles: dict[str, Any] = {}
    for panel in panels:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    panels[0].figure.legend(
        handles.values(),
        handles.keys(),
        loc="outside lower center",
        ncols=5 if len(handles) <= 5 else 3,
        fontsize=8,
    )
