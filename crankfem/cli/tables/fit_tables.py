"""The tables of `crankfem fit`: all responses, and the forms of one with all that is known of them."""

from collections.abc import Mapping

from crankbase.tables.table import Column, Table
from crankbase.units.quantity import format_quantity
from crankfem.analyses.record import Record
from crankfem.analyses.study.fit_records import LACK_OF_FIT
from crankfem.cli.console import number, print_line, print_table

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
        Which one in detail; the axial compliance, or the first, otherwise.
    form : str, optional
        Whose equation and coefficients are printed, or its twin's; the chosen one's otherwise.
    """
    detailed = response or (MAIN_RESPONSE if MAIN_RESPONSE in fits else next(iter(fits)))
    _print_overview(fits, form)
    record = fits[detailed]
    shown = _selected_form(record, form)
    _print_forms(detailed, record, shown)
    print_line(f"Chosen by its errors: {record['reason']}")
    if form is None:
        print_line("That error chose the form, so it is slightly optimistic for other designs.")
    else:
        print_line(f"Taken all the same, as --form asks: {form}.")
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
    """Return the form that goes into the model: the given one or its twin, else the chosen one."""
    wanted = record["chosen"] if form is None else record["twins"].get(form, form)
    found: Record = next(f for f in record["forms"] if f["form"] == wanted)
    return found


def print_main_fits(fits: Mapping[str, Record]) -> None:
    """Print all responses in one table, and the equation chosen for the axial compliance."""
    _print_overview(fits)
    record = fits.get(MAIN_RESPONSE)
    if record is not None:
        chosen = _selected_form(record, None)
        print_line(f"{chosen['form']}: {chosen['equation']}")


def print_comparisons(records: list[Record]) -> None:
    """Print imported measured values beside the equations; nothing if there are none."""
    if not records:
        return
    print_table(
        Table(
            "Measured values beside the equations",
            [
                Column("source", words=True),
                Column("response", words=True),
                Column("measured"),
                Column("calculated"),
                Column("calculated / measured", decimals=3, missing=""),
            ],
            [
                [
                    r["source"],
                    _form_label(r["response"]),
                    r["measured"],
                    r.get("calculated"),
                    r.get("ratio"),
                ]
                for r in records
            ],
        )
    )
    for reason in dict.fromkeys(f"{r['source']}: {r['reason']}" for r in records if "reason" in r):
        print_line(f"Not compared: {reason}")
    remarks = (f"{r['source']}: {text}" for r in records for text in r.get("remarks", ()))
    for remark in dict.fromkeys(remarks):
        print_line(f"Note: {remark}")


def _print_overview(fits: Mapping[str, Record], form: str | None = None) -> None:
    chosen = {name: _selected_form(record, form) for name, record in fits.items()}
    equations = "their chosen equations" if form is None else f"the form {form}, as given"
    print_table(
        Table(
            f"All responses by {equations}: largest and mean error held out, estimated error of FE",
            [
                Column("response", words=True),
                Column("form", words=True),
                Column("Q2", decimals=5),
                *map(Column, ("held out", "mean", "FE")),
            ],
            [
                [
                    _form_label(name),
                    f["form"],
                    f["q_squared"],
                    _percent(f["largest_error_held_out"]),
                    _percent(f["mean_error_held_out"]),
                    _percent(fits[name]["fe_error"]),
                ]
                for name, f in chosen.items()
            ],
        )
    )


def _print_forms(name: str, record: Record, taken: Record) -> None:
    support = f", {record['support']}" if record["support"] else ""
    print_table(
        Table(
            f"{_form_label(name).capitalize()} {record['symbol']}{support}: largest (mean) errors in %",
            [
                Column("form", words=True),
                Column("terms"),
                *(Column(name, decimals=5) for name in ("R2", "Q2")),
                *map(Column, ("at the runs", "held out")),
            ],
            [
                [
                    f["form"] + (" *" if f is taken else ""),
                    f["coefficient_count"],
                    f["r_squared"],
                    f["q_squared"],
                    _both(f["largest_error_at_runs"], f["mean_error_at_runs"]),
                    _both(f["largest_error_held_out"], f["mean_error_held_out"]),
                ]
                for f in record["forms"]
            ],
        )
    )


def _print_coefficients(form: Record) -> None:
    natural = form["coefficients"]
    print_table(
        Table(
            f"Coefficients of {form['form']}: coded (-1 ... 1 over the runs), and natural in SI units",
            [
                Column("term", words=True),
                Column("coded", digits=5),
                Column("std. error", digits=2),
                Column("t", digits=3),
                Column("VIF", digits=3),
                Column("natural", digits=6),
            ],
            [
                [
                    c["symbols"],
                    c["coefficient"],
                    c["standard_error"],
                    c["t"],
                    c["variance_inflation"],
                    natural[c["term"]],
                ]
                for c in form["coded"]
            ],
        )
    )
    print_line(
        f"Adjusted R2 {_share(form['adjusted_r_squared'])}, F {_or_none(form['f_value'])}, "
        f"AIC {_or_none(form['aic'], 5)}, BIC {_or_none(form['bic'], 5)}, "
        f"condition number {form['condition_number']:.3g}, largest leverage "
        f"{form['largest_leverage']:.2f}."
    )


def _print_sensitivities(name: str, record: Record) -> None:
    found = record["sensitivities"]
    sobol = found["sobol"] or {"first": {}, "total": {}}
    print_table(
        Table(
            f"Sensitivity of the {_form_label(name)} by the chosen equation",
            [
                Column("factor", words=True),
                Column("nominal"),
                Column("elasticity"),
                Column("Sobol, first", decimals=3),
                Column("total", decimals=3),
            ],
            [
                [
                    factor,
                    value
                    if isinstance(value, str)
                    else format_quantity(value, found["units"][factor]),
                    f"{round(found['elasticity'][factor], 3) + 0.0:+.3f}"
                    if factor in found["elasticity"]
                    else "",
                    *(sobol[order].get(factor) for order in ("first", "total")),
                ]
                for factor, value in found["nominal"].items()
            ],
        )
    )
    print_line(
        "Elasticity: change in per cent for one per cent of the factor, at the nominal values. "
        "Sobol indices: shares of the variance over the ranges, alone and with others."
    )


def _form_label(name: str) -> str:
    return name.replace("_", " ")


def _share(value: float | None) -> str:
    return "none" if value is None else f"{value:.5f}"


def _percent(value: float | None) -> str:
    if value is None:
        return "none"
    return f"{100.0 * value:.3g} %" if value >= LEAST_SHOWN else f"< {100.0 * LEAST_SHOWN:g} %"


def _both(largest: float, mean: float) -> str:
    if largest < LEAST_SHOWN:
        return f"< {100.0 * LEAST_SHOWN:g}"
    return f"{100.0 * largest:.3g} ({100.0 * mean:.2g})"


def _or_none(value: float | None, digits: int = 4) -> str:
    return "none" if value is None else number(value, digits)
