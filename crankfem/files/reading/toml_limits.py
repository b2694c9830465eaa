"""Limits of a TOML file, before and after parsing; no file written by people reaches them."""

import math
import re
from typing import Any

from crankbase.errors import InputError, shortened
from crankbase.input_file import DEEPEST_TABLE, LONGEST_TEXT, MOST_BITS, MOST_VALUES

# A key of more names than tables may lie in tables; taking it apart would take long. Nothing is gone
# back on, so that looking for it does not take long either.
_LONG_KEY = re.compile(
    rf"(?<![\w-])(?>(?>[\w-]+|\"[^\"\n]*\"|'[^'\n]*')[ \t]*\.[ \t]*){{{DEEPEST_TABLE}}}", re.ASCII
)


def check_keys(name: str, text: str) -> None:
    """Refuse a text with a dotted key of too many names.

    Parameters
    ----------
    name : str
        Of the file, for the message.
    text : str

    Raises
    ------
    InputError
    """
    found = _LONG_KEY.search(text)
    if found is not None:
        line = text.count("\n", 0, found.start()) + 1
        raise InputError(
            f"{name}: line {line}, {shortened(found[0])!r}: given a key of more than {DEEPEST_TABLE} names; "
            f"allowed is {DEEPEST_TABLE} at most, because sections are nested no deeper than a table or two."
        )


def too_deep(name: str) -> InputError:
    """Return the error for too deeply nested tables or lists."""
    return InputError(
        f"{name}: given tables or lists within more than {DEEPEST_TABLE} others; allowed are "
        f"{DEEPEST_TABLE}, because sections are nested no deeper than a table or two."
    )


def check_content(name: str, content: dict[str, Any]) -> None:
    """Refuse content with too many values, too long texts or numbers, or too deeply nested tables.

    Parameters
    ----------
    name : str
        Of the file, for the message.
    content : dict
        From the parser.

    Raises
    ------
    InputError
        With the first field that is too long.
    """
    count = 0
    waiting: list[tuple[str, int, Any]] = [("", 0, content)]
    while waiting:
        field, depth, value = waiting.pop()
        count += 1
        if count > MOST_VALUES:
            raise InputError(
                f"{name}: given more than {MOST_VALUES} values; allowed is {MOST_VALUES} at most, because an "
                "engine has some hundred."
            )
        if depth > DEEPEST_TABLE:
            raise too_deep(name)
        if isinstance(value, dict):
            for key in value:
                _check_text(name, f"{field}.{key}".lstrip("."), key)
            inner = [(f"{field}.{key}".lstrip("."), depth + 1, own) for key, own in value.items()]
            waiting.extend(reversed(inner))
        elif isinstance(value, list):
            inner = [(f"{field}[{place}]", depth + 1, own) for place, own in enumerate(value)]
            waiting.extend(reversed(inner))
        elif isinstance(value, str):
            _check_text(name, field, value)
        elif isinstance(value, float) and not math.isfinite(value):
            raise InputError(
                f"{name}: {field}: given {value}, which is not finite; allowed are numbers up to 1.8e308."
            )
        elif isinstance(value, int) and (value if value > 0 else ~value).bit_length() > MOST_BITS:
            raise InputError(
                f"{name}: {field}: given a whole number of {value.bit_length()} bits; allowed is "
                f"{MOST_BITS} at most, because TOML has no larger ones."
            )


def _check_text(name: str, field: str, text: str) -> None:
    if len(text) > LONGEST_TEXT:
        raise InputError(
            f"{name}: {field}: given {text!r}, of {len(text)} characters; allowed is {LONGEST_TEXT} at most, "
            "because even a citation is shorter."
        )
