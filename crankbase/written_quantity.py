"""Quantities as a person writes them, in a file or on the command line: "170 mm" -> 0.170."""

import math
import re
from collections.abc import Sequence
from contextlib import suppress
from itertools import pairwise

from crankbase.choices import is_number, is_whole
from crankbase.errors import InputError, quoted, shortened
from crankbase.input_file import LONGEST_QUANTITY
from crankbase.quantity import UNITS, without_noise
from crankbase.units import NoUnitError, OtherKindError, like_named, size_in, unit_quantity

# Between the thousands of a number, beside the comma and the point.
_SPACES = " \u00a0\u2009\u202f"
_MARKS = rf".,'\u2019_{_SPACES}"
SEPARATED_NUMBER = rf"[+-]?\d+(?:[{_MARKS}]\d+)*\.?(?:[eE][+-]?\d+)?"
_QUANTITY = re.compile(
    rf"([+-]?)(\d[\d{_MARKS}]*?)((?:[eE][+-]?\d+)?)[\s]*((?:1?\s*/\s*\(?)?[^\W\d_].*|[%°℃].*|)"
)
_WHOLE = re.compile(rf"\d+|[1-9]\d{{0,2}}([{_MARKS}])\d{{3}}(?:\1\d{{3}})*")
_PLAIN = re.compile(r"\d+\.?\d*")


def readings(text: str) -> tuple[str, ...]:
    """Return what a number with separators may mean, with a decimal point alone and with its unit.

    None for a number without separators, and for what can be read in no way.

    Examples
    --------
    >>> readings("82,5 mm"), readings("1,200 mm"), readings("1 200,50 1/min")
    (('82.5 mm',), ('1.2 mm', '1200 mm'), ('1200.5 1/min',))
    >>> readings("82.5 mm"), readings("17 0 mm")
    ((), ())
    """
    match = _QUANTITY.fullmatch(text.strip())
    if match is None or _PLAIN.fullmatch(match[2]):
        return ()
    sign, digits, power, unit = match.groups()
    split = [tuple(digits.split(mark)) for mark in ",." if digits.count(mark) == 1]
    numbers = []
    for whole, fraction in (*split, (digits, "")):
        if not _WHOLE.fullmatch(whole) or not (fraction or "0").isdigit():
            continue
        thousands = re.sub(r"\D", "", whole)
        numbers.append(f"{thousands}.{fraction}".rstrip("0").rstrip("."))
    return tuple(dict.fromkeys(f"{sign}{number}{power} {unit}".strip() for number in numbers))


def either(meant: tuple[str, ...]) -> str:
    """Name in quotes what may be meant.

    Examples
    --------
    >>> either(("1.2 mm", "1200 mm"))
    '"1.2 mm" or "1200 mm", whichever is meant'
    """
    named = " or ".join(f'"{reading}"' for reading in meant)
    return f"{named}, whichever is meant" if len(meant) > 1 else named


# Revolutions, in a field of speeds.
TURNING = ("1/min", "rad/s")
# Units that are known without pint, which takes a third of a second to load: each with its SI unit.
PLAIN_SIZES = {
    (name, unit): size for name, (unit, size) in UNITS.items() if (name, unit) != TURNING
}
# What an example of a temperature is [K].
ROOM_TEMPERATURE = 293.15
# Nobody means so many of a usual unit, nor a thousand of what another one is a thousand of.
LARGEST_MEANT, MOST_MICROMETERS = 1e4, 1e3
# A wrong unit misses a range by more than this factor; else the number is wrong.
LEAST_MISS = 1.5

# A decimal number, then a unit. pint itself would calculate ("17 0 mm" is a product to it), drop
# commas ("1,2 mm" would be 12 mm) and take a unit alone for one of it.
NUMBER_AND_UNIT = re.compile(
    r"\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(.*?)\s*"
)


def parse_quantity(
    text: object,
    unit: str,
    field: str,
    allowed: str = "",
    limits: tuple[float | None, float | None] = (None, None),
) -> float:
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
    limits : tuple of float or None, optional
        The same range [SI], in which the example of the message lies.

    Returns
    -------
    float
        The value in `unit`.

    Raises
    ------
    InputError
        If the unit is missing, unknown or of another kind, or the number is not finite.
    """
    fault = f"{field}: given {_shortened_text(text)}"
    remedy = f"; allowed is {allowed}" if allowed else ""
    if unit == "":
        return _pure_number(text, fault, remedy)
    if not isinstance(text, str) and not is_number(text):
        example = _example(unit, limits)
        raise InputError(f'{fault}; write a number with its unit, like "{example}"{remedy}.')
    if not isinstance(text, str):
        raise _without_unit(fault, _shortened_text(text), unit, limits, remedy)
    value = _evaluate(text.replace("\u2212", "-"), unit, fault, limits, remedy)
    if unit == "K" and value < 0.0:
        raise InputError(f"{fault}, which is below absolute zero{remedy}.")
    if not math.isfinite(value):
        raise InputError(f"{fault}, which is not finite{remedy}.")
    return value


Limits = tuple[float | None, float | None]
# Units in which people write what has a unit of SI, the most usual first.
WRITTEN = {
    "m": ("mm", "m", "um"),
    "Pa": ("MPa", "GPa", "bar", "kPa", "Pa"),
    "rad": ("deg", "rad"),
    "rad/s": ("1/min", "rad/s"),
    "K": ("degC", "K"),
    "N": ("N", "kN", "MN"),
    "W": ("kW", "MW", "W"),
}


# What messages call a quantity of a unit.
KINDS = {
    "m": "length",
    "kg": "mass",
    "Pa": "pressure or modulus",
    "rad": "angle",
    "rad/s": "speed of rotation",
    "kg m^2": "moment of inertia",
    "N/m": "stiffness",
    "N m/rad": "torsional stiffness",
    "N m s/rad": "torsional damping",
    "N s/m": "damping",
    "rad/(N m)": "torsional flexibility",
    "m/N": "flexibility",
    "N": "force",
    "N m": "torque",
    "W": "power",
    "Hz": "frequency",
    "K": "temperature",
    "s": "time",
    "m^2": "area",
    "kg/m^3": "density",
}


def _is_within(value: float, limits: Limits) -> bool:
    low, high = limits
    return (low is None or value >= low) and (high is None or value <= high)


def other_unit(text: object, unit: str, value: float, limits: Limits) -> str:
    """Return a number that is not allowed in the first usual unit in which it is; else nothing.

    Nothing of what is only just outside, nor what nobody writes, such as 2500 um.

    Parameters
    ----------
    text : object
        What is given, such as "68 m".
    unit : str
        SI unit of the field.
    value : float
        What is given [SI].
    limits : tuple of float or None
        The field's range [SI].

    Examples
    --------
    >>> other_unit("68 m", "m", 68.0, (0.0002, 1.5))
    '68 mm'
    """
    match = NUMBER_AND_UNIT.fullmatch(text) if isinstance(text, str) else None
    if match is None or _is_within(value, limits):
        return ""
    number, small = float(match[1]), 0.0 < value < (limits[0] or 0.0)
    nearer = value * LEAST_MISS if small else value / LEAST_MISS
    # Kelvins and degrees Celsius are near to each other.
    if unit != "K" and _is_within(nearer, limits):
        return ""
    for usual in WRITTEN.get(unit, ()):
        most = MOST_MICROMETERS if usual == "um" else LARGEST_MEANT
        size, zero = size_in(usual, unit)
        if abs(number) < most and _is_within(number * size + zero, limits):
            return f"{match[1]} {usual}"
    return ""


def split_quantity(words: Sequence[str]) -> tuple[str, str] | None:
    """Return a word that ends in a bare number and the unit that is the next word; None if there is none.

    Examples
    --------
    >>> split_quantity(["web_width=300mm", "web_thickness=58", "mm"])
    ('web_thickness=58', 'mm')
    """
    for word, following in pairwise(words):
        number = NUMBER_AND_UNIT.fullmatch(word.rpartition("=")[2])
        if number is None or number[2] or not following[:1].isalnum() or "=" in following:
            continue
        with suppress(NoUnitError):
            if not unit_quantity(following).unitless:
                return word, following
    return None


def _example(unit: str, limits: Limits, number: str = "") -> str:
    """Write a quantity that is allowed: the number that was given in a usual unit, else one in the range."""
    units = WRITTEN.get(unit, (unit,))
    for usual in units if number else ():
        size, zero = size_in(usual, unit)
        if _is_within(float(number) * size + zero, limits):
            return f"{number} {usual}"
    low, high = limits
    if low is not None and high is not None:
        middle = math.sqrt(low * high) if low > 0.0 else 0.5 * (low + high)
    else:
        any_size = ROOM_TEMPERATURE if unit == "K" else 1.0
        middle = any_size if low is None and high is None else float(low or high or 0.0)
    for usual in units:
        size, zero = size_in(usual, unit)
        exact = (middle - zero) / size
        for rounded in (float(f"{exact:.1g}"), exact):
            if 0.01 <= abs(rounded) < 1e5 and _is_within(rounded * size + zero, limits):
                return f"{rounded:g} {usual}"
    return f"{middle:g} {unit}"


def _without_unit(fault: str, number: str, unit: str, limits: Limits, remedy: str) -> InputError:
    return InputError(
        f"{fault}, a bare number that could be in any unit; "
        f'write it with its unit, like "{_example(unit, limits, number)}"{remedy}.'
    )


def _shortened_text(text: object) -> str:
    return quoted(text) if isinstance(text, str | int) else shortened(str(text))


def _evaluate(text: str, unit: str, fault: str, limits: Limits, remedy: str) -> float:
    # A text that long is no quantity, and would take long to look at.
    match = NUMBER_AND_UNIT.fullmatch(text) if len(text) <= LONGEST_QUANTITY else None
    size = None if match is None else PLAIN_SIZES.get((match[2], unit))
    if match is not None and size is not None:
        return _scaled(float(match[1]), size)
    if match is not None and (match[2], unit) == TURNING:
        return _scaled(float(match[1]), 1.0 / 60.0) * (2.0 * math.pi)
    usual = f"write it in {WRITTEN.get(unit, (unit,))[0]} or a like unit{remedy}."
    try:
        if match is None:
            raise NoUnitError("no number in front")
        if not match[2]:
            raise _without_unit(fault, match[1], unit, limits, remedy)
        size, zero = size_in(match[2], unit)
    except NoUnitError as error:
        if error.cure:
            raise InputError(f"{fault}; {error.cure}{remedy}.") from None
        meant = _read_as(text, unit, limits)
        if meant:
            raise InputError(
                f"{fault}; write a decimal point and no separators, like {either(meant)}{remedy}."
            ) from None
        if error.name and match is not None:
            like = _in_like_named(match[1], match[2], error.name, unit, limits)
            raise InputError(f"{fault}, in the unknown unit {error.name}; {like}{usual}") from None
        # As behind a sign for a diameter: "Ø180 mm".
        tail = re.sub(r"^[^\d.+\-\u2012-\u2015\u2212]+", "", text[:LONGEST_QUANTITY])
        example, behind = _example(unit, limits), NUMBER_AND_UNIT.fullmatch(tail)
        with suppress(NoUnitError):
            if behind is not None and not unit_quantity(behind[2]).unitless:
                example = tail
        raise InputError(
            f'{fault}, which is not one number with one unit; write for example "{example}"{remedy}.'
        ) from None
    except OtherKindError:
        assert match is not None
        kind = KINDS.get(unit, f"quantity in {unit}")
        weighed = effect_by_mass(text) if unit == "kg m^2" else None
        if weighed is not None:
            raise InputError(
                f"{fault}, a flywheel effect G D^2; write an inertia, a quarter of its mass and diameter "
                f'squared, "{weighed / 4.0:.6g} kg m^2", or "{weighed:.6g} kg m^2" where a flywheel_effect '
                f"is wanted{remedy}."
            ) from None
        raise InputError(f"{fault}, which is no {kind}; {usual}") from None
    return _scaled(float(match[1]), size) + zero


def _read_as(text: str, unit: str, limits: Limits) -> tuple[str, ...]:
    """Return what a quantity with separators in its number may mean, as far as a field can read it.

    Only what lies in the field's range, if anything does.
    """
    meant, within = [], []
    for reading in readings(text) if len(text) <= LONGEST_QUANTITY else ():
        match = NUMBER_AND_UNIT.fullmatch(reading)
        if match is None or not match[2]:
            meant += [_example(unit, limits, reading)] if match is not None else []
            continue
        with suppress(NoUnitError, OtherKindError):
            size, zero = size_in(match[2], unit)
            meant.append(reading)
            within += [reading] if _is_within(float(match[1]) * size + zero, limits) else []
    return tuple(within or meant)


def _in_like_named(number: str, text: str, name: str, unit: str, limits: Limits) -> str:
    """Return "did you mean ...? " of what is allowed in units that differ in capital letters alone."""
    likely = []
    for other in like_named(name):
        spelling = text.replace(name, other)
        with suppress(NoUnitError, OtherKindError):
            size, zero = size_in(spelling, unit)
            if _is_within(float(number) * size + zero, limits):
                likely.append(f'"{number} {spelling}"')
    return f"did you mean {' or '.join(likely)}? " if likely else ""


def effect_by_mass(text: object) -> float | None:
    """Return a flywheel effect GD2 by weight as one by mass [kg m^2]; None for any other text.

    Examples
    --------
    >>> effect_by_mass("40 kgf m2")
    40.0
    """
    short = text if isinstance(text, str) and len(text) <= LONGEST_QUANTITY else ""
    match = NUMBER_AND_UNIT.fullmatch(short)
    if match is None or not match[2]:
        return None
    try:
        size, _ = size_in(match[2], "N m^2")
    except (NoUnitError, OtherKindError):
        return None
    return float(match[1]) * (size / size_in("kgf", "N")[0])


def _scaled(number: float, factor: float) -> float:
    """Multiply so that "51 mm" is exactly what Python writes as 0.051."""
    inverse = round(1.0 / factor) if factor < 1.0 else 0
    exact = inverse and math.isclose(1.0 / inverse, factor, rel_tol=1e-15)
    return number / inverse if exact else number * factor


def _pure_number(text: object, fault: str, limits: str) -> float:
    short = text if isinstance(text, str) and len(text) <= LONGEST_QUANTITY else ""
    match = NUMBER_AND_UNIT.fullmatch(short)
    if match is not None and not match[2]:
        raise InputError(f"{fault}, a number in quotes; allowed is a number without quotes.")
    if not isinstance(text, float) and not is_whole(text):
        meant = readings(short)
        if match is not None and match[2] == "%":
            meant = (f"{without_noise(float(match[1]) / 100.0):g}",)
        like = f", like {either(meant)}" if meant else ""
        raise InputError(f"{fault}; write a plain number without a unit{like}{limits}.")
    if not is_number(text):  # also a whole number of hundreds of digits
        raise InputError(f"{fault}, which is not finite{limits}.")
    return float(text)
