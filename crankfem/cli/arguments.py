"""What several commands take: throws, models, laws, angles, speeds, quantities and firing orders."""

import math
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from crankbase.array_checks import refuse_crank_radians
from crankbase.choices import did_you_mean
from crankbase.errors import InputError
from crankbase.model import limits_of, range_text
from crankbase.sentences import amount
from crankbase.written_quantity import parse_quantity
from crankfem.cli import console
from fem.material import STEEL, Material
from geometry.throw import CrankThrow

if TYPE_CHECKING:
    from crankfem.files.reading.toml_file import TomlFile
    from geometry.any_throw import Throw
    from regression.models.compliance_model import ComplianceModel
    from regression.models.family import Family


def parse_gamma(text: str, quiet: bool = False) -> float:
    """Return the angle of --gamma [deg].

    A bare number counts as degrees, with a note: the option once took nothing else.
    """
    try:
        degrees = float(text)
    except ValueError:
        # Rounding takes away what the way over radians adds to "120 deg".
        return round(math.degrees(parse_quantity(text, "rad", "--gamma")), 9)
    if not math.isfinite(degrees):
        raise InputError(
            f'--gamma: given {text}; allowed is a finite angle, like "120 deg", because it is the '
            "angle between neighboring cranks."
        )
    console.print_note(f'Note: --gamma {text} is read as "{text} deg"; write the unit.', quiet)
    return degrees


def angle_text(gamma_deg: float) -> str:
    """Write an angle between neighboring cranks [deg], and the equivalent one in use.

    Examples
    --------
    >>> angle_text(120.0), angle_text(240.0)
    ('120 deg', '240 deg (counts as 120)')
    """
    from regression.response_kinds import fold_angle_deg

    folded = fold_angle_deg(gamma_deg)
    return f"{gamma_deg:g} deg" + ("" if folded == gamma_deg else f" (counts as {folded:g})")


def parse_speed(text: str | None) -> float | None:
    """Return the speed of --speed [rad/s], None where it is not given.

    Examples
    --------
    >>> parse_speed("5 rad/s")
    5.0
    """
    # Imported here: the sections take long to load.
    from crankbase.model import field_extra
    from crankfem.files.sections.engine_sections import Engine

    if text is None:
        return None
    speed = parse_quantity(text, "rad/s", "--speed")
    field = Engine.model_fields["rated_speed"]
    low, high = (float(field_extra(field, key)) for key in ("minimum_si", "maximum_si"))
    if not low <= speed <= high:
        shown = " to ".join(amount(limit, "rad/s", 5) for limit in (low, high))
        raise InputError(
            f"--speed: given {text!r}; allowed is {shown}, because engine.rated_speed has the same limits."
        )
    return speed


def select_throw(
    engine: "str | TomlFile", name: str | None = None, quiet: bool = False, *, alone: bool = True
) -> "tuple[Throw, Material]":
    """Select the throw of a name; by default that at the free end, with a note if there are others.

    Parameters
    ----------
    engine : str or TomlFile
        File, or the name of a shipped engine; or its sections, if already read.
    name : str, optional
        From `--throw`.
    quiet : bool
        Whether to omit notes.
    alone : bool
        Whether the command uses no other throw, so that the others are named as not used.
    """
    from crankfem.files.engine.throw_file import load_throw, names_of_throws, unused_throws

    first, *others = names_of_throws(engine)
    if name is None and others:
        console.print_note(
            f"Note: throw {first} is used; the file has {', '.join(others)} too.", quiet
        )
    if alone and console.output.not_used is not None:
        console.output.not_used += unused_throws(engine, name or first)
    return load_throw(engine, name)


def model_dimensions(model: "ComplianceModel", pairs: Sequence[str]) -> dict[str, float | str]:
    """Read NAME=VALUE pairs: quantities with units, plain numbers, and labels of choices."""
    family = model.family
    choices = {*family.categories, *family.labels}
    known = {*family.ranges, *family.fixed, *family.relations}

    def convert(name: str, text: str) -> float | str:
        if name in choices:
            return text.strip()
        if name not in known:
            family.checked({name: text})  # says that it is unknown
        return parse_value(name, text, family.unit(name))

    return console.parse_pairs(pairs, convert)


def parse_value(name: str, text: str, unit: str) -> float:
    """Read a quantity with its unit, or a pure number where the unit is ""."""
    if unit:
        return parse_quantity(text, unit, name)
    try:
        number: object = float(text)
    except ValueError:
        number = text
    return parse_quantity(number, unit, name)


def dimensions_text(family: "Family", dimensions: Mapping[str, float | str]) -> list[str]:
    """Write dimensions as NAME = VALUE."""
    return [
        f"{name} = {value if isinstance(value, str) else amount(value, family.unit(name))}"
        for name, value in dimensions.items()
    ]


UNIT = re.compile(r"[a-zA-Z][^,\s]*(\s+[a-zA-Z][^,\s]*)*\s*$")


def parse_quantities(text: str, unit: str, field: str) -> list[float]:
    """Convert quantities between commas to SI numbers; a unit at the end applies to bare numbers too.

    Parameters
    ----------
    unit : str
        The SI unit to convert to.
    field : str
        Name of the option, for the message.

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


def parse_pin_force(text: str, radial: Sequence[float] = (0.0, -1.0, 0.0)) -> list[float]:
    """Return the force on a pin in the throw frame, x, y, z [N]; one number is Z towards the shaft.

    A bare 0 needs no unit.

    Examples
    --------
    >>> parse_pin_force("0, -100 kN, 0"), parse_pin_force("100 kN")
    ([0.0, -100000.0, 0.0], [0.0, -100000.0, 0.0])
    """
    from fem.end_reactions import LARGEST_LOAD

    parts = text.split(",")
    if any(UNIT.search(part) for part in parts):
        parts = [f"{part} N" if part.strip() == "0" else part for part in parts]
    forces = parse_quantities(",".join(parts), "N", "--pin-force")
    if len(forces) == 2 and re.search(r"\d,\d", text):
        raise InputError(
            f"--pin-force: given {text!r}, two numbers; allowed is one, with a decimal point, like "
            f'"{text.strip().replace(",", ".", 1)}", or three, x, y, z.'
        )
    if len(forces) not in (1, 3) or not max(map(abs, forces)) <= LARGEST_LOAD:
        raise InputError(
            f'--pin-force: given {text!r}; allowed is one radial force, like "100 kN", or x, y, z, like '
            f'"40, -100, 0 kN", none beyond {LARGEST_LOAD:g} N.'
        )
    return forces if len(forces) == 3 else [0.0 + forces[0] * share for share in radial]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def law_throw(
    pairs: Sequence[str], engine: str | None = None, quiet: bool = False
) -> tuple[CrankThrow, Material]:
    """Make a throw of NAME=VALUE pairs, or of an engine's throw that they change."""
    dimensions = console.parse_pairs(pairs, _convert)
    if engine is None:
        return CrankThrow(**dimensions), STEEL
    throw, material = select_throw(engine, quiet=quiet)
    from geometry.any_throw import with_dimensions  # here: most throws are given by dimensions

    return with_dimensions(throw).changed(**dimensions), material


def throw_text(throw: CrankThrow) -> list[str]:
    """Write the dimensions of a throw as NAME = VALUE, those that are there."""
    from regression.throw_values import field_unit

    values = ((name, getattr(throw, name)) for name in type(throw).model_fields)
    return [
        f"{name} = {amount(value, field_unit(name) or '')}"
        for name, value in values
        if isinstance(value, float) and value != 0.0
    ]


def _convert(name: str, text: str) -> Any:
    from regression.throw_values import field_unit

    choices = [field for field in CrankThrow.model_fields if field_unit(field) is not None]
    if name == "web_outline":
        return text.strip()
    if name not in choices:
        raise InputError(
            f"{name}: unknown dimension; {did_you_mean(name, choices)}allowed are web_outline, "
            f"{', '.join(choices)}; parts of a throw come with --throw ENGINE.toml."
        )
    field = CrankThrow.model_fields[name]
    return parse_quantity(text, field_unit(name) or "", name, range_text(field), limits_of(field))


def firing_angles_deg(order: str | None, angles: str | None, *, strokes: int) -> list[float]:
    """Return the shaft angle at which each cylinder fires [deg]; none without options.

    Parameters
    ----------
    order : str or None
        Numbers of the cylinders as they fire, at even steps over the cycle.
    angles : str or None
        With a unit each, or one at the end for all.
    strokes : int
        Per cycle, 2 or 4.

    Examples
    --------
    >>> firing_angles_deg("1-3-4-2", None, strokes=4)
    [0.0, 540.0, 180.0, 360.0]
    >>> firing_angles_deg(None, "0, 90 deg", strokes=2)
    [0.0, 90.0]
    """
    from dynamics.cycle import cycle_degrees
    from dynamics.engine.layout import MOST_CYLINDERS, firing_order_from_text

    if order is not None and angles is not None:
        raise InputError(
            f"--firing-order: given {order!r} with --firing-angles; allowed is one of them, because each "
            "defines when the cylinders fire."
        )
    if angles is not None:
        radians = parse_quantities(angles, "rad", "--firing-angles")
        if len(radians) > MOST_CYLINDERS:
            raise InputError(
                f"--firing-angles: given {len(radians)} angles; allowed are at most {MOST_CYLINDERS}, one "
                "for each cylinder."
            )
        # Rounding takes away what the way over radians adds.
        degrees = [round(math.degrees(angle), 9) for angle in radians]
        refuse_crank_radians("--firing-angles", degrees, written=True)
        return degrees
    if order is None:
        return []
    numbers = firing_order_from_text(order, "--firing-order: ")
    count = len(numbers)
    if count > MOST_CYLINDERS or sorted(numbers) != list(range(1, count + 1)):
        raise InputError(
            f"--firing-order: given {order!r}; allowed is each number from 1 to that of the last cylinder, "
            f'at most {MOST_CYLINDERS}, once, like "1-3-4-2", because each cylinder fires once in a cycle.'
        )
    cycle = cycle_degrees(strokes)
    return [cycle * numbers.index(number) / count for number in range(1, count + 1)]
