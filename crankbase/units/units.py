"""The units in which numbers are shown: what they are in SI, and how they are written."""

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
