"""Several quantities in one option, such as "0, -100, 0 kN"."""

import re

from crankbase.units.quantity import parse_quantity

UNIT = re.compile(r"[a-zA-Z][^,\s]*(\s+[a-zA-Z][^,\s]*)*\s*$")


def parse_quantities(text: str, unit: str, field: str) -> list[float]:
    """Convert quantities between commas to SI numbers; a unit at the end holds for bare numbers too.

    Parameters
    ----------
    text : str
    unit : str
        The SI unit to convert to.
    field : str
        Name of the option, for the message.

    Raises
    ------
    InputError
        If one cannot be read.

    Examples
    --------
    >>> parse_quantities("0, -100, 0.5 kN", "N", "--pin-force")
    [0.0, -100000.0, 500.0]
    """
    parts = [part.strip() for part in text.split(",")]
    last = UNIT.search(parts[-1])
    words = [
        f"{part} {last.group()}" if last is not None and _is_number(part) else part
        for part in parts
    ]
    return [parse_quantity(word, unit, field) for word in words]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
