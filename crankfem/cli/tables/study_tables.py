"""Tables of studies: designs and fits."""

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from crankbase.quantity import DISPLAY_UNITS, format_quantity
from crankbase.table import Column, OutputUnit, Table
from crankfem.analyses.record import Record, attributes
from crankfem.analyses.study.fit_records import LACK_OF_FIT
from crankfem.cli.console import number, print_line, print_table
from regression.plans.designs import DesignQuality, design_quality
from regression.plans.factors import Factor
from regression.plans.plan import ExcludedDesign, PlannedStudy
from regression.records import HELD_OUT, RUN
from regression.response_kinds import END_MOMENTS

# More lines than this nobody reads.
MOST_ROWS = 200
MOST_REASONS = 12
# Reasons that differ in numbers alone are told once.
NUMBER = re.compile(r"\d[\d.]*(?:e[+-]?\d+)?")


def plan_record(planned: PlannedStudy) -> dict[str, Any]:
    """Return the designs of a study as JSON content: SI units, choices by their labels."""
    factors, quality = planned.plan.factors, _quality(planned)
    return {
        "study": planned.plan.key,
        "statement": planned.statement,
        "remarks": list(planned.remarks),
        "quality": asdict(quality) | {"correlated": list(quality.correlated)},
        "factors": [
            {"name": factor.name, "unit": factor.unit, "labels": list(factor.labels)}
            for factor in factors
        ],
        "designs": [
            attributes(design, "role", "key") | {"values": _named(factors, design.values)}
            for design in planned.designs
        ],
        "excluded": [
            attributes(design, "role", "reason") | {"values": _named(factors, design.values)}
            for design in planned.excluded
        ],
    }


def print_plan(planned: PlannedStudy) -> None:
    """Print the designs of a study, their names, and which were excluded and why."""
    plan = planned.plan
    held_out = sum(design.role == HELD_OUT for design in planned.designs)
    print_line(
        f"{planned.statement[0].upper()}{planned.statement[1:]}; {held_out} held-out designs to judge the "
        f"fits (Latin hypercube, seed {plan.seed})."
    )
    for remark in planned.remarks:
        print_line(f"Note: {remark}")
    for line in _quality_lines(_quality(planned)):
        print_line(line)
    print_table(
        Table(
            "Designs",
            [Column("design"), Column("role", words=True), *map(_column, plan.factors)],
            [
                [number, design.role, *_named(plan.factors, design.values).values()]
                for number, design in enumerate(planned.designs[:MOST_ROWS], start=1)
            ],
        )
    )
    if len(planned.designs) > MOST_ROWS:
        print_line(f"... and {len(planned.designs) - MOST_ROWS} more; --json has them all.")
    for path, text in plan.relations.items():
        print_line(f"In every design {path} = {text}.")
    _print_excluded(planned)


def _quality(planned: PlannedStudy) -> DesignQuality:
    runs = [design.values for design in planned.designs if design.role == RUN]
    return design_quality(planned.plan.factors, np.array(runs))


def _quality_lines(quality: DesignQuality) -> Iterator[str]:
    """State how well the runs fill the box, with ranges scaled to 0 to 1."""
    distance = "" if quality.distance is None else f"nearest runs {quality.distance:.3g} apart, "
    yield (
        f"Runs in the unit cube: {distance}discrepancy {quality.discrepancy:.2g} (random points: "
        f"{quality.random_discrepancy:.2g})."
    )
    if quality.correlated:
        yield (
            f"Largest correlation of two factors: {quality.correlation:.2g}, of "
            f"{' and '.join(quality.correlated)}."
        )
    elif quality.correlation is not None:
        yield "No two factors are correlated."


def _print_excluded(planned: PlannedStudy) -> None:
    """State which designs are excluded and why; of those for the same reason only the first."""
    if not planned.excluded:
        return
    factors = planned.plan.factors
    print_line(f"Excluded before any finite-element run: {len(planned.excluded)} designs.")
    alike: dict[str, list[ExcludedDesign]] = defaultdict(list)
    for design in planned.excluded:
        alike[NUMBER.sub("#", design.reason)].append(design)
    groups = sorted(alike.values(), key=len, reverse=True)
    for designs in groups[:MOST_REASONS]:
        first = designs[0]
        values = ", ".join(
            f"{factor.name} {factor.format_value(value)}"
            for factor, value in zip(factors, first.values, strict=True)
        )
        more = f" ({len(designs) - 1} more alike)" if len(designs) > 1 else ""
        print_line(f"  {first.role}, {values}: {first.reason.rstrip('.')}{more}.")
    if len(groups) > MOST_REASONS:
        print_line(f"  ... and {len(groups) - MOST_REASONS} other reasons; --json has them all.")


def _column(factor: Factor) -> Column:
    unit, size = DISPLAY_UNITS.get(factor.unit, (factor.unit, 1.0))
    return Column(factor.name, OutputUnit(unit, size), 6, words=bool(factor.labels))


def _named(factors: tuple[Factor, ...], values: tuple[float, ...]) -> dict[str, float | str]:
    return {
        factor.name: factor.setting(value) for factor, value in zip(factors, values, strict=True)
    }


MAIN_RESPONSE = "axial_compliance"
# Relative errors below this are round-off.
LEAST_SHOWN = 1e-5


def print_fits(
    fits: Mapping[str, Record], response: str | None = None, form: str | None = None
) -> None:
    """Print all responses in one table, and one of them with all its forms.

    Parameters
    ----------
    fits : mapping
        Response name to its record (`crankfem.analyses.study.fit_records.fits_record`).
    response : str, optional
        Response to print in detail; by default the axial compliance, or the first.
    form : str, optional
        Form whose equation and coefficients are printed, or its equivalent; by default the chosen one.
    """
    detailed = response or (MAIN_RESPONSE if MAIN_RESPONSE in fits else next(iter(fits)))
    _print_overview(fits, form)
    record = fits[detailed]
    shown = _selected_form(record, form)
    _print_forms(detailed, record, shown)
    print_line(f"Chosen by its errors: {record['reason']}")
    if form is None:
        print_line(
            "The form was chosen by this error, so it is slightly optimistic for other designs."
        )
    else:
        print_line(f"Used because of --form: {form}.")
    for line in record["skipped"]:
        print_line(f"Not fitted: {line}")
    print_line(f"\n{shown['form']}: {shown['equation']}\n")
    if "[" in shown["equation"]:
        print_line("A condition in square brackets is 1 where it holds, 0 elsewhere.")
    _print_coefficients(shown)
    for title, terms in (
        ("Dropped, because PRESS does not grow without them", shown["dropped"]),
        ("Left out, because the runs do not determine them", shown["undetermined"]),
    ):
        if terms:
            print_line(f"{title}: {', '.join(terms)}.")
    for line in shown["warnings"]:
        print_line(f"Warning: {line}")
    print_line(LACK_OF_FIT)
    _print_sensitivities(detailed, record)


def _selected_form(record: Record, form: str | None) -> Record:
    """Return the form for the model: the given one or its equivalent, else the chosen one."""
    wanted = record["chosen"] if form is None else record["twins"].get(form, form)
    selected: Record = next(f for f in record["forms"] if f["form"] == wanted)
    return selected


def print_main_fits(fits: Mapping[str, Record]) -> None:
    """Print all responses in one table, and the equation chosen for the axial compliance."""
    _print_overview(fits)
    record = fits.get(MAIN_RESPONSE)
    if record is not None:
        chosen = _selected_form(record, None)
        print_line(f"{chosen['form']}: {chosen['equation']}")


def print_comparisons(records: list[Record]) -> None:
    """Print imported measured values and those of the equations; nothing if there are none."""
    if not records:
        return
    print_table(
        Table.of_records(
            "Measured values compared with the equations",
            records,
            (Column("source", words=True), "source"),
            (Column("response", words=True), lambda r: _form_label(r["response"])),
            (Column("measured"), "measured"),
            (Column("calculated"), lambda r: r.get("calculated")),
            (Column("calculated / measured", decimals=3, missing=""), lambda r: r.get("ratio")),
        )
    )
    for reason in dict.fromkeys(f"{r['source']}: {r['reason']}" for r in records if "reason" in r):
        print_line(f"Not compared: {reason}")
    remarks = (f"{r['source']}: {text}" for r in records for text in r.get("remarks", ()))
    for remark in dict.fromkeys(remarks):
        print_line(f"Note: {remark}")


def _print_overview(fits: Mapping[str, Record], form: str | None = None) -> None:
    every = {name: _selected_form(record, form) for name, record in fits.items()}
    moments = {name: fit for name, fit in every.items() if name in END_MOMENTS}
    chosen = {name: fit for name, fit in every.items() if name not in moments}
    equations = "their chosen equations" if form is None else f"the form {form}, as given"
    print_table(
        Table.of_records(
            f"All responses by {equations}: largest and mean held-out error, error not exceeded by 95 % of "
            "new throws, estimated error of FE",
            [f | {"name": name, "fe_error": fits[name]["fe_error"]} for name, f in chosen.items()],
            (Column("response", words=True), lambda f: _form_label(f["name"])),
            (Column("form", words=True), "form"),
            (Column("Q2", decimals=5), "q_squared"),
            (Column("held out"), lambda f: _percent(f["largest_error_held_out"])),
            (Column("mean"), lambda f: _percent(f["mean_error_held_out"])),
            (Column("95 %"), lambda f: _percent(f["band_error"])),
            (Column("FE"), lambda f: _percent(f["fe_error"])),
        )
    )
    errors = [fit["largest_error_held_out"] for fit in moments.values()]
    known = [error for error in errors if error is not None]
    if known:
        print_line(
            f"Besides, {len(moments)} responses from which reactions follow: largest held-out error "
            f"{_percent(max(known))}; --response NAME and --json report each ({', '.join(moments)})."
        )


def _print_forms(name: str, record: Record, taken: Record) -> None:
    support = f", {record['support']}" if record["support"] else ""
    print_table(
        Table.of_records(
            f"{_form_label(name).capitalize()} {record['symbol']}{support}: largest (mean) errors in %",
            record["forms"],
            (Column("form", words=True), lambda f: f["form"] + (" *" if f is taken else "")),
            (Column("terms"), "coefficient_count"),
            (Column("R2", decimals=5), "r_squared"),
            (Column("Q2", decimals=5), "q_squared"),
            (Column("at the runs"), lambda f: _both(f, "at_runs")),
            (Column("held out"), lambda f: _both(f, "held_out")),
        )
    )


def _print_coefficients(form: Record) -> None:
    print_table(
        Table.of_records(
            f"Coefficients of {form['form']}: coded (-1 ... 1 over the runs), and natural in SI units",
            form["coded"],
            (Column("term", words=True), "symbols"),
            (Column("coded", digits=5), "coefficient"),
            (Column("std. error", digits=2), "standard_error"),
            (Column("t", digits=3), "t"),
            (Column("VIF", digits=3), "variance_inflation"),
            (Column("natural", digits=6), lambda c: form["coefficients"][c["term"]]),
        )
    )
    adjusted = form["adjusted_r_squared"]
    print_line(
        f"Adjusted R2 {'none' if adjusted is None else f'{adjusted:.5f}'}, F {_or_none(form['f_value'])}, "
        f"AIC {_or_none(form['aic'], 5)}, BIC {_or_none(form['bic'], 5)}, "
        f"condition number {form['condition_number']:.3g}, largest leverage "
        f"{form['largest_leverage']:.2f}."
    )


def _print_sensitivities(name: str, record: Record) -> None:
    sensitivities = record["sensitivities"]
    sobol, elasticity = (
        sensitivities["sobol"] or {"first": {}, "total": {}},
        sensitivities["elasticity"],
    )
    shapley = sobol.get("shapley")

    def nominal(factor: str) -> str:
        value = sensitivities["nominal"][factor]
        return (
            value
            if isinstance(value, str)
            else format_quantity(value, sensitivities["units"][factor])
        )

    def change(factor: str) -> str:
        return f"{round(elasticity[factor], 3) + 0.0:+.3f}" if factor in elasticity else ""

    print_table(
        Table.of_records(
            f"Sensitivity of the {_form_label(name)} by the chosen equation",
            sensitivities["nominal"],
            (Column("factor", words=True), str),
            (Column("nominal"), nominal),
            (Column("elasticity"), change),
            (Column("Sobol, first", decimals=3), sobol["first"].get),
            (Column("total", decimals=3), sobol["total"].get),
            *(() if shapley is None else ((Column("Shapley", decimals=3), shapley.get),)),
        )
    )
    shares = (
        "shares of the variance over the ranges, alone and with others."
        if shapley is None
        else "shares of the variance over the ranges within the constraints: reduction if only this factor "
        "is known (first), remainder if only this factor is unknown (total), and its share of the whole "
        "(Shapley; these add up to 1)."
    )
    print_line(
        "Elasticity: change in per cent for one per cent of the factor, at the nominal values. "
        f"Sobol indices: {shares}"
    )


def _form_label(name: str) -> str:
    return name.replace("_", " ")


def _percent(value: float | None) -> str:
    if value is None:
        return "none"
    return f"{100.0 * value:.3g} %" if value >= LEAST_SHOWN else f"< {100.0 * LEAST_SHOWN:g} %"


def _both(form: Record, designs: str) -> str:
    largest, mean = form[f"largest_error_{designs}"], form[f"mean_error_{designs}"]
    if largest < LEAST_SHOWN:
        return f"< {100.0 * LEAST_SHOWN:g}"
    return f"{100.0 * largest:.3g} ({100.0 * mean:.2g})"


def _or_none(value: float | None, digits: int = 4) -> str:
    return "none" if value is None else number(value, digits)
