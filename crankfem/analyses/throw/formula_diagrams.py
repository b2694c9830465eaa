"""Diagrams of the published formulas: of one throw, and over the angle between neighboring cranks."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from crankbase.checks.arrays import FloatArray, positive_number
from crankbase.diagrams import (
    ALL_ORDERS,
    Curves,
    Series,
    display_unit,
    draw_curves,
    new_axes,
    order_line_style,
    write_title,
)
from crankbase.errors import InputError
from fem.material import STEEL, Material
from fem.plots import ANGLES_DEG
from fem.throw_analysis import ThrowAnalysis
from geometry.throw import CrankThrow
from regression.formulas.axial_formulas import axial_formulas
from regression.formulas.case import FormulaValue
from regression.plots import draw_formula_bars

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NANO = 1e9


def plot_formulas(
    found: Mapping[str, FormulaValue],
    axes: "Axes | None" = None,
    *,
    finite_elements: float | None = None,
) -> "Axes":
    """Draw the values of the published formulas for one throw, a bar for each.

    Parameters
    ----------
    found : mapping of str to FormulaValue
        From `axial_formulas` or `torsional_formulas`.
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
        Of the same throw, drawn too; its material is then used.
    material : Material
        For the formulas otherwise.

    Returns
    -------
    matplotlib.axes.Axes
    """
    used = material if analysis is None else analysis.material
    tables = [axial_formulas(throw, angle, material=used) for angle in ANGLES_DEG.tolist()]
    # A compliance that is not above zero has no meaning: it leaves a gap.
    curves = {
        name: np.array([v if (v := one[name].value) > 0.0 else np.nan for one in tables])
        for name in tables[0]
    }
    if analysis is None:
        described = formulas_over_angle(ANGLES_DEG, curves)
    else:
        bounds = {name: analysis.axial_compliance(name) for name in ("guided", "pinned")}
        described = formulas_over_angle(ANGLES_DEG, curves, analysis.over_angle(), bounds)
    return _draw(axes, described, "Published formulas over the angle")


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
    return _draw(axes, run_formulas_over_angle(results), "Axial compliance over the angle")


def _draw(axes: "Axes | None", described: Curves, title: str) -> "Axes":
    axes = new_axes(axes)
    draw_curves(axes, described)
    axes.legend(
        frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=3.2
    )
    write_title(axes, title)
    return axes


def run_formulas_over_angle(results: Mapping[str, Any]) -> Curves:
    """Describe finite elements and formulas over the angle, from the results of a run."""
    law, supports = results["angle_law"], results["throw"]["supports"]
    # Where a formula gives no compliance above zero, there is null, which becomes nan.
    curves = {name: np.array(values, dtype=np.float64) for name, values in law["formulas"].items()}
    bounds = {name: supports[name]["axial_compliance"] for name in ("guided", "pinned")}
    return formulas_over_angle(np.array(law["gamma_deg"]), curves, np.array(law["fe"]), bounds)


def formulas_over_angle(
    gammas: FloatArray,
    formulas: Mapping[str, FloatArray],
    fe: FloatArray | None = None,
    bounds: Mapping[str, float] | None = None,
) -> Curves:
    """Describe the axial compliance over the angle between neighboring cranks.

    Parameters
    ----------
    gammas : (g,) array
        [deg]
    formulas : mapping
        Formula name to (g,) values [m/N], NaN where it does not apply.
    fe : (g,) array, optional
        By finite elements in a helix of that angle [m/N].
    bounds : mapping of str to float, optional
        Support to its value by finite elements [m/N].
    """
    series = []
    for number, (name, values) in enumerate(formulas.items()):
        color, dash, _ = order_line_style(number)
        series.append(Series(name, NANO * values, color=color, dash=dash))
    if fe is not None:
        series.append(Series("finite elements", NANO * fe, "total"))
    for name, value in (bounds or {}).items():
        level = np.full(len(gammas), NANO * value)
        series.append(Series(f"FE {name}: {NANO * value:.4g}", level, color=ALL_ORDERS, dash="dot"))
    return Curves(
        gammas,
        tuple(series),
        "angle between neighboring cranks γ [deg]",
        "axial compliance [10⁻⁹ m/N]",
        x_step=30.0,
    )
