"""Several quantities in one option, such as "0, -100, 0 kN"."""

import re

from crankbase.errors import InputError
from crankbase.units.quantity import parse_quantity

UNIT = re.compile(r"[a-zA-Z][^,\s]*(\s+[a-zA-Z][^,\s]*)*\s*$")


def parse_quantities(text: str, unit: str, field: str) -> list[float]:
    """Convert quantities between commas to SI numbers; a unit at the end applies to bare numbers too.

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


def parse_pin_force(text: str) -> list[float]:
    """Return the force on a pin in the throw frame, x, y, z [N]; one number is Z towards the shaft.

    A bare 0 needs no unit.

    Raises
    ------
    InputError

    Examples
    --------
    >>> parse_pin_force("0, -100 kN, 0"), parse_pin_force("100 kN")
    ([0.0, -100000.0, 0.0], [0.0, -100000.0, 0.0])
    """
    from fem.end_reactions import LARGEST_LOAD

    parts = text.split(",")
    if any(UNIT.search(part) for part in parts):
        parts = [f"{part} N" if part.strip() == "0" else part for part in parts]
    found = parse_quantities(",".join(parts), "N", "--pin-force")
    if len(found) == 2 and re.search(r"\d,\d", text):
        raise InputError(
            f"--pin-force: given {text!r}, two numbers; allowed is one, with a decimal point, like "
            f'"{text.strip().replace(",", ".", 1)}", or three, x, y, z.'
        )
    if len(found) not in (1, 3) or not max(map(abs, found)) <= LARGEST_LOAD:
        raise InputError(
            f'--pin-force: given {text!r}; allowed is one radial force, like "100 kN", or x, y, z, like '
            f'"40, -100, 0 kN", none beyond {LARGEST_LOAD:g} N.'
        )
    return found if len(found) == 3 else [0.0, 0.0 - found[0], 0.0]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
