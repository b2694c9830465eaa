"""Files with diagrams of a study's equations, from its table and the fits of one response."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from crankbase.diagrams import display_unit, figure, make_folder, math_symbol, write_title
from crankfem.analyses.study.nominal_throw import Sensitivities, factor_sweep, sensitivities
from crankfem.analyses.study.response_fits import ResponseFits, predicted
from regression.fits.fits import Fit
from regression.plots import (
    BARS,
    Curve,
    draw_curves,
    draw_elasticities,
    draw_errors,
    draw_parity,
    draw_section,
    draw_shapley,
    draw_sobol,
    factor_size,
    label_factor_axis,
    response_text,
    sweep,
)
from regression.runs.study_table import StudyTable
from regression.throw_values import factor_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# Beside the chosen form these are drawn, as far as they were fitted, to compare it with.
COMPARED = ("linear", "quadratic", "power law", "log-quadratic", "log-cubic", "group quadratic")
FORMS_DRAWN = 4


def draw_over_factor(axes: "Axes", table: StudyTable, response: ResponseFits, place: int) -> None:
    """Draw the chosen equation, and others for comparison, over one factor.

    The other factors are those of the nominal throw, or the nearest levels. Filled dots are finite
    element results there; open ones are results elsewhere, shifted along the chosen equation with
    their distance to it unchanged.
    """
    factor, size = table.plan.factors[place], display_unit(response.unit)[1]
    forms = forms_drawn(response)
    values = sweep(factor.lowest, factor.highest, factor.labels)
    section = factor_sweep(table, response, place, forms, values)
    x_size = factor_size(factor.unit, factor.labels)
    drawn = [
        Curve(fit.form, curve / size, fit is response.chosen)
        for fit, curve in zip(forms, section.curves, strict=True)
    ]
    draw_curves(axes, values / x_size, drawn, bool(factor.labels))
    places = table.values[:, place] / x_size
    draw_section(axes, places, section.results / size, section.on_line)
    label_factor_axis(axes, factor.name, factor.unit, factor.labels)


def draw_fit_parity(axes: "Axes", table: StudyTable, response: ResponseFits, fit: Fit) -> None:
    """Draw a form's values over those by finite elements, with the errors of held-out designs."""
    size = display_unit(response.unit)[1]
    by_fe, values = table.responses[response.column], predicted(table, response, fit)
    draw_parity(axes, by_fe / size, values / size, table.held_out)
    worst = 100.0 * (fit.largest_heldout_error or 0.0)
    write_title(axes, f"{response.form_text(fit)}:\nheld out within {worst:.2g} %", 9)


def draw_fit_errors(axes: "Axes", table: StudyTable, response: ResponseFits, fit: Fit) -> None:
    """Draw a form's errors over the values by finite elements."""
    size = display_unit(response.unit)[1]
    by_fe, values = table.responses[response.column], predicted(table, response, fit)
    draw_errors(axes, by_fe / size, 100.0 * (values / by_fe - 1.0), table.held_out)
    axes.set_xlabel(fe_axis_label(response))


def fe_axis_label(response: ResponseFits) -> str:
    """Label of an axis for a response by finite elements."""
    return f"{math_symbol(response.symbol)} by FE [{display_unit(response.unit)[0]}]"


def draw_fit_elasticities(
    axes: "Axes", table: StudyTable, response: ResponseFits, known: Sensitivities
) -> None:
    """Draw the elasticities of a response at the nominal throw."""
    factors = table.plan.factors
    slopes = [known.elasticity.get(factor.name) for factor in factors]
    draw_elasticities(
        axes, [factor_text(factor.name) for factor in factors], slopes, math_symbol(response.symbol)
    )


def draw_fit_sobol(axes: "Axes", names: Sequence[str], known: Sensitivities) -> None:
    """Draw Sobol indices over the ranges, under constraints Shapley effects; nothing without either."""
    sobol = known.sobol
    if sobol is not None and sobol.shapley is not None:
        draw_shapley(axes, names, sobol.shapley)
        return
    first, total = ((), ()) if sobol is None else (sobol.first, sobol.total)
    draw_sobol(axes, names, first, total)


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
    plot_sensitivities(paths[3], table, response)
    return paths


def fit_plot_files(response: str) -> list[str]:
    """Return the names of the files of a response's diagrams."""
    return [f"{response}_{name}.svg" for name in DIAGRAMS]


def plot_response(path: Path, table: StudyTable, response: ResponseFits) -> None:
    """Plot the chosen equation, and others for comparison, over each factor; see `draw_over_factor`."""
    factors = table.plan.factors
    with _grid(path, len(factors)) as panels:
        for place, panel in enumerate(panels):
            draw_over_factor(panel, table, response, place)
        for panel in panels[::PANELS_PER_ROW]:
            panel.set_ylabel(response_text(response.symbol, response.unit))
        _legend(panels)


def plot_parity(path: Path, table: StudyTable, response: ResponseFits) -> None:
    """Plot forms against finite elements: the values above, the errors in per cent below."""
    shown = forms_drawn(response)
    with _grid(path, 2 * len(shown), per_row=len(shown)) as panels:
        for fit, panel, below in zip(shown, panels, panels[len(shown) :], strict=False):
            draw_fit_parity(panel, table, response, fit)
            draw_fit_errors(below, table, response, fit)
        panels[0].set_ylabel("by the equation")
        panels[len(shown)].set_ylabel("error of the equation [%]")
        panels[0].legend(fontsize=8)


def plot_effects(path: Path, response: ResponseFits, fit: Fit) -> None:
    """Plot the coded coefficients of a fit in the order of their size (Pareto)."""
    shown = min(fit.coefficient_count - 1, BARS)
    with figure(path, width=7.2, height=1.2 + 0.26 * shown) as axes:
        response.plot(axes, show="effects", form=fit.form)


def plot_sensitivities(path: Path, table: StudyTable, response: ResponseFits) -> None:
    """Plot elasticities at the nominal throw, and Sobol indices over the ranges."""
    known = sensitivities(table, response)
    factors = table.plan.factors
    with figure(path, 2, width=8.6, height=1.4 + 0.32 * len(factors)) as (left, right):
        draw_fit_elasticities(left, table, response, known)
        draw_fit_sobol(right, [""] * len(factors), known)


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
