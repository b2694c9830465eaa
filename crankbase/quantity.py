"""How numbers and quantities are shown: 0.170 -> "170 mm"; the units with their sizes."""

import math

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
# Units that large numbers are shown a thousandfold in.
THOUSANDFOLD, KILO_FROM = ("N", "N m", "W"), 1e4
# Numbers from here on get an exponent; smaller ones a person reads without one.
WRITTEN_OUT = 1e7
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
