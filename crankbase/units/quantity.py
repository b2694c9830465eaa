"""Text with a unit to SI numbers and back: "170 mm" -> 0.170, and 0.170 -> "170 mm"."""

import math
import re
from functools import cache
from typing import Any

from crankbase.checks.scalars import is_number
from crankbase.errors import InputError
from crankbase.units.units import DISPLAY_UNITS, POWER_OF_TEN

# Units that large numbers are shown a thousandfold in.
THOUSANDFOLD, KILO_FROM = ("N", "N m", "W"), 1e4

# A decimal number, then a unit. pint itself would calculate ("17 0 mm" is a product to it), drop
# commas ("1,2 mm" would be 12 mm) and take a unit alone for one of it.
NUMBER_AND_UNIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.ASCII)
# "g/cm3" is meant as g/cm^3.
POWER = re.compile(r"([A-Za-z])([2-4])\b")


@cache
def unit_registry() -> Any:
    """Return the one pint registry; built on first use because it takes 0.2 s."""
    import pint

    registry: Any = pint.UnitRegistry()
    registry.define("@alias revolution = rev")
    return registry


def parse_quantity(text: object, unit: str, field: str, allowed: str = "") -> float:
    """Convert a quantity with its unit to an SI number.

    Parameters
    ----------
    text : object
        What stands in the file or on the command line, for example ``"170 mm"``.
    unit : str
        The SI unit to convert to; ``""`` for a pure number, which then takes no unit.
        ``"rad/s"`` takes ``"500 1/min"`` as revolutions.
    field : str
        Name of the field, for the message.
    allowed : str
        The field's range, for the message.

    Returns
    -------
    float
        The value in `unit`.

    Raises
    ------
    InputError
        If the unit is missing, unknown or of another kind, or the number is not finite.
    """
    given = f"{field}: given {_shown(text)}"
    limits = f"; allowed is {allowed}" if allowed else ""
    if unit == "":
        return _pure_number(text, given, limits)
    shown = DISPLAY_UNITS.get(unit, (unit, 1.0))[0]
    if shown.startswith(POWER_OF_TEN):
        shown = unit  # "1e-9 m/N" is shown, but no unit to be written
    if not isinstance(text, str) and not is_number(text):
        raise InputError(f'{given}; write a number with its unit, like "1 {shown}"{limits}.')
    if not isinstance(text, str):
        raise InputError(
            f"{given}, a bare number that could be in any unit; "
            f'write it with its unit, like "{text} {shown}"{limits}.'
        )
    value = _evaluate(text, unit, shown, given, limits)
    if not math.isfinite(value):
        raise InputError(f"{given}, which is not finite{limits}.")
    return value


def _shown(text: object) -> str:
    return repr(text) if isinstance(text, str) else str(text)


def _evaluate(text: str, unit: str, shown: str, given: str, limits: str) -> float:
    if "," in text:
        raise InputError(
            f"{given}, in which the comma could mean two things; write a decimal point and no "
            f'separators, like "1.5 {shown}"{limits}.'
        )
    found = NUMBER_AND_UNIT.fullmatch(text)
    try:
        if found is None:
            raise ValueError("no number in front")
        number, rest = float(found[1]), found[2]
        one = unit_registry().Quantity(1.0, unit_registry().parse_units(POWER.sub(r"\1^\2", rest)))
    except Exception:  # pint raises a dozen kinds for text that is no unit
        raise InputError(
            f"{given}, which is not one number with one unit; "
            f'write for example "1.5 {shown}"{limits}.'
        ) from None
    if one.unitless:
        raise InputError(
            f"{given}, a bare number that could be in any unit; "
            f'write it with its unit, like "{text.strip()} {shown}"{limits}.'
        )
    if unit == "rad/s" and one.check("1/[time]") and not _names_an_angle(one):
        # "500 1/min" and "8.3 Hz" mean revolutions in this field.
        return _scaled(number, float(one.to("1/s").magnitude)) * 2.0 * math.pi
    try:
        return _scaled(number, float(one.to(unit).magnitude))
    except Exception:  # pint's DimensionalityError, and offset units such as degC
        raise InputError(
            f"{given}, which is no {_kind(unit)}; write it in {shown} or a like unit{limits}."
        ) from None


def _scaled(number: float, factor: float) -> float:
    """Multiply so that "51 mm" is exactly what Python writes as 0.051."""
    inverse = round(1.0 / factor) if factor < 1.0 else 0
    return number / inverse if inverse and 1.0 / inverse == factor else number * factor


def _names_an_angle(quantity: Any) -> bool:
    return "radian" in str(quantity.to_root_units().units)


def _pure_number(text: object, given: str, limits: str) -> float:
    if isinstance(text, float) and not math.isfinite(text):
        raise InputError(f"{given}, which is not finite{limits}.")
    if not is_number(text):
        raise InputError(f"{given}; write a plain number without a unit{limits}.")
    return float(text)


def _kind(unit: str) -> str:
    kinds = {
        "m": "length",
        "kg": "mass",
        "Pa": "pressure or modulus",
        "rad": "angle",
        "rad/s": "speed of rotation",
        "kg m^2": "moment of inertia",
        "N/m": "stiffness",
        "N m/rad": "torsional stiffness",
        "N": "force",
    }
    return kinds.get(unit, f"quantity in {unit}")


def show_quantity(value: float, unit: str, digits: int = 6) -> str:
    """Write an SI number with the unit in which engineers read it.

    Examples
    --------
    >>> show_quantity(0.170, "m")
    '170 mm'
    >>> show_quantity(1.281e-9, "m/N")
    '1.281e-9 m/N'
    >>> show_quantity(30730.0, "N m")
    '30.73 kN m'
    """
    shown, size = DISPLAY_UNITS.get(unit, (unit, 1.0))
    if shown.startswith(POWER_OF_TEN):
        return f"{value / size:.{digits}g}e-9 {unit}"
    if unit in THOUSANDFOLD and abs(value) >= KILO_FROM:
        shown, size = f"k{unit}", 1e3
    return f"{value / size:.{digits}g} {shown}".strip()
