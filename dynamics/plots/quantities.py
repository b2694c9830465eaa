"""Names of vibrating quantities on an axis, the units they are shown in."""

import math
from typing import Literal, NamedTuple, TypeAlias

from geometry.errors import InputError

# Turns per minute in a radian per second.
RPM = 30.0 / math.pi
# What values in SI are multiplied by to be shown in thousands, thousandths and so on.
KILO, MEGA, MILLI, MICRO = 1e-3, 1e-6, 1e3, 1e6
SPEED_LABEL = "crankshaft speed [1/min]"

Quantity: TypeAlias = Literal["twist", "displacement", "torque", "force", "stress"]
# Label of the axis, and what a value in SI is multiplied by.
QUANTITIES: dict[str, tuple[str, float]] = {
    "twist": ("amplitude [mrad]", MILLI),
    "displacement": ("amplitude [µm]", MICRO),
    "torque": ("alternating torque [kN m]", KILO),
    "force": ("alternating force [kN]", KILO),
    "stress": ("alternating stress [MPa]", 1e-6),
}
SI_UNITS: dict[str, str] = {
    "twist": "rad",
    "displacement": "m",
    "torque": "N m",
    "force": "N",
    "stress": "Pa",
}


class Shown(NamedTuple):
    """How a quantity is drawn.

    Parameters
    ----------
    label : str
        Of the axis, with its unit.
    factor : float
        What a value in SI is multiplied by.
    unit : str
        The unit in SI.
    """

    label: str
    factor: float
    unit: str


def shown(quantity: Quantity | None, either: str, words: str = "amplitude") -> Shown:
    """Tell how a quantity is drawn.

    Parameters
    ----------
    quantity : {"twist", "displacement", "torque", "force", "stress"}, optional
        What the values are; a chain may be a torsional or an axial one and does not say.
    either : str
        Unit in SI where that is not told, such as "rad or m".
    words : str, optional
        Name of the axis then.

    Raises
    ------
    InputError
        If the quantity is none of these.

    Examples
    --------
    >>> shown("twist", "rad or m").label, shown(None, "rad or m").label
    ('amplitude [mrad]', 'amplitude [rad or m]')
    """
    if quantity is None:
        return Shown(f"{words} [{either}]", 1.0, either)
    if not isinstance(quantity, str) or quantity not in QUANTITIES:
        raise InputError(
            f"quantity: given {quantity!r}; allowed are {', '.join(QUANTITIES)}, because the axis has "
            "the unit of one of them."
        )
    return Shown(*QUANTITIES[quantity], SI_UNITS[quantity])


# Of what is drawn as it moves, not by its amplitude.
MOVING: dict[str, tuple[str, float]] = {
    "twist": ("twist [mrad]", MILLI),
    "displacement": ("displacement [µm]", MICRO),
    "torque": ("torque [kN m]", KILO),
    "force": ("force [kN]", KILO),
}


def in_unit(unit: str) -> Shown:
    """Tell how amplitudes in a unit of SI are drawn.

    Examples
    --------
    >>> in_unit("Pa").label
    'alternating stress [MPa]'
    """
    for quantity, own in SI_UNITS.items():
        if own == unit:
            return Shown(*QUANTITIES[quantity], unit)
    return Shown(f"amplitude [{unit}]", 1.0, unit)
