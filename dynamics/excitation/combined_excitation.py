"""Excitations of different orders acting together."""

import numpy as np

from crankbase.errors import InputError
from dynamics.response.order_excitation import OrderExcitation

# Two orders are one within this share: that of a propeller comes from a gear ratio.
SAME_ORDER = 1e-9


def combined_excitation(*excitations: OrderExcitation) -> OrderExcitation:
    """Return several excitations of the same nodes as one with all their orders.

    Parameters
    ----------
    excitations : OrderExcitation
        With the same speeds and nodes; orders may differ, as those of engine and propeller.
        Phasors of one order are added, with their phases.

    Raises
    ------
    InputError
        If none is given, or speeds or the number of nodes differ.
    """
    if not excitations:
        raise InputError(
            "excitations: given none; allowed are one or more, because they are added up."
        )
    first = excitations[0]
    for other in excitations[1:]:
        if (
            not np.array_equal(other.speeds, first.speeds)
            or other.forces.shape[2] != first.forces.shape[2]
        ):
            raise InputError(
                f"excitations: given {other.speeds.size} speeds and {other.forces.shape[2]} nodes beside "
                f"{first.speeds.size} and {first.forces.shape[2]}; allowed are the same speeds and nodes, "
                "because forces are added speed by speed and node by node."
            )
    every = np.sort(np.concatenate([own.orders for own in excitations]))
    orders = every[np.diff(every, prepend=0.0) > SAME_ORDER * every]
    forces = np.zeros((orders.size, *first.forces.shape[1:]), dtype=np.complex128)
    for own in excitations:
        places = np.argmin(np.abs(orders[:, np.newaxis] - own.orders), axis=0)
        np.add.at(forces, places, own.forces)
    return OrderExcitation(orders, first.speeds, forces)
