"""Values of the published formulas for one throw, compared with finite elements, law and regression."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np

from crankbase.array_checks import Array, positive_number
from crankbase.diagrams import (
    ALL_ORDERS,
    Diagram,
    Series,
    curve_diagram,
    display_unit,
    draw_diagram,
    new_axes,
    order_line_style,
    write_title,
)
from crankbase.errors import InputError
from crankbase.frames import Axes
from crankbase.quantity import percent
from crankbase.results import Flat, InItsUnit, Internal, Number, Quantity, Result, result
from crankfem.analyses.throw.law_record import LAW, LawAnswer, law_results
from crankfem.analyses.throw.throw_record import ThrowResults
from fem.analysis import ThrowAnalysis, analyze_throw
from fem.angle_law import AngleNumbers, is_symmetric
from fem.material import STEEL, Material
from fem.plots import ANGLES_DEG
from fem.supports import Neighbors
from geometry.any_throw import Throw
from geometry.throw import CrankThrow
from regression.formulas.axial_formulas import axial_formula_faults, axial_formulas
from regression.formulas.case import FormulaValue
from regression.formulas.torsional_formulas import torsional_formulas
from regression.models.response_model import ResponseModel
from regression.plots import draw_formula_bars

MetrePerNewton = Annotated[float, Quantity("m/N")]
Kind = Literal["axial", "torsional"]
KINDS: dict[Kind, str] = {"axial": "m/N", "torsional": "rad/(N m)"}


@result("axial", "torsional", "error_estimate", eq=True)
class ElementValues(Result):
    """Compliances of a throw by finite elements, to compare with the formulas.

    The axial one is in a helix of throws with one angle between them, the torsional one pinned; the
    error is that of the axial one.
    """

    axial: MetrePerNewton
    torsional: Annotated[float, Quantity("rad/(N m)")]
    error_estimate: Number


@result("axial", "torsional", "error_estimate")
class ElementsOfThrow(ElementValues):
    """Compliances of a throw by finite elements, rigid sections and the law of the angle among them."""

    axial_rigid_sections: MetrePerNewton
    # None where the webs differ.
    angle_law: AngleNumbers | None


@result("name", "reason", eq=True)
class LeftOut(Result):
    """A formula, the law or a regression without a value, with the reason."""

    name: str
    reason: str


@result("value", "of", "form", eq=True)
class Regression(Result):
    """The value of a fitted equation for a throw, with the source of the equation."""

    value: InItsUnit
    of: str
    form: str
    largest_error_held_out: Annotated[float | None, Quantity("1")]
    remarks: tuple[str, ...]
    unit: Internal[str] = ""

    @classmethod
    def by_equation(
        cls, value: float, fit: ResponseModel, source: str = "the study", *remarks: str
    ) -> Self:
        """Return the value [SI] of an equation of a source, with remarks on it."""
        held = fit.largest_heldout_error
        judged = (
            "none was held out to judge it"
            if held is None
            else f"its largest error at held-out designs is {percent(held)} %"
        )
        fitted = f"{fit.form.capitalize()} equation fitted to {fit.runs} designs; {judged}."
        return cls(value, source, fit.form, held, (fitted, *remarks), fit.unit)


@result("axial", "torsional", "law", "left_out")
class Formulas(Result):
    """Values of all published formulas for a throw, with those of finite elements, law and regression.

    Of the law those at the same angle. `left_out` has axial formulas without a value in a printed
    reading, and what else does not apply.
    """

    axial: tuple[FormulaValue, ...]
    torsional: tuple[FormulaValue, ...]
    law: Mapping[str, LawAnswer] | None
    left_out: tuple[LeftOut, ...]
    fe: Annotated[ElementsOfThrow | None, Quantity(left_out=True)] = None
    regression: Annotated[Mapping[str, Regression] | None, Quantity(left_out=True)] = None
    gamma_deg: Annotated[float | None, Quantity("deg", left_out=True)] = None
    constants: Annotated[Mapping[str, float] | None, Quantity("1", left_out=True)] = None

    def of_kind(self, kind: Kind) -> tuple[FormulaValue, ...]:
        """Return the axial or the torsional formulas."""
        return self.axial if kind == "axial" else self.torsional

    def by_law(self, kind: Kind) -> LawAnswer | None:
        """Return the law's compliance."""
        return (self.law or {}).get(f"{kind}_compliance")


@result("engine", "formulas")
class EngineFormulas(Result):
    """One of several engines with its formulas."""

    engine: str
    formulas: Flat[Formulas]


def formulas_of(
    throw: Throw,
    material: Material,
    gamma_deg: float = 180.0,
    variant: str = "corrected",
    constants: Mapping[str, float] | None = None,
) -> Formulas:
    """Evaluate all published formulas for a throw; arguments and errors as of `axial_formulas`.

    Of a throw from a file none is evaluated.
    """
    if not isinstance(throw, CrankThrow):
        reason = f"formulas take dimensions, which {Path(throw.path).name} does not give"
        return Formulas((), (), None, (LeftOut("formulas", reason),))
    axial = axial_formulas(
        throw, gamma_deg, material=material, variant=variant, constants=constants
    )
    torsional = torsional_formulas(throw, material=material)
    faults = axial_formula_faults(throw, variant) if variant in ("printed", "corrected") else {}
    law = law_results(throw, material, gamma_deg)
    if law.answers is None:
        faults |= {LAW: f"the law, {str(law.reason).rstrip('.')}"}
    return Formulas(
        axial=tuple(replace(value, name=name) for name, value in axial.items()),
        torsional=tuple(replace(value, name=name) for name, value in torsional.items()),
        law=law.answers,
        left_out=tuple(LeftOut(name, reason) for name, reason in faults.items()),
    )


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


def by_elements(analysis: ThrowAnalysis, gamma_deg: float = 180.0) -> ElementsOfThrow:
    """Return the values by finite elements at an angle between neighboring cranks [deg]."""
    return ElementsOfThrow(
        axial=fe_axial(analysis, gamma_deg),
        torsional=analysis.torsional_compliance("pinned"),
        error_estimate=analysis.error_estimate,
        axial_rigid_sections=fe_axial(analysis.with_sections("rigid"), gamma_deg),
        angle_law=analysis.angle_law if is_symmetric(analysis.superelement) else None,
    )


# In the results of a run.
ANGLES_SHOWN_DEG = np.arange(0.0, 181.0, 5.0)
# Formulas differ by factors: finite elements within 2 % are far more than enough beside them.
ACCURACY = 0.02


@result("value", "valid", eq=True)
class Ratio(Result):
    """Ratio of a formula's value to finite elements, and whether the formula applies to the throw."""

    value: Annotated[float, Quantity("1", key="ratio")]
    valid: bool


@result("engine", "overlap", "fe", eq=True)
class EngineSpread(Result):
    """One engine's formulas compared with finite elements.

    The overlap of main journal and crankpin is negative without overlap. `ratios` has formula name to
    formula / finite elements for each kind.
    """

    engine: str
    overlap: Annotated[float, Quantity("1", "of the crank radius", key="overlap_per_radius")]
    fe: ElementValues
    ratios: Annotated[Mapping[str, Mapping[str, Ratio]], Quantity(key="beside_fe")]


@result("gamma_deg", "engines")
class FormulasOfEngines(Result):
    """What was calculated for each of several engines, at the same angle and with the same constants."""

    gamma_deg: Annotated[float, Quantity("deg")]
    constants: Annotated[Mapping[str, float], Quantity("1")]
    engines: tuple[EngineFormulas | EngineSpread, ...]


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
) -> EngineSpread:
    """Compute one engine's throw by finite elements and by all formulas.

    Parameters
    ----------
    engine : str
        Its name.
    gamma_deg, variant, constants
        As in `axial_formulas`.

    Raises
    ------
    InputError
        As `axial_formulas`.
    """
    formulas = formulas_of(throw, material, gamma_deg, variant, constants)
    analysis = analyze_throw(throw, material, accuracy=ACCURACY)
    fe = ElementValues(
        fe_axial(analysis, gamma_deg),
        analysis.torsional_compliance("pinned"),
        analysis.error_estimate,
    )
    return EngineSpread(
        engine=engine,
        overlap=throw.overlap / throw.crank_radius,
        fe=fe,
        ratios={
            kind: {
                formula.name: Ratio(formula.value / getattr(fe, kind), formula.valid)
                for formula in formulas.of_kind(kind)
            }
            for kind in KINDS
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
    summary = {}
    for name in names:
        ratios = [
            ratio.value
            for spread in spreads
            if (ratio := spread.ratios[kind].get(name)) is not None and ratio.value > 0.0
        ]
        if ratios:
            mean = math.exp(sum(math.log(ratio) for ratio in ratios) / len(ratios))
            summary[name] = FormulaSpread(min(ratios), mean, max(ratios))
    return summary


@result("gamma_deg")
class CompliancesOverAngle(Result):
    """Axial compliances of an engine's throw over the angle between neighboring cranks.

    The formulas have None where they give no compliance above zero.
    """

    gamma_deg: Annotated[Array, Quantity("deg")]
    fe: Annotated[Array, Quantity("m/N")]
    formulas: Annotated[Mapping[str, tuple[float | None, ...]], Quantity("m/N")]
    law: AngleNumbers | None

    def curves(self, throw: ThrowResults) -> Diagram:
        """Describe finite elements and formulas over the angle."""
        curves = {name: np.array(row, dtype=np.float64) for name, row in self.formulas.items()}
        bounds = {name: throw.supports[name].axial for name in ("guided", "pinned")}
        return formulas_over_angle(self.gamma_deg, curves, self.fe, bounds)


def compliances_over_angle(
    throw: Throw, analysis: ThrowAnalysis, law: AngleNumbers | None
) -> CompliancesOverAngle:
    """Return the axial compliances by finite elements and formulas over the angle."""
    tables = [
        axial_formulas(throw, gamma, material=analysis.material)
        for gamma in ANGLES_SHOWN_DEG.tolist()
        if isinstance(throw, CrankThrow)
    ]
    return CompliancesOverAngle(
        gamma_deg=ANGLES_SHOWN_DEG,
        fe=np.array(fe_axial_curve(analysis, ANGLES_SHOWN_DEG.tolist())),
        formulas={
            name: tuple(table[name].value if table[name].value > 0.0 else None for table in tables)
            for name in (tables[0] if tables else ())
        },
        law=law,
    )


@dataclass(frozen=True)
class ComparedRow:
    """A source's compliance in the report's table.

    Attributes
    ----------
    beside : float
        Divided by that of finite elements.
    in_shaft, frequency : float or None
        Mean over the throws in the shaft with that source, and the first natural frequency that follows
        [Hz]; None where the source is not used.
    notes : list of int
        Numbers of its notes.
    """

    name: str
    value: float
    beside: float
    in_shaft: float | None
    frequency: float | None
    applies: bool
    notes: list[int]


@dataclass(frozen=True)
class ComparedCompliances:
    """The rows of each kind, the notes by their numbers from 1, and the ratios of formulas that apply.

    `range` is None where fewer than two apply.
    """

    tables: Mapping[str, list[ComparedRow]]
    notes: list[str]
    range: Mapping[str, tuple[float, float] | None]


def compared_compliances(
    throw: ThrowResults,
    formulas: Formulas,
    sources_in_shaft: Mapping[str, Sequence[Any]] | None = None,
) -> ComparedCompliances:
    """Compare the compliances of a throw by all sources.

    Parameters
    ----------
    sources_in_shaft : mapping, optional
        `SourceFrequencies` by kind of vibration.
    """
    numbers: dict[str, int] = {}

    def rows_of(kind: Kind, fe: float) -> list[ComparedRow]:
        chains = {chain.source: chain for chain in (sources_in_shaft or {}).get(kind, ())}
        rows: list[ComparedRow] = []

        def add(
            name: str, value: float, source: str, remarks: Sequence[str] = (), applies: bool = True
        ) -> None:
            chain = chains.get(source)
            mean = None if chain is None else chain.mean_compliance
            first = None if chain is None else chain.first_frequency
            notes = sorted(numbers.setdefault(text, len(numbers) + 1) for text in remarks)
            rows.append(ComparedRow(name, value, value / fe, mean, first, applies, notes))

        add("finite elements", fe, "fe")
        add("finite elements, pinned throughout", fe, "fe pinned")
        if fitted := (formulas.regression or {}).get(kind):
            add(f"regression of {fitted.of}", fitted.value, "regression", fitted.remarks)
        if law := formulas.by_law(kind):
            width = percent(law.upper / law.value - 1.0)
            text = f"Fitted to finite elements of thousands of throws; 95 of 100 err by less than {width} %."
            add("the law", law.value, "law", [text])
        for formula in formulas.of_kind(kind):
            add(formula.name, formula.value, formula.name, formula.remarks, formula.valid)
        return rows

    tables: dict[str, list[ComparedRow]] = {}
    ranges: dict[str, tuple[float, float] | None] = {}
    for kind in KINDS:
        fe = getattr(throw.supports["pinned"], kind)
        applying = [formula.value / fe for formula in formulas.of_kind(kind) if formula.valid]
        ranges[kind] = (min(applying), max(applying)) if len(applying) > 1 else None
        tables[kind] = rows_of(kind, fe)
    return ComparedCompliances(tables, list(numbers), ranges)


NANO = 1e9


def plot_formulas(
    found: Mapping[str, FormulaValue],
    axes: Axes | None = None,
    *,
    finite_elements: float | None = None,
) -> Axes:
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
    axes: Axes | None = None,
    *,
    analysis: ThrowAnalysis | None = None,
    material: Material = STEEL,
) -> Axes:
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


def plot_run_formulas(results: Result | Mapping[str, Any], axes: Axes | None = None) -> Axes:
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
    shown = CompliancesOverAngle.from_record(content["angle_law"])
    described = shown.curves(ThrowResults.from_record(content["throw"]))
    return _draw(axes, described, "Axial compliance over the angle")


def _draw(axes: Axes | None, described: Diagram, title: str) -> Axes:
    axes = new_axes(axes)
    draw_diagram(axes, described)
    axes.legend(
        frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=3.2
    )
    write_title(axes, title)
    return axes


def formulas_over_angle(
    gammas: Array,
    formulas: Mapping[str, Array],
    fe: Array | None = None,
    bounds: Mapping[str, float] | None = None,
) -> Diagram:
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
    return curve_diagram(
        gammas,
        tuple(series),
        "angle between neighboring cranks γ [deg]",
        "axial compliance [10⁻⁹ m/N]",
        x_step=30.0,
    )
