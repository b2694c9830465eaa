"""Units of measurement as people write them: one table of names, each read as meant or refused by name.

pint knows sizes and dimensions. It also knows names that nobody means here (PS is a petasiemens to it, mil an
angle, ton a short one, Grad a thousand million rad), so that it sees only names of this table, spelled as it
spells them itself.
"""

import math
import re
import unicodedata
from collections.abc import Iterator
from functools import cache, lru_cache
from typing import Any, NamedTuple

from crankbase.input_file import LARGEST_POWER, LONGEST_QUANTITY

# Size in SI of the smallest unit, so that its inverse is a number too.
SMALLEST_UNIT = 1e-300

_PREFIXES = {
    "": "",
    "G": "giga",
    "M": "mega",
    "k": "kilo",
    "h": "hecto",
    "da": "deca",
    "d": "deci",
    "c": "centi",
    "m": "milli",
    "u": "micro",
    "n": "nano",
}
# Metric units: pint's name, and the prefixes with which they are written here. The others are slips of the
# keyboard: "Mm" for mm, "mPa" for MPa, "mW" for MW.
_METRIC = {
    "m": ("meter", "k d c m u n"),
    "g": ("gram", "M k m"),
    "N": ("newton", "G M k da m"),
    "Pa": ("pascal", "G M k h"),
    "bar": ("bar", "k m"),
    "J": ("joule", "M k m"),
    "W": ("watt", "M k"),
    "VA": ("volt_ampere", "M k"),
    "V": ("volt", "k m u"),
    "s": ("second", "m u"),
    "Hz": ("hertz", "k"),
    "rad": ("radian", "m u"),
}
_LONG_METRIC = {
    "meter": ("meter", "kilo deci centi milli micro"),
    "metre": ("meter", "kilo deci centi milli micro"),
    "gram": ("gram", "kilo milli"),
    "newton": ("newton", "mega kilo"),
    "pascal": ("pascal", "giga mega kilo"),
    "joule": ("joule", "kilo"),
    "watt": ("watt", "mega kilo"),
    "second": ("second", "milli micro"),
    "hertz": ("hertz", "kilo"),
    "byte": ("byte", "kilo mega giga"),
    "radian": ("radian", "milli"),
}
_CYRILLIC = {
    "м": ("meter", {"": "", "к": "kilo", "д": "deci", "с": "centi", "м": "milli", "мк": "micro"}),
    "г": ("gram", {"": "", "к": "kilo", "м": "milli"}),
    "Н": ("newton", {"": "", "М": "mega", "к": "kilo", "да": "deca"}),
    "Па": ("pascal", {"": "", "Г": "giga", "М": "mega", "к": "kilo"}),
    "Вт": ("watt", {"": "", "М": "mega", "к": "kilo"}),
    "с": ("second", {"": "", "м": "milli"}),
    "Гц": ("hertz", {"": "", "к": "kilo"}),
    "рад": ("radian", {"": "", "м": "milli"}),
}
# Other names, with pint's: of turns, angle, time, force, mass, pressure, power, length and temperature.
_OTHERS = {
    "turn": "turn turns rev revs revolution revolutions cycle cycles об",
    "revolutions_per_minute": "rpm RPM Upm UpM",
    "revolutions_per_second": "rps",
    "cycles_per_second": "cps",
    "cycles_per_minute": "cpm",
    "degree": "deg degs degree degrees",
    "gon": "gon gons",
    "arcminute": "arcmin",
    "arcsecond": "arcsec",
    "second": "sec seconds",
    "minute": "min minute minutes мин",
    "hour": "h hr hour hours ч",
    "kilogram_force": "kgf kp kG кгс кГ",
    "gram_force": "gf гс",
    "metric_ton_force": "tf Mp тс",
    "pound_force": "lbf",
    "kilopound_force": "klbf kip kips",
    "ounce_force": "ozf",
    "dyne": "dyn dyne",
    "metric_ton": "t tonne tonnes т",
    "short_ton": "short_ton",
    "long_ton": "long_ton",
    "pound": "lb lbs lbm pound pounds",
    "ounce": "oz ounce ounces",
    "slug": "slug slugs",
    "bar": "bara бар",
    "technical_atmosphere": "at ata ат ата",
    "standard_atmosphere": "atm атм",
    "pound_force_per_square_inch": "psi psia",
    "kilopound_force_per_square_inch": "ksi kpsi",
    "torr": "Torr torr",
    "millimeter_Hg": "mmHg",
    "inch_Hg": "inHg",
    "horsepower": "hp",
    "metric_horsepower": "PS CV",
    "british_thermal_unit": "BTU Btu",
    "inch": "in inch inches",
    "foot": "ft foot feet",
    "thou": "thou mil mils",
    "micrometer": "micron microns",
    "liter": "l L liter litre л",
    "cubic_centimeter": "cc ccm",
    "square_centimeter": "qcm",
    "square_millimeter": "qmm",
    "byte": "B",
    "kilobyte": "kB",
    "megabyte": "MB",
    "gigabyte": "GB",
    "terabyte": "TB",
    "mebibyte": "MiB",
    "gibibyte": "GiB",
    "kelvin": "K К kelvin Kelvin degK",
    "degree_Celsius": "degC degС celsius Celsius C",
    "degree_Fahrenheit": "degF fahrenheit Fahrenheit F",
}
# Names of pint's that it does not have itself.
_DEFINED = (
    "cycles_per_second = 1 / second",
    "cycles_per_minute = 1 / minute",
    "kilopound_force = 1000 * pound_force",
    "kilopound_force_per_square_inch = 1000 * pound_force_per_square_inch",
    "square_centimeter = centimeter ** 2",
    "square_millimeter = millimeter ** 2",
)
# What stands for a unit of mass where a weight is meant.
_WEIGHTS = {
    "kilogram": "kilogram_force",
    "gram": "gram_force",
    "metric_ton": "metric_ton_force",
    "pound": "pound_force",
    "ounce": "ounce_force",
}


def _joined_names() -> Iterator[tuple[str, ...]]:
    """List the products that are written as one word, such as kNm, Nms, kgm2 and ftlb."""
    forces = ["N", "kN", "MN", "daN", "mN", "kgf", "kp", "gf", "tf", "Mp", "lbf"]
    for length in ("m", "cm", "mm"):
        for force in [*forces, "kg", "t"]:
            yield from ((force, length), (force, length, "s"))
        yield from ((length, force) for force in ("kg", "kp", "kgf", "t"))
    yield from ((force, "s") for force in [*forces, "J"])
    yield "g", "cm"
    for length in ("in", "ft"):
        for force in ("lb", "lbf", "oz", "ozf"):
            yield from ((force, length), (length, force))
    for force in ("Н", "кН", "МН"):
        yield from ((force, "м"), (force, "м", "с"), (force, "с"))
    yield "кг", "м"


@cache
def _names() -> dict[str, tuple[str, ...]]:
    """Return the table: each name to the factors that it stands for, in pint's names."""
    names: dict[str, tuple[str, ...]] = {
        f"{short}{symbol}": (f"{_PREFIXES[short]}{unit}",)
        for symbol, (unit, prefixes) in _METRIC.items()
        for short in ("", *prefixes.split())
    }
    for word, (unit, prefixes) in _LONG_METRIC.items():
        for prefix in ("", *prefixes.split()):
            for ending in ("",) if word == "hertz" else ("", "s"):
                names[f"{prefix}{word}{ending}"] = (f"{prefix}{unit}",)
    for symbol, (unit, written) in _CYRILLIC.items():
        names |= {f"{short}{symbol}": (f"{prefix}{unit}",) for short, prefix in written.items()}
    for unit, words in _OTHERS.items():
        names |= dict.fromkeys(words.split(), (unit,))
    for parts in _joined_names():
        names.setdefault("".join(parts), tuple(factor for part in parts for factor in names[part]))
    return names


# Names that mean several units, or more than a unit, and what to write in their place.
_AMBIGUOUS = {
    "ton tons": "write t (1000 kg), short_ton (907.185 kg) or long_ton (1016.05 kg), whichever is meant",
    "bhp ihp shp ehp mhp whp": "write PS (735.499 W) or hp (745.7 W), whichever is meant",
    "grad grads Grad град": "write deg (1/360 of a turn) or gon (1/400), whichever is meant",
    "kgs": "write kg (mass) or kgf (force), whichever is meant",
    "кгсм": "write кгс м or кгс см, whichever is meant",
    "BTDC ATDC bTDC aTDC btdc atdc": "write deg, with the sign that the meaning of the field says",
    "GD2 WR2 WK2": "write a moment of inertia in kg m^2, which is G D^2 / 4",
}
# Signs of units that are in use for others, too.
_MARKS = {'"': "in", "''": "in", "″": "in", "'": "ft or arcmin", "′": "ft or arcmin", "#": "lb"}
# Whole units with points in them.
_ABBREVIATED = {"r.p.m": "rpm", "л.с": "PS", "лс": "PS"}

_PRESSURE = r"((?:m?bar|бар|psi|[hkM]?Pa|[кМ]?Па|atm?|атм?|(?:kgf?|kp|кгс?)/[cс][mм]\^?2))"
_ABSOLUTE = re.compile(rf"{_PRESSURE}[\s_]*[(\[]?\s*(?:a|A|abs|Abs|ABS|absolute|абс)\.?\s*[)\]]?")
_GAUGE = re.compile(
    rf"{_PRESSURE}[\s_]*[(\[]?\s*(?:g|G|ga|gauge|Gauge|ü|Ü|u|e|rel|изб|и)\.?\s*[)\]]?"
)
# Letters that stand for a turn in front of a time alone.
_TURN = re.compile(r"^(?:r|U|c|tr|obr)(?=\s*/|[\s*]+(?:min|s)\s?-1)")
# The degree of crank angle is one of turning.
_CRANK_ANGLE = re.compile(r"(?:°|degs?|degrees?)\s*(?:CA|CRA|KW|ПКВ|п\.\s?к\.\s?в)|CAD")

# Middle dots and crosses multiply; a minus is a hyphen; what looks like a degree is one; u is micro.
_SIGNS = str.maketrans(
    {
        **dict.fromkeys("·⋅∙•×∗", "*"),
        **dict.fromkeys("−‐‑", "-"),
        **dict.fromkeys("º˚", "°"),
        **dict.fromkeys("\u00b5\u03bc", "u"),
    }
)
# "g/cm3" is meant as g/cm^3, "min-1" as min^-1.
_POWER = re.compile(r"([^\W\d_])(-?[1-4])(?![\w.])")
# "kg-m2" and "N.m" are products.
_JOINED = re.compile(r"(?<=[\w)])[-.](?=[^\W\d_(])")
_DEGREE = re.compile(r"(?:°|\bdeg(?:rees?|\.)?\s)\s*([CFKСК])\b")
# What pint may see of a unit: names, ones and brackets with exponents, multiplied and divided. Anything else
# it would calculate first, however long that takes.
_NUMBER = r"[+-]?(?!0\d)(?:\d+\.?\d*|\.\d+)"
_EXPONENT = rf"(?:\*\*\s*(?:(?P<power>{_NUMBER})|\(\s*(?P<root>{_NUMBER})\s*(?:/\s*\d+\s*)?\)))?"
_FACTOR = re.compile(rf"(?<![\w.])(?P<name>[^\W\d]\w*)\s*{_EXPONENT}")
# Names and brackets are "x" once they are checked; a one stands before a stroke alone: "10 1 mm" is no 10 mm.
_INVERSE = r"(?:1(?:\.0*)?\s*/\s*)?x\s*"
_BRACKET = re.compile(rf"\(\s*{_INVERSE}(?:[*/]\s*{_INVERSE})*\)\s*{_EXPONENT}")
_SPACE = re.compile(r"(?<=[\w.)])\s+(?=[\w.(])")
_PRODUCT = re.compile(rf"\s*(?:{_INVERSE}(?:[*/]\s*{_INVERSE})*)?")


class NoUnitError(ValueError):
    """Text that is no unit, or one of several.

    Attributes
    ----------
    cure : str
        What to write in its place, as the rest of a sentence; empty if nobody knows.
    name : str
        The name in it that is unknown, if it is that.
    """

    def __init__(self, reason: str, cure: str = "", name: str = "") -> None:
        super().__init__(reason)
        self.cure, self.name = cure, name


@cache
def unit_registry() -> Any:
    """Return the one pint registry; built on first use because it takes 0.2 s."""
    import pint

    registry: Any = pint.UnitRegistry()
    for definition in _DEFINED:
        registry.define(definition)
    return registry


def pressure_reference(unit: str) -> tuple[str, str]:
    """Split a unit of pressure from what it says the pressure is: absolute, or gauge, above the atmosphere.

    Examples
    --------
    >>> pressure_reference("bar(a)"), pressure_reference("barg"), pressure_reference("bar")
    (('bar', 'absolute'), ('bar', 'gauge'), ('bar', ''))
    """
    for reference, pattern in (("absolute", _ABSOLUTE), ("gauge", _GAUGE)):
        if (match := pattern.fullmatch(unit)) is not None:
            return match[1], reference
    return unit, ""


def spelled(text: str) -> str:
    """Spell a unit as a product of names of the table and their powers, whatever signs join them.

    Raises
    ------
    NoUnitError
        If it is too long, or has a name that means several units.

    Examples
    --------
    >>> spelled("kg·m²"), spelled("U/min"), spelled("min-1"), spelled("bar(a)"), spelled("N.m/°")
    ('kg*m**2', 'turn/min', 'min**-1', 'bar', 'N*m/deg')
    """
    if len(text) > LONGEST_QUANTITY:
        raise NoUnitError("too long")
    plain = unicodedata.normalize("NFKC", text.translate(_SIGNS)).translate(_SIGNS).strip()
    plain = _ABBREVIATED.get(plain.rstrip("."), plain)
    if plain in ("%", "‰"):
        raise NoUnitError(f"{plain} is unknown", name=plain)
    if plain in _MARKS:
        raise NoUnitError(plain, f"write a name, {_MARKS[plain]}, in place of a sign")
    if _CRANK_ANGLE.fullmatch(plain.rstrip(".")):
        return "deg"
    pressure, reference = pressure_reference(plain)
    if reference == "absolute":
        plain = pressure
    elif reference == "gauge":
        raise NoUnitError(
            plain,
            "write the absolute pressure, in bar for example, which is that above the atmosphere and "
            "about 1.013 bar more",
        )
    plain = _DEGREE.sub(r"deg\1", plain).replace("°", " deg ").strip()
    plain = re.sub(r"\s*\bper\b\s*|\s*/\s*", "/", plain.replace("^", "**"))
    plain = _TURN.sub("turn", plain)
    plain = _JOINED.sub("*", re.sub(r"(?<=[^\W\d_])\.$", "", plain))
    return _POWER.sub(r"\1**\2", f"1{plain}" if plain.startswith("/") else plain)


def unit_quantity(text: str, *, weights: bool = False) -> Any:
    """Return pint's unit quantity, 1, of a unit written as text; one without unit for empty text.

    Parameters
    ----------
    text : str
        In names of the table.
    weights : bool
        Whether units of mass stand for their weights, as in "lb in" or "kg/cm2".

    Raises
    ------
    NoUnitError
        If the text is no unit of the table, is too long, has exponents that nobody writes, or is of
        a size that is no number.
    """
    registry = unit_registry()
    expression = _checked(spelled(text), weights)
    from pint.errors import PintError

    try:
        quantity = registry.Quantity(1.0, registry.parse_units(expression))
        size = float(quantity.to_root_units().magnitude)
    # Pint fails by an assertion where it finds no unit at all.
    except (PintError, OverflowError, ValueError, AssertionError):
        raise NoUnitError(text) from None
    if not SMALLEST_UNIT <= size <= 1.0 / SMALLEST_UNIT:
        raise NoUnitError("too small or large for a number")
    return quantity


def _checked(text: str, weights: bool) -> str:
    """Replace the names by pint's, and refuse what is no product of powers.

    Raises
    ------
    NoUnitError
    """
    product, names = _SPACE.sub("*", text), _names()
    powers = 1.0

    def factor(match: re.Match[str]) -> str:
        nonlocal powers
        power = abs(float(match["power"] or match["root"] or 1.0))
        if power == 0.0:
            raise NoUnitError("a unit to the power of zero is none")
        powers *= max(1.0, power)
        return "x"

    def replaced(match: re.Match[str]) -> str:
        name = match["name"]
        if name in _several():
            raise NoUnitError(name, _several()[name])
        if name not in names:
            raise NoUnitError(f"{name} is unknown", name=name)
        parts = [_WEIGHTS.get(part, part) if weights else part for part in names[name]]
        # The power of a product in one word is that of its last factor, as in kgm2.
        return f"({'*'.join(parts)}{match[0].removeprefix(name)})"

    left, more = _FACTOR.sub(factor, product), 1
    while more:
        left, more = _BRACKET.subn(factor, left)
    if powers > LARGEST_POWER or _PRODUCT.fullmatch(left) is None:
        raise NoUnitError("no product of powers")
    return _FACTOR.sub(replaced, product)


@cache
def _several() -> dict[str, str]:
    return {name: cure for names, cure in _AMBIGUOUS.items() for name in names.split()}


def is_unit(name: str) -> bool:
    """Return whether a name is that of one unit, no product, such as h or mm."""
    return len(_names().get(name, ())) == 1


def pint_name(name: str) -> str:
    """Return pint's name of a unit; see `is_unit`."""
    return _names()[name][0]


def like_named(name: str) -> tuple[str, ...]:
    """Return the names of the table that differ from an unknown one in capital letters alone."""
    return tuple(other for other in _names() if other.casefold() == name.casefold())


# Dimension of a unit, and the power of the angle in it: a speed of rotation is no frequency.
Kind = tuple[frozenset[tuple[str, float]], float]


def kind_of(quantity: Any) -> Kind:
    """Return the kind of one of pint's quantities."""
    root = quantity.to_root_units()
    angle = float(dict(root.units._units).get("radian", 0.0))
    return frozenset((name, float(power)) for name, power in root.dimensionality.items()), angle


class _Unit(NamedTuple):
    """A unit: its kind, its size in pint's root units, and pint's names in it."""

    kind: Kind
    size: float
    names: frozenset[str]

    def size_in(self, unit: str) -> float | None:
        """Return the size of a unit in one of SI, None if it is of another kind."""
        wanted = _unit(unit)
        (dimension, angle), (wanted_dimension, wanted_angle) = self.kind, wanted.kind
        if dimension != wanted_dimension or not self.names.isdisjoint(_ZEROS):
            return None
        size = self.size / wanted.size
        if unit in PER_TURN:
            if angle not in (0.0, 1.0):
                return None
            return size * math.pow(2.0 * math.pi, wanted_angle - angle)
        left_out = angle == 0.0 and "N m" in unit and self.names.isdisjoint(_COUNTING)
        return size if angle == wanted_angle or left_out else None


@lru_cache(maxsize=4096)
def _unit(text: str, weights: bool = False) -> _Unit:
    quantity = unit_quantity(text, weights=weights)
    names = frozenset(name for name, _ in quantity.units._units.items())
    return _Unit(kind_of(quantity), float(quantity.to_root_units().magnitude), names)


def kind_of_si(unit: str) -> Kind:
    """Return the kind of a unit of SI."""
    return _unit(unit).kind


class OtherKindError(ValueError):
    """A unit of another kind than that of the field."""


# Of these the turn, or the period, is the unit where no angle is named.
PER_TURN = ("rad/s", "Hz")
# Units of temperature whose zero is none: their size and their zero in K.
_ZEROS = {"degree_Celsius": (1.0, 273.15), "degree_Fahrenheit": (5.0 / 9.0, 459.67 * 5.0 / 9.0)}
# Units of power that only a base of values per unit is given in: engines have a power factor of their own.
_APPARENT = {"volt_ampere", "kilovolt_ampere", "megavolt_ampere"}
# Units of time that count turns: a damping of 1 N m/(1/min) is not one of 60 N m s.
_COUNTING = {"minute", "hour", "hertz", "kilohertz", "cycles_per_second", "cycles_per_minute"}


def size_in(text: str, unit: str) -> tuple[float, float]:
    """Return the size of a unit in another one of SI, and its zero: 0 but for temperatures.

    A turn is an angle in a speed, and one period in a frequency; a speed without an angle is in turns. Units
    of mass are weights where only these make sense. The radian of a torsional stiffness may be left out.

    Raises
    ------
    NoUnitError
        If the text is no unit, or one of apparent power where power is wanted.
    OtherKindError
        If it is of another kind.

    Examples
    --------
    >>> size_in("rev/s", "Hz"), size_in("kgf m", "N m"), size_in("degC", "K")
    ((1.0, 0.0), (9.80665, 0.0), (1.0, 273.15))
    """
    for weights in (False, True):
        source = _unit(text, weights)
        if unit != "VA" and not source.names.isdisjoint(_APPARENT):
            raise NoUnitError(
                text, "write the power in kW, which is that in kVA times the power factor"
            )
        if unit == "K" and len(source.names) == 1 and not source.names.isdisjoint(_ZEROS):
            return _ZEROS[next(iter(source.names))]
        if (size := source.size_in(unit)) is not None:
            return size, 0.0
    raise OtherKindError(text)
