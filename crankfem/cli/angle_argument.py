"""The angle between neighboring cranks on the command line: checked, and written as it counts."""

import math

from crankbase.errors import InputError
from crankbase.units.quantity import parse_quantity
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
            f'--gamma: given {text}; allowed is a finite angle, like "120 deg", because it stands '
            "between neighboring cranks."
        )
    console.print_note(
        f'Note: --gamma {text} is taken as "{text} deg"; write the unit with it.', quiet
    )
    return degrees


def angle_text(gamma_deg: float) -> str:
    """Write an angle between neighboring cranks [deg], and as what it counts.

    Examples
    --------
    >>> angle_text(120.0), angle_text(240.0)
    ('120 deg', '240 deg (counts as 120)')
    """
    from regression.formulas.arguments import fold_angle_deg

    folded = fold_angle_deg(gamma_deg)
    return f"{gamma_deg:g} deg" + ("" if folded == gamma_deg else f" (counts as {folded:g})")
