"""Command-line arguments for a compliance model: dimensions with units, labels, limits."""

import re
from collections.abc import Mapping, Sequence

from crankbase.checks.choices import did_you_mean
from crankbase.errors import InputError
from crankbase.units.quantity import parse_quantity
from crankfem.cli import console
from regression.models.compliance_model import ComplianceModel
from regression.optimum import Limit

_LIMIT = re.compile(r"\s*(?P<name>[\w.]+)\s*(?P<sign><=|>=)\s*(?P<value>.+?)\s*")
_BOUND = re.compile(r"\s*(?P<sign><=|>=)\s*(?P<value>.+?)\s*")


def model_dimensions(model: ComplianceModel, pairs: Sequence[str]) -> dict[str, float | str]:
    """Read NAME=VALUE pairs: quantities with units, plain numbers, and labels of choices.

    Raises
    ------
    InputError
    """
    family = model.family
    choices = {*family.categories, *family.labels}
    known = {*family.ranges, *family.fixed, *family.relations}

    def convert(name: str, text: str) -> float | str:
        if name in choices:
            return text.strip()
        if name not in known:
            family.checked({name: text})  # says that it is unknown
        return parse_value(name, text, family.unit(name))

    return console.parse_pairs(pairs, convert)


def parse_value(name: str, text: str, unit: str) -> float:
    """Read a quantity with its unit, or a pure number where the unit is "".

    Raises
    ------
    InputError
    """
    if unit:
        return parse_quantity(text, unit, name)
    try:
        number: object = float(text)
    except ValueError:
        number = text
    return parse_quantity(number, unit, name)


def parse_limit(model: ComplianceModel, text: str) -> Limit:
    """Read a limit on a response or dimension, like "axial_compliance <= 1.2e-9 m/N".

    Raises
    ------
    InputError
    """
    found = _LIMIT.fullmatch(text)
    if found is None:
        raise InputError(
            f"--limit: given {text!r}; allowed is NAME <= VALUE or NAME >= VALUE, like "
            '"axial_compliance <= 1.2e-9 m/N".'
        )
    name = found["name"]
    response = model.responses.get(name)
    units = model.family.all_units
    if response is None and name not in units:
        meant = did_you_mean(name, (*model.responses, *units))
        raise InputError(
            f"--limit: given {name!r}; {meant}allowed are the responses {', '.join(model.responses)} and the "
            f"dimensions {', '.join(units)}."
        )
    unit = units[name] if response is None else response.unit
    bound = parse_value(name, found["value"], unit)
    if found["sign"] == "<=":
        return Limit((name,), at_most=bound, unit=unit)
    return Limit((name,), at_least=bound, unit=unit)


def parse_bound(option: str, text: str) -> float:
    """Read a lower bound of a frequency, like ">= 40 Hz" or "40 Hz" [Hz].

    Raises
    ------
    InputError
    """
    found = _BOUND.fullmatch(text)
    if found is not None and found["sign"] == "<=":
        raise InputError(
            f'{option}: given {text!r}; allowed is at least a frequency, like ">= 40 Hz", because a '
            "shaft is made stiffer to bring its frequency above the speeds."
        )
    value = parse_quantity(text if found is None else found["value"], "Hz", option)
    if not value > 0.0:
        raise InputError(f"{option}: given {text!r}; allowed is a frequency above 0 Hz.")
    return value


def dimensions_text(model: ComplianceModel, dimensions: Mapping[str, float | str]) -> list[str]:
    """Write dimensions as NAME = VALUE."""
    show = model.family.format_value
    return [
        f"{name} = {value if isinstance(value, str) else show(name, value)}"
        for name, value in dimensions.items()
    ]
