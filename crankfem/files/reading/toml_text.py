"""Write sections as TOML: values as they are parsed, and records with their units."""

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

from crankbase.choices import is_number
from crankbase.errors import InputError
from crankbase.model import InputModel, field_extra
from crankbase.quantity import format_quantity
from crankbase.written_quantity import parse_quantity

BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(content: Mapping[str, Any]) -> str:
    """Return the text that is parsed to the same content.

    Parameters
    ----------
    content : mapping
        Section to fields. Tables become sections of their own, but those with a "value".
    """
    return "\n".join(
        line for name, table in content.items() for line in _section(_key(name), table)
    )


def record_values(record: InputModel) -> dict[str, Any]:
    """Return the given values of a record as they stand in a file, quantities with units."""
    return {
        name: field_value(record, name)
        for name in type(record).model_fields
        if name in record.model_fields_set and getattr(record, name) is not None
    }


def field_value(record: InputModel, name: str) -> Any:
    """Return the value of one field as it stands in a file."""
    return _written(
        getattr(record, name), field_extra(type(record).model_fields[name], "unit") or ""
    )


def _written(value: Any, unit: str) -> Any:
    if isinstance(value, InputModel):
        return record_values(value)
    if isinstance(value, tuple | list):
        return [_written(item, unit) for item in value]
    return quantity_text(value, unit) if unit and is_number(value) else value


def quantity_text(value: float, unit: str) -> str:
    """Write a quantity that is read as exactly this number, in the usual unit where that holds it.

    Examples
    --------
    >>> quantity_text(0.285, "m"), quantity_text(0.1 + 0.2, "m")
    ('285 mm', '0.30000000000000004 m')
    """
    for digits in (6, 12):
        text = format_quantity(value, unit, digits)
        try:
            if parse_quantity(text, unit, "") == value:
                return text
        except InputError:
            break
    return f"{value!r} {unit}"


def _section(name: str, table: Mapping[str, Any], header: str = "[{}]") -> Iterator[str]:
    inner = {key: value for key, value in table.items() if _is_section(value)}
    plain = [key for key in table if key not in inner]
    if plain or not inner or header != "[{}]":
        yield header.format(name)
        yield from (f"{_key(key)} = {_value(table[key])}" for key in plain)
        yield ""
    for key, value in inner.items():
        path = f"{name}.{_key(key)}"
        if isinstance(value, Mapping):
            yield from _section(path, value)
        else:
            for item in value:
                yield from _section(path, item, "[[{}]]")


def _is_section(value: object) -> bool:
    if isinstance(value, list):
        return bool(value) and all(isinstance(item, Mapping) for item in value)
    return isinstance(value, Mapping) and "value" not in value


def _key(name: str) -> str:
    return name if BARE_KEY.fullmatch(name) else _value(name)


def _value(value: Any) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{_key(key)} = {_value(item)}' for key, item in value.items())} }}"
    return str(value)
