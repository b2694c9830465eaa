"""Headings of channels: name and unit, and whether a channel is the time or the crank angle of others."""

import re
from functools import lru_cache
from typing import Literal

from crankbase.exported_table import BRACKETED, DEGREES, NO_UNIT
from crankbase.units import NoUnitError, OtherKindError, pressure_reference, size_in

# Unit in SI of each kind of axis.
AXIS_UNITS = {"time": "s", "angle": "rad"}
# Units in SI of what is measured, in the order in which they are tried: a kg is a mass before it is a weight,
# and a 1/min one of turning.
SI_UNITS = (
    "s", "rad", "kg", "rad/s", "N m", "N", "Pa", "m", "m/s", "m/s^2", "rad/s^2", "W", "K", "V", "m/m",
)  # fmt: skip
# Spelled so, a unit is one of frequency.
_FREQUENCY = re.compile(r"Hz|hertz|cpm|cps|Гц")
# At the end of a name, behind "_", units are these alone: "min", "max", "a" and "in" are words there.
_SUFFIXES = frozenset({
    "s", "ms", "us", "deg", "rad", "mrad", "N", "kN", "Nm", "kNm", "Pa", "kPa", "MPa", "bar", "rpm", "Hz",
    "kHz", "V", "mV", "mm", "um", "m", "kg", "W", "kW", "degC",
})  # fmt: skip
_QUOTIENT = re.compile(r"(.+?)\s+/\s+(\S.*)|(.+?)\s+in\s+(\S+)")
_TIME = re.compile(r"t|x|(?:.*[\W_])?(?:time|zeit|timestamp|время)(?:[\W_].*)?", re.IGNORECASE)
_ANGLE = re.compile(
    r"(?:.*[\W_])?(?:crank|crank_?angle|angle|winkel|kurbelwinkel|kw|ca|cad|phi|°ca|°kw|угол)(?:[\W_].*)?",
    re.IGNORECASE,
)
# Instants of events, not of the samples of other columns.
EVENTS = re.compile(r"pulse|edge|tooth|teeth|zahn|impuls|импульс", re.IGNORECASE)


@lru_cache(maxsize=1024)
def kind_of_unit(unit: str) -> str:
    """Return the unit in SI of a unit's kind; empty if it is unknown.

    Examples
    --------
    >>> [kind_of_unit(unit) for unit in ("U/min", "min-1", "cpm", "kNm", "mil", "%")]
    ['rad/s', 'rad/s', 'Hz', 'N m', 'm', '']
    """
    first: tuple[str, ...] = ("Hz",) if _FREQUENCY.search(unit) else ()
    for si in (*first, *SI_UNITS) if unit else ():
        try:
            size_in(unit, si)
        except OtherKindError:
            continue
        except NoUnitError:
            return ""
        return si
    return ""


def read_unit(text: str) -> tuple[str, str]:
    """Return a unit as the table of units reads it, and what it says of a pressure; empty if it is unknown.

    Examples
    --------
    >>> read_unit("bar(g)"), read_unit("°CA"), read_unit("KW"), read_unit("bananas")
    (('bar', 'gauge'), ('°CA', ''), ('deg', ''), ('', ''))
    """
    unit, reference = pressure_reference(text.strip())
    if kind_of_unit(unit):
        return unit, reference
    return ("deg" if unit and unit.casefold() in DEGREES and unit not in NO_UNIT else ""), ""


def split_heading(heading: str, unit: str = "") -> tuple[str, str]:
    """Split a heading into name and unit; the name stays whole if what follows it is no unit.

    Parameters
    ----------
    unit : str
        Given elsewhere, as in a row of units.

    Examples
    --------
    >>> split_heading("Torque [kNm]"), split_heading("pulse_time_s"), split_heading("n / U/min")
    (('Torque', 'kNm'), ('pulse_time', 's'), ('n', 'U/min'))
    >>> split_heading("p (cylinder 1)"), split_heading("speed_min")
    (('p (cylinder 1)', ''), ('speed_min', ''))
    """
    heading = heading.strip().strip('"').strip()
    tries = []
    if (bracketed := BRACKETED.match(heading)) is not None:
        tries.append((bracketed[1], bracketed[2]))
    if (quotient := _QUOTIENT.fullmatch(heading)) is not None:
        tries.append((quotient[1] or quotient[3], quotient[2] or quotient[4]))
    name, _, suffix = heading.rpartition("_")
    if name and suffix in _SUFFIXES:
        tries.append((name, suffix))
    for name, text in tries:
        text = text.strip()
        if name and (text.casefold() in NO_UNIT or read_unit(text)[0]):
            return name.strip(), unit or text
    return heading, unit


def axis_of(name: str, unit: str) -> Literal["time", "angle", "none"]:
    """Return what a column of rising numbers with this name and unit is for the others: "none" for a channel.

    Examples
    --------
    >>> axis_of("Time", "ms"), axis_of("crank angle", "deg"), axis_of("twist", "deg")
    ('time', 'angle', 'none')
    >>> axis_of("pulse_time", "s")
    'none'
    """
    kind = kind_of_unit(read_unit(unit)[0]) if unit else ""
    if EVENTS.search(name):
        return "none"
    if kind in ("s", "") and _TIME.fullmatch(name):
        return "time"
    if kind in ("rad", "") and _ANGLE.fullmatch(name):
        return "angle"
    return "none"
