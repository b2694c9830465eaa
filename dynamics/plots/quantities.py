"""Names and display units of vibrating quantities on an axis."""

from typing import Literal, NamedTuple, TypeAlias

from crankbase.checks.choices import check_choice
from crankbase.units.units import UNITS, VIBRATING, factor_of, unit_symbol

# What values in SI are multiplied by to be shown in thousands, thousandths and so on.
KILO, MEGA, MILLI = factor_of("kN"), factor_of("MPa"), factor_of("mm")
SPEED_LABEL = "crankshaft speed [1/min]"

Quantity: TypeAlias = Literal["twist", "displacement", "torque", "force", "stress"]


def _labelled(quantity: str, words: str) -> tuple[str, float]:
    unit = VIBRATING[quantity]
    return f"{words} [{unit_symbol(unit)}]", factor_of(unit)


# Label of the axis, and what a value in SI is multiplied by.
QUANTITIES: dict[str, tuple[str, float]] = {
    **{name: _labelled(name, "amplitude") for name in ("twist", "displacement")},
    **{name: _labelled(name, f"alternating {name}") for name in ("torque", "force", "stress")},
}
SI_UNITS: dict[str, str] = {quantity: UNITS[unit][0] for quantity, unit in VIBRATING.items()}


class QuantityDisplay(NamedTuple):
    """Display of a quantity in diagrams.

    Parameters
    ----------
    label : str
        Of the axis, with its unit.
    factor : float
        Factor from SI to the displayed unit.
    unit : str
        The unit in SI.
    """

    label: str
    factor: float
    unit: str


def quantity_display(
    quantity: Quantity | None, either: str, words: str = "amplitude"
) -> QuantityDisplay:
    """Return the display of a quantity in diagrams.

    Parameters
    ----------
    quantity : {"twist", "displacement", "torque", "force", "stress"}, optional
        Quantity of the values; a chain may be torsional or axial and does not determine it.
    either : str
        SI unit if the quantity is None, such as "rad or m".
    words : str, optional
        Label of the axis in this case.

    Raises
    ------
    InputError
        If the quantity is none of these.

    Examples
    --------
    >>> quantity_display("twist", "rad or m").label, quantity_display(None, "rad or m").label
    ('amplitude [mrad]', 'amplitude [rad or m]')
    """
    if quantity is None:
        return QuantityDisplay(f"{words} [{either}]", 1.0, either)
    check_choice("quantity", quantity, QUANTITIES, "the axis has the unit of one of them")
    return QuantityDisplay(*QUANTITIES[quantity], SI_UNITS[quantity])


# Of what is drawn as it moves, not by its amplitude.
MOVING: dict[str, tuple[str, float]] = {
    quantity: _labelled(quantity, quantity)
    for quantity in ("twist", "displacement", "torque", "force")
}


def in_unit(unit: str) -> QuantityDisplay:
    """Return the display of amplitudes in an SI unit.

    Examples
    --------
    >>> in_unit("Pa").label
    'alternating stress [MPa]'
    """
    for quantity, own in SI_UNITS.items():
        if own == unit:
            return QuantityDisplay(*QUANTITIES[quantity], unit)
    return QuantityDisplay(f"amplitude [{unit}]", 1.0, unit)
