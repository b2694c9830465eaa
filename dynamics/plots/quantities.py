"""Names of vibrating quantities on an axis, the units they are shown in."""

from typing import Literal, NamedTuple, TypeAlias

from crankbase.errors import InputError
from crankbase.units.units import UNITS, VIBRATING, factor_of, written

# What values in SI are multiplied by to be shown in thousands, thousandths and so on.
KILO, MEGA, MILLI = factor_of("kN"), factor_of("MPa"), factor_of("mm")
SPEED_LABEL = "crankshaft speed [1/min]"

Quantity: TypeAlias = Literal["twist", "displacement", "torque", "force", "stress"]


def _labelled(quantity: str, words: str) -> tuple[str, float]:
    unit = VIBRATING[quantity]
    return f"{words} [{written(unit)}]", factor_of(unit)


# Label of the axis, and what a value in SI is multiplied by.
QUANTITIES: dict[str, tuple[str, float]] = {
    "twist": _labelled("twist", "amplitude"),
    "displacement": _labelled("displacement", "amplitude"),
    "torque": _labelled("torque", "alternating torque"),
    "force": _labelled("force", "alternating force"),
    "stress": _labelled("stress", "alternating stress"),
}
SI_UNITS: dict[str, str] = {quantity: UNITS[unit][0] for quantity, unit in VIBRATING.items()}


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
    quantity: _labelled(quantity, quantity)
    for quantity in ("twist", "displacement", "torque", "force")
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
