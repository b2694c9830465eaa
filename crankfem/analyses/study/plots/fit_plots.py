"""Files with diagrams of a study's equations, from its table and the fits of one response."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from crankbase.drawing.diagram_style import figure, make_folder
from crankfem.analyses.study.fit_diagrams import (
    draw_fit_elasticities,
    draw_fit_errors,
    draw_fit_parity,
    draw_fit_sobol,
    draw_over_factor,
    forms_drawn,
)
from crankfem.analyses.study.nominal_throw import sensitivities
from crankfem.analyses.study.response_fits import ResponseFits
from regression.fits.fits import Fit
from regression.plots.equations import BARS
from regression.plots.factor_axis import response_text
from regression.runs.study_table import StudyTable

PANELS_PER_ROW = 4
DIAGRAMS = ("response", "parity", "effects", "sensitivities")


def plot_fits(
    folder: Path, table: StudyTable, found: ResponseFits, form: str | None = None
) -> list[Path]:
    """Write all diagrams of one response into a folder, which is created if necessary.

    Parameters
    ----------
    folder : Path
    table : StudyTable
    found : ResponseFits
    form : str, optional
        Form whose effects are drawn; by default the chosen one.

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
    paths = [folder / name for name in fit_plot_files(found.response)]
    plot_response(paths[0], table, found)
    plot_parity(paths[1], table, found)
    plot_effects(paths[2], found, fit)
    plot_sensitivities(paths[3], table, found)
    return paths


def fit_plot_files(response: str) -> list[str]:
    """Return the names of the files of a response's diagrams."""
    return [f"{response}_{name}.svg" for name in DIAGRAMS]


def plot_response(path: Path, table: StudyTable, found: ResponseFits) -> None:
    """Plot the chosen equation, and others for comparison, over each factor; see `draw_over_factor`."""
    factors = table.plan.factors
    with _grid(path, len(factors)) as panels:
        for place, panel in enumerate(panels):
            draw_over_factor(panel, table, found, place)
        for panel in panels[::PANELS_PER_ROW]:
            panel.set_ylabel(response_text(found.symbol, found.unit))
        _legend(panels)


def plot_parity(path: Path, table: StudyTable, found: ResponseFits) -> None:
    """Plot forms against finite elements: the values above, the errors in per cent below."""
    shown = forms_drawn(found)
    with _grid(path, 2 * len(shown), per_row=len(shown)) as panels:
        for fit, panel, below in zip(shown, panels, panels[len(shown) :], strict=False):
            draw_fit_parity(panel, table, found, fit)
            draw_fit_errors(below, table, found, fit)
        panels[0].set_ylabel("by the equation")
        panels[len(shown)].set_ylabel("error of the equation [%]")
        panels[0].legend(fontsize=8)


def plot_effects(path: Path, found: ResponseFits, fit: Fit) -> None:
    """Plot the coded coefficients of a fit in the order of their size (Pareto)."""
    shown = min(fit.coefficient_count - 1, BARS)
    with figure(path, width=7.2, height=1.2 + 0.26 * shown) as axes:
        found.plot(axes, show="effects", form=fit.form)


def plot_sensitivities(path: Path, table: StudyTable, found: ResponseFits) -> None:
    """Plot elasticities at the nominal throw, and Sobol indices over the ranges."""
    known = sensitivities(table, found)
    factors = table.plan.factors
    with figure(path, 2, width=8.6, height=1.4 + 0.32 * len(factors)) as (left, right):
        draw_fit_elasticities(left, table, found, known)
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
