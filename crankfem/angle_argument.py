"""The angle between neighboring cranks on the command line: checked, and written as it counts."""

import math

from geometry.errors import InputError
from regression.formulas.arguments import fold_angle_deg


def checked_gamma(gamma_deg: float) -> float:
    """Return the angle of --gamma as it was given [deg].

    Raises
    ------
    InputError
        If it is not finite.
    """
    if not math.isfinite(gamma_deg):
        raise InputError(
            f"--gamma: given {gamma_deg:g}; allowed is a finite angle in deg, because it stands between "
            "neighboring cranks."
        )
    return gamma_deg


def angle_text(gamma_deg: float) -> str:
    """Write an angle between neighboring cranks [deg], and as what it counts.

    Examples
    --------
    >>> angle_text(120.0), angle_text(240.0)
    ('120 deg', '240 deg (counts as 120)')
    """
    folded = fold_angle_deg(gamma_deg)
    return f"{gamma_deg:g} deg" + ("" if folded == gamma_deg else f" (counts as {folded:g})")
