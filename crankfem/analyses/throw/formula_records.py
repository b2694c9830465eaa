"""Values of the published formulas for one throw as plain JSON content, with those of finite elements."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from crankbase.array_checks import FloatArray, positive_number
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
from crankbase.results import Result
from crankfem.analyses.record import Record, attributes, plain
from crankfem.analyses.throw.law_record import LAW, law_results
from crankfem.analyses.throw.throw_record import ThrowResults
from fem.analysis import ThrowAnalysis, analyze_throw
from fem.angle_law import is_symmetric
from fem.material import STEEL, Material
from fem.plots import ANGLES_DEG
from fem.supports import Neighbors
from geometry.throw import CrankThrow
from regression.formulas.axial_formulas import axial_formula_faults, axial_formulas
from regression.formulas.case import FormulaValue
from regression.formulas.torsional_formulas import torsional_formulas
from regression.plots import draw_formula_bars

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def formula_records(
    throw: CrankThrow,
    material: Material,
    gamma_deg: float = 180.0,
    variant: str = "corrected",
    constants: Mapping[str, float] | None = None,
) -> Record:
    """Values of all published formulas for a throw.

    Parameters
    ----------
    gamma_deg, variant, constants
        As in `axial_formulas`.

    Returns
    -------
    dict
        "axial" [m/N] and "torsional" [rad/(N m)]: a record for each formula; "law": `law_answers`
        at that angle, None if it does not cover the throw; "left_out": axial formulas without a value in
        a printed reading, and the law without results, with the reason.

    Raises
    ------
    InputError
        As `axial_formulas`.
    """
    axial = axial_formulas(
        throw, gamma_deg, material=material, variant=variant, constants=constants
    )
    torsional = torsional_formulas(throw, material=material)
    faults = axial_formula_faults(throw, variant) if variant in ("printed", "corrected") else {}
    law = law_results(throw, material, gamma_deg)
    if law.answers is None:
        faults |= {LAW: f"the law, {str(law.reason).rstrip('.')}"}
    return {
        "axial": _records(axial),
        "torsional": _records(torsional),
        "law": None if law.answers is None else plain(law.answers),
        "left_out": [{"name": name, "reason": reason} for name, reason in faults.items()],
    }


def _records(values: Mapping[str, FormulaValue]) -> list[Record]:
    names = ("value", "unit", "valid", "variant", "remarks", "source")
    return [{"name": name, **attributes(formula, *names)} for name, formula in values.items()]


def fe_axial(analysis: ThrowAnalysis, gamma_deg: float) -> float:
    """Axial compliance by finite elements in a helix of throws with one angle between them [m/N].

    Parameters
    ----------
    gamma_deg : float
        Angle between neighboring cranks [deg].

    Raises
    ------
    InputError
        If the angle is not finite.
    """
    return fe_axial_curve(analysis, [gamma_deg])[0]


def fe_axial_curve(analysis: ThrowAnalysis, gammas_deg: Sequence[float]) -> list[float]:
    """Return `fe_axial` at several angles; the law of equal webs is found once for all of them."""
    if is_symmetric(analysis.superelement):
        law = analysis.angle_law
        return [float(law.axial(gamma)) for gamma in gammas_deg]
    return [analysis.axial_compliance(Neighbors(gamma, gamma)) for gamma in gammas_deg]


def fe_record(analysis: ThrowAnalysis, gamma_deg: float) -> Record:
    """Values by finite elements to compare with the formulas.

    Parameters
    ----------
    gamma_deg : float
        Angle between neighboring cranks [deg].

    Returns
    -------
    dict
        "axial" at that angle [m/N], and with rigid sections "axial_rigid_sections"; "torsional" (pinned)
        [rad/(N m)], "error_estimate"; and "angle_law", the law's e_0, e_180 [m/N] and rho, None where
        the webs differ.
    """
    law = analysis.angle_law if is_symmetric(analysis.superelement) else None
    return {
        "axial": fe_axial(analysis, gamma_deg),
        "axial_rigid_sections": fe_axial(analysis.with_sections("rigid"), gamma_deg),
        "torsional": analysis.torsional_compliance("pinned"),
        "error_estimate": analysis.error_estimate,
        "angle_law": None
        if law is None
        else {"e_0": law.in_line, "e_180": law.opposite, "rho": law.ratio},
    }


# Formulas differ by factors: finite elements within 2 % are far more than enough beside them.
ACCURACY = 0.02


@dataclass(frozen=True)
class Ratio:
    """Ratio of a formula's value to finite elements, and whether the formula applies to the throw."""

    value: float
    valid: bool


@dataclass(frozen=True)
class EngineSpread:
    """One engine's formulas compared with finite elements.

    Attributes
    ----------
    overlap : float
        Overlap of main journal and crankpin relative to the crank radius, negative without overlap.
    fe : mapping of str to float
        "axial" [m/N] and "torsional" [rad/(N m)] by finite elements.
    error_estimate : float
        Relative, of the axial compliance.
    ratios : mapping of str to mapping of str to Ratio
        "axial" and "torsional", each formula name to formula / finite elements.
    """

    engine: str
    overlap: float
    fe: Mapping[str, float]
    error_estimate: float
    ratios: Mapping[str, Mapping[str, Ratio]]


@dataclass(frozen=True)
class FormulaSpread:
    """One formula compared with finite elements over many engines: least, mean and greatest ratio."""

    least: float
    mean: float
    greatest: float


def engine_spread(
    engine: str,
    throw: CrankThrow,
    material: Material,
    gamma_deg: float = 180.0,
    variant: str = "corrected",
    constants: Mapping[str, float] | None = None,
    accuracy: float = ACCURACY,
) -> EngineSpread:
    """Compute one engine's throw by finite elements and by all formulas.

    Parameters
    ----------
    engine : str
        Its name.
    gamma_deg, variant, constants
        As in `axial_formulas`.
    accuracy : float
        Of the finite elements.

    Raises
    ------
    InputError
        As `axial_formulas`.
    """
    records = formula_records(throw, material, gamma_deg, variant, constants)
    fe = fe_record(analyze_throw(throw, material, accuracy=accuracy), gamma_deg)
    return EngineSpread(
        engine=engine,
        overlap=throw.overlap / throw.crank_radius,
        fe={kind: fe[kind] for kind in ("axial", "torsional")},
        error_estimate=fe["error_estimate"],
        ratios={
            kind: {
                record["name"]: Ratio(record["value"] / fe[kind], record["valid"])
                for record in records[kind]
            }
            for kind in ("axial", "torsional")
        },
    )


def spread_of_engines(
    engines: Sequence[tuple[str, CrankThrow, Material]],
    compute: Callable[[str, CrankThrow, Material], EngineSpread],
    progress: Callable[[int, int, str], None] | None = None,
) -> tuple[EngineSpread, ...]:
    """Compute many engines one after another.

    Parameters
    ----------
    engines : sequence of (name, throw, material)
    compute : callable
        `engine_spread` with its further arguments.
    progress : callable, optional
        Called before each engine with its number from 1, their count, and its name.
    """
    spreads = []
    for number, (name, throw, material) in enumerate(engines, start=1):
        if progress is not None:
            progress(number, len(engines), name)
        spreads.append(compute(name, throw, material))
    return tuple(spreads)


def formula_spreads(spreads: Sequence[EngineSpread], kind: str) -> dict[str, FormulaSpread]:
    """Least, geometric mean and greatest of each formula's ratios over the engines.

    Parameters
    ----------
    kind : {"axial", "torsional"}

    Returns
    -------
    dict of str to FormulaSpread
        In the formulas' order. Formulas without a positive ratio are left out, and so are single
        ratios that are not positive.
    """
    names = dict.fromkeys(name for spread in spreads for name in spread.ratios[kind])
    result = {}
    for name in names:
        ratios = [
            ratio.value
            for spread in spreads
            if (ratio := spread.ratios[kind].get(name)) is not None and ratio.value > 0.0
        ]
        if ratios:
            mean = math.exp(sum(math.log(ratio) for ratio in ratios) / len(ratios))
            result[name] = FormulaSpread(min(ratios), mean, max(ratios))
    return result


def spread_record(spread: EngineSpread) -> Record:
    """Return an engine's spread as plain JSON content."""
    return {
        "engine": spread.engine,
        "overlap_per_radius": spread.overlap,
        "fe": dict(spread.fe) | {"error_estimate": spread.error_estimate},
        "beside_fe": {
            kind: {
                name: {"ratio": ratio.value, "valid": ratio.valid} for name, ratio in ratios.items()
            }
            for kind, ratios in spread.ratios.items()
        },
    }


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
    finite_elements : float, optional
        Compliance of the same throw by finite elements, drawn as a line, in the formulas' unit.

    Raises
    ------
    InputError
        If there is no formula, their units differ, or the compliance is not above zero.
    """
    if finite_elements is not None:
        positive_number("finite_elements", finite_elements, "", "a compliance is above zero")
    units = {formula.unit for formula in found.values()}
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
        np.array([formula.value for formula in found.values()]) / size,
        [formula.valid for formula in found.values()],
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
    analysis : ThrowAnalysis, optional
        Of the same throw, drawn too; its material is then used.
    material : Material
        For the formulas otherwise.
    """
    used = material if analysis is None else analysis.material
    tables = [axial_formulas(throw, angle, material=used) for angle in ANGLES_DEG.tolist()]
    # A compliance that is not above zero has no meaning: it leaves a gap.
    curves = {
        name: np.array([v if (v := formulas[name].value) > 0.0 else np.nan for formulas in tables])
        for name in tables[0]
    }
    if analysis is None:
        described = formulas_over_angle(ANGLES_DEG, curves)
    else:
        bounds = {name: analysis.axial_compliance(name) for name in ("guided", "pinned")}
        described = formulas_over_angle(ANGLES_DEG, curves, analysis.over_angle(), bounds)
    return _draw(axes, described, "Published formulas over the angle")


def plot_run_formulas(results: Result | Mapping[str, Any], axes: "Axes | None" = None) -> "Axes":
    """Draw finite elements and formulas over the angle between cranks, from the results of a run.

    Parameters
    ----------
    results : RunResults or mapping
        Of a run, or the content of its results.json.
    axes : matplotlib.axes.Axes, optional
        New ones by default.

    Raises
    ------
    InputError
        If the results have no compliances over the angle.
    """
    content = results.to_record() if isinstance(results, Result) else results
    if not isinstance(content, Mapping) or not {"angle_law", "throw"} <= set(content):
        raise InputError(
            "results: given some without angle_law and throw; allowed is the content of a run's "
            "results.json, because these hold what is drawn."
        )
    throw = ThrowResults.from_record(content["throw"])
    described = run_formulas_over_angle(content["angle_law"], throw)
    return _draw(axes, described, "Axial compliance over the angle")


def _draw(axes: "Axes | None", described: Curves, title: str) -> "Axes":
    axes = new_axes(axes)
    draw_curves(axes, described)
    axes.legend(
        frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=3.2
    )
    write_title(axes, title)
    return axes


def run_formulas_over_angle(law: Mapping[str, Any], throw: ThrowResults) -> Curves:
    """Describe finite elements and formulas over the angle, from the results of a run."""
    supports = throw.supports
    # Where a formula gives no compliance above zero, there is null, which becomes nan.
    curves = {name: np.array(values, dtype=np.float64) for name, values in law["formulas"].items()}
    bounds = {name: supports[name].axial for name in ("guided", "pinned")}
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
