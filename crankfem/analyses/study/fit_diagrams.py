"""Single diagrams of a study's equations, each drawn on the axes it is given."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from crankbase.drawing.diagram_style import math_symbol
from crankbase.drawing.legends import display_unit, write_title
from crankfem.analyses.study.nominal_throw import Sensitivities, factor_sweep
from crankfem.analyses.study.response_fits import ResponseFits, predicted
from regression.factor_labels import factor_text
from regression.fits.fits import Fit
from regression.plots.equations import (
    Curve,
    draw_curves,
    draw_elasticities,
    draw_shapley,
    draw_sobol,
)
from regression.plots.factor_axis import factor_size, label_factor_axis, sweep
from regression.plots.runs import draw_errors, draw_parity, draw_section
from regression.runs.study_table import StudyTable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Beside the chosen form these are drawn, as far as they were fitted, to compare it with.
COMPARED = ("linear", "quadratic", "power law", "log-quadratic", "log-cubic", "group quadratic")
FORMS_DRAWN = 4


def draw_over_factor(axes: "Axes", table: StudyTable, found: ResponseFits, place: int) -> None:
    """Draw the chosen equation, and others for comparison, over one factor.

    The other factors are those of the nominal throw, or the nearest levels. Filled dots are finite
    element results there; open ones are results elsewhere, shifted along the chosen equation with
    their distance to it unchanged.
    """
    factor, size = table.plan.factors[place], display_unit(found.unit)[1]
    forms = forms_drawn(found)
    values = sweep(factor.lowest, factor.highest, factor.labels)
    section = factor_sweep(table, found, place, forms, values)
    x_size = factor_size(factor.unit, factor.labels)
    drawn = [
        Curve(fit.form, curve / size, fit is found.chosen)
        for fit, curve in zip(forms, section.curves, strict=True)
    ]
    draw_curves(axes, values / x_size, drawn, bool(factor.labels))
    places = table.values[:, place] / x_size
    draw_section(axes, places, section.results / size, section.on_line)
    label_factor_axis(axes, factor.name, factor.unit, factor.labels)


def draw_fit_parity(axes: "Axes", table: StudyTable, found: ResponseFits, fit: Fit) -> None:
    """Draw a form's values over those by finite elements, with the errors of held-out designs."""
    size = display_unit(found.unit)[1]
    by_fe, values = table.responses[found.column], predicted(table, found, fit)
    draw_parity(axes, by_fe / size, values / size, table.held_out)
    worst = 100.0 * (fit.largest_heldout_error or 0.0)
    write_title(axes, f"{found.form_text(fit)}:\nheld out within {worst:.2g} %", 9)


def draw_fit_errors(axes: "Axes", table: StudyTable, found: ResponseFits, fit: Fit) -> None:
    """Draw a form's errors over the values by finite elements."""
    size = display_unit(found.unit)[1]
    by_fe, values = table.responses[found.column], predicted(table, found, fit)
    draw_errors(axes, by_fe / size, 100.0 * (values / by_fe - 1.0), table.held_out)
    axes.set_xlabel(fe_axis_label(found))


def fe_axis_label(found: ResponseFits) -> str:
    """Label of an axis for a response by finite elements."""
    return f"{math_symbol(found.symbol)} by FE [{display_unit(found.unit)[0]}]"


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
    """Draw Sobol indices over the ranges, under constraints Shapley effects; nothing without either."""
    sobol = known.sobol
    if sobol is not None and sobol.shapley is not None:
        draw_shapley(axes, names, sobol.shapley)
        return
    first, total = ((), ()) if sobol is None else (sobol.first, sobol.total)
    draw_sobol(axes, names, first, total)


def forms_drawn(found: ResponseFits) -> list[Fit]:
    """Return the chosen form and a few to compare it with, in the order in which they were fitted."""
    others = [fit for name in COMPARED for fit in found.fits if fit.form == name]
    kept = [fit for fit in others if fit is not found.chosen][: FORMS_DRAWN - 1]
    return [fit for fit in found.fits if fit is found.chosen or fit in kept]
