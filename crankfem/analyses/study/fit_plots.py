"""Files with diagrams of a study's equations, from its table and the fits of one response."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import compress
from pathlib import Path
from typing import Any

import numpy as np

from crankbase.array_checks import Array
from crankbase.diagrams import (
    BLUE,
    GRAY,
    GREEN,
    ORANGE,
    Dash,
    Diagram,
    Dots,
    Limits,
    Line,
    display_unit,
    draw_diagram,
    draw_rows,
    figure,
    legend_inside,
    make_folder,
    math_symbol,
    write_title,
)
from crankbase.frames import Axes
from crankfem.analyses.study.nominal_throw import factor_sweep, sensitivities
from crankfem.analyses.study.response_fits import ResponseFits, predicted
from regression.fits.fit import Fit
from regression.fits.sensitivity import Sensitivities
from regression.plots import (
    BARS,
    POINTS,
    design_dots,
    factor_label_text,
    factor_size,
    factor_text,
    response_text,
)
from regression.runs.study_table import StudyTable

# Beside the chosen form these are drawn, as far as they were fitted, to compare it with.
COMPARED = ("linear", "quadratic", "power law", "log-quadratic", "log-cubic", "group quadratic")
FORMS_DRAWN = 4


PALE_BLUE = "#b9cfe4"


def factor_diagram(
    table: StudyTable, response: ResponseFits, place: int, unit: str = "", texts: Sequence[str] = ()
) -> Diagram:
    """Describe the chosen equation, and others for comparison, over one factor.

    The other factors are those of the nominal throw, or the nearest levels. Filled dots are finite
    element results there; open ones are results elsewhere, shifted along the chosen equation with
    their distance to it unchanged. Over the labels of a choice equations are dashes.

    Parameters
    ----------
    unit, texts
        What a screen tells of a value, and of the designs.
    """
    factor, size = table.plan.factors[place], display_unit(response.unit)[1]
    labels, forms = factor.labels, forms_drawn(response)
    values = (
        np.arange(len(labels), dtype=np.float64)
        if labels
        else np.linspace(factor.lowest, factor.highest, POINTS)
    )
    section = factor_sweep(table, response, place, forms, values)
    x_size, hover = factor_size(factor.unit, labels), f"%{{y:.5g}}{unit}"
    dashes: Iterator[Dash] = iter(("dash", "dot", "dashdot"))
    lines, dots = [], []
    for fit, curve in zip(forms, section.curves, strict=True):
        name, chosen = response.form_text(fit), fit is response.chosen
        x, y, tip = values / x_size, curve / size, f"{fit.form}<br>%{{x:.5g}}<br>{hover}"
        color, width = (BLUE, 1.8) if chosen else (GRAY, 1.4)
        if labels:
            dots.append(Dots(x, y, name, color, "_", hover=tip))
        else:
            dash = "solid" if chosen else next(dashes)
            lines.append(Line(x, y, name, color, tip, width, dash))
    x, y = table.values[:, place] / x_size, section.results / size
    for those, symbol, name in (
        (~section.on_line, "O", "other designs, moved to this line"),
        (section.on_line, "o", "finite elements"),
    ):
        if those.any():
            tip_texts = tuple(compress(texts, those))
            tip = f"<b>{name}</b><br>%{{text}}<br>{hover}"
            dots.append(Dots(x[those], y[those], name, ORANGE, symbol, hover=tip, texts=tip_texts))
    return Diagram(
        Limits(
            factor_label_text(factor.name, factor.unit, labels),
            (-0.5, len(labels) - 0.5) if labels else None,
            dict(enumerate(labels)) if labels else None,
        ),
        Limits(response_text(response.symbol, response.unit)),
        lines,
        dots,
    )


def parity_diagrams(
    table: StudyTable,
    response: ResponseFits,
    fit: Fit,
    symbol: str = "",
    unit: str = "",
    texts: Sequence[str] = (),
) -> tuple[Diagram, Diagram]:
    """Describe a form's values, and their errors [%], over those by finite elements.

    Parameters
    ----------
    symbol, unit, texts
        What a screen tells of a value, and of the designs.
    """
    shown, size = display_unit(response.unit)
    by_fe, values = table.responses[response.column], predicted(table, response, fit)
    name = math_symbol(response.symbol)
    x, tip = Limits(f"{name} by FE [{shown}]"), f"{symbol} by FE %{{x:.5g}}{unit}<br>"

    def dots(y: Array, hover: str) -> list[Dots]:
        return design_dots(by_fe / size, y, table.held_out, tip + hover, texts)

    return (
        Diagram(
            x,
            Limits(f"{name} by the equation [{shown}]"),
            (),
            dots(values / size, f"by the equation %{{y:.5g}}{unit}"),
            diagonal=(float(by_fe.min() / size), float(by_fe.max() / size)),
        ),
        Diagram(
            x,
            Limits("error [%]"),
            (),
            dots(100.0 * (values / by_fe - 1.0), "error of the equation %{y:+.2g} %"),
            level=True,
        ),
    )


def parity_title(response: ResponseFits, fit: Fit) -> str:
    """Name a form, with the largest error of a held-out design."""
    worst = 100.0 * (fit.largest_heldout_error or 0.0)
    return f"{response.form_text(fit)}:\nheld out within {worst:.2g} %"


def draw_fit_elasticities(
    axes: Axes, table: StudyTable, response: ResponseFits, known: Sensitivities
) -> None:
    """Draw the elasticities of a response at the nominal throw as bars; a choice has none."""
    slopes = [known.elasticity.get(name) for name in table.plan.names]
    sizes = [slope or 0.0 for slope in slopes]
    draw_rows(
        axes,
        [factor_text(name) for name in table.plan.names],
        sizes,
        f"elasticity: % of {math_symbol(response.symbol)} per % of the factor",
        colors=[BLUE if size >= 0.0 else ORANGE for size in sizes],
        texts=[
            "a choice" if slope is None else f"{round(slope, 2) + 0.0:+.2f}" for slope in slopes
        ],
    )
    axes.axvline(0.0, color=GRAY, linewidth=1.0)
    axes.margins(x=0.22)


def draw_fit_sobol(axes: Axes, names: Sequence[str], known: Sensitivities) -> None:
    """Draw factors' shares of the variance over the ranges: Sobol indices, alone and with others.

    Under constraints Shapley effects, which add up to 1; nothing without either.
    """
    sobol = known.sobol
    if sobol is not None and sobol.shapley is not None:
        shares, label = [*sobol.shapley.values()], "Shapley effect: share of the variance"
        draw_rows(axes, names, shares, label, texts=[f"{share:.2f}" for share in shares])
        axes.set_xlim(0.0, 1.15 * max(shares))
        return
    places = np.arange(len(names))
    if sobol is not None:
        total, first = ([*shares.values()] for shares in (sobol.total, sobol.first))
        axes.barh(places - 0.18, total, height=0.34, color=PALE_BLUE, label="with others")
        axes.barh(places + 0.18, first, height=0.34, color=GREEN, label="alone")
        legend_inside(axes)
        axes.set_xlim(0.0, max(1.0, 1.05 * max(total)))
    axes.set_xlabel("Sobol index: share of the variance")
    axes.set_yticks(places, list(names), fontsize=8)
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)


def forms_drawn(response: ResponseFits) -> list[Fit]:
    """Return the chosen form and a few to compare it with, in the order in which they were fitted."""
    others = [fit for name in COMPARED for fit in response.fits if fit.form == name]
    kept = [fit for fit in others if fit is not response.chosen][: FORMS_DRAWN - 1]
    return [fit for fit in response.fits if fit is response.chosen or fit in kept]


PANELS_PER_ROW = 4
DIAGRAMS = ("response", "parity", "effects", "sensitivities")


def plot_fits(
    folder: Path, table: StudyTable, response: ResponseFits, form: str | None = None
) -> list[Path]:
    """Write all diagrams of one response into a folder, which is created if necessary.

    Parameters
    ----------
    form : str, optional
        Form whose effects are drawn; by default the chosen one.
    """
    fit = response.chosen if form is None else response.fit_named(form)
    make_folder(folder)
    paths = [folder / name for name in fit_plot_files(response.response)]
    plot_response(paths[0], table, response)
    plot_parity(paths[1], table, response)
    plot_effects(paths[2], response, fit)
    known, names = sensitivities(table, response), table.plan.names
    # Elasticities at the nominal throw, and shares of the variance over the ranges.
    with figure(paths[3], 2, width=8.6, height=1.4 + 0.32 * len(names)) as (left, right):
        draw_fit_elasticities(left, table, response, known)
        draw_fit_sobol(right, [""] * len(names), known)
    return paths


def fit_plot_files(response: str) -> list[str]:
    """Return the names of the files of a response's diagrams."""
    return [f"{response}_{name}.svg" for name in DIAGRAMS]


def plot_response(path: Path, table: StudyTable, response: ResponseFits) -> None:
    """Plot the chosen equation, and others for comparison, over each factor; see `factor_diagram`."""
    factors = table.plan.factors
    with _grid(path, len(factors)) as panels:
        for place, panel in enumerate(panels):
            draw_diagram(panel, factor_diagram(table, response, place))
            if place % PANELS_PER_ROW:
                panel.set_ylabel("")
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


def plot_parity(path: Path, table: StudyTable, response: ResponseFits) -> None:
    """Plot forms against finite elements: the values above, the errors in per cent below."""
    shown = forms_drawn(response)
    with _grid(path, 2 * len(shown), per_row=len(shown)) as panels:
        for fit, panel, below in zip(shown, panels, panels[len(shown) :], strict=False):
            for axes, diagram in zip(
                (panel, below), parity_diagrams(table, response, fit), strict=True
            ):
                draw_diagram(axes, diagram)
                if fit is not shown[0]:
                    axes.set_ylabel("")
            panel.set_xlabel("")
            write_title(panel, parity_title(response, fit), 9)
        panels[0].legend(fontsize=8)


def plot_effects(path: Path, response: ResponseFits, fit: Fit) -> None:
    """Plot the coded coefficients of a fit in the order of their size (Pareto)."""
    shown = min(len(fit.fitted.terms) - 1, BARS)
    with figure(path, width=7.2, height=1.2 + 0.26 * shown) as axes:
        response.plot(axes, show="effects", form=fit.form)


# ---------------------------------------------------------------------------------- helpers


@contextmanager
def _grid(path: Path, panels: int, per_row: int = PANELS_PER_ROW) -> Iterator[Any]:
    """Yield the axes of a figure of several rows, as many as requested."""
    columns = min(panels, per_row)
    rows = math.ceil(panels / columns)
    with figure(path, width=2.6 * columns + 0.6, height=2.5 * rows + 0.3) as axes:
        made = axes.figure
        axes.remove()
        grid = np.atleast_1d(made.subplots(rows, columns)).ravel()
        for empty in grid[panels:]:
            empty.set_visible(False)
        yield grid[:panels]
