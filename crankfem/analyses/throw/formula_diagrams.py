"""Diagrams of the published formulas: of one throw, and over the angle between neighboring cranks."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from crankbase.checks.arrays import positive_number
from crankbase.drawing.diagram_style import new_axes
from crankbase.drawing.legends import display_unit, write_title
from crankbase.errors import InputError
from fem.material import STEEL, Material
from fem.plots.over_angle import ANGLES_DEG
from fem.throw_analysis import ThrowAnalysis
from geometry.throw import CrankThrow
from regression.formulas.axial_formulas import axial_formulas
from regression.formulas.formula_value import FormulaValue
from regression.plots.formula_curves import draw_formula_bars, draw_over_angle

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_formulas(
    found: Mapping[str, FormulaValue],
    axes: "Axes | None" = None,
    *,
    finite_elements: float | None = None,
) -> "Axes":
    """Draw what the published formulas give for one throw, a bar for each.

    Parameters
    ----------
    found : mapping of str to FormulaValue
        As `axial_formulas` or `torsional_formulas` returns it.
    axes : matplotlib.axes.Axes, optional
        New ones by default.
    finite_elements : float, optional
        Compliance of the same throw by finite elements, drawn as a line, in the formulas' unit.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InputError
        If there is no formula, their units differ, or the compliance is not above zero.
    """
    if finite_elements is not None:
        positive_number("finite_elements", finite_elements, "", "a compliance is above zero")
    units = {one.unit for one in found.values()}
    if len(units) != 1:
        raise InputError(
            f"found: given values in {', '.join(sorted(units)) or 'no unit'}; allowed are the formulas of "
            "one kind, at least one, because they share an axis."
        )
    unit, size = display_unit(next(iter(units)))
    kind = "axial" if unit.endswith("m/N") else "torsional"
    axes = new_axes(axes)
    draw_formula_bars(
        axes,
        list(found),
        np.array([one.value for one in found.values()]) / size,
        [one.valid for one in found.values()],
        f"{kind} compliance [{unit}]",
        None if finite_elements is None else finite_elements / size,
    )
    write_title(axes, "Published formulas")
    return axes


def plot_formulas_over_angle(
    throw: CrankThrow,
    axes: "Axes | None" = None,
    *,
    analysis: ThrowAnalysis | None = None,
    material: Material = STEEL,
) -> "Axes":
    """Draw the published formulas of the axial compliance over the angle between neighboring cranks.

    Parameters
    ----------
    throw : CrankThrow
    axes : matplotlib.axes.Axes, optional
        New ones by default.
    analysis : ThrowAnalysis, optional
        Of the same throw, drawn beside them; its material counts then.
    material : Material
        For the formulas otherwise.

    Returns
    -------
    matplotlib.axes.Axes
    """
    used = material if analysis is None else analysis.material
    tables = [
        axial_formulas(
            throw,
            angle,
            youngs_modulus=used.youngs_modulus,
            poisson_ratio=used.poisson_ratio,
        )
        for angle in ANGLES_DEG.tolist()
    ]
    # A compliance that is not above zero has no meaning: it leaves a gap.
    curves = {
        name: np.array([v if (v := one[name].value) > 0.0 else np.nan for one in tables])
        for name in tables[0]
    }
    axes = new_axes(axes)
    if analysis is None:
        draw_over_angle(axes, ANGLES_DEG, curves)
    else:
        bounds = {name: analysis.axial_compliance(name) for name in ("guided", "pinned")}
        draw_over_angle(axes, ANGLES_DEG, curves, analysis.over_angle(), bounds)
    write_title(axes, "Published formulas over the angle")
    return axes


def plot_run_formulas(results: Mapping[str, Any], axes: "Axes | None" = None) -> "Axes":
    """Draw finite elements and formulas over the angle between cranks, from the results of a run.

    Parameters
    ----------
    results : mapping
        The content of a run's results.json.
    axes : matplotlib.axes.Axes, optional
        New ones by default.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InputError
        If the results have no compliances over the angle.
    """
    if not isinstance(results, Mapping) or not {"angle_law", "throw"} <= set(results):
        raise InputError(
            "results: given some without angle_law and throw; allowed is the content of a run's "
            "results.json, because these hold what is drawn."
        )
    law, supports = results["angle_law"], results["throw"]["supports"]
    # Where a formula gives no compliance above zero, there is null.
    curves = {
        name: np.array([np.nan if value is None else value for value in column])
        for name, column in law["formulas"].items()
    }
    bounds = {name: supports[name]["axial_compliance"] for name in ("guided", "pinned")}
    axes = new_axes(axes)
    draw_over_angle(axes, np.array(law["gamma_deg"]), curves, np.array(law["fe"]), bounds)
    write_title(axes, "Axial compliance over the angle")
    return axes
