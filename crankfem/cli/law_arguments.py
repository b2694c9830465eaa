"""Command-line arguments of a throw for the law."""

from collections.abc import Sequence
from typing import Any

from crankbase.checks.choices import did_you_mean
from crankbase.errors import InputError
from crankbase.model import limits_of, range_text
from crankbase.units.quantity import format_quantity, parse_quantity
from crankfem.cli import console
from crankfem.cli.throw_choice import select_throw
from fem.material import STEEL, Material
from geometry.throw import CrankThrow
from regression.throw_values import field_unit


def law_throw(
    pairs: Sequence[str], engine: str | None = None, quiet: bool = False
) -> tuple[CrankThrow, Material]:
    """Make a throw of NAME=VALUE pairs, or of an engine's throw that they change.

    Raises
    ------
    InputError
        If a name is not a dimension, a value is not allowed, or they are not a possible throw.
    """
    given = console.parse_pairs(pairs, _convert)
    if engine is None:
        return CrankThrow(**given), STEEL
    throw, material = select_throw(engine, quiet=quiet)
    return throw.changed(**given), material


def throw_text(throw: CrankThrow) -> list[str]:
    """Write the dimensions of a throw as NAME = VALUE, those that are there."""
    values = ((name, getattr(throw, name)) for name in type(throw).model_fields)
    return [
        f"{name} = {format_quantity(value, field_unit(name) or '')}"
        for name, value in values
        if isinstance(value, float) and value != 0.0
    ]


def _convert(name: str, text: str) -> Any:
    choices = [one for one in CrankThrow.model_fields if field_unit(one) is not None]
    if name == "web_outline":
        return text.strip()
    if name not in choices:
        raise InputError(
            f"{name}: unknown dimension; {did_you_mean(name, choices)}allowed are web_outline, "
            f"{', '.join(choices)}; parts of a throw come with --throw ENGINE.toml."
        )
    field = CrankThrow.model_fields[name]
    return parse_quantity(text, field_unit(name) or "", name, range_text(field), limits_of(field))
