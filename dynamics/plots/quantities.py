"""Names, units and grid coordinates of vibrating quantities."""

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from crankbase.array_checks import ComplexArray, FloatArray
from crankbase.choices import check_choice
from crankbase.quantity import UNITS, VIBRATING, factor_of, unit_symbol

Coordinate: TypeAlias = tuple[Any, str, str]


def orders_and_speeds(orders: FloatArray, speeds: FloatArray) -> dict[str, Coordinate]:
    """Return the coordinates "order" and "speed"."""
    return {
        "order": (orders, "1", "order, in cycles per crankshaft revolution"),
        "speed": (speeds, "rad/s", "crankshaft speed"),
    }


def angle_axis(angles: FloatArray) -> Coordinate:
    """Return the coordinate of shaft angles [deg]."""
    return angles, "deg", "shaft angle"


def time_axis(time: FloatArray) -> Coordinate:
    """Return the coordinate of the time [s]."""
    return time, "s", "time"


def name_axis(names: Sequence[str], words: str) -> Coordinate:
    """Return a coordinate of names."""
    return np.array(list(names), dtype=str), "", words


def number_axis(count: int, words: str) -> Coordinate:
    """Return a coordinate of numbers from 1."""
    return np.arange(1, count + 1), "1", words


def infinite_where_unbounded(values: ComplexArray, unbounded: NDArray[np.bool_]) -> ComplexArray:
    """Return phasors (K, S, ...), infinite where the response is unbounded (K, S)."""
    where = unbounded.reshape(unbounded.shape + (1,) * (values.ndim - unbounded.ndim))
    return np.where(where, complex(np.inf), values)


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
    for quantity, si_unit in SI_UNITS.items():
        if si_unit == unit:
            return QuantityDisplay(*QUANTITIES[quantity], unit)
    return QuantityDisplay(f"amplitude [{unit}]", 1.0, unit)
