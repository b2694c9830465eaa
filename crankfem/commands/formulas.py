"""The published formulas."""

from typing import Annotated, Any

import typer

from crankfem import tables
from crankfem.commands.options import EngineArgument, JsonOption
from crankfem.console import print_json


def formulas(
    engine: EngineArgument,
    gamma: Annotated[float, typer.Option(help="Angle between neighboring cranks in deg.")] = 180.0,
    variant: Annotated[str, typer.Option(help="corrected, printed or k/4.")] = "corrected",
    fe: Annotated[bool, typer.Option(help="Also compute the finite element value.")] = True,
    json: JsonOption = False,
) -> None:
    """Show the published formulas for a throw beside finite elements."""
    from crankfem.engine_file import load_throw
    from crankfem.results import formula_records
    from fem.analysis import analyze_throw
    from fem.supports import Neighbors

    dimensions, material = load_throw(engine)
    records: dict[str, Any] = dict(formula_records(dimensions, material, gamma, variant))
    records["gamma_deg"] = gamma
    if fe:
        analysis = analyze_throw(dimensions, material)
        records["fe"] = {
            "axial": analysis.axial_compliance(Neighbors(gamma, gamma)),
            "torsional": analysis.torsional_compliance("pinned"),
            "error_estimate": analysis.error_estimate,
        }
    if json:
        print_json(records)
        return
    for kind in ("axial", "torsional"):
        tables.print_formula_table(
            f"{kind.capitalize()} compliance"
            + (f", gamma = {gamma:g} deg" if kind == "axial" else ""),
            records[kind],
            records["fe"][kind] if fe else None,
            f"neighbors at {gamma:g} deg" if kind == "axial" else "pinned",
        )
