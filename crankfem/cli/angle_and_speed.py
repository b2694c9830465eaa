"""The angle of --gamma and the speed of --speed: checks, and the text of the angle."""

import math

from crankbase.errors import InputError
from crankbase.units.quantity import format_quantity, parse_quantity
from crankfem.cli import console


def parse_gamma(text: str, quiet: bool = False) -> float:
    """Return the angle of --gamma [deg].

    A bare number counts as degrees, with a note: the option once took nothing else.

    Raises
    ------
    InputError
        If it is no angle, or not finite.
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
    from regression.formulas.arguments import fold_angle_deg

    folded = fold_angle_deg(gamma_deg)
    return f"{gamma_deg:g} deg" + ("" if folded == gamma_deg else f" (counts as {folded:g})")


def parse_speed(text: str | None) -> float | None:
    """Return the speed of --speed [rad/s], None where it is not given.

    Raises
    ------
    InputError
        If it is no speed, or outside the range of the field engine.rated_speed.

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
        shown = " to ".join(format_quantity(limit, "rad/s", 5) for limit in (low, high))
        raise InputError(
            f"--speed: given {text!r}; allowed is {shown}, because engine.rated_speed has the same limits."
        )
    return speed
