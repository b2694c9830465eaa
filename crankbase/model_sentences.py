"""What is wrong with the fields of an input record, each a sentence for people."""

from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from crankbase.checks.choices import allowed_names
from crankbase.checks.scalars import is_number
from crankbase.errors import named, quoted
from crankbase.units.quantity import Limits, format_quantity, other_unit
from crankbase.units.units import DISPLAY_UNITS

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails


def field_extra(info: FieldInfo, key: str) -> Any:
    """Return one entry of a field's declaration (unit, symbol, range), or None."""
    extra = info.json_schema_extra
    return extra.get(key) if isinstance(extra, dict) else None


def sentences(model: type[BaseModel], error: ValidationError) -> list[str]:
    """Turn what pydantic found into sentences for people, one for each field."""
    found: dict[str, str] = {}
    for one in error.errors():
        found.setdefault(str(one["loc"][0]) if one["loc"] else "", sentence(model, one))
    return list(found.values())


def sentence(model: type[BaseModel], first: "ErrorDetails") -> str:
    """Turn one finding of pydantic into a sentence."""
    location = [str(part) for part in first["loc"]]
    section = getattr(model, "section", "")
    prefix = f"{section}." if section else ""
    given = first.get("input")
    if first["type"] == "value_error":
        text = str(first["ctx"]["error"])
        if not location:
            return text if text.startswith(prefix) else prefix + text
        return prefix + ".".join(location) + ": " + text
    name = location[0] if location else ""
    field = prefix + ".".join(map(named, location))
    if first["type"] == "missing":
        info = model.model_fields[name]
        return f"{field}: missing; give {_describe(info)}{_allowed_range(info)}."
    if first["type"] == "extra_forbidden":
        return f"{field}: unknown field; {allowed_names(name, model.model_fields)}."
    known = model.model_fields.get(name)
    if known is None:
        return f"{field}: given {quoted(given)}; {first['msg']}."
    unit = field_extra(known, "unit")
    shown = quoted(given)
    if unit is not None and is_number(given):
        shown = format_quantity(float(given), unit)
    if first["type"] == "literal_error":
        expected = str(first["ctx"]["expected"]).replace("'", "")
        return f"{field}: given {quoted(given)}; allowed is {expected}."
    allowed = range_text(known) if unit is not None else ""
    bound = _BOUNDS.get(first["type"])
    if unit is None and bound is not None:
        allowed = bound.format(**first.get("ctx", {}))
    if first["type"] in _KINDS:
        allowed = f"{_KINDS[first['type']]}, {allowed}".removesuffix(", ")
    meant = ""
    if unit is not None and bound is not None:
        value = float(first["input"])
        other = other_unit(f"{value:.12g} {unit}", unit, value, limits_of(known))
        meant = f"did you mean {other}? " if other else ""
    return f"{field}: given {shown}; {meant}allowed is {allowed} for {_describe(known)}."


# What pydantic's findings about fields without a unit mean to people.
_KINDS = {
    "float_type": "a number",
    "int_from_float": "a whole number",
    "int_parsing": "a whole number",
    "int_type": "a whole number",
    "string_type": "text",
    "tuple_type": "a list",
    "dict_type": "a table",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
}
# And about the numbers in them; a field with a unit tells its range.
_BOUNDS = {
    "finite_number": "a finite number",
    "greater_than_equal": "a number of {ge:g} or more",
    "less_than_equal": "a number of {le:g} or less",
}


def _describe(info: FieldInfo) -> str:
    symbol = field_extra(info, "symbol")
    meaning = info.description or "this value"
    return f"{meaning} ({symbol})" if symbol else meaning


def _allowed_range(info: FieldInfo) -> str:
    return f"; allowed is {range_text(info)}" if field_extra(info, "unit") is not None else ""


def limits_of(info: FieldInfo) -> Limits:
    """Return the smallest and the largest value of a field [SI], None where there is none."""
    return field_extra(info, "minimum_si"), field_extra(info, "maximum_si")


def range_text(info: FieldInfo) -> str:
    """Write the allowed range of a field."""
    unit = field_extra(info, "unit")
    low, high = limits_of(info)
    if low is not None and high is not None:
        return f"{format_quantity(low, unit)} to {format_quantity(high, unit)}"
    if low is not None:
        return f"{format_quantity(low, unit)} or more"
    if high is not None:
        return f"{format_quantity(high, unit)} or less"
    return f"any number in {DISPLAY_UNITS.get(unit, (unit,))[0]}" if unit else "any number"
