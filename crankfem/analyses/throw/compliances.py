"""Compliances of a throw by finite elements, regression and formulas, in one table for each kind."""

from collections.abc import Mapping
from typing import Any

from crankbase.units.units import percent
from crankfem.analyses.record import Record
from regression.models.response_model import ResponseModel

UNITS = {"axial": "m/N", "torsional": "rad/(N m)"}


def compliance_tables(results: Mapping[str, Any]) -> Record:
    """Return the content of the tables of compliances.

    Parameters
    ----------
    results : mapping
        Content of results.json.

    Returns
    -------
    dict
        "tables": for each kind its unit and rows: name, value, beside finite elements, mean over the throws
        in the shaft with that source and first natural frequency that follows (both None where the source
        is not used), whether it applies, numbers of its notes; "notes": the
        notes in the order of their numbers, each said once; "range": for each kind the lowest and the
        highest ratio of the formulas that apply, None where fewer than two do.
    """
    numbers: dict[str, int] = {}

    def note(text: str) -> int:
        return numbers.setdefault(text, len(numbers) + 1)

    tables, ranges = {}, {}
    for kind, unit in UNITS.items():
        fe = results["throw"]["supports"]["pinned"][f"{kind}_compliance"]
        sources = {own["source"]: own for own in results["vibration"][kind]["sources"]}

        def row(
            name: str,
            value: float,
            source: str,
            remarks: list[str],
            applies: bool = True,
            fe: float = fe,
            sources: Mapping[str, Any] = sources,
        ) -> Record:
            own = sources.get(source)
            return {
                "name": name,
                "value": value,
                "beside": value / fe,
                "in_shaft": None if own is None else own["mean_compliance"],
                "frequency": None
                if own is None
                else own.get("first_frequency", own["first_frequencies"][0]),
                "applies": applies,
                "notes": sorted(note(text) for text in remarks),
            }

        rows = [
            row("finite elements", fe, "fe", []),
            row("finite elements, pinned throughout", fe, "fe pinned", []),
        ]
        regression = results["formulas"].get("regression")
        if regression is not None and regression.get(kind) is not None:
            own = regression[kind]
            rows.append(
                row(
                    f"regression of {own.get('of', 'the study')}",
                    own["value"],
                    "regression",
                    own["remarks"],
                )
            )
        law = (results["formulas"].get("law") or {}).get(f"{kind}_compliance")
        if law is not None:
            width = percent(law["upper"] / law["value"] - 1.0)
            said = f"Fitted to finite elements of thousands of throws; 95 of 100 err by less than {width} %."
            rows.append(row("the law", law["value"], "law", [said]))
        own_rows = [
            row(f["name"], f["value"], f["name"], f["remarks"], f["valid"])
            for f in results["formulas"][kind]
        ]
        applying = [own["beside"] for own in own_rows if own["applies"]]
        ranges[kind] = (min(applying), max(applying)) if len(applying) > 1 else None
        tables[kind] = {"unit": unit, "rows": [*rows, *own_rows]}
    return {"tables": tables, "notes": list(numbers), "range": ranges}


def further_compliances(results: Mapping[str, Any]) -> dict[str, Record]:
    """Return the tables of an engine's further throws by name, without frequencies."""
    return {
        name: compliance_tables(
            {
                "throw": own["throw"],
                "formulas": own["formulas"],
                "throws": {name: own},
                "vibration": {kind: {"sources": []} for kind in UNITS},
            }
        )
        for name, own in list((results.get("throws") or {}).items())[1:]
    }


def regression_record(
    values: Mapping[str, tuple[float, ResponseModel]], source: str = "the study", *remarks: str
) -> Record:
    """Return the results of fitted equations for the throw itself.

    Parameters
    ----------
    values : mapping
        Kind, "axial" or "torsional", to the compliance of the throw [SI] and its equation.
    source : str, optional
        Source of the equations.
    *remarks : str
        Further remarks on them.

    Returns
    -------
    dict
        For each kind "value", "of" (the source), "form", "largest_error_held_out" and "remarks".
    """
    return {
        kind: {
            "value": value,
            "of": source,
            "form": fit.form,
            "largest_error_held_out": fit.largest_heldout_error,
            "remarks": [_fit_remark(fit), *remarks],
        }
        for kind, (value, fit) in values.items()
    }


def _fit_remark(fit: ResponseModel) -> str:
    held = fit.largest_heldout_error
    judged = (
        "none was held out to judge it"
        if held is None
        else f"its largest error at held-out designs is {percent(held)} %"
    )
    return f"{fit.form.capitalize()} equation fitted to {fit.runs} designs; {judged}."
