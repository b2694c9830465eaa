"""Quantities with units: "170 mm" -> 0.170 and 0.170 -> "170 mm"; units with their sizes and spelling."""

import math
import re
from collections.abc import Sequence
from contextlib import suppress
from itertools import pairwise

from crankbase.choices import is_number, is_whole
from crankbase.errors import InputError, quoted, shortened
from crankbase.input_file import LONGEST_QUANTITY
from crankbase.units import NoUnitError, OtherKindError, like_named, size_in, unit_quantity

# The units of tables, axes and sentences: the SI unit of each, and its size in it.
UNITS: dict[str, tuple[str, float]] = {
    "mm": ("m", 1e-3),
    "um": ("m", 1e-6),
    "m": ("m", 1.0),
    "dm^3": ("m^3", 1e-3),
    "N": ("N", 1.0),
    "kN": ("N", 1e3),
    "N m": ("N m", 1.0),
    "kN m": ("N m", 1e3),
    "Pa": ("Pa", 1.0),
    "kPa": ("Pa", 1e3),
    "MPa": ("Pa", 1e6),
    "GPa": ("Pa", 1e9),
    "kg": ("kg", 1.0),
    "kg m": ("kg m", 1.0),
    "kg m^2": ("kg m^2", 1.0),
    "kg/m^2": ("kg/m^2", 1.0),
    "kg/m^3": ("kg/m^3", 1.0),
    "W": ("W", 1.0),
    "kW": ("W", 1e3),
    "kJ": ("J", 1e3),
    "rad": ("rad", 1.0),
    "mrad": ("rad", 1e-3),
    "deg": ("rad", math.pi / 180.0),
    "rad/s": ("rad/s", 1.0),
    "1/min": ("rad/s", math.pi / 30.0),
    "m/s": ("m/s", 1.0),
    "m/s^2": ("m/s^2", 1.0),
    "Hz": ("Hz", 1.0),
    "s": ("s", 1.0),
    "m/N": ("m/N", 1.0),
    "rad/(N m)": ("rad/(N m)", 1.0),
    "N/m": ("N/m", 1.0),
    "N m/rad": ("N m/rad", 1.0),
    "N s/m": ("N s/m", 1.0),
    "N m s/rad": ("N m s/rad", 1.0),
}
# What stands before a unit that is shown, but is none to be written.
POWER_OF_TEN = "1e-9 "
# The unit in which a quantity of each SI unit is shown to people, and its size in SI.
DISPLAY_UNITS: dict[str, tuple[str, float]] = {
    **{UNITS[name][0]: (name, UNITS[name][1]) for name in ("mm", "MPa", "deg", "1/min")},
    **{unit: (f"{POWER_OF_TEN}{unit}", 1e-9) for unit in ("m/N", "rad/(N m)", "1/N")},
}
# Size of a turn per minute [rad/s], and how many there are in a rad/s.
PER_MINUTE = UNITS["1/min"][1]
RPM = 1.0 / PER_MINUTE
# The unit in which diagrams and reports show what vibrates.
VIBRATING = {
    "twist": "mrad",
    "displacement": "um",
    "torque": "kN m",
    "force": "kN",
    "stress": "MPa",
}


def unit_symbol(unit: str) -> str:
    """Return the symbol of a unit of `UNITS` as diagrams and reports print it.

    Examples
    --------
    >>> unit_symbol("um"), unit_symbol("kN m")
    ('µm', 'kN m')
    """
    return "µm" if unit == "um" else unit


def factor_of(unit: str) -> float:
    """Return what a value in SI is multiplied by to be shown in a unit of `UNITS`.

    Examples
    --------
    >>> factor_of("um"), factor_of("MPa")
    (1000000.0, 1e-06)
    """
    return 1.0 / UNITS[unit][1]


UNBOUNDED = "unbounded"
# What is below is round-off: nobody measures a picometer or a millionth of a newton.
ROUND_OFF = {"m": 1e-12, "rad": 1e-12, "N": 1e-6, "N m": 1e-6}


def without_round_off(value: float, unit: str) -> float:
    """Return an SI number, zero in place of round-off.

    Examples
    --------
    >>> without_round_off(7.9e-16, "m"), without_round_off(7.9e-6, "m")
    (0.0, 7.9e-06)
    """
    return 0.0 if abs(value) < ROUND_OFF.get(unit, 0.0) else value


def without_noise(value: float) -> float:
    """Return a number without the noise of round-off, so that equal ones on a tie are written alike.

    Zero has no sign.

    Examples
    --------
    >>> without_noise(0.1 + 0.2)
    0.3
    """
    return float(f"{value:.12g}") + 0.0


def format_number(value: float, digits: int) -> str:
    """Format a number with so many significant digits or, if it is large, all before the point.

    Examples
    --------
    >>> format_number(57.25, 3), format_number(1234.5, 3)
    ('57.2', '1234')
    """
    text = f"{without_noise(value):.{digits}g}"
    return f"{value:.0f}" if "e+" in text else text


def compact(value: float, digits: int = 3) -> str:
    """Write a number with so many digits at most, and a power of ten as in engine files.

    Examples
    --------
    >>> compact(1.4e8), compact(0.5)
    ('1.4e8', '0.5')
    """
    return f"{value + 0.0:.{digits}g}".replace("e+0", "e").replace("e+", "e")


def significant(value: float, digits: int = 4) -> str:
    """Format a number with so many significant digits, zeros at its end included; see `format_number`.

    Examples
    --------
    >>> significant(1.6)
    '1.600'
    >>> significant(15597.0)
    '15597'
    """
    text = f"{without_noise(value):#.{digits}g}"
    return f"{value:.0f}" if "e+" in text else text.removesuffix(".")


def nano(value: float, digits: int = 4) -> str:
    """Write a number in 1e-9 of its unit."""
    return significant(value * 1e9, digits)


def percent(share: float, digits: int = 2, *, signed: bool = False) -> str:
    """Write a share in per cent, with a plus if `signed`; what is next to nothing as that.

    Examples
    --------
    >>> percent(0.00958)
    '0.96'
    >>> percent(12.345)
    '1234'
    >>> percent(2e-12)
    'below 0.001'
    """
    hundredfold = share * 100.0
    if 0.0 < abs(hundredfold) < 1e-3:
        return "below 0.001"
    text = format_number(hundredfold, digits)
    return f"+{text}" if signed and hundredfold >= 0.0 else text


def fixed(value: float, digits: int = 1) -> str:
    """Write a number with so many digits behind the point; round-off is a plain zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def scaled(value: float | None, size: float, digits: int = 3) -> str:
    """Write a number in units of `size`."""
    return UNBOUNDED if value is None else significant(value / size, digits)


def tiny(value: float) -> str:
    """Write the size of an error that is round-off, or nearly.

    Examples
    --------
    >>> tiny(3.87e-13)
    '4e-13'
    """
    return "0" if value == 0.0 else f"{abs(value):.0e}".replace("e-0", "e-")


def format_usage(share: float | None) -> str:
    """Format how much of a limit is used; what is unbounded as that, what exceeds it above 100 %.

    Examples
    --------
    >>> format_usage(0.9996), format_usage(1.0021)
    ('100 %', '100.2 %')
    """
    if share is None or math.isinf(share):
        return UNBOUNDED
    text = format_number(100.0 * share, 3)
    return f"{exceeding(share) if share > 1.0 and text == '100' else text} %"


def exceeding(share: float) -> str:
    """Format a share slightly above one in percent, with the first digit that is above."""
    excess = 100.0 * (share - 1.0)
    digits = max(0, -math.floor(math.log10(excess)))
    return f"{100.0 + excess:.{digits}f}"


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
# Units that large numbers are shown a thousandfold in.
THOUSANDFOLD, KILO_FROM = ("N", "N m", "W"), 1e4
# What an example of a temperature is [K].
ROOM_TEMPERATURE = 293.15
# Nobody means so many of a usual unit, nor a thousand of what another one is a thousand of.
LARGEST_MEANT, MOST_MICROMETERS = 1e4, 1e3
# A wrong unit misses a range by more than this factor; else the number is wrong.
LEAST_MISS = 1.5
# Numbers from here on get an exponent; smaller ones a person reads without one.
WRITTEN_OUT = 1e7

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


def format_quantity(value: float, unit: str, digits: int = 6) -> str:
    """Format an SI number with the unit in which engineers read it.

    Examples
    --------
    >>> format_quantity(0.170, "m")
    '170 mm'
    >>> format_quantity(1.281e-9, "m/N")
    '1.281e-9 m/N'
    >>> format_quantity(30730.0, "N m")
    '30.73 kN m'
    >>> format_quantity(3372.4, "N m", 3)
    '3370 N m'
    """
    return " ".join(number_and_unit(value, unit, digits)).strip()


def number_and_unit(value: float, unit: str, digits: int = 6) -> tuple[str, str]:
    """Write an SI number and, apart from it, the unit in which engineers read it."""
    shown, size = DISPLAY_UNITS.get(unit, (unit, 1.0))
    value = without_round_off(value, unit)
    if shown.startswith(POWER_OF_TEN):
        return f"{value / size:.{digits}g}e-9", unit
    if unit in THOUSANDFOLD and abs(value) >= KILO_FROM:
        shown, size = f"k{unit}", 1e3
    return compact_large(value / size, digits), shown


def compact_large(value: float, digits: int) -> str:
    """Write a number as `compact` does, but without a power of ten where a person reads it so."""
    text = compact(value, digits)
    return f"{float(text):.0f}" if "e" in text and 1.0 <= abs(value) < WRITTEN_OUT else text
