"""Forces of the cylinders on the crankpins as excitation of a whole crankshaft."""

from collections.abc import Sequence

import numpy as np

from crankbase.checks.scalars import is_whole_within
from crankbase.errors import InputError
from dynamics.crankshaft.assembly import PIN_MOTIONS
from dynamics.crankshaft.shaft_system import CrankshaftSystem
from dynamics.excitation.cylinders import CylinderForces
from dynamics.response.order_excitation import OrderExcitation


def shaft_excitation(
    crankshaft: CrankshaftSystem,
    forces: CylinderForces,
    *,
    pins: Sequence[int] | None = None,
    tangential: bool = True,
    radial: bool = True,
) -> OrderExcitation:
    """Return the cylinders' forces as excitation of a whole crankshaft.

    Parameters
    ----------
    crankshaft : CrankshaftSystem
    forces : CylinderForces
        Orders (K,), speeds (S,), tangential and radial phasors (K, S, c) of c cylinders.
    pins : sequence of c int, optional
        Pin of each cylinder from 0, counted along the shaft; by default that of its throw, if each throw
        has one.
    tangential, radial : bool
        Whether these forces act; with one of them alone, the response shows its effect.

    Returns
    -------
    OrderExcitation
        On the points of the system.

    Raises
    ------
    InputError
        If there is not one pin for each cylinder, or a pin does not exist.

    Notes
    -----
    Forces of several cylinders on one pin act at its middle and add up: rods side by side load it off the
    middle, and their opposite moments on the pin are neglected. Each force is uniform over the pin.
    """
    places = pins_of_cylinders(crankshaft.shaft.pin_throws, forces.throws, pins)
    first = 6 * crankshaft.shaft.section_count
    acting = np.zeros((*forces.tangential.shape[:2], len(crankshaft.names)), dtype=np.complex128)
    kinds = {"tangential": tangential, "radial": radial}
    for direction in (name for name, acts in kinds.items() if acts):
        rows = first + 3 * np.array(places) + PIN_MOTIONS.index(direction)
        for cylinder, row in enumerate(rows.tolist()):
            acting[:, :, row] += getattr(forces, direction)[:, :, cylinder]
    return OrderExcitation(forces.orders, forces.speeds, acting)


def pins_of_cylinders(
    pin_throws: Sequence[int], throws: Sequence[int], pins: Sequence[int] | None = None
) -> tuple[int, ...]:
    """Return the pin of each cylinder, checked.

    Parameters
    ----------
    pin_throws : sequence of p int
        Throw of each pin.
    throws : sequence of c int
        Throw of each cylinder.
    pins : sequence of c int, optional
        As for `shaft_excitation`.

    Raises
    ------
    InputError
        As `shaft_excitation`.
    """
    if pins is None:
        if len(set(pin_throws)) != len(pin_throws):
            raise InputError(
                "pins: given none for throws of several pins; allowed is the pin of each cylinder, because "
                "its throw does not define it."
            )
        pins = [
            pin_throws.index(throw) if throw in pin_throws else len(pin_throws) for throw in throws
        ]
    count = len(pin_throws)
    if len(pins) != len(throws) or not all(is_whole_within(pin, 0, count - 1) for pin in pins):
        raise InputError(
            f"pins: given {list(pins)}; allowed is a whole number from 0 to {count - 1} for each of the "
            f"{len(throws)} cylinders, because its rod sits on one of {count} pins."
        )
    return tuple(int(pin) for pin in pins)
