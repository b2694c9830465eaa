"""The damping of a coupling in the three conventions of data sheets, all converted here."""

import math
from collections.abc import Callable, Mapping

from crankbase.errors import InputError

# The loss factor of each other convention: psi is the energy lost in a cycle over the largest stored, the
# magnifier that of a single inertia at resonance. Each is in the range of a loss factor from 0 to 2.
CONVENTIONS: Mapping[str, Callable[[float], float]] = {
    "relative_damping": lambda psi: psi / (2.0 * math.pi),
    "magnifier": lambda magnifier: 1.0 / magnifier,
}
LARGEST_PSI, SMALLEST_MAGNIFIER = 4.0 * math.pi, 0.5
PSI = "relative damping psi, energy lost in a cycle over the largest stored: 2 pi times the loss factor"
MAGNIFIER = "dynamic magnifier: 1 over the loss factor"


def one_convention(field: str, damping: Mapping[str, float | None]) -> float:
    """Return the loss factor that one of the conventions gives; zero where none does.

    Parameters
    ----------
    field : str
        What stands in front of the names in a message.
    damping : mapping
        Value of loss_factor, relative_damping and magnifier; None, or a loss factor of zero, if absent.

    Examples
    --------
    >>> round(one_convention("", {"relative_damping": 1.13}), 4)
    0.1798
    """
    values = {name: value for name, value in damping.items() if value}
    if len(values) > 1:
        raise InputError(
            f"{field}{list(values)[1]}: given both it and {next(iter(values))}; allowed is one of "
            "loss_factor, relative_damping and magnifier, because each is the same damping in another "
            "convention."
        )
    return sum(CONVENTIONS[name](v) if name in CONVENTIONS else v for name, v in values.items())


def in_all_conventions(loss_factor: float) -> str:
    """Write a damping in all conventions.

    Examples
    --------
    >>> in_all_conventions(0.1)
    'loss factor 0.1, relative damping psi 0.6283, dynamic magnifier 10'
    """
    return (
        f"loss factor {loss_factor:.4g}, relative damping psi {2.0 * math.pi * loss_factor:.4g}, "
        f"dynamic magnifier {1.0 / loss_factor:.4g}"
    )
