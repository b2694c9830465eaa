"""Compliances from a model."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crankfem import console
from crankfem.commands.options import JsonOption
from crankfem.console import print_json
from geometry.errors import InputError

if TYPE_CHECKING:
    from regression.models.compliance_model import ComplianceModel, Lookup


def lookup(
    model: Annotated[Path, typer.Argument(metavar="MODEL.json", help="Model file.")],
    dimensions: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAME=VALUE...", help="Dimensions with units, and choices."),
    ] = None,
    throw: Annotated[
        str | None,
        typer.Option(
            metavar="ENGINE.toml",
            help="Take the dimensions of this file's throw; those given change it.",
        ),
    ] = None,
    gamma: Annotated[
        float | None,
        typer.Option(help="Angle to the neighboring cranks in degrees, for e_n and c."),
    ] = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="Refuse what lies outside the range of the model.")
    ] = False,
    json: JsonOption = False,
) -> None:
    """Look compliances up in a model, with range check and error band."""
    from crankfem.model_arguments import model_dimensions
    from regression.models.compliance_model import ComplianceModel

    loaded = ComplianceModel.load(model)
    asked: dict[str, Any] = {}
    if throw is not None:
        from crankfem.engine_file import load_throw

        asked |= loaded.dimensions_of(load_throw(throw)[0])
    asked |= model_dimensions(loaded, dimensions or [])
    answers, refused = _answers(loaded, asked, gamma, strict)
    if json:
        records = {name: _record(answer) for name, answer in answers.items()}
        print_json(records | {name: {"refused": reason} for name, reason in refused.items()})
        return
    for name, answer in answers.items():
        _print_answer(name, answer)
    for name, reason in refused.items():
        _print(f"{_title(name)}: left out; {reason}")


def _answers(
    model: "ComplianceModel", asked: dict[str, Any], gamma: float | None, strict: bool
) -> tuple[dict[str, "Lookup"], dict[str, str]]:
    """Look all responses up; tell which cannot be, as long as any can."""
    from regression.models.compliance_model import ANGLE_LAWS

    answers: dict[str, Lookup] = {}
    refused: dict[str, str] = {}
    angles = [name for name in model.responses if gamma is not None and name in ANGLE_LAWS]
    if gamma is not None and not angles:
        raise InputError(
            f"--gamma: given {gamma:g}; allowed only with a model of {' or '.join(ANGLE_LAWS)}, because "
            "nothing else depends on the angle."
        )
    for name in angles:
        try:
            model.angle_law(name)
        except InputError as error:
            refused[name] = str(error)
    if angles and len(refused) == len(angles):
        raise InputError(refused[angles[0]])
    for name in [name for name in model.responses if name not in refused]:
        angle = gamma if name in angles else None
        try:
            answers[name] = model.lookup(name, gamma_deg=angle, strict=strict, **asked)
        except InputError as error:
            if strict:
                raise
            refused[name] = str(error)
    if not answers:
        raise InputError(next(iter(refused.values())))
    return answers, refused


def _record(answer: "Lookup") -> dict[str, Any]:
    return {
        "value": answer.value,
        "lower": answer.lower,
        "upper": answer.upper,
        "unit": answer.unit,
        "symbol": answer.symbol,
        "support": answer.support,
        "inside": answer.inside,
        "remarks": list(answer.remarks),
        "largest_held_out_error": answer.error,
        "largest_fe_error_estimate": answer.fe_error,
        "band": answer.band,
        "equation": answer.equation,
    }


def _print_answer(name: str, answer: "Lookup") -> None:
    from crankfem.model_arguments import value_text

    value = value_text(answer.value, answer.unit)
    support = f" ({answer.support})" if answer.support else ""
    if answer.lower is None or answer.upper is None:
        band = "its band is open"
    else:
        lower, upper = (value_text(end, answer.unit) for end in (answer.lower, answer.upper))
        band = f"{lower} to {upper}"
    place = "inside the range" if answer.inside else "OUTSIDE the range, where no band holds"
    _print(f"{_title(name)}: {value}{support}, {band}, {place}")
    for remark in answer.remarks:
        _print(f"  {remark}")
    _print(f"  Band: {answer.band}.")


def _title(name: str) -> str:
    return name.replace("_", " ")


def _print(text: str) -> None:
    console.output.print(text, soft_wrap=True, highlight=False)
