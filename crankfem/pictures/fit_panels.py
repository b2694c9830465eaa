"""Single panels of a study's diagrams, each drawn on the axes it is given."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crankfem.fitting import ResponseFits, Sensitivities, predicted, surface
from crankfem.nominal_section import moved, nominal_section, same_designs
from geometry.diagram_style import math_symbol
from geometry.plots.legends import shown_unit, write_title
from regression.factor_labels import factor_text
from regression.fits.equation_text import term_effects
from regression.fits.fits import Fit
from regression.plots.equations import (
    Curve,
    draw_curves,
    draw_effects,
    draw_elasticities,
    draw_sobol,
)
from regression.plots.factor_axis import factor_size, label_factor_axis, sweep
from regression.plots.runs import draw_errors, draw_parity, draw_section
from regression.runs.study_table import StudyTable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

# Beside the chosen form these are drawn, as far as they were fitted, to compare it with.
COMPARED = ("linear", "quadratic", "power law", "log-quadratic", "log-cubic", "group quadratic")
FORMS_DRAWN = 4


class ResponseCurves(NamedTuple):
    """A response's forms as functions of factor values (n, k), and how runs lie off the chosen one."""

    forms: list[tuple[Fit, Callable[[Array], Array]]]
    chosen: Callable[[Array], Array]
    off_curve: Array


def response_curves(table: StudyTable, found: ResponseFits) -> ResponseCurves:
    """Return what is drawn over every factor."""
    return ResponseCurves(
        [(fit, surface(table.plan, found, fit)) for fit in forms_drawn(found)],
        surface(table.plan, found, found.chosen),
        table.responses[found.column] / predicted(table, found, found.chosen),
    )


def draw_over_factor(
    axes: "Axes", table: StudyTable, found: ResponseFits, place: int, curves: ResponseCurves
) -> None:
    """Draw the chosen equation, and others beside it, over one factor.

    The other factors stay at the nominal throw, or at the levels next to it. Filled dots are finite
    element results there; open ones are results elsewhere, moved there along the chosen equation: they
    keep their distance to it.
    """
    factor, size = table.plan.factors[place], shown_unit(found.unit)[1]
    section = nominal_section(table)
    values = sweep(factor.lowest, factor.highest, factor.labels)
    points = moved(section, place, values)
    x_size = factor_size(factor.unit, factor.labels)
    drawn = [
        Curve(fit.form, curve(points) / size, fit is found.chosen) for fit, curve in curves.forms
    ]
    draw_curves(axes, values / x_size, drawn, bool(factor.labels))
    here = moved(section, place, table.values[:, place])
    dots = curves.chosen(here) * curves.off_curve / size
    draw_section(axes, table.values[:, place] / x_size, dots, same_designs(table, here))
    label_factor_axis(axes, factor.name, factor.unit, factor.labels)


def draw_fit_parity(axes: "Axes", table: StudyTable, found: ResponseFits, fit: Fit) -> None:
    """Draw a form's values over those by finite elements, and say how far held-out designs are off."""
    size = shown_unit(found.unit)[1]
    by_fe, values = table.responses[found.column], predicted(table, found, fit)
    draw_parity(axes, by_fe / size, values / size, table.held_out)
    worst = 100.0 * (fit.largest_heldout_error or 0.0)
    star = " (chosen)" if fit is found.chosen else ""
    write_title(axes, f"{fit.form}{star}:\nheld out within {worst:.2g} %", 9)


def draw_fit_errors(axes: "Axes", table: StudyTable, found: ResponseFits, fit: Fit) -> None:
    """Draw a form's errors over the values by finite elements."""
    size = shown_unit(found.unit)[1]
    by_fe, values = table.responses[found.column], predicted(table, found, fit)
    draw_errors(axes, by_fe / size, 100.0 * (values / by_fe - 1.0), table.held_out)
    axes.set_xlabel(fe_text(found))


def fe_text(found: ResponseFits) -> str:
    """Label of an axis for a response by finite elements."""
    return f"{math_symbol(found.symbol)} by FE [{shown_unit(found.unit)[0]}]"


def draw_fit_effects(axes: "Axes", found: ResponseFits, fit: Fit) -> None:
    """Draw the coded coefficients of a fit in the order of their size (Pareto)."""
    names, values = term_effects(fit.fitted)
    if fit.fitted.logarithmic:
        unit, size, of = "%", 0.01, "ln "
    elif fit.basis == "groups":
        unit, size, of = "1", 1.0, ""
    else:
        (unit, size), of = shown_unit(found.unit), ""
    label = f"coded coefficient of {of}{math_symbol(found.symbol)} [{unit}]"
    draw_effects(axes, names, values / size, label, fit.form)


def draw_fit_elasticities(
    axes: "Axes", table: StudyTable, found: ResponseFits, known: Sensitivities
) -> None:
    """Draw the elasticities of a response at the nominal throw."""
    factors = table.plan.factors
    slopes = [known.elasticity.get(factor.name) for factor in factors]
    draw_elasticities(
        axes, [factor_text(factor.name) for factor in factors], slopes, math_symbol(found.symbol)
    )


def draw_fit_sobol(axes: "Axes", names: Sequence[str], known: Sensitivities) -> None:
    """Draw Sobol indices over the ranges, none for a response that does not vary."""
    sobol = known.sobol
    first, total = ((), ()) if sobol is None else (sobol.first, sobol.total)
    draw_sobol(axes, names, first, total)


def forms_drawn(found: ResponseFits) -> list[Fit]:
    """Return the chosen form and a few to compare it with, in the order in which they were fitted."""
    others = [fit for name in COMPARED for fit in found.fits if fit.form == name]
    kept = [fit for fit in others if fit is not found.chosen][: FORMS_DRAWN - 1]
    return [fit for fit in found.fits if fit is found.chosen or fit in kept]
