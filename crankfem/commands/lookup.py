"""Compliances from a model."""

import warnings
from pathlib import Path
from typing import Annotated

import typer

from crankfem import console
from crankfem.commands.options import JsonOption
from crankfem.console import number, print_json
from geometry.model import field_extra
from geometry.quantity import DISPLAY_UNITS, parse_quantity


def lookup(
    model: Annotated[Path, typer.Argument(metavar="MODEL.json", help="Model file.")],
    dimensions: Annotated[
        list[str], typer.Argument(metavar="NAME=VALUE...", help="Dimensions with units.")
    ],
    json: JsonOption = False,
) -> None:
    """Look compliances up in a model, with range check and error."""
    from geometry.throw import CrankThrow
    from regression.compliance_model import ComplianceModel

    loaded = ComplianceModel.load(model)

    def convert(name: str, text: str) -> float:
        info = CrankThrow.model_fields.get(name)
        unit = "m" if info is None else field_extra(info, "unit")
        return parse_quantity(text, unit, name)

    given = console.parse_pairs(dimensions, convert)
    fe_error = loaded.provenance.get("largest_fe_error_estimate")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the answer itself says what lies outside the range
        answers = {name: loaded.lookup(name, **given) for name in loaded.responses}
    if json:
        print_json(
            {
                name: {
                    "value": answer.value,
                    "unit": answer.unit,
                    "support": answer.support,
                    "inside": answer.inside,
                    "remarks": list(answer.remarks),
                    "largest_held_out_error": answer.error,
                    "largest_fe_error_estimate": fe_error,
                    "equation": answer.equation,
                }
                for name, answer in answers.items()
            }
        )
        return
    for name, answer in answers.items():
        shown, size = DISPLAY_UNITS.get(answer.unit, (answer.unit, 1.0))
        digits = number(answer.value / size)
        value = f"{digits}e-9 {answer.unit}" if shown.startswith("1e-9") else f"{digits} {shown}"
        error = "unknown" if answer.error is None else f"{100.0 * answer.error:.2g} %"
        place = "inside the range" if answer.inside else "OUTSIDE the range"
        console.output.print(
            f"{name.replace('_', ' ')}: {value} ({answer.support}), {place}; up to {error} from finite "
            "elements at held-out designs",
            soft_wrap=True,
            highlight=False,
        )
        for remark in answer.remarks:
            console.output.print(f"  {remark}", soft_wrap=True, highlight=False)
    if isinstance(fe_error, float):
        console.output.print(
            f"The finite elements themselves: axial compliance too small by up to about "
            f"{100.0 * fe_error:.2g} %.",
            soft_wrap=True,
            highlight=False,
        )
